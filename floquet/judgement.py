"""The verdict at one advance ratio, in words.

For each mode: whether the simple model holds to the tolerance, why not, and what to use instead (the averaged model
with more harmonics if that holds, else the Floquet exponents); where it stops to hold, and by what; and how this limit
moves where the rotor is not known better than to 10 %.  Every verdict says that dynamic inflow is not in the model.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from floquet.comparison import Cause, Comparison, Metric, ModeComparison, Rule, compare, exact_model
from floquet.errors import FloquetWarning
from floquet.exponents import Verdict
from floquet.report import (
    NO_INFLOW,
    Record,
    amount,
    intervals_text,
    limit_records,
    number,
    per_rev,
    title,
    tolerance_text,
)  # fmt: skip
from floquet.rotor import Rotor
from floquet.validity import Limit, all_limits, limits, lock_windows

__all__ = ["KNOT", "ModeVerdict", "RotorVerdict", "verdict", "verdict_records", "verdict_text"]

KNOT = 1852.0 / 3600.0  # m/s
CHANGE = 0.1
"""By what part parameters are changed to see how a limit moves."""
NEARBY = {
    "lock_number": "the Lock number γ", "hinge_offset": "the hinge offset ε",
    "offset_mass_ratio": "the offset mass ratio m = e·M_β/I_β", "hinge_stiffness": "the hinge spring κ",
    "pitch_flap_coupling": "the pitch-flap coupling K₁",
}  # fmt: skip
"""The parameters that are changed, where they are not zero."""
STILL = 0.005  # of μ: a limit that moves less is told to stay
FARTHEST = 1.0 / (1.0 + CHANGE)  # of the radius that lifts: no offset beyond has one that is as much greater
FINER = (2, 3, 4)  # harmonics of the averaged models that are tried where the tip-path plane fails
CAUSES = {
    Cause.NONE: "the models agree",
    Cause.DRIFT: "both pairs are complex and have drifted apart, for the simple model averages the periodic terms away",
    Cause.LOCK: "the exact pair is locked at {lock} per rev (two dampings, one frequency), the simple model's is not",
    Cause.TPP_SPLIT: "the simple model's pair has split into two reals, the exact pair has not",
    Cause.DRIFT_IN_LOCK: "both pairs are split, the exact one in its lock at {lock} per rev, and lie apart",
    Cause.STABILITY: "one of the two models is stable and the other is not",
}
BRIEFLY = {
    Cause.NONE: "",
    Cause.DRIFT: "by drift",
    Cause.LOCK: "by a lock at {lock} per rev",
    Cause.TPP_SPLIT: "by a split of the simple pair",
    Cause.DRIFT_IN_LOCK: "by drift within a lock at {lock} per rev",
    Cause.STABILITY: "by a difference in stability",
}


@dataclasses.dataclass(frozen=True)
class ModeVerdict:
    """Whether the simple model holds for a mode at one μ.

    ``rule`` is what the mode is compared with; ``dampings`` are the blade's and ``simple_dampings`` the simple mode's,
    per rev, the lesser first.  ``harmonics`` of the averaged model that holds where this one does not; 0 if none
    does, None if none was tried.  ``nearby`` are the limits for 10 % less and 10 % more of a parameter; where m follows
    ε it does so for them, too.
    """

    mode: str
    valid: bool
    error: float
    rule: Rule
    dampings: tuple[float, float]
    simple_dampings: tuple[float, float]
    cause: Cause
    lock: float
    limit: Limit
    harmonics: int | None
    harmonics_error: float
    nearby: Mapping[str, tuple[Limit, Limit]]


@dataclasses.dataclass(frozen=True)
class RotorVerdict:
    """The verdicts for the modes of a rotor at one advance ratio, and what they were judged by.

    ``window`` is the lock (enter, leave, per_rev) that the advance ratio lies in, None outside a lock.
    """

    rotor: Rotor
    advance_ratio: float
    tolerance: float
    metric: Metric
    comparison: Comparison
    modes: tuple[ModeVerdict, ...]
    window: tuple[float, float, float] | None = None


def verdict(
    rotor: Rotor, advance_ratio: float, *, tolerance: float = 0.05, metric: Metric = Metric.RELATIVE,
    modes: Sequence[str] | None = None, mu_max: float = 1.0, **options: Any,
) -> RotorVerdict:  # fmt: skip
    """Compare at one advance ratio, and put each mode's limit and a model that holds beside it."""
    comparison = compare(rotor, advance_ratio, **options)
    sought = max(mu_max, advance_ratio)
    found = limits(rotor, tolerances=((metric, tolerance),), modes=modes, mu_max=sought, **options)
    failing = any(not comparison[one.mode].by(metric) <= tolerance for one in found)
    finer = FINER if failing and exact_model(rotor, options.get("model")) == "flapping" else ()
    better = {m: compare(rotor, advance_ratio, harmonics=m, **options) for m in finer}
    nearby = _nearby(rotor, found, sought, **options)
    judged = tuple(
        _judge(comparison, comparison[one.mode], one, better, near) for one, near in zip(found, nearby, strict=True)
    )
    window = _window(rotor, advance_ratio, float(comparison.stability.lock), sought, **options)
    return RotorVerdict(rotor, advance_ratio, tolerance, metric, comparison, judged, window)


