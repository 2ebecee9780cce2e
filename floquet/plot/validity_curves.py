"""Errors against the advance ratio and limits against the Lock number, of several rotors or models at once.

A figure is a table of panels:

=================  ===================================================================================================
:class:`Errors`    relative errors of a mode against μ, with the tolerances and the folklore band; or, in two
                   logarithms, with powers of μ beside them
:class:`Limits`    the μ at which a mode fails first, against γ; the marker says how the two models differ there
:class:`Locks`     the windows in μ in which the exact exponents of the same rotors are locked
=================  ===================================================================================================
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MultipleLocator, NullFormatter
from numpy.typing import NDArray

from floquet.comparison import Cause, Rule
from floquet.plot.curves import Band
from floquet.plot.labels import Labels, along
from floquet.plot.parts import (
    DARK,
    DASHED,
    DOTTED,
    FOLKLORE_COLOUR,
    LOCKED,
    PAGE,
    SMALL,
    new_figure,
    pale,
    per_rev,
    percent,
    settle,
    shade,
    styled,
    write_footer,
)
from floquet.plot.summary import FOLKLORE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Curve", "Errors", "Limits", "Locks", "Series", "validity_figure"]

Array = NDArray[np.float64]
COLOURS = (DARK, "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9")
"""Of the series or curves of a panel; the first is what the others are held against."""
MARKERS = {
    Cause.DRIFT: ("o", "both oscillate, drifted apart"),
    Cause.TPP_SPLIT: ("^", "simple model split, Floquet not locked"),
    Cause.LOCK: ("s", "Floquet locked, simple model not split"),
    Cause.DRIFT_IN_LOCK: ("D", "both split, drifted apart"),
    Cause.STABILITY: ("X", "one stable, the other not"),
}
"""What differs in kind at a limit: the marker, and what it means."""
TOLERANCES = (0.01, 0.05, 0.1)
BESIDE = 2  # panels in a row that leave room for names beside the curves
NONE, TOP = 1.08, 1.15  # where a rotor without a limit is drawn, and the end of the axis


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """Errors of one rotor or model along μ; an ``order`` adds this power of μ through the first point."""

    label: str
    mu: Array
    error: Array
    colour: str = ""
    dashed: bool = False
    order: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Rotors that differ in γ: limits (inf = none), causes, whether held against a mean, and lock windows."""

    label: str
    lock_number: Sequence[float]
    limit: Sequence[float] = ()
    cause: Sequence[Cause] = ()
    mean: Sequence[bool] = ()
    windows: Sequence[Sequence[Band]] = ()

    @classmethod
    def of(cls, label: str, records: Sequence[Mapping[str, Any]]) -> Series:
        """From records with the names of :class:`~floquet.validity.Limit`, lock_number and lock_windows."""
        names = ("lock_number", "limit", "cause", "rule", "lock_windows")
        gamma, limit, cause, rule, windows = ([record[name] for record in records] for name in names)
        mean = [one == Rule.MEAN for one in rule]
        return cls(label=label, lock_number=gamma, limit=limit, cause=cause, mean=mean, windows=windows)


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """``locks`` are shaded; errors below ``lowest`` are not drawn; two ``logarithms`` are for small μ.

    ``dashed`` says what dashed curves are.
    """

    title: str
    curves: Sequence[Curve]
    locks: Sequence[Band] = ()
    lowest: float = 1e-4
    logarithms: bool = False
    dashed: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Limits:
    """Limits of one mode at a tolerance."""

    title: str
    series: Sequence[Series]
    tolerance: float = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Locks:
    """Lock windows."""

    title: str
    series: Sequence[Series]


Panel = Errors | Limits | Locks
BESIDE_EACH_OTHER = {
    Limits: r"Points of one $\gamma$ stand side by side.",
    Locks: "In the lowest row a thin line is a rotor, a bar the part in which it is locked.",
}
"""What the footer says of a kind of panel."""


