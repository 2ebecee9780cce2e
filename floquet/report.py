"""What people read: tables, and the strict JSON of results.

A *record* is a dict with the names of the Python results.  Every command's answer is records, shown in one of three
ways: ``table`` (aligned text), ``as_csv``, ``as_json`` (strict: nan is null, inf is "inf", complex is [re, im], an enum
is its word).

Whatever tells of stability says that dynamic inflow is not in the model.  The verdict at one advance ratio, in words,
is :mod:`floquet.judgement`'s.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum, IntEnum
from itertools import islice
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from floquet.comparison import Cause, Comparison, Metric, ModeComparison, Rule
from floquet.errors import ParameterError
from floquet.exponents import Reason, Verdict
from floquet.period_map import Method
from floquet.plain import csv_lines, strict, words
from floquet.rotor import PARAMETERS, Hub, Rotor
from floquet.validity import Limit

if TYPE_CHECKING:
    from floquet.exponents import Stability
    from floquet.export import Answer
    from floquet.query import Database
    from floquet.query.between import Interpolated
    from floquet.study import Estimate, RunReport

__all__ = [
    "NO_INFLOW", "Record", "amount", "analysis", "analysis_rows", "analysis_text", "answer_table", "as_csv", "as_json",
    "estimate_text", "fields", "interpolated_records", "intervals_text", "limit_records", "limit_table", "markdown",
    "number", "per_rev", "rotor_object", "rotor_records", "rotor_text", "run_text", "stored_limits", "table", "title",
    "tolerance_text",
]  # fmt: skip

Record = dict[str, Any]

NO_INFLOW = "Dynamic inflow is not in the model; it matters most for the low-frequency regressing mode."
LEGEND = """\
limit: first advance ratio μ at which the simple model's error passes the tolerance; from: still failing at the last μ;
lock edge, split edge: the nearest μ where the exact pair locks or unlocks, where the simple pair splits or merges;
inside a lock, modes that no other meets (at 1 per rev coning and advancing) are held against the pair's mean, which is
no exponent of the rotor: its two dampings lie on either side of it."""
RULES = {
    Rule.REALS: "the mode is locked on the real axis and compared with its two real exponents",
    Rule.JOINT: "two modes share the four exponents of a lock and are compared with them together",
    Rule.MEAN: "compared with the mean of the two locked exponents, which is no exponent of the rotor",
}
REASONS = {
    Reason.NONE: "",
    Reason.NEUTRAL: "undamped and bounded: it neither grows nor decays",
    Reason.BOUND: "the bound of an exponent reaches across zero",
}
_WORDS: dict[str, type[IntEnum]] = {
    "rule": Rule, "cause": Cause, "verdict": Verdict, "reason": Reason, "method": Method, "metric": Metric, "hub": Hub,
}  # fmt: skip
_FRACTIONS = {0.0: "0", 0.5: "½", 1.0: "1", 1.5: "1½", 2.0: "2", 2.5: "2½", 3.0: "3"}


# Values in three dresses.


def plain(value: Any) -> Any:
    """A result as strict JSON data: nan → None, inf → "inf", complex → [re, im], enums → words, arrays → lists."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(_word(f.name, getattr(value, f.name))) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(_word(key, entry)) for key, entry in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(entry) for entry in value]
    return strict(value)


def _word(name: str, value: Any) -> Any:
    """The enum of a field that is stored as an integer."""
    kind = _WORDS.get(name)
    return kind(int(value)) if kind is not None and isinstance(value, int | np.integer) else value


def _name(name: str, value: Any) -> str:
    """The word of an enum's field, whether it comes as the enum, its integer or the word."""
    return value if isinstance(value, str) else str(_WORDS[name](value).name)