def _nearby(
    rotor: Rotor, found: Sequence[Limit], mu_max: float, **options: Any
) -> list[dict[str, tuple[Limit, Limit]]]:
    """For each limit those of rotors with a little less and a little more of each parameter, by its name."""
    values = {name: float(getattr(rotor, name)) for name in NEARBY}
    farthest = FARTHEST * float(options.get("tip_loss", 1.0))
    names = [name for name, value in values.items() if value and not (name == "hinge_offset" and value >= farthest)]
    changed = {name: np.full(2 * len(names), value) for name, value in values.items()}
    for i, name in enumerate(names):
        together = [name, "offset_mass_ratio"] if name == "hinge_offset" and rotor.offset_mass_derived else [name]
        for moved in together:
            changed[moved][2 * i : 2 * i + 2] *= (1.0 - CHANGE, 1.0 + CHANGE)
    with warnings.catch_warnings():  # what is to be said of the rotor has been said of itself
        warnings.simplefilter("ignore", FloquetWarning)
        near = all_limits(
            rotor.replace(**changed), tolerances=((found[0].metric, found[0].tolerance),),
            modes=[one.mode for one in found], mu_max=mu_max, **options,
        )  # fmt: skip
    there = [near.of(case) for case in range(2 * len(names))]
    return [{name: (there[2 * i][k], there[2 * i + 1][k]) for i, name in enumerate(names)} for k in range(len(found))]


def _window(
    rotor: Rotor, advance_ratio: float, lock: float, mu_max: float, **options: Any
) -> tuple[float, float, float] | None:
    """The lock that the advance ratio lies in; its edges are nan where the windows do not show it."""
    if math.isnan(lock):
        return None
    inside = (w for w in lock_windows(rotor, mu_max=mu_max, **options) if w[0] <= advance_ratio <= w[1])
    return next((w for w in inside if w[2] == lock), (math.nan, math.nan, lock))


def _judge(
    comparison: Comparison,
    mode: ModeComparison,
    limit: Limit,
    better: Mapping[int, Comparison],
    nearby: Mapping[str, tuple[Limit, Limit]],
) -> ModeVerdict:
    error = float(mode.by(limit.metric))
    valid = error <= limit.tolerance
    holds = {m: float(c[mode.name].by(limit.metric)) for m, c in better.items()}
    first = None if valid or not holds else next((m for m, e in holds.items() if e <= limit.tolerance), 0)
    return ModeVerdict(
        mode.name, valid, error, Rule(mode.rule), _dampings(comparison.stability.exponents), _dampings(mode.simple),
        mode.cause, mode.lock, limit, first, holds.get(first or 0, math.nan),
        nearby,
    )  # fmt: skip


def _dampings(pair: Any) -> tuple[float, float]:
    """The two dampings of a pair, the lesser first."""
    low, high = sorted(-float(one) for one in np.real(pair))
    return low, high


