"""Many rotors at once: where in μ the TPP modes hold, where they fail, where Floquet is locked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from floquet.comparison import Rule
from floquet.errors import ParameterError
from floquet.plot.curves import Band, Failing, Rows, all_intervals, checked, failing, lock_bands, modes_of, span
from floquet.plot.labels import Labels, Side
from floquet.plot.parts import (
    COLOURS,
    DARK,
    FOLKLORE_COLOUR,
    MU_LABEL,
    PAGE,
    described,
    new_figure,
    pale,
    per_rev,
    percent,
    root_figure,
    settle,
    styled,
    wide,
    write_footer,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["FOLKLORE", "RotorRows", "validity_summary"]

FOLKLORE = (0.3, 0.4)
"""The advance ratios up to which the simple model is commonly said to hold."""
BARS = {"regressing": (0.30, 0.34), "coning": (0.69, 0.11), "advancing": (0.84, 0.11)}
"""Top and height of a mode's bar in its rotor's row, which is 1 high."""
LOCK = (0.27, 0.71)
ROW = 0.52  # inches


class RotorRows(NamedTuple):
    """A rotor's name, its rows of the table ``points`` and of the table ``limits``."""

    name: str
    points: Rows
    limits: Rows


@styled
def validity_summary(rotors: Sequence[RotorRows], *, ax: Axes | None = None, width: float = PAGE) -> Axes:
    """For every rotor the ranges of μ in which the TPP modes hold or fail, with locks and the folklore band.

    Bars end where the rows or the limits of a rotor do, whichever is first: beyond, its locks are not known.
    """
    found = [_failings(rotor) for rotor in rotors]
    every = [limit for limits in found for limit in limits.values()]
    own = ax is None
    ax = new_figure(width, 1.2 + ROW * len(rotors)).subplots() if ax is None else ax
    ends = [_end(rotor, limits) for rotor, limits in zip(rotors, found, strict=True)]
    end = max(ends)
    ax.set(xlim=(0.0, end), ylim=(len(rotors) + 0.12, 0.0), xlabel=MU_LABEL)
    _folklore(ax)
    for row, (rotor, limits) in enumerate(zip(rotors, found, strict=True)):
        _bars(ax, row, rotor.points, limits, ends[row])
    _frame(ax, rotors)
    _head(ax, {limit.tolerance for limit in every}, locked=any(lock_bands(r.points) for r in rotors))
    if own:
        write_footer(root_figure(ax), _notes(rotors, ends))
    settle(ax)
    labels = Labels(ax, avoid_lines=False, margin=2.0)
    for row, (rotor, limits) in enumerate(zip(rotors, found, strict=True)):
        _label_row(labels, row, rotor, limits, end, ends[row])
    return ax


def _end(rotor: RotorRows, limits: Mapping[str, Failing]) -> float:
    """The last μ that is known: of the rows and of the limits."""
    return min(span(rotor.points)[1], max(limit.mu_max for limit in limits.values()))


def _notes(rotors: Sequence[RotorRows], ends: Sequence[float]) -> str:
    """What the bars do not show by themselves: modes judged against a mean, and the mode left out."""
    mean = [mode for mode in BARS if any(_against_mean(r.points, mode, e) for r, e in zip(rotors, ends, strict=True))]
    modes = " and ".join(filter(None, [", ".join(mean[:-1]), *mean[-1:]]))
    verb = "is" if len(mean) == 1 else "are"
    notes = [f"Inside a lock, {modes} {verb} held against the pair's mean."] if mean else []
    if any("differential" in modes_of(rotor.points) for rotor in rotors):
        notes.append("Differential is not shown.")
    return " ".join(notes)


def _against_mean(rows: Rows, mode: str, end: float) -> bool:
    return mode in modes_of(rows) and bool(np.any((rows[f"rule_{mode}"] == Rule.MEAN) & (rows["advance_ratio"] <= end)))


def _failings(rotor: RotorRows) -> dict[str, Failing]:
    checked(rotor.points, rotor.name)
    found = {mode: failing(rotor.limits, mode) for mode in BARS if mode in modes_of(rotor.points)}
    limits = {mode: limit for mode, limit in found.items() if limit is not None}
    if len(limits) < len(found) or not found:
        sentence = f"no limits of {rotor.name!r} are stored: run its study with a relative tolerance"
        raise ParameterError("rotor", rotor.name, sentence)
    return limits


def _folklore(ax: Axes) -> None:
    ax.axvspan(*FOLKLORE, color=FOLKLORE_COLOUR, alpha=0.45, lw=0, zorder=0, gid="folklore")
    for mu in FOLKLORE:
        ax.axvline(mu, color="#8A7F00", lw=0.6, ls=(0, (3, 2)), zorder=4, gid="folklore edge")


