"""Curves of one quantity against another, each named at its end: figures of required parameters and of residuals.

A figure is panels; a panel is axis titles, curves and marked points.  Colours go with families, not with modes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

from floquet.plot.labels import Labels, along
from floquet.plot.parts import DARK, DASHED, DOTTED, PAGE, SMALL, new_figure, settle, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FAMILY", "Line", "Panel", "lines"]

FAMILY = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", DARK)
"""Colours of the members of a family, after Okabe and Ito."""
STYLES: dict[str, Any] = {"solid": "-", "dashed": DASHED, "dotted": DOTTED}


@dataclass(frozen=True, eq=False, kw_only=True)
class Line:
    """A curve: x and y (n,), nan where it is not; ``label`` is written beside it, ``colour`` is a place in FAMILY."""

    x: ArrayLike
    y: ArrayLike
    label: str = ""
    colour: int = 0
    style: str = "solid"


@dataclass(frozen=True, eq=False, kw_only=True)
class Panel:
    """Axis titles, curves, and ``points`` (x, y, what they are), which are ringed."""

    x: str
    y: str
    curves: Sequence[Line]
    title: str = ""
    points: Sequence[tuple[float, float, str]] = ()
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    log: bool = False
    every: float = 0.0  # spacing of the ticks along x, 0: chosen


@styled
def lines(panels: Sequence[Panel], *, styles: dict[str, str] | None = None, footer: str = "", height: float = 0.0,
          columns: int = 0) -> Figure:  # fmt: skip
    """Draw panels in rows of ``columns`` (all in one row if 0); ``styles`` says what solid, dashed, dotted are."""
    across = columns or len(panels)
    down = -(-len(panels) // across)
    figure = new_figure(PAGE, height or (3.4 if across > 1 else 3.9) * down)
    if footer:
        figure.supxlabel(footer, fontsize=6.5, color=DARK, x=0.99, ha="right")
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for ax, panel in zip(axes, panels, strict=True):
        _draw(ax, panel)
    if styles:
        handles = [Line2D([], [], color=DARK, ls=STYLES[kind], lw=1.4, label=text) for kind, text in styles.items()]
        figure.legend(handles=handles, loc="outside upper left", ncols=len(handles), frameon=False, handlelength=2.6)
    settle(axes[0])
    for ax, panel in zip(axes, panels, strict=True):
        _name(ax, panel)
    return figure


def _draw(ax: Axes, panel: Panel) -> None:
    for one in panel.curves:
        ax.plot(one.x, one.y, ls=STYLES[one.style], color=FAMILY[one.colour], lw=1.5, label=one.label)
    for x, y, _ in panel.points:
        ax.plot([x], [y], "o", ms=4.5, mfc="white", mec=DARK, mew=1.0, zorder=4, label="_point")
    ax.set(xlabel=panel.x, ylabel=panel.y)
    ax.set_title(panel.title, loc="left")
    if panel.log:
        ax.set_yscale("log")
    if panel.xlim:
        ax.set_xlim(*panel.xlim)
    if panel.ylim:
        ax.set_ylim(*panel.ylim)
    if panel.every:
        ax.xaxis.set_major_locator(MultipleLocator(panel.every))
    if not panel.log:
        ax.axhline(0.0, color="0.6", lw=0.6, zorder=0.5, label="_zero")
    ax.grid(True, color="0.92", lw=0.5)
    ax.set_axisbelow(True)


def _name(ax: Axes, panel: Panel) -> None:
    """Names beside the curves, where they cover nothing."""
    labels = Labels(ax)
    (left, right), (low, high) = sorted(ax.get_xlim()), sorted(ax.get_ylim())
    for x, y, text in panel.points:
        labels.put(text, [(x, y)], distance=5.0, fontsize=SMALL, color=DARK)
    for one in panel.curves:
        if one.label:
            across, up = np.asarray(one.x, float), np.asarray(one.y, float)
            seen = (across >= left) & (across <= right) & (up >= low) & (up <= high)
            anchors = along(np.where(seen, across, np.nan), up)
            labels.put(one.label, anchors, distance=4.0, color=FAMILY[one.colour], fontsize=SMALL)
