"""Eigenvalues and errors of one rotor against the advance ratio."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator, NullFormatter
from numpy.typing import NDArray

from floquet.comparison import Rule
from floquet.plot.at_edges import Errors, errors_of
from floquet.plot.curves import (
    Array,
    Exact,
    Failing,
    Pair,
    Rows,
    checked,
    exact_curves,
    failing,
    span,
    tpp_curves,
)  # fmt: skip
from floquet.plot.labels import ABOVE_BELOW, Labels, along
from floquet.plot.parts import (
    COLOURS,
    COLUMN,
    DARK,
    DASH_DOT,
    DASHED,
    DOTTED,
    LOCKED,
    MU_LABEL,
    PAGE,
    SMALL,
    UNSTABLE,
    draw_pair,
    headline,
    in_drawing_order,
    limit_text,
    line_handles,
    name_bands,
    new_figure,
    percent,
    settle,
    shade,
    styled,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["eigenvalues_vs_mu", "error_vs_mu"]

LOWEST = 1e-4  # errors below are not shown
TOLERANCES = (0.01, 0.05, 0.1)


# ---------------------------------------------------------------------- eigenvalues
@styled
def eigenvalues_vs_mu(rows: Rows, limits: Rows | None = None, *, name: str = "", axes: Sequence[Axes] | None = None,
                      width: float = PAGE) -> tuple[Axes, Axes]:  # fmt: skip
    """Frequency above, damping below, of every mode of one rotor.

    Parameters
    ----------
    rows, limits
        Columns of the tables ``points`` and ``limits``.
    axes
        Two Axes; None makes a figure of ``width`` inches.
    """
    rows = checked(rows, name)
    if axes is None:
        figure = new_figure(width, max(0.62 * width, 1.4 * COLUMN))
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.35, 1.0))
    else:
        upper, lower = axes
    exact, simple = exact_curves(rows), tpp_curves(rows)
    regressing = failing(limits, "regressing")
    _draw_eigenvalues(upper, lower, exact, simple, span(rows)[1])
    _frame_eigenvalues(upper, lower, span(rows))
    handles = line_handles() + _mark_limit(upper, lower, regressing, span(rows)[1])
    if exact.bands:
        handles.append(Patch(color=LOCKED, label="Floquet locked"))
    headline(upper, rows, name, handles)
    settle(upper)
    _label_frequencies(upper, exact, simple, regressing, span(rows)[1])
    _label_dampings(lower, exact, simple, span(rows))
    return upper, lower


def _draw_eigenvalues(upper: Axes, lower: Axes, exact: Exact, simple: Mapping[str, Pair], end: float) -> None:
    for ax in (upper, lower):
        shade(ax, exact.bands, end)
    for mode in in_drawing_order(list(simple)):
        draw_pair(upper, None, np.imag, (exact.mu, exact.mode(mode)), mode, "Floquet")
        draw_pair(upper, None, np.imag, simple[mode], mode, "TPP")
        draw_pair(lower, None, lambda z: -z.real, simple[mode], mode, "TPP")
    mu, sigma = exact.mu, exact.sigma
    both = np.r_[mu, np.nan, mu], -np.r_[sigma[:, 0], np.nan, sigma[:, 1]]
    lower.plot(*both, color=DARK, lw=1.6, zorder=3, label="Floquet, every mode")


def _frame_eigenvalues(upper: Axes, lower: Axes, across: tuple[float, float]) -> None:
    top = max(float(np.nanmax(np.asarray(line.get_ydata(), float))) for line in upper.lines)
    upper.set(xlim=across, ylim=(-0.03 * top, 1.12 * top), ylabel=r"frequency $|$Im $\eta\,|$ (per rev)")
    upper.yaxis.set_major_locator(MultipleLocator(0.5))
    upper.tick_params(labelbottom=False)
    values = np.concatenate([np.asarray(line.get_ydata(), float) for line in lower.lines])
    low, high = min(float(np.nanmin(values)), 0.0), max(float(np.nanmax(values)), 0.0)
    room = 0.13 * (high - low)
    lower.set(xlim=across, ylim=(low - room, high + room), xlabel=MU_LABEL)
    lower.set_ylabel(r"damping $-$Re $\eta$ (per rev)")
    lower.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    lower.axhspan(low - room, 0.0, color=UNSTABLE, lw=0, zorder=0.2, gid="unstable")


def _mark_limit(upper: Axes, lower: Axes, found: Failing | None, end: float) -> list[Any]:
    """A line where the TPP fails first, and a strip at the top where it fails; what the legend says of it."""
    if found is None:
        return []
    if not found.intervals:
        return []
    for ax in (upper, lower):
        ax.axvline(found.limit, color="black", lw=0.9, ls=DOTTED, zorder=2, gid="limit", label="_limit")
    for enter, leave in found.intervals:
        upper.axvspan(enter, min(leave, end), ymin=0.975, color=COLOURS["regressing"], lw=0, zorder=4, gid="failing")
    return [Patch(color=COLOURS["regressing"], label=f"regressing error > {percent(found.tolerance)}")]


def _label_frequencies(ax: Axes, exact: Exact, simple: Mapping[str, Pair], found: Failing | None, end: float) -> None:
    labels = Labels(ax)
    name_bands(labels, exact.bands, end, 0.965)
    if found is not None and found.intervals:
        heights = [(found.limit, f * ax.get_ylim()[1]) for f in (0.75, 0.68, 0.9, 0.6, 0.4, 0.3, 0.25, 0.2, 0.15)]
        _write_limit(labels, "limit ", found, heights, sides=((-1, 0), (1, 0)), color="black")
    if found is not None and not found.intervals:
        _write_no_limit(labels, found, [0.5 * y for y in range(1, 6)])
    for mode in simple:
        if mode != "differential":
            text = "coning, differential" if mode == "coning" and "differential" in simple else mode
            anchors = along(exact.mu, exact.mode(mode)[:, 0].imag)
            labels.put(text, anchors, sides=ABOVE_BELOW, color=COLOURS[mode], fontsize=SMALL)


def _write_limit(
    labels: Labels, before: str, found: Failing, anchors: Sequence[tuple[float, float]], **style: Any
) -> None:
    """The limit with its cause where there is room, else without."""
    text, short = before + limit_text(found), before + limit_text(found, cause=False)
    if labels.put(text, anchors, optional=True, fontsize=SMALL, **style) is None:
        labels.put(short, anchors, fontsize=SMALL, **style)


def _label_dampings(ax: Axes, exact: Exact, simple: Mapping[str, Pair], across: tuple[float, float]) -> None:
    labels = Labels(ax)
    anchors = along(exact.mu, -exact.sigma[:, 0])
    labels.put("Floquet, every mode", anchors, sides=ABOVE_BELOW, color=DARK, fontsize=SMALL)
    for mode, (x, z) in simple.items():
        anchors = along(x, -z[:, 0].real) + along(x, -z[:, 1].real)
        labels.put(mode, anchors, sides=ABOVE_BELOW, color=COLOURS[mode], fontsize=SMALL, optional=True)
    corners = [(across[0], 0.0), (across[1], 0.0)]
    labels.put("unstable", corners, sides=((1, -1), (-1, -1)), distance=1.5, fontsize=SMALL, color=DARK, optional=True)


# ---------------------------------------------------------------------- errors
@styled
def error_vs_mu(rows: Rows, limits: Rows | None = None, *, name: str = "", ax: Axes | None = None,
                width: float = PAGE, options: Mapping[str, Any] | None = None) -> Axes:  # fmt: skip
    """Relative errors of the TPP modes of one rotor on a logarithmic scale, with tolerances and their crossings.

    ``options`` are the keywords of ``compare`` that the rows were made with: by them the errors are computed at and
    beside lock edges and splits of the TPP.
    """
    rows = checked(rows, name)
    ax = new_figure(width, max(0.55 * width, COLUMN)).subplots() if ax is None else ax
    errors, (start, end) = errors_of(rows, options or {}), span(rows)
    bands = errors.bands
    shade(ax, bands, end)
    _mark_splits(ax, errors)
    found = {mode: failing(limits, mode) for mode in in_drawing_order(list(errors.error))}
    curves = {mode: _error_curve(errors, mode, limit) for mode, limit in found.items()}
    for mode, curve in curves.items():
        _draw_error(ax, mode, *curve)
    highest = max((float(np.nanmax(error, initial=0.0)) for _, error, _ in curves.values()), default=0.0)
    ax.set(xlim=(start, end), yscale="log", ylim=(LOWEST, max(1.0, 3.0 * highest)), xlabel=MU_LABEL)
    ax.set_ylabel(r"error of the TPP eigenvalue, $|s-\eta|\,/\,|\eta|$ (%)")
    ax.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{100.0 * y:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    _tolerance_lines(ax)
    _mark_crossings(ax, found)
    headline(ax, rows, name, _error_handles(errors, any(mean.any() for *_, mean in curves.values())), narrow=1)
    settle(ax)
    labels = Labels(ax)
    name_bands(labels, bands, end, 0.985)
    _label_errors(labels, curves, found)
    return ax


def _mark_splits(ax: Axes, errors: Errors) -> None:
    """A hatched strip at the bottom where a TPP pair is split, and a line up from each end."""
    for a, b in errors.splits:
        ax.axvspan(a, b, ymax=0.035, fill=False, hatch="//////", ec=DARK, lw=0.0, zorder=1.0, gid="TPP split")
        for edge in (a, b):
            if errors.mu[0] < edge < errors.mu[-1]:
                ax.axvline(edge, color=DARK, lw=0.6, ls=DASH_DOT, zorder=1.2, gid="split edge", label="_split")


def _error_curve(errors: Errors, mode: str, found: Failing | None) -> tuple[Array, Array, NDArray[np.bool_]]:
    """μ, error, and whether it is against the mean; through the crossings of the tolerance that the limits know."""
    mu, error, mean = errors.mu, errors.error[mode], errors.rule[mode] == Rule.MEAN
    if found is not None:
        ends = np.array([x for pair in found.intervals for x in pair if mu[0] < x < mu[-1] and x not in mu], float)
        index = np.searchsorted(mu, ends)
        mean = np.insert(mean, index, mean[np.minimum(index, len(mean) - 1)])
        mu, error = np.insert(mu, index, ends), np.insert(error, index, found.tolerance)
    return mu, np.where((error > 0) & np.isfinite(error), error, np.nan), mean


def _draw_error(ax: Axes, mode: str, mu: Array, error: Array, mean: NDArray[np.bool_]) -> None:
    style: dict[str, Any] = {"color": COLOURS[mode], "lw": 1.8 if mode == "regressing" else 1.2, "zorder": 3}
    ax.plot(mu, np.where(mean, np.nan, error), label=mode, **style)
    if mean.any():  # with the points next to it, so that it joins the rest
        joined = mean | np.r_[False, mean[:-1]] | np.r_[mean[1:], False]
        ax.plot(mu, np.where(joined, error, np.nan), ls=DOTTED, label=f"{mode}, against the mean", **style)


def _error_handles(errors: Errors, mean: bool) -> list[Any]:
    handles: list[Any] = [Patch(color=LOCKED, label="Floquet locked")] if errors.bands else []
    if errors.splits:
        handles.append(Patch(fill=False, hatch="//////", ec=DARK, lw=0.0, label="a TPP pair is split"))
    if mean:
        handles.append(Line2D([], [], color=DARK, lw=1.4, ls=DOTTED, label="against a locked pair's mean"))
    return handles


def _tolerance_lines(ax: Axes) -> None:
    for tolerance in TOLERANCES:
        ax.axhline(tolerance, color=DARK, lw=0.6, ls=DASHED, zorder=1.5, gid="tolerance", label="_tolerance")
        ax.annotate(
            percent(tolerance), (1.0, tolerance), (3.0, 0.0), xycoords=("axes fraction", "data"), va="center",
            textcoords="offset points", ha="left", fontsize=SMALL, color=DARK, annotation_clip=False,
        )  # fmt: skip


def _mark_crossings(ax: Axes, found: Mapping[str, Failing | None]) -> None:
    """A dot at every mode's limit, and a line down from the regressing one's."""
    for mode, limit in found.items():
        if limit is None or not limit.intervals:
            continue
        ax.plot([limit.limit], [limit.tolerance], "o", ms=4.0, color=COLOURS[mode], mec="white", mew=0.6, zorder=5,
                gid=f"limit {mode}", label="_limit")  # fmt: skip
        if mode == "regressing":
            ax.plot([limit.limit] * 2, [LOWEST, limit.tolerance], color="black", lw=0.9, ls=DOTTED, zorder=2,
                    gid="limit", label="_limit")  # fmt: skip


def _label_errors(
    labels: Labels, curves: Mapping[str, tuple[Array, Array, Any]], found: Mapping[str, Failing | None]
) -> None:
    regressing = found.get("regressing")
    if regressing is not None and regressing.intervals:
        heights = (regressing.tolerance, *np.geomspace(0.8 * regressing.tolerance, 2.0 * LOWEST, 12).tolist())
        anchors = [(regressing.limit, y) for y in heights]
        _write_limit(labels, "", regressing, anchors, distance=4.0, color=COLOURS["regressing"])
    for mode, limit in found.items():
        if limit is not None and limit.intervals and mode != "regressing":
            anchors = [(limit.limit, limit.tolerance)]
            labels.put(f"{limit.limit:.3f}", anchors, distance=4.0, fontsize=SMALL, color=COLOURS[mode], optional=True)
    for mode, (mu, error, _) in curves.items():
        shown = np.where(error > 1.5 * LOWEST, error, np.nan)
        labels.put(mode, along(mu, shown), color=COLOURS[mode], fontsize=SMALL)
    if regressing is not None and not regressing.intervals:
        _write_no_limit(labels, regressing, [regressing.tolerance, 0.1, 0.5], optional=True)


def _write_no_limit(labels: Labels, found: Failing, heights: Sequence[float], *, optional: bool = False) -> None:
    """At the left or the right end, on one of some heights."""
    text = f"regressing within {percent(found.tolerance)} up to $\\mu$ = {found.mu_max:g}"
    anchors = [(x, y) for y in heights for x in labels.ax.get_xlim()]
    style: dict[str, Any] = {"fontsize": SMALL, "color": COLOURS["regressing"], "optional": optional}
    labels.put(text, anchors, sides=((1, 1), (-1, 1)), **style)
