"""Rows of a database computed again from the parameters that they store.

A row of points is a point; a row of limits is computed with the others of its design, because the roots of all its
tolerances are sought together.  Where the engine is the one that made the file, and the processor rounds as that one
did, both have the same bits.  Else a row is sound if

    exponents, exact modes    |stored - again| ≤ b, the sum of both error bounds (where none is stored, twice the other)
    other numbers             |stored - again| ≤ (ROUNDING + FOLLOWING b) max(1, |again|), or both are nan, or equal
    words                     the same

A stored bound is believed up to LOOSER times the one computed again, or up to a millionth, and must be above 0.  Rows
are of maps where the study says so; then a verdict may be UNDECIDED on one side.  Of another engine only exponents are
compared, for what is made of them may have been defined otherwise, and no limits.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import store
from .comparison import Metric
from .errors import DamageError, FloquetError
from .kernels import POINTS, part_of
from .models import Physics
from .period_map import Method
from .rotor import PARAMETERS, Hub, Rotor
from .store.guard import Beat
from .study.alike import DESIGN
from .sweep import ENGINE, Plan, limit_rows, point_rows
from .verdict import Verdict

__all__ = ["Recomputed", "misplaced", "recompute"]

Rows = dict[str, NDArray[Any]]
ROUNDING = 1e-6
"""Rounding moves what follows from exponents by the root of a last digit, 1e-8, where a pair has just split; without
fused multiply-adds the largest of 13 849 points and 32 904 limits moved by 4e-12 (computed here)."""
FOLLOWING = 100.0  # times the bound of exponents: relative errors divide by a root mean square, seldom below 1e-2
LOOSER = 1e3  # bounds of maps were up to 440 times those of a row by itself, among 400 random ones
BRANCH = 1e-6  # bounds next to branch points are roots of roundings, or far less where they were computed in pairs
OF_METHOD = ("method", "panels", "exponent_error", "determinant_defect", "verdict")  # maps differ in these by nature
MAPPED = re.compile(r"\bmap\s*=\s*true\b")
AROUND = 1024  # rows before and after one of limits, in which others of its design are looked for


@dataclass(frozen=True, kw_only=True)
class Recomputed:
    """Rows of a table computed again: how many are equal to the bit, or within their bounds; the numbers of others."""

    table: str
    rows: int
    equal: int
    within: int
    others: tuple[int, ...]
    engine: int
    reason: str = ""

    def __str__(self) -> str:
        if not self.rows:
            return f"no row of {self.table} was computed again ({self.reason})"
        said = [f"{self.equal} equal"] if self.equal else []
        said += [f"{self.within} within the bounds of error"] if self.within else []
        engine = "" if self.engine == ENGINE else f", with engine {ENGINE} where the file has {self.engine}"
        return f"{self.rows} rows of {self.table} computed again{engine}: {' and '.join(said)}"


def recompute(file: store.File, table: str, sample: int, seed: int = 0) -> Recomputed:
    """Compute random rows of a table again and compare them; none where the file does not say its equations."""
    rows, engine = file.rows(table), file.attributes.get("engine_version", 0)
    if not isinstance(engine, int):
        raise DamageError(
            file.path, ["attributes"], f"its engine_version is {engine!r}, which is no number of an engine"
        )
    reason = _none(file, table, engine)
    chosen = np.sort(np.random.default_rng(seed).choice(rows, 0 if reason else min(sample, rows), replace=False))
    compared = {"points": _point, "limits": _limit}[table]
    results = [compared(file, row, engine) for row in chosen.tolist()]
    return Recomputed(
        table=table,
        rows=len(chosen),
        equal=results.count(True),
        within=results.count(False),
        others=tuple(row for row, result in zip(chosen.tolist(), results, strict=True) if result is None),
        engine=engine,
        reason=reason,
    )


def _none(file: store.File, table: str, engine: int) -> str:
    """Why no row of a table can be computed again and compared; or empty."""
    if not file.rows(table):
        return "it has none"
    if "options" not in file.attributes:
        return "the file does not say by which equations"
    if engine != ENGINE and (table != "points" or not {"exponent_1", "exponent_2"} & set(file.columns(table))):
        return f"engine {engine} has made them, this is {ENGINE}, and they have no exponents with bounds"
    return ""


def _point(file: store.File, row: int, engine: int) -> bool | None:
    """Whether a row is equal to the bit (True), within its bounds (False), or neither (None)."""
    stored = _rows(file, "points", row, row + 1)
    mapped = MAPPED.search(str(file.attributes.get("input", ""))) is not None
    mapped &= "method" not in stored or int(stored["method"][0]) == Method.MAP
    try:
        plan = _plan(file, stored, stored["advance_ratio"])
        for many in (POINTS, 1):  # the last digits are those of a large study or of a small one
            with part_of(many):
                again = point_rows(plan, 0, 1)
            if _equal(stored, again):
                return True
    except (FloquetError, AttributeError, KeyError, RecursionError, TypeError, ValueError):
        return None
    return False if _within(stored, again, mapped, engine) else None


def _limit(file: store.File, row: int, engine: int) -> bool | None:
    """The same of a row of limits."""
    first = max(0, row - AROUND)
    near = _rows(file, "limits", first, min(row + AROUND, file.rows("limits")))
    design = np.flatnonzero(near["rotor"] == near["rotor"][row - first])
    stored, wanted = ({name: value[some] for name, value in near.items()} for some in ([row - first], design))
    try:
        asked = zip(wanted["metric"].tolist(), wanted["tolerance"].tolist(), strict=True)
        tolerances = tuple((Metric(metric), tolerance) for metric, tolerance in dict.fromkeys(asked))
        mu_max = float(stored["mu_max"][0])
        found = limit_rows(_plan(file, stored, np.zeros(1), tolerances=tolerances, mu_max=mu_max), 0, 1)
    except (FloquetError, AttributeError, KeyError, RecursionError, TypeError, ValueError):
        return None
    same = np.logical_and.reduce([found[name] == stored[name] for name in ("mode", "metric", "tolerance")])
    if same.sum() != 1:
        return None
    again = {name: value[same] for name, value in found.items()}
    if _equal(stored, again):
        return True
    return False if _agree(stored, again, 0.0, ()) else None


def _rows(file: store.File, table: str, start: int, stop: int) -> Rows:
    pieces = [rows for _, rows in file.chunks(table, list(file.columns(table)), start, stop)]
    return {name: np.concatenate([rows[name] for rows in pieces]) for name in pieces[0]}


def _plan(file: store.File, stored: Rows, advance_ratio: NDArray[np.float64], **limits: Any) -> Plan:
    """The study of one design, with the equations of the file."""
    options = json.loads(file.attributes["options"])
    model = options.pop("model")
    values: dict[str, Any] = {p.name: float(stored[p.name][0]) for p in PARAMETERS}
    rotor = Rotor(hub=Hub(int(stored["hub"][0])), blades=int(stored["blades"][0]), **values)
    return Plan(
        rotors=(rotor,),
        advance_ratio=advance_ratio,
        model=None if model == "by hub" else model,
        physics=Physics(**options),
        **limits,
    )


# ---------------------------------------------------------------------- what is as it was
def _equal(stored: Rows, again: Rows) -> bool:
    return all(again[name].tobytes() == value.tobytes() for name, value in stored.items() if name != "rotor")


def _within(stored: Rows, again: Rows, mapped: bool, engine: int) -> bool:
    """Whether a point is what both bounds allow."""
    own = float(again["exponent_error"][0])
    theirs = float(stored.get("exponent_error", again["exponent_error"])[0])
    if theirs <= 0.0 or theirs > max(LOOSER * own, BRANCH):
        return False
    bound = own + theirs
    exponents = [name for name in stored if name.startswith(("exponent_1", "exponent_2", "exact_"))]
    if engine != ENGINE:
        exponents = [name for name in exponents if name.startswith("exponent_")]
        return all(_near(stored[name], again[name], bound) for name in exponents)
    if not all(_near(stored[name], again[name], bound) for name in exponents):
        return False
    if mapped and "verdict" in stored:
        words = {int(stored["verdict"][0]), int(again["verdict"][0])}
        if len(words) > 1 and Verdict.UNDECIDED not in words:
            return False
    return _agree(stored, again, bound, (*exponents, *(OF_METHOD if mapped else OF_METHOD[:3])))


def _agree(stored: Rows, again: Rows, bound: float, apart: Collection[str]) -> bool:
    """Whether words are the same, and numbers as close as rounding and the bound of their exponents leave them."""
    compared: Mapping[str, NDArray[Any]] = {n: v for n, v in stored.items() if n not in ("rotor", *apart)}
    for name, value in compared.items():
        if value.dtype.kind in "iu":
            if not np.array_equal(value, again[name]):
                return False
        elif not _near(value, again[name], (ROUNDING + FOLLOWING * bound) * max(1.0, float(np.abs(again[name][0])))):
            return False
    return True


def _near(stored: NDArray[Any], again: NDArray[Any], distance: float) -> bool:
    with np.errstate(invalid="ignore"):
        near = (stored == again) | (np.abs(stored - again) <= distance) | (np.isnan(stored) & np.isnan(again))
    return bool(near.all())


# ---------------------------------------------------------------------- rotors
def misplaced(file: store.File, beat: Beat) -> Iterator[str]:
    """Tables whose rotors do not follow one another, are more than have names, or change on their way."""
    for table in file.tables:
        last: Rows = {}
        for _, rows in file.chunks(table, ["rotor", *DESIGN]):
            beat()
            both = {name: np.concatenate([last.get(name, value[:1]), value]) for name, value in rows.items()}
            last = {name: value[-1:] for name, value in rows.items()}
            step = np.diff(both["rotor"])
            change = np.logical_or.reduce([np.diff(both[name]) != 0 for name in DESIGN])
            many = file.names and int(rows["rotor"].max()) >= len(file.names)
            if many or (step < 0).any() or (change & (step == 0)).any():
                yield f"{table}/rotor"
                break