def _bars(ax: Axes, row: int, rows: Rows, limits: Mapping[str, Failing], end: float) -> None:
    """Full colour where a mode holds, pale where it fails, hatched over the locks."""
    for mode, limit in limits.items():
        top, height = BARS[mode]
        style: dict[str, Any] = {"height": height, "align": "edge", "lw": 0}
        ax.barh(row + top, end, color=COLOURS[mode], zorder=2, gid=f"holds {mode}", **style)
        for enter, leave in all_intervals(rows, mode, limit):
            if enter < end:
                ax.barh(row + top, min(leave, end) - enter, left=enter, color=pale(COLOURS[mode]), zorder=2.5,
                        gid=f"fails {mode}", **style)  # fmt: skip
    for enter, leave, lock in _locks(rows, end):
        ax.barh(row + LOCK[0], leave - enter, left=enter, height=LOCK[1], align="edge", fill=False,
                hatch="////", ec="0.3", lw=0.0, zorder=3, gid=f"lock {lock:g}")  # fmt: skip


def _locks(rows: Rows, end: float) -> list[Band]:
    """Lock bands up to an end."""
    return [(enter, min(leave, end), lock) for enter, leave, lock in lock_bands(rows) if enter < end]


def _frame(ax: Axes, rotors: Sequence[RotorRows]) -> None:
    beside = wide(root_figure(ax))
    names = [f"{r.name}\n" + described(r.points).replace(" per rev", "") for r in rotors]
    ax.set_yticks([row + 0.5 for row in range(len(rotors))] if beside else [], names if beside else [], fontsize=7.0)
    ax.tick_params(axis="y", length=0)
    ax.xaxis.set_major_locator(MultipleLocator(0.1 if beside else 0.2))
    ax.spines[["top", "right", "left"]].set_visible(False)


def _head(ax: Axes, tolerances: set[float], *, locked: bool) -> None:
    tolerance = " or ".join(percent(t) for t in sorted(tolerances))
    handles = [
        Patch(color="0.35", label=f"TPP within {tolerance} of Floquet"),
        Patch(color=pale("0.35"), label="TPP fails"),
    ]
    if locked:
        handles.append(Patch(fill=False, hatch="//////", ec="0.3", lw=0.0, label="Floquet locked"))
    band = f"rule of thumb, {FOLKLORE[0]:g} to {FOLKLORE[1]:g}"
    handles.append(Patch(color=FOLKLORE_COLOUR, alpha=0.45, label=band))
    columns = 4 if wide(root_figure(ax)) else 2
    ax.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=columns, frameon=False, borderaxespad=0.2,
        handlelength=1.6, columnspacing=1.2, handletextpad=0.5, fontsize=7.0 if columns == 4 else 6.5,
    )  # fmt: skip


def _label_row(
    labels: Labels, row: int, rotor: RotorRows, limits: Mapping[str, Failing], right: float, end: float
) -> None:
    """The regressing limit at its end, the locks' frequencies above their bars, the modes' names at the right."""
    ax, beside = labels.ax, wide(root_figure(labels.ax))
    if not beside:
        text = f"{rotor.name}:  " + described(rotor.points).replace(" per rev", "")
        labels.put(text, [(0.0, row + 0.27)], sides=((1, 1),), distance=0.8, fontsize=6.0)
    for mode in limits:
        top, height = BARS[mode]
        size = 6.5 if mode == "regressing" and beside else 5.5
        ax.annotate(
            mode, (1.0, row + top + 0.5 * height), (3.0, 0.0), xycoords=("axes fraction", "data"), va="center",
            textcoords="offset points", ha="left", fontsize=size, color=COLOURS[mode], annotation_clip=False,
        )  # fmt: skip
    if "regressing" in limits:
        _write_limit(ax, row, limits["regressing"], right, end)
    for a, b, lock in _locks(rotor.points, end):
        text = f"lock, {per_rev(lock)}" if beside else per_rev(lock).replace(" per ", "/")
        anchors = [(a, row + 0.27)] if beside else [(b, row + 0.27), (0.5 * (a + b), row + 0.27), (a, row + 0.27)]
        sides: tuple[Side, ...] = ((1, 1), (-1, 1)) if beside else ((-1, 1), (0, 1), (1, 1))
        labels.put(text, anchors, sides=sides, distance=0.8, fontsize=6.0, color=DARK, optional=not beside)


def _write_limit(ax: Axes, row: int, limit: Failing, right: float, end: float) -> None:
    """Inside the bar if it is long enough, on its colour, so that no hatching crosses it."""
    top, height = BARS["regressing"]
    at = min(limit.limit, end)
    inside = at > 0.14 * right
    ax.annotate(
        f"{limit.limit:.3f}" if limit.limit <= end else f"no limit up to {end:g}",
        (at, row + top + 0.5 * height), (-4.0 if inside else 4.0, 0.0), va="center",
        textcoords="offset points", ha="right" if inside else "left", fontsize=7.0, weight="bold", zorder=6,
        color="white" if inside else "black", gid="limit",
        bbox={"boxstyle": "square,pad=0.15", "fc": COLOURS["regressing"] if inside else "white", "lw": 0.0},
    )  # fmt: skip
