"""Strutt diagrams: in the plane of two parameters, where a system is locked and where it grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from floquet.plot.labels import Labels, Side
from floquet.plot.parts import DARK, FOLKLORE_COLOUR, FOOTER_OF_ONE, PAGE, SMALL, new_figure, settle, styled
from floquet.plot.summary import FOLKLORE
from floquet.validity import BoundaryCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Plane", "strutt"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
LOCKED, GROWING = "#DCE6F2", "#E8907A"
HATCHES = (None, "////", "\\\\\\\\", "xxxx")
"""By half turns in a period, and over again."""
HEIGHT = 3.5  # inches
HALO = [withStroke(linewidth=2.5, foreground="white")]
MARK_SIDES: tuple[Side, ...] = ((1, 0), (1, 1), (1, -1), (-1, 0), (-1, 1), (-1, -1))


@dataclass(frozen=True, eq=False, kw_only=True)
class Plane:
    """A plane of parameters.

    Attributes
    ----------
    title, across, up : str
        Of the panel and of its axes.
    x, y : (m,), (n,)
        The grid.
    turns : (n, m)
        Half turns of the solutions in a period inside locks, nan outside.
    growth : bool (n, m)
    locks, onset : curves of the two boundaries
    names : number of half turns → what is written into its region
    ticks : places along y that mean something
    marks : (x, y, text) of points
    folklore : bool
        Whether the band of advance ratios in which the simple model is said to end is drawn.
    """

    title: str
    across: str
    up: str
    x: Array
    y: Array
    turns: Array
    growth: Flags
    locks: Sequence[BoundaryCurve]
    onset: Sequence[BoundaryCurve]
    names: Mapping[int, str]
    marks: Sequence[tuple[float, float, str]] = ()
    ticks: Sequence[float] = ()
    folklore: bool = False


@styled
def strutt(planes: Sequence[Plane], *, footer: str = "", width: float = PAGE) -> Figure:
    """Panels side by side: locks shaded and hatched with their names, growth in red, boundaries as lines."""
    figure = new_figure(width, HEIGHT, " ".join([footer, FOOTER_OF_ONE]).strip())
    axes = np.atleast_1d(figure.subplots(1, len(planes)))
    for ax, plane in zip(axes, planes, strict=True):
        _draw(ax, plane)
    handles = [
        Patch(facecolor=LOCKED, edgecolor=DARK, hatch="////", linewidth=0.4, label="locked, no growth"),
        Patch(facecolor=GROWING, edgecolor=DARK, hatch="////", linewidth=0.4, label="locked and growing"),
        Patch(facecolor="white", edgecolor=DARK, linewidth=0.4, label="not locked, no growth"),
    ]
    if any(plane.folklore for plane in planes):
        handles.append(Patch(facecolor=FOLKLORE_COLOUR, alpha=0.6, label="folklore: TPP valid to 0.3 … 0.4"))
    figure.legend(handles=handles, loc="outside upper center", ncols=4, frameon=False, handlelength=2.4)
    settle(axes[0])
    for ax, plane in zip(axes, planes, strict=True):
        _name(ax, plane)
    return figure


def _draw(ax: Axes, plane: Plane) -> None:
    x, y = plane.x, plane.y
    locked = np.isfinite(plane.turns)
    kind = np.where(plane.growth, 1.0, np.where(locked, 0.0, np.nan))
    colours = ListedColormap([LOCKED, GROWING])
    ax.pcolormesh(x, y, kind, cmap=colours, vmin=0.0, vmax=1.0, shading="nearest", rasterized=True, gid="regions")
    for n in np.unique(plane.turns[locked]).astype(int).tolist():
        hatch = HATCHES[n % len(HATCHES)] or "...."
        ax.contourf(x, y, (plane.turns == n).astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch])
    if plane.folklore:
        ax.axvspan(*FOLKLORE, color=FOLKLORE_COLOUR, alpha=0.6, lw=0, zorder=1.5, gid="folklore")
    for curves, name, width in ((plane.locks, "lock", 0.9), (plane.onset, "growth", 1.6)):
        for curve in curves:
            ax.plot(curve.x, curve.y, color=DARK if name == "lock" else "#8C1C0C", lw=width, gid=name)
    for across, up, _ in plane.marks:
        ax.plot([across], [up], "o", ms=4.0, mfc="white", mec="black", mew=1.0, zorder=6, clip_on=False, gid="mark")
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel=plane.across, ylabel=plane.up)
    if plane.ticks:
        ax.set_yticks(plane.ticks)
    ax.set_title(plane.title, loc="left")


def _name(ax: Axes, plane: Plane) -> None:
    """Texts of marks, and names of locks where their regions are widest; where a part of one is stable, there."""
    labels = Labels(ax, margin=-2.0)
    style: dict[str, Any] = {"fontsize": SMALL, "color": "black", "zorder": 7.0, "path_effects": HALO}
    for x, y, text in plane.marks:
        labels.put(text, [(x, y)], sides=MARK_SIDES, distance=5.0, **style)
    named = False
    for n, text in plane.names.items():
        stable, growing = ((plane.turns == n) & (plane.growth == grows) for grows in (False, True))
        if stable.any() or growing.any():
            _write(labels, plane, stable if stable.any() else growing, text, style)
        named = named or (stable.any() and growing.any())
    if named:
        _write(labels, plane, plane.growth, "growth", style, turns=True)


def _write(
    labels: Labels, plane: Plane, inside: Flags, text: str, style: dict[str, Any], *, turns: bool = False
) -> None:
    """A text into a region, around the point that is farthest from its edge or almost, upright if it may turn."""
    from scipy.ndimage import distance_transform_edt

    frame = labels.ax.get_window_extent()
    pixel = (frame.height / len(plane.y), frame.width / len(plane.x))
    distance = np.asarray(distance_transform_edt(np.pad(inside, 1), sampling=pixel))[1:-1, 1:-1]
    best = np.argsort(-distance, axis=None)[: max(1, int((distance > 0.6 * distance.max()).sum())) : 40]
    i, j = np.unravel_index(best, distance.shape)
    width, height = labels.size(text, **style)
    if 0.5 * width > distance.max() and turns:
        style, height = {**style, "rotation": 90}, width
    at = [(float(plane.x[across]), float(plane.y[up])) for up, across in zip(i, j, strict=True)]
    labels.put(text, at, sides=[(0, -1)], distance=-0.5 * height / labels.point, **style)
