"""Limits of modes by model: a dot at one tolerance, a bar between a narrower and a wider one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from matplotlib.lines import Line2D

from floquet.plot.parts import COLOURS, DARK, FOLKLORE_COLOUR, PAGE, new_figure, pale, styled, write_footer
from floquet.plot.summary import FOLKLORE
from floquet.plot.validity_curves import NONE, TOP

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Ranges", "ranges_figure"]

LOOKS = {
    "regressing": (COLOURS["regressing"], "o"), "coning": (COLOURS["coning"], "s"),
    "advancing": (COLOURS["advancing"], "^"), "further": (DARK, "D"), "differential": (COLOURS["differential"], "v"),
}  # fmt: skip
LABELS = {"further": "worst of the further modes", "differential": "differential (even N)"}
Limits = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranges:
    """Model → mode → limits in μ at a narrow, the middle and a wide tolerance; inf is none up to 1."""

    title: str
    values: Mapping[str, Mapping[str, Limits]]


@styled
def ranges_figure(
    rows: Sequence[Sequence[Ranges]], *, xlabel: str, ylabel: str, note: str = "", width: float = PAGE
) -> Figure:
    """Panels in rows of equal length, models along x, modes side by side."""
    figure = new_figure(width, 0.7 + 1.9 * len(rows))
    write_footer(figure, note)
    axes = figure.subplots(len(rows), len(rows[0]), sharex=True, sharey=True, squeeze=False)
    for i, row in enumerate(rows):
        for j, one in enumerate(row):
            _draw(axes[i, j], one)
            if i == len(rows) - 1:
                axes[i, j].set_xlabel(xlabel)
            if j == 0:
                axes[i, j].set_ylabel(ylabel)
    style: dict[str, Any] = {"lw": 2.5, "ms": 4.0}
    drawn = {mode for row in rows for one in row for modes in one.values.values() for mode in modes}
    handles = [Line2D([], [], color=pale(colour), marker=marker, mfc=colour, mec=colour, label=LABELS.get(mode, mode),
                      **style) for mode, (colour, marker) in LOOKS.items() if mode in drawn]  # fmt: skip
    figure.legend(handles=handles, loc="outside upper center", ncols=5, frameon=False, handletextpad=0.5)
    return figure


def _draw(ax: Axes, one: Ranges) -> None:
    ax.set_title(one.title, loc="left")
    ax.axhspan(*FOLKLORE, color=FOLKLORE_COLOUR, alpha=0.45, lw=0, zorder=0, gid="folklore")
    ax.axhline(1.0, color=DARK, lw=0.5, zorder=0.5)
    for x, modes in enumerate(one.values.values()):
        for i, (mode, (colour, marker)) in enumerate(LOOKS.items()):
            if mode not in modes:
                continue
            at = x + 0.16 * (i - 2)
            low, middle, high = (y if math.isfinite(y) else NONE for y in modes[mode])
            ax.plot([at, at], [low, high], color=pale(colour), lw=2.5, zorder=2, solid_capstyle="butt")
            ax.plot([at], [middle], marker, color=colour, ms=3.2, mew=0.0, zorder=3, gid=f"{mode} {x}")
    ax.set_xticks(range(len(one.values)), list(one.values))
    ax.set(xlim=(-0.5, len(one.values) - 0.5), ylim=(0.0, TOP))
    ax.set_yticks([0.0, 0.2, 0.4, 0.6, 0.8, 1.0, NONE], ["0", "0.2", "0.4", "0.6", "0.8", "1", "none"])