def as_json(value: Any) -> str:
    """Strict JSON, readable by every parser."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def as_csv(records: Iterable[Mapping[str, Any]], names: Sequence[str] = ()) -> str:
    """Comma-separated values with a header; complex numbers and lists take a column for each part.

    ``names`` is the header of a table without rows.
    """
    rows = [_flat(record) for record in records]
    header = list(dict.fromkeys(name for row in rows for name in row)) or list(names)
    return csv_lines([header, *([row.get(name, "") for name in header] for row in rows)]).rstrip("\n")


def _flat(record: Mapping[str, Any], prefix: str = "") -> Record:
    row: Record = {}
    for key, value in record.items():
        name, value = f"{prefix}{key}", _word(key, value)
        value = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, complex):
            row |= {f"{name}_re": value.real, f"{name}_im": value.imag}
        elif isinstance(value, Mapping):
            row |= _flat(value, f"{name}_")
        elif isinstance(value, Sequence | np.ndarray) and not isinstance(value, str):
            row |= _flat({str(i): entry for i, entry in enumerate(value, 1)}, f"{name}_")
        else:
            row[name] = value.name if isinstance(value, Enum) else "" if value is None else value
    return row


def table(headers: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Aligned columns, numbers to the right, two spaces between."""
    text = [[_cell(entry) for entry in row] for row in rows]
    right = [all(_numeric(row[i]) for row in text) and bool(text) for i in range(len(headers))]
    widths = [max(len(line[i]) for line in [list(headers), *text]) for i in range(len(headers))]
    lines = [list(headers), ["─" * width for width in widths], *text]
    return "\n".join(
        "  ".join(c.rjust(w) if r else c.ljust(w) for c, w, r in zip(line, widths, right, strict=True)).rstrip()
        for line in lines
    )


def markdown(records: Iterable[Mapping[str, Any]]) -> str:
    """Records as a Markdown table, a column for every name that occurs."""
    rows = [{name: _word(name, value) for name, value in record.items()} for record in records]
    headers = list(dict.fromkeys(name for row in rows for name in row))
    lines = [headers, ["---"] * len(headers), *([_cell(row.get(name)) for name in headers] for row in rows)]
    return "\n".join("| " + " | ".join(_escaped(cell) for cell in line) + " |" for line in lines)


def _escaped(cell: str) -> str:
    """A cell in which nothing is taken for Markdown."""
    return cell.replace("|", "\\|").replace("*", "\\*")


def _cell(value: Any) -> str:
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, complex):
        return exponent(value)
    if isinstance(value, float | np.floating):
        return number(float(value))
    return "" if value is None else str(value)


def _numeric(cell: str) -> bool:
    return not cell or cell[0] in "+->.0123456789" or cell in ("none", "nan")


def number(value: float, digits: int = 5) -> str:
    """A number as people read it; a hyphen where there is none."""
    return "-" if math.isnan(value) else "inf" if math.isinf(value) else f"{value:.{digits}g}"


def exponent(value: complex) -> str:
    """σ + iω with six decimals, per rev."""
    if math.isnan(value.real):
        return "-"
    return f"{value.real:+.6f} {'-' if value.imag < 0 else '+'} {abs(value.imag):.6f}i"


def percent(value: float) -> str:
    return "-" if math.isnan(value) else f"{100 * value:.3g} %"


def amount(value: float, metric: Metric) -> str:
    """An error in the unit of its metric: all but ABSOLUTE are ratios."""
    return f"{number(value, 3)} per rev" if metric is Metric.ABSOLUTE else percent(value)


def per_rev(value: float) -> str:
    return _FRACTIONS.get(value, number(value))


def intervals_text(intervals: Iterable[tuple[float, float]]) -> str:
    """``0.31-0.52, from 0.6``: where the simple model fails; ``from`` is still failing at the last advance ratio."""
    parts = [(number(start, 4), number(end, 4) if math.isfinite(end) else "") for start, end in intervals]
    return ", ".join(f"{start}-{end}" if end else f"from {start}" for start, end in parts) or "nowhere"


# A rotor.