def verdict_records(answer: RotorVerdict) -> list[Record]:
    """One record a mode: the answer at the advance ratio, then the limit as in ``limit_records``."""
    out = []
    for one in answer.modes:
        here = {
            "advance_ratio": answer.advance_ratio, "mode": one.mode, "valid": one.valid, "error": one.error,
            "rule_here": one.rule, "dampings": one.dampings, "simple_dampings": one.simple_dampings,
            "cause_here": one.cause, "lock_here": one.lock, "harmonics": one.harmonics,
            "harmonics_error": one.harmonics_error,
            **{f"nearby_{name}s": {parameter: tuple(getattr(limit, name) for limit in pair)
                                   for parameter, pair in one.nearby.items()} for name in ("limit", "cause", "lock")},
            "verdict": Verdict(answer.comparison.stability.verdict),
        }  # fmt: skip
        out.append(here | limit_records(answer.rotor, [one.limit])[0] | {"note": NO_INFLOW})
    return out


def verdict_text(answer: RotorVerdict) -> str:
    """A few sentences: the rotor's, then three for each mode, each on its own line."""
    known = {Verdict.STABLE: "stable", Verdict.UNSTABLE: "UNSTABLE"}
    state = known.get(Verdict(answer.comparison.stability.verdict), "neither surely stable nor surely unstable")
    failing = [one.mode for one in answer.modes if not one.valid]
    mean = [one.mode for one in answer.modes if one.valid and one.rule is Rule.MEAN]
    holds = f"does not hold for {_listed(failing)}" if failing else "holds for every mode"
    if mean:
        against = f"for {_listed(mean)} only against the mean of a locked pair"
        holds += f" and holds {against}" if failing else f", {against}"
    tolerance = tolerance_text({"tolerance": answer.tolerance, "metric": answer.metric})
    head = (
        f"{title(answer.rotor)} at advance ratio {number(answer.advance_ratio)}"
        f"{_speed(answer.rotor, answer.advance_ratio)}: the simple model {holds} "
        f"(tolerance {tolerance}); by the Floquet exponents the flapping is {state}{_locked(answer.window)}."
    )
    return "\n".join(
        [head, *(line for one in answer.modes for line in _sentences(one, answer.rotor.offset_mass_derived)), NO_INFLOW]
    )


def _locked(window: tuple[float, float, float] | None) -> str:
    """``, and the blade is locked at 1 per rev (from μ = 0.1215)``."""
    if window is None:
        return ""
    enter, leave, lock = window
    until = "" if math.isinf(leave) else f" to {number(leave, 4)}"
    where = "" if math.isnan(enter) else f" (from μ = {number(enter, 4)}{until})"
    return f", and the blade is locked at {per_rev(lock)} per rev{where}"


def _speed(rotor: Rotor, advance_ratio: float) -> str:
    if not (rotor.rotor_speed and rotor.radius):
        return ""
    return f" ({advance_ratio * rotor.rotor_speed * rotor.radius / KNOT:.0f} knots with the disc level)"


def _sentences(one: ModeVerdict, together: bool) -> list[str]:
    """Whether the mode is right here, where it stops to be, and how that limit moves with the rotor."""
    metric = Metric(one.limit.metric)
    because = "" if one.valid else f", because {CAUSES[one.cause].format(lock=per_rev(one.lock))}"
    instead = "" if one.valid else f"; {_instead(one, metric)}"
    here = f"  {one.mode}: {_judged(one, metric)}{because}{instead}."
    return [
        here,
        f"      {'; '.join([_where(one.limit), *_edges(one)])}.",
        *(f"      {s}." for s in _moved(one, together)),
    ]


