"""From one value to another in steps: bars that begin where the one before ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from floquet.plot.parts import DARK, PAGE, new_figure, styled, write_footer

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Waterfall", "waterfall_figure"]

UP, DOWN, TOTAL = "#D55E00", "#0072B2", "#555555"
"""Bars that add to the total, that take from it, and the total."""
ROW = 0.24  # inches
ROOM = 0.24  # of the range, beside the bars, for their numbers


@dataclass(frozen=True, kw_only=True, eq=False)
class Waterfall:
    """Steps in per cent, which add up to the total; none: ``title`` and ``empty`` in words."""

    title: str
    steps: Sequence[float] = ()
    empty: str = ""


@styled
def waterfall_figure(
    rows: Sequence[Sequence[Waterfall]], names: Sequence[str], *, xlabel: str, note: str = "", width: float = PAGE
) -> Figure:
    """Waterfalls in rows of equal length; ``names`` of the steps and of the total stand at the left."""
    figure = new_figure(width, 0.35 + len(rows) * (0.45 + ROW * len(names)))
    write_footer(figure, note)
    axes = figure.subplots(len(rows), len(rows[0]), squeeze=False)
    for i, row in enumerate(rows):
        for j, one in enumerate(row):
            ax = axes[i, j]
            _draw(ax, one)
            ax.set_ylim(len(names) - 0.5, -0.5)
            ax.set_yticks(range(len(names)), names if j == 0 else [""] * len(names))
            ax.tick_params(axis="y", length=0)
            if i == len(rows) - 1:
                ax.set_xlabel(xlabel)
    return figure


def _draw(ax: Axes, one: Waterfall) -> None:
    ax.set_title(one.title, loc="left")
    ax.spines[["top", "right"]].set_visible(False)
    if one.empty:
        ax.text(0.5, 0.5, one.empty, transform=ax.transAxes, ha="center", va="center", color=DARK, fontsize=7.0)
        ax.set_xticks([])
        return
    ends = np.cumsum([0.0, *one.steps])
    low, high = float(ends.min()), float(ends.max())
    room = ROOM * (high - low)
    for i, step in enumerate(one.steps):
        a, b = float(ends[i]), float(ends[i + 1])
        ax.barh(i, b - a, left=a, height=0.62, color=UP if step * ends[-1] >= 0.0 else DOWN, lw=0, gid=f"step {i}")
        ax.plot([b, b], [i - 0.31, i + 1.31], color=DARK, lw=0.6, zorder=3)
        _write(ax, max(a, b), min(a, b), i, step, room)
    last = len(one.steps)
    ax.barh(last, ends[-1], height=0.62, color=TOTAL, lw=0, gid="total")
    _write(ax, max(0.0, float(ends[-1])), min(0.0, float(ends[-1])), last, float(ends[-1]), room)
    ax.axvline(0.0, color=DARK, lw=0.6, zorder=1)
    ax.set_xlim(low - 0.05 * (high - low), high + 2.6 * room)
    ax.locator_params(axis="x", nbins=4)


def _write(ax: Axes, right: float, left: float, row: int, value: float, room: float) -> None:
    """A number right of its bar."""
    text = f"{value:+.2g}".replace("-", "−") if abs(value) >= 0.005 else "0"
    ax.annotate(text, (right, row), (2.5, 0.0), textcoords="offset points", va="center", ha="left", fontsize=6.5)