def rotor_records(rotor: Rotor) -> list[Record]:
    """Parameters and derived values: name, symbol, value, units, range, source, description."""
    rows = [
        {"name": p.name, "symbol": p.symbol, "value": getattr(rotor, p.name), "units": p.units, "range": p.rule,
         "source": rotor.sources.get(p.name, ""), "description": p.description}
        for p in PARAMETERS
    ]  # fmt: skip
    others = [
        ("blades", "N", rotor.blades, "1", ">= 1", "number of blades"),
        ("hub", "", rotor.hub, "", "ARTICULATED, TEETERING", "how the blades are held"),
        ("rotor_speed", "Ω", rotor.rotor_speed, "rad/s", "> 0", "rotor speed"),
        ("radius", "R", rotor.radius, "m", "> 0", "rotor radius"),
        ("flap_frequency", "ν_β", rotor.flap_frequency, "1/rev", "derived", "sqrt(1 + κ + m), structure only"),
        ("frequency_ratio_squared", "P²", rotor.frequency_ratio_squared, "1/rev²", "derived",
         "ν_β² and the spring of pitch-flap coupling"),
    ]  # fmt: skip
    keys = ("name", "symbol", "value", "units", "range", "description")
    rows += [dict(zip(keys, row, strict=True)) | {"source": rotor.sources.get(row[0], "")} for row in others]
    return rows


def rotor_object(rotor: Rotor) -> Record:
    """The rotor as one object: its fields, its derived values, its sources."""
    values = {f.name: getattr(rotor, f.name) for f in dataclasses.fields(rotor)}
    derived = {name: getattr(rotor, name) for name in ("flap_frequency", "frequency_ratio_squared")}
    return values | derived | {"sources": dict(rotor.sources)}


def rotor_text(rotor: Rotor) -> str:
    shown = ("name", "symbol", "value", "units", "range", "source")
    rows = [[record[key] for key in shown] for record in rotor_records(rotor)]
    return f"{title(rotor)}\n\n{table(shown, rows)}"


def title(rotor: Rotor) -> str:
    """``Bo 105 (N = 4, γ = 5.1, ν_β = 1.12, articulated)``."""
    return (
        f"{rotor.name or 'Rotor'} (N = {rotor.blades}, γ = {number(float(rotor.lock_number))}, "
        f"ν_β = {number(float(rotor.flap_frequency))}, {rotor.hub.name.lower()})"
    )


# One point: exponents beside the simple model's.


def analysis(rotor: Rotor, advance_ratio: float, comparison: Comparison) -> Record:
    """Everything known at one point: the fields of the Stability, the modes, and Hz and seconds where Ω is known."""
    stability = comparison.stability
    evidence = {"check": stability.check, "certificates": stability.certificates}
    fields = {f.name: getattr(stability, f.name) for f in dataclasses.fields(stability) if f.name not in evidence}
    fields |= {"multipliers": stability.multipliers, **_evidence(stability)}
    modes = [mode_record(mode, rotor.rotor_speed) for mode in comparison.modes]
    return {"rotor": rotor.name, "advance_ratio": advance_ratio, **fields, "modes": modes, "note": NO_INFLOW}


def _evidence(stability: Stability) -> Record:
    """The second answer and the proof, where they were asked for."""
    out: Record = {}
    if stability.check is not None:
        names = ("exponents", "exponent_errors", "harmonics", "converged")
        out["check"] = {name: getattr(stability.check, name) for name in names}
    if stability.certificates is not None:
        out["certificate"] = dataclasses.asdict(stability.certificates[0])
    return out


def mode_record(mode: ModeComparison, rotor_speed: float | None) -> Record:
    record = {f.name: getattr(mode, f.name) for f in dataclasses.fields(mode)} | {"error": mode.error}
    if rotor_speed:
        record["frequency_hz"] = [abs(complex(s).imag) * rotor_speed / math.tau for s in mode.exact]
        record["time_to_half"] = [_half(mode, complex(s), rotor_speed) for s in mode.exact]
    return record


def _half(mode: ModeComparison, exact: complex, rotor_speed: float) -> float:
    """No motion of the rotor decays with the mean of a locked pair."""
    return math.nan if mode.rule == Rule.MEAN else time_to_half(exact.real, rotor_speed)


def analysis_rows(record: Mapping[str, Any]) -> list[Record]:
    """The modes of an analysis for a flat table: a column for every metric."""
    errors = [{f"error_{metric.name.lower()}": mode["errors"][metric] for metric in Metric} for mode in record["modes"]]
    rest = [{k: v for k, v in mode.items() if k not in ("error", "errors")} for mode in record["modes"]]
    return [{"advance_ratio": record["advance_ratio"]} | r | e for r, e in zip(rest, errors, strict=True)]


