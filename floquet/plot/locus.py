"""Root locus of one rotor: its eigenvalues' paths in the upper half plane, with the advance ratio marked along them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator
from matplotlib.transforms import Bbox

from floquet.plot.curves import Array, Complex, Failing, Rows, checked, exact_curves, failing, span, tpp_curves
from floquet.plot.labels import Labels, along
from floquet.plot.parts import (
    COLOURS,
    DARK,
    MM,
    PAGE,
    SMALL,
    UNSTABLE,
    draw_pair,
    heading,
    headline,
    in_drawing_order,
    line_handles,
    new_figure,
    per_rev,
    percent,
    root_figure,
    settle,
    styled,
    wide,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["root_locus"]

TALLEST = 165.0 * MM


class _Path(NamedTuple):
    """What one model says of one mode: eigenvalues (n, 2) in the upper half plane along μ."""

    mode: str
    model: str
    mu: Array
    z: Complex

    @property
    def extent(self) -> Bbox:
        z = self.z[np.isfinite(self.z.real)]
        return Bbox.from_extents(z.real.min(), z.imag.min(), z.real.max(), z.imag.max())


@styled
def root_locus(rows: Rows, limits: Rows | None = None, *, name: str = "", ax: Axes | None = None,
               width: float = PAGE) -> Axes:  # fmt: skip
    """Paths of the eigenvalues of one rotor in the upper half plane, with the advance ratio marked along them.

    Rings mark both models' regressing eigenvalues at the limit.  A figure of its own (``ax=None``) that is wide enough
    shows every mode enlarged beside the whole, all at one scale.
    """
    rows = checked(rows, name)
    exact, simple = exact_curves(rows), tpp_curves(rows)
    modes = in_drawing_order(list(simple))
    paths = [_Path(mode, "Floquet", exact.mu, exact.mode(mode)) for mode in modes]
    paths += [_Path(mode, "TPP", *simple[mode]) for mode in modes]
    box = _whole(paths)
    boxes = _enlarged(paths) if ax is None and width > 0.7 * PAGE else {}
    own = ax is None
    ax, panels = _new_axes(width, box, boxes) if ax is None else (ax, {})
    limit = failing(limits, "regressing")
    for panel in (ax, *panels.values()):
        _draw(panel, paths, span(rows), limit)
    _frame(ax, box)
    _head(ax, rows, name, limit, own=own)
    settle(ax)
    _one_scale(panels, boxes)
    low = ax.get_window_extent().height < 1.5 * root_figure(ax).dpi
    _label_whole(ax, paths, box, () if panels or low else span(rows))
    for mode, panel in panels.items():
        _label_enlarged(panel, mode, paths, span(rows))
    return ax


# ---------------------------------------------------------------------- what is shown
def _whole(paths: Sequence[_Path]) -> Bbox:
    """All paths, the imaginary axis and some of the unstable half plane, never a thin strip."""
    union = Bbox.union([path.extent for path in paths])
    left, right, top = union.x0, max(union.x1, 0.0), max(union.y1, 1.0)
    y0, y1 = -0.06 * top, 1.06 * top
    x0, x1 = left - 0.08 * (right - left), right + max(0.08 * (right - left), 0.12)
    spare = max((y1 - y0) / 2.1 - (x1 - x0), 0.0)
    return Bbox.from_extents(x0 - 0.75 * spare, y0, x1 + 0.25 * spare, y1)


def _enlarged(paths: Sequence[_Path]) -> dict[str, Bbox]:
    """A box around each mode, all equally wide; none where the whole is not much larger than they are."""
    boxes = {}
    for mode in ("advancing", "coning", "regressing"):
        shown = [path for path in paths if path.mode == mode or (path.mode, mode) == ("differential", "coning")]
        if shown:
            exact, both = shown[0].extent, Bbox.union([path.extent for path in shown])
            reach = max(0.5 * exact.width, 0.1)
            left, right = max(both.x0, exact.x0 - reach), min(both.x1, exact.x1 + reach)
            boxes[mode] = Bbox.from_extents(left, both.y0, right, both.y1)
    left, right = min(b.x0 for b in boxes.values()), max(b.x1 for b in boxes.values())
    pad, least = 0.08 * (right - left), 0.2 * (right - left)
    for mode, b in boxes.items():
        above = pad + max(least - b.height, 0.0) / 2.0
        boxes[mode] = Bbox.from_extents(left - pad, b.y0 - above, right + pad, b.y1 + above)
    tall = sum(b.height for b in boxes.values())
    return boxes if tall < 0.8 * max(b.y1 for b in boxes.values()) else {}


def _new_axes(width: float, box: Bbox, boxes: Mapping[str, Bbox]) -> tuple[Axes, dict[str, Axes]]:
    """Axes for the whole and, in a column beside it, for the enlarged modes."""
    if not boxes:
        height = min(max((width - 1.2) * box.height / box.width, 1.0), TALLEST) + 1.1
        return new_figure(width, height).subplots(), {}
    heights = [b.height for b in boxes.values()]
    height = min(max(0.46 * width * sum(heights) / next(iter(boxes.values())).width, 0.5 * width), 0.9 * width)
    beside = height * box.width / box.height
    figure = new_figure(width, height + 0.9)
    grid = figure.add_gridspec(len(boxes), 2, width_ratios=(beside, width - beside - 1.6), height_ratios=heights)
    panels = {mode: figure.add_subplot(grid[i, 1]) for i, mode in enumerate(boxes)}
    for panel in list(panels.values())[:-1]:
        panel.tick_params(labelbottom=False)
    panels[next(reversed(panels))].set_xlabel(r"Re $\eta$ (per rev), enlarged")
    return figure.add_subplot(grid[:, 0]), panels


def _one_scale(panels: Mapping[str, Axes], boxes: Mapping[str, Bbox]) -> None:
    """Limits around the boxes that fill the panels at one scale, the same across as up."""
    if not panels:
        return
    frames = {mode: panel.get_window_extent() for mode, panel in panels.items()}
    scale = min(min(f.width / boxes[mode].width, f.height / boxes[mode].height) for mode, f in frames.items())
    for mode, panel in panels.items():
        box, frame = boxes[mode], frames[mode]
        x, y = 0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)
        across, up = 0.5 * frame.width / scale, 0.5 * frame.height / scale
        panel.set(xlim=(x - across, x + across), ylim=(y - up, y + up))
        panel.axvspan(0.0, max(x + across, 0.0), color=UNSTABLE, lw=0, zorder=0, gid="unstable")
        panel.set_aspect("equal", adjustable="box")


# ---------------------------------------------------------------------- drawing
def _draw(ax: Axes, paths: Sequence[_Path], across: tuple[float, float], limit: Failing | None) -> None:
    for path in paths:
        draw_pair(ax, np.real, np.imag, (path.mu, path.z), path.mode, path.model)
        at = _at(_marks(*across), path).ravel()
        colour = COLOURS[path.mode]
        ax.plot(at.real, at.imag, "o", ms=2.6, color=colour, mfc=colour if path.model == "Floquet" else "white",
                mew=0.7, zorder=4, gid=f"mu {path.model} {path.mode}", label="_mu")  # fmt: skip
        if path.mode == "regressing" and limit is not None and across[0] <= limit.limit <= across[1]:
            at = _at(np.array([limit.limit]), path).ravel()
            ax.plot(at.real, at.imag, "o", ms=6.0, color="black", mfc="none", mew=0.8, zorder=4.5,
                    gid=f"limit {path.model}", label="_limit")  # fmt: skip
    for lock in np.arange(0.0, 4.0, 0.5):
        ax.axhline(lock, color="0.6", lw=0.6, zorder=1, gid="per rev", label="_per rev")


def _marks(start: float, end: float) -> Array:
    """0, .1, .2 … between the first and the last μ."""
    return np.round(np.arange(math.ceil(10.0 * start - 1e-9), math.floor(10.0 * end + 1e-9) + 1) / 10.0, 10)


def _at(mu: Array, path: _Path) -> Complex:
    """The eigenvalues (n, 2) at some μ; nan where a member of the pair is not drawn."""
    out = np.full((len(mu), 2), complex(np.nan, np.nan))
    for member in (0, 1):
        z = path.z[:, member]
        drawn = np.isfinite(path.mu[:-1]) & np.isfinite(path.mu[1:]) & np.isfinite(z[:-1].real + z[1:].real)
        for i, value in enumerate(mu):
            cells = np.flatnonzero(drawn & (path.mu[:-1] - 1e-12 <= value) & (value <= path.mu[1:] + 1e-12))
            if cells.size:
                a = cells[0]
                t = (value - path.mu[a]) / max(path.mu[a + 1] - path.mu[a], 1e-300)
                out[i, member] = (1.0 - t) * z[a] + t * z[a + 1]
    return out


def _frame(ax: Axes, box: Bbox) -> None:
    """Limits, the unstable half plane, the imaginary axis, and names of the lines at 0, ½, 1 … per rev."""
    ax.set(xlim=(box.x0, box.x1), ylim=(box.y0, box.y1), xlabel=r"Re $\eta$ (per rev)")
    ax.set_ylabel("Im $\\eta$ (per rev)\nupper half plane")
    ax.set_aspect("equal", adjustable="box")
    ax.axvspan(0.0, box.x1, color=UNSTABLE, lw=0, zorder=0, gid="unstable")
    ax.axvline(0.0, color=DARK, lw=0.8, zorder=1, label="_axis")
    for lock in np.arange(0.0, box.y1, 0.5):
        ax.annotate(
            per_rev(float(lock)), (1.0, lock), (3.0, 0.0), xycoords=("axes fraction", "data"), va="center", ha="left",
            textcoords="offset points", fontsize=SMALL, color=DARK, annotation_clip=False,
        )  # fmt: skip
    ax.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    ax.yaxis.set_major_locator(MultipleLocator(0.5))


def _head(ax: Axes, rows: Rows, name: str, limit: Failing | None, *, own: bool) -> None:
    """Title and legend: above the figure if it is ours, else above the Axes."""
    handles = [
        *line_handles(),
        Line2D([], [], color=DARK, marker="o", ms=2.6, lw=0, label=r"$\mu$ = 0, 0.1 … (open: TPP)"),
    ]
    if limit is not None and limit.intervals:
        text = rf"regressing {percent(limit.tolerance)} limit, $\mu$ = {limit.limit:.3f}"
        handles.append(Line2D([], [], color="black", mfc="none", marker="o", ms=6.0, mew=0.8, lw=0, label=text))
    figure = root_figure(ax)
    if not own:
        headline(ax, rows, name, handles)
        return
    figure.legend(
        handles=handles, loc="outside upper left", ncols=len(handles) if wide(figure) else 2, frameon=False,
        borderaxespad=0.2, handlelength=2.2, columnspacing=1.2, handletextpad=0.5, title=heading(figure, rows, name),
        title_fontsize=8.5, alignment="left",
    )  # fmt: skip


# ---------------------------------------------------------------------- labels
def _label_whole(ax: Axes, paths: Sequence[_Path], box: Bbox, across: Sequence[float]) -> None:
    """Names of half planes and modes and, if ``across`` is given, some advance ratios."""
    labels = Labels(ax)
    heights = (0.75, 0.25, 1.25, 0.5 * box.y1)
    style: dict[str, Any] = {"rotation": 90, "fontsize": SMALL, "color": DARK}
    labels.put("unstable", [(0.5 * box.x1, y) for y in heights], sides=((0, 0),), **style)
    labels.put("stable", [(0.0, y) for y in heights], sides=((-1, 0),), **style)
    both = any(path.mode == "differential" for path in paths)
    for path in paths:
        if path.model == "Floquet" and path.mode != "differential":
            text = "coning =\ndifferential" if both and path.mode == "coning" else path.mode
            anchors = along(path.z[:, 0].real, path.z[:, 0].imag) + along(path.z[:, 1].real, path.z[:, 1].imag)
            labels.put(text, anchors, distance=5.0, color=COLOURS[path.mode], fontsize=SMALL)
    if across:
        _label_mu(labels, paths, across)


def _label_enlarged(ax: Axes, mode: str, paths: Sequence[_Path], across: Sequence[float]) -> None:
    labels = Labels(ax)
    (x, _), (low, high) = ax.get_xlim(), ax.get_ylim()
    labels.put(mode, [(x, high), (x, low)], sides=((1, -1), (1, 1)), color=COLOURS[mode], fontsize=SMALL)
    _label_mu(labels, [path for path in paths if path.mode == mode], across)


def _label_mu(labels: Labels, paths: Sequence[_Path], across: Sequence[float]) -> None:
    """Write μ beside some of its dots, ends first, where there is room: above for Floquet, below for TPP."""
    start, end = across
    chosen = dict.fromkeys((start, end, *(mu for mu in (0.5, 0.8, 0.3) if start < mu < end)))
    for path in paths:
        for mu in chosen:
            for z in _at(np.array([mu]), path)[0]:
                if np.isfinite(z.real) and path.mode != "differential":
                    anchor, up = (float(z.real), float(z.imag)), 1 if path.model == "Floquet" else -1
                    sides = ((0, up), (1, up), (-1, up), (1, 0), (-1, 0))
                    labels.put(
                        f"{mu:g}",
                        [anchor],
                        color=COLOURS[path.mode],
                        fontsize="x-small",
                        optional=True,
                        distance=2.5,
                        apart=6.0,
                        sides=sides,
                    )