def _judged(one: ModeVerdict, metric: Metric) -> str:
    """Valid or not; against a mean, which no motion of the rotor has, with the dampings on either side."""
    error = amount(one.error, metric)
    if one.rule is not Rule.MEAN:
        return f"{'valid' if one.valid else 'NOT valid'}, error {error}"
    against = "valid against" if one.valid else "NOT valid, even against"
    two = " and ".join(f"{value:.3f}" for value in one.dampings)
    low, high = one.simple_dampings
    simple = f"one, {low:.3f}" if high - low < 1e-9 else f"{low:.3f} and {high:.3f}"
    only = " only" if one.valid else ""
    dampings = f"the rotor has two dampings, {two} per rev, the simple model {simple}"
    return f"{against} the mean of a locked pair{only}: {dampings}; error {error}"


def _where(limit: Limit) -> str:
    """``It fails at μ = 0.247-0.268, from 0.3032, first by drift``."""
    if not limit.intervals:
        return f"It keeps the tolerance up to μ = {number(limit.mu_max)}"
    places = f"It fails at μ = {intervals_text(limit.intervals)}".replace("at μ = from ", "from μ = ")
    return f"{places}, {'first ' if len(limit.intervals) > 1 else ''}{_briefly(limit)}"


def _briefly(limit: Limit) -> str:
    """The cause of a limit."""
    return BRIEFLY[Cause(limit.cause)].format(lock=per_rev(limit.lock))


def _edges(one: ModeVerdict) -> Iterator[str]:
    """The lock edge nearest to the limit, and the nearest split of any simple pair where one has to do with it."""
    limit, split = one.limit, (Cause.TPP_SPLIT, Cause.DRIFT_IN_LOCK)
    if not math.isnan(limit.lock_edge):
        yield f"the nearest lock edge is at μ = {number(limit.lock_edge, 4)}"
    if (one.cause in split or limit.cause in split) and not math.isnan(limit.split_edge):
        yield f"the nearest split of a simple pair is at μ = {number(limit.split_edge, 4)}"


def _moved(one: ModeVerdict, together: bool) -> Iterator[str]:
    """How the limit moves with the rotor: one sentence, none where there is no parameter to change."""
    said = NEARBY | ({"hinge_offset": f"{NEARBY['hinge_offset']} (m with it)"} if together else {})
    still = [said[name] for name, pair in one.nearby.items() if _stays(one.limit, pair)]
    moved = [(said[name], _places(one.limit, pair)) for name, pair in one.nearby.items() if not _stays(one.limit, pair)]
    clauses = [f"{name}{'' if i else ' the limit is'} {places}" for i, (name, places) in enumerate(moved)]
    if still:
        stays = f"moves by less than {STILL:g}" if one.limit.intervals else f"stays beyond {number(one.limit.mu_max)}"
        clauses.append(f"{_listed(still)} {'it' if moved else 'the limit'} {stays}")
    if clauses:
        yield f"With {CHANGE:.0%} less or more of ".replace("%", " %") + ", of ".join(clauses)


def _stays(limit: Limit, pair: tuple[Limit, Limit]) -> bool:
    """Whether a change moves a limit hardly, and leaves its cause."""
    return all(
        abs(there.limit - limit.limit) < STILL if math.isfinite(there.limit) else math.isinf(limit.limit)
        for there in pair
    ) and not any(_elsewise(limit, there) for there in pair)


def _elsewise(limit: Limit, there: Limit) -> bool:
    """Whether a moved limit has another cause."""
    return bool(there.intervals) and _briefly(there) != _briefly(limit)


def _places(limit: Limit, pair: tuple[Limit, Limit]) -> str:
    """``at 0.3989 or 0.2749 (by drift)``, with the cause where it is another one."""
    low, high = (
        f"at {number(there.limit, 4)}{f' ({_briefly(there)})' if _elsewise(limit, there) else ''}"
        if there.intervals
        else f"beyond {number(there.mu_max)}"
        for there in pair
    )
    return low if low == high else f"{low} or {high.removeprefix('at ') if low.startswith('at ') else high}"


def _instead(one: ModeVerdict, metric: Metric) -> str:
    if one.harmonics:
        error = amount(one.harmonics_error, metric)
        return f"use the Floquet exponents, or the averaged model with {one.harmonics} harmonics (error {error})"
    tried = "" if one.harmonics is None else ", for no averaged model of a few harmonics holds either"
    return f"use the Floquet exponents{tried}"


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))