@styled
def validity_figure(
    rows: Sequence[Sequence[Panel]], *, note: str = "", width: float = PAGE, height: float | None = None
) -> Figure:
    """Draw panels in rows of equal length, over a ``note``; the series of a column are named above its first panel."""
    figure = new_figure(width, (0.31 * len(rows) + 0.12) * width if height is None else height)
    panels = [panel for row in rows for panel in row]
    kinds = [text for kind, text in BESIDE_EACH_OTHER.items() if any(isinstance(panel, kind) for panel in panels)]
    write_footer(figure, " ".join([note, *kinds]).strip())
    axes = figure.subplots(len(rows), len(rows[0]), squeeze=False)
    places = [(i, j, panel) for i, row in enumerate(rows) for j, panel in enumerate(row)]
    for i, j, panel in places:
        ax: Axes = axes[i, j]
        ax.set_title(panel.title, loc="left")
        if isinstance(panel, Errors):
            _draw_errors(ax, panel, outer=j == 0)
            if len(rows[i]) > BESIDE:
                _name_above(ax, [(c.label, colour) for c, colour in zip(panel.curves, _colours(panel), strict=True)])
            continue
        if isinstance(panel, Limits):
            _draw_limits(ax, panel, outer=j == 0)
        else:
            _draw_locks(ax, panel, outer=j == 0)
        _frame(ax, panel.series, bottom=i == len(rows) - 1)
        if i == 0 or _names(rows[i - 1][j]) != _names(panel):
            _name_above(ax, [(s.label, colour) for s, colour in zip(panel.series, COLOURS, strict=False)])
    if handles := _handles([panel for *_, panel in places]):
        figure.legend(handles=handles, loc="outside upper left", ncols=3, frameon=False, handletextpad=0.6,
                  columnspacing=1.6, borderaxespad=0.3)  # fmt: skip
    for i, j, panel in places:
        if isinstance(panel, Errors) and len(rows[i]) <= BESIDE:
            settle(axes[i, j])
            _label_errors(axes[i, j], panel)
    return figure


def _names(panel: Panel) -> list[str]:
    return [] if isinstance(panel, Errors) else [series.label for series in panel.series]


def _handles(panels: Sequence[Panel]) -> list[Any]:
    """What markers, lines and shades mean, of those that are drawn."""
    errors = [p for p in panels if isinstance(p, Errors)]
    series = [s for p in panels if isinstance(p, Limits) for s in p.series]
    limits = [(c, m) for s in series for x, c, m in zip(s.limit, s.cause, _means(s), strict=True) if math.isfinite(x)]
    style: dict[str, Any] = {"color": DARK, "lw": 0, "ms": 4.0, "mew": 0.9}
    found: list[Any] = [
        Line2D([], [], marker=marker, label=text, **style)
        for cause, (marker, text) in MARKERS.items()
        if cause in {c for c, _ in limits}
    ]
    if any(mean for _, mean in limits):
        found.append(Line2D([], [], marker="s", mfc="white", label="open: against a locked pair's mean", **style))
    if any(p.locks for p in errors):
        found.append(Patch(color=LOCKED, label="Floquet locked"))
    locked = {rho for p in panels if isinstance(p, Locks) for s in p.series for w in s.windows for *_, rho in w}
    found += [Patch(label=f"Floquet locked at {per_rev(rho)}", **_lock_style("#555555", rho)) for rho in sorted(locked)]
    for text in dict.fromkeys(p.dashed for p in errors if p.dashed):
        found.append(Line2D([], [], color=DARK, lw=1.2, ls=DASHED, label=text))
    if any(c.order for p in errors for c in p.curves):
        found.append(Line2D([], [], color=DARK, lw=0.8, ls=DOTTED, label=r"power of $\mu$ through the first point"))
    if not all(p.logarithms for p in errors) or len(errors) < len(panels):
        band = f"rule of thumb, {FOLKLORE[0]:g} to {FOLKLORE[1]:g}"
        found.append(Patch(color=FOLKLORE_COLOUR, alpha=0.45, label=band))
    return found


# ---------------------------------------------------------------------- limits and locks
def _means(series: Series) -> Sequence[bool]:
    return series.mean or [False] * len(series.limit)


def _beside(series: Sequence[Series], index: int) -> Array:
    """γ of the rotors, moved a little so that those of all series stand beside each other."""
    gamma = np.asarray(series[index].lock_number, float)
    step = float(np.diff(gamma).min()) if gamma.size > 1 else 1.0
    return gamma + 0.2 * step * (index - 0.5 * (len(series) - 1))


def _draw_limits(ax: Axes, panel: Limits, *, outer: bool) -> None:
    ax.axhspan(*FOLKLORE, color=FOLKLORE_COLOUR, alpha=0.45, lw=0, zorder=0, gid="folklore")
    ax.axhline(1.0, color=DARK, lw=0.5, zorder=0.5)
    for index, (series, colour) in enumerate(zip(panel.series, COLOURS, strict=False)):
        x, limit = _beside(panel.series, index), np.asarray(series.limit, float)
        ax.plot(x, np.where(np.isfinite(limit), limit, NONE), color=pale(colour), lw=0.9, zorder=2, gid="limits")
        for at, y, cause, mean in zip(x, limit, series.cause, _means(series), strict=True):
            if math.isfinite(y):
                ax.plot([at], [y], MARKERS[cause][0], color=colour, mfc="white" if mean else colour, ms=3.4, mew=0.8,
                        zorder=3, gid=f"limit {cause.name}")  # fmt: skip
            else:
                ax.plot([at], [NONE], "_", color=colour, ms=4.5, mew=1.6, zorder=3, gid="no limit")
    ax.set_yticks([0.0, 0.2, 0.4, 0.6, 0.8, 1.0, NONE], ["0", "0.2", "0.4", "0.6", "0.8", "1", "none"])
    if outer:
        ax.set_ylabel(rf"$\mu$ of an error of {percent(panel.tolerance)}")