def time_to_half(sigma: float, rotor_speed: float) -> float:
    """Seconds until a motion e^{σΩt} has halved; nan for one that does not decay."""
    return -math.log(2.0) / (sigma * rotor_speed) if sigma < 0 else math.nan


def analysis_text(rotor: Rotor, advance_ratio: float, comparison: Comparison) -> str:
    stability = comparison.stability
    bounds = zip(stability.exponents, stability.exponent_errors, strict=True)
    lock = "no lock" if math.isnan(stability.lock) else f"locked at {per_rev(float(stability.lock))} per rev"
    headers = ["mode", "Floquet", "simple model", "error", "rule", "cause"]
    seconds = ["damped frequency, Hz", "half after, s"] if rotor.rotor_speed else []
    lines = [
        f"{title(rotor)} at advance ratio {number(advance_ratio)}: {verdict_word(stability)}",
        "",
        "exponents per rev (σ < 0 decays), with bounds:",
        *(f"    {exponent(complex(eta))}  ± {bound:.1e}" for eta, bound in bounds),
        f"    rotation number {number(float(stability.rotation_number), 7)} per rev, {lock}",
        *_evidence_lines(stability),
        "",
        table([*headers, *seconds], [row for mode in comparison.modes for row in _mode_rows(mode, rotor.rotor_speed)]),
        "",
        *(
            f"{rule.name}: {text}"
            for rule, text in RULES.items()
            if any(mode.rule == rule for mode in comparison.modes)
        ),
        NO_INFLOW,
    ]
    return "\n".join(lines)


def _evidence_lines(stability: Stability) -> list[str]:
    lines = []
    if stability.check is not None:
        bound = float(np.max(stability.check.exponent_errors))
        with_harmonics = f"with {stability.check.harmonics} harmonics"
        lines.append(f"    checked by Koopman–Hill projection {with_harmonics}: ± {bound:.1e}")
    if stability.certificates is not None:
        lines.append(f"    proved: {stability.certificates[0].theorem}")
    return lines


def _mode_rows(mode: ModeComparison, rotor_speed: float | None) -> Iterable[list[Any]]:
    for i, (exact, simple) in enumerate(zip(mode.exact, mode.simple, strict=True)):
        first = [mode.name, percent(float(mode.error)), Rule(mode.rule).name, Cause(mode.cause).name]
        name, error, rule, cause = first if i == 0 else ["", "", "", ""]
        row = [name, complex(exact), complex(simple), error, rule, cause]
        if rotor_speed:
            row += [abs(exact.imag) * rotor_speed / math.tau, _half(mode, complex(exact), rotor_speed)]
        yield row


def verdict_word(stability: Any) -> str:
    reason = REASONS[Reason(stability.reason)]
    return f"{Verdict(stability.verdict).name}{f' ({reason})' if reason else ''}"


# Limits: rotor × mode.


def limit_records(rotor: Rotor, found: Iterable[Limit]) -> list[Record]:
    """The limits of one rotor with the parameters a table needs beside them."""
    about = {
        "rotor": rotor.name, "blades": rotor.blades, "lock_number": rotor.lock_number,
        "flap_frequency": rotor.flap_frequency,
    }  # fmt: skip
    return [about | {f.name: getattr(one, f.name) for f in dataclasses.fields(one)} for one in found]


def limit_table(records: Sequence[Mapping[str, Any]]) -> str:
    """The table of limits at one tolerance: one line a rotor and mode, the rotor named once."""
    tolerance = tolerance_text(records[0]) if records else "the tolerance"
    about, edges = ["rotor", "N", "γ", "ν_β", "mode"], ["lock edge", "split edge"]
    headers = [*about, f"limit μ at {tolerance}", "fails at μ", "cause", *edges]
    rows: list[list[Any]] = []
    before: tuple[str, ...] = ()
    for r in records:
        gamma, frequency = float(r["lock_number"]), float(r["flap_frequency"])
        here = (r["rotor"] or "-", str(r["blades"]), number(gamma, 4), number(frequency, 4))
        limit = f"> {number(r['mu_max'])}" if math.isinf(r["limit"]) else number(r["limit"], 4)
        shown = [intervals_text(r["intervals"]), _cause(r), number(r["lock_edge"], 4), number(r["split_edge"], 4)]
        rows.append([*(here if here != before else ("",) * 4), r["mode"], limit, *shown])
        before = here
    return f"{table(headers, rows)}\n\n{LEGEND}\n{NO_INFLOW}"