def _draw_locks(ax: Axes, panel: Locks, *, outer: bool) -> None:
    ax.axhspan(*FOLKLORE, color=FOLKLORE_COLOUR, alpha=0.45, lw=0, zorder=0, gid="folklore")
    for index, (series, colour) in enumerate(zip(panel.series, COLOURS, strict=False)):
        for x, windows in zip(_beside(panel.series, index), series.windows, strict=True):
            ax.plot([x, x], [0.0, 1.0], color=pale(colour), lw=0.5, zorder=1)
            for enter, leave, rho in windows:
                ax.bar(x, min(leave, 1.0) - enter, bottom=enter, width=0.3, zorder=2, gid=f"lock {rho:g}",
                       **_lock_style(colour, rho))  # fmt: skip
    ax.set_yticks([0.0, 0.2, 0.4, 0.6, 0.8, 1.0], ["0", "0.2", "0.4", "0.6", "0.8", "1"])
    if outer:
        ax.set_ylabel(r"$\mu$ inside a lock")


def _lock_style(colour: str, rho: float) -> dict[str, Any]:
    """1 per rev filled, ½ pale, others hatched."""
    face = {1.0: colour, 0.5: pale(colour)}.get(rho, "white")
    return {"facecolor": face, "edgecolor": colour, "lw": 0.6, "hatch": "" if rho in (0.5, 1.0) else "//////"}


def _frame(ax: Axes, series: Sequence[Series], *, bottom: bool) -> None:
    gamma = np.concatenate([np.asarray(one.lock_number, float) for one in series])
    ax.set(xlim=(gamma.min() - 1.0, gamma.max() + 1.0), ylim=(0.0, TOP))
    ax.xaxis.set_major_locator(MultipleLocator(2.0))
    ax.tick_params(labelbottom=bottom)
    if bottom:
        ax.set_xlabel(r"Lock number $\gamma$")


def _name_above(ax: Axes, names: Sequence[tuple[str, str]]) -> None:
    """Labels and colours between title and panel."""
    handles = [Line2D([], [], color=colour, lw=1.6, label=label.replace("-", "−")) for label, colour in names]
    ax.set_title(ax.get_title(loc="left"), loc="left", pad=15.5)
    ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=len(handles), frameon=False,
              borderaxespad=0.1, handlelength=1.0, columnspacing=0.8, handletextpad=0.3)  # fmt: skip


# ---------------------------------------------------------------------- errors
def _colours(panel: Errors) -> list[str]:
    return [curve.colour or COLOURS[i % len(COLOURS)] for i, curve in enumerate(panel.curves)]


def _shown(panel: Errors, curve: Curve) -> Array:
    return np.where(np.isfinite(curve.error) & (curve.error > panel.lowest), curve.error, np.nan)


def _draw_errors(ax: Axes, panel: Errors, *, outer: bool) -> None:
    mu = np.concatenate([curve.mu for curve in panel.curves])
    low, high = float(mu.min()), float(mu.max())
    for curve, colour in zip(panel.curves, _colours(panel), strict=True):
        ax.plot(curve.mu, _shown(panel, curve), color=colour, lw=1.2, ls=DASHED if curve.dashed else "-", zorder=3,
                label=curve.label)  # fmt: skip
        if curve.order:
            power = curve.error[0] * (curve.mu / curve.mu[0]) ** curve.order
            ax.plot(curve.mu, power, color=DARK, lw=0.8, ls=DOTTED, zorder=2.5, label=f"_order {curve.order}")
    ax.set(xlim=(low, high), yscale="log", ylim=(panel.lowest, 1.0), xlabel=r"advance ratio $\mu$")
    if panel.logarithms:
        ax.set_xscale("log")
    else:
        ax.axvspan(*FOLKLORE, color=FOLKLORE_COLOUR, alpha=0.45, lw=0, zorder=0, gid="folklore")
        shade(ax, panel.locks, high)
        for tolerance in TOLERANCES:
            ax.axhline(tolerance, color=DARK, lw=0.6, ls=DASHED, zorder=1.5, gid="tolerance", label="_tolerance")
        decades = [10.0**n for n in range(round(math.log10(panel.lowest)), 1)]
        ax.set_yticks([*decades, 0.05] if len(decades) < 6 else decades)
        ax.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{100.0 * y:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    if outer:
        ax.set_ylabel("error of the eigenvalue" + (", relative" if panel.logarithms else " (%)"))


def _label_errors(ax: Axes, panel: Errors) -> None:
    labels = Labels(ax)
    for curve, colour in zip(panel.curves, _colours(panel), strict=True):
        labels.put(curve.label, along(curve.mu, _shown(panel, curve), 60), color=colour, fontsize=SMALL)