def _cause(record: Mapping[str, Any]) -> str:
    cause, lock = Cause[_name("cause", record["cause"])], float(record["lock"])
    if cause is Cause.NONE:
        return "-"
    return cause.name if math.isnan(lock) else f"{cause.name} at {per_rev(lock)} per rev"


def tolerance_text(record: Mapping[str, Any]) -> str:
    metric = Metric[_name("metric", record["metric"])]
    size = amount(record["tolerance"], metric)
    return size if metric is Metric.RELATIVE else f"{size} {metric.name.lower()}"


def stored_limits(database: Database, *, tolerance: float, metric: str, modes: Sequence[str] = ()) -> list[Record]:
    """The rows of a database's ``limits`` table at one tolerance, as the records of ``limit_records``."""
    columns = database.columns("limits")
    found = database.limits(f'metric == "{metric}"', columns="*")
    rows = {n: words(values, columns[n].flags if n in columns else None) for n, values in found.items()}
    about = ("blades", "lock_number", "flap_frequency")
    names = [f.name for f in dataclasses.fields(Limit) if f.name != "intervals"]
    out = []
    for i, count in enumerate(rows["intervals"]):
        name = rows["rotor_name"][i] if "rotor_name" in rows else ""
        record = {"rotor": name or f"rotor {rows['rotor'][i]}"} | {key: rows[key][i] for key in (*about, *names)}
        pairs = [(f"interval_{k}_start", f"interval_{k}_end") for k in range(1, count + 1)]
        kept = [(rows[start][i], rows[end][i]) for start, end in pairs if start in rows]
        out.append(record | {"intervals": tuple(kept)})
    known = sorted({record["tolerance"] for record in out})
    if known and tolerance not in known:
        has = ", ".join(f"{value:g}" for value in known)
        raise ParameterError("tolerance", tolerance, f"{database.path} has no limits at {tolerance:g}; it has {has}")
    return [r for r in out if r["tolerance"] == tolerance and (not modes or r["mode"] in modes)]


def answer_table(answer: Answer, most: int | None = None) -> tuple[str, int]:
    """What a query found as aligned text, ``most`` rows of it, and how many there are."""
    columns = answer.columns
    pieces = ([words(piece[name], column.flags) for name, column in columns.items()] for piece in answer.pieces)
    rows = list(islice((row for lists in pieces for row in zip(*lists, strict=True)), most))
    return table(list(columns), rows), len(rows) if most is None or len(rows) < most else answer.count()


def interpolated_records(found: Interpolated) -> list[Record]:
    """Values between rows, a record a column."""
    return [{"column": name, "value": v, "error": found.errors[name]} for name, v in found.values.items()]


def fields(result: Any) -> Record:
    """The fields of a result, one by one."""
    return {f.name: getattr(result, f.name) for f in dataclasses.fields(result)}


def estimate_text(estimate: Estimate) -> str:
    """What a study will make, and that its time is an estimate."""
    about = {
        "bytes": f"about {estimate.bytes / 1e6:.2g} MB, by a sample",
        "seconds": f"about {estimate.seconds:.2g}, by a sample",
    }
    found = {name: value for name, value in {**fields(estimate), **about}.items() if value}
    return table(("what", "value"), [(name, str(value)) for name, value in found.items()])


def run_text(finished: RunReport) -> str:
    """What a run did."""
    made = "made" if finished.copied else "computed"
    parts = f"{finished.computed} parts {made}, {finished.reused} kept, {len(finished.failed)} failed"
    if finished.failed:
        return f"{finished.path} is not finished: {parts}; mend the cause and run again with --resume"
    if not finished.computed and not finished.seconds:
        return f"{finished.path} is this study already, finished: {finished.points} points"
    copied = f"{finished.copied} copied, {finished.points - finished.copied} computed"
    points = f"{finished.points} points" + (f" ({copied})" if finished.copied else "")
    return f"{finished.path}: {points}, {finished.limits} limits; {parts}, {finished.seconds:.1f} s"
