"""What options move: a panel a quantity, a row an option, a marker a rotor at its change."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from matplotlib.lines import Line2D

from floquet.plot.parts import DARK, PAGE, new_figure, styled, write_footer

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Effects", "effects_figure"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", DARK, "#B8860B")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
EDGE = 1.12  # of the largest finite change: where what appears or vanishes is drawn
ROW = 0.47  # inches
GAINED, LOST = ">", "<"


@dataclass(frozen=True, kw_only=True, eq=False)
class Effects:
    """One quantity: option → rotor → (before, after); inf is none in the range."""

    title: str
    values: Mapping[str, Mapping[str, tuple[float, float]]]


@styled
def effects_figure(panels: Sequence[Effects], *, note: str = "", width: float = PAGE) -> Figure:
    """Changes from before to after, options in rows; what appears or vanishes stands at the edge."""
    options = list(panels[0].values)
    figure = new_figure(width, 1.35 + ROW * len(options))
    write_footer(figure, note)
    axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    rotors = list(dict.fromkeys(name for one in panels for row in one.values.values() for name in row))
    for ax, panel in zip(axes, panels, strict=True):
        _draw(ax, panel, rotors)
    axes[0].set_yticks(range(len(options)), options)
    axes[0].set_ylim(len(options) - 0.5, -0.5)
    style: dict[str, Any] = {"lw": 0, "ms": 4.0}
    handles = [Line2D([], [], marker=MARKERS[i], color=COLOURS[i], label=name, **style)
               for i, name in enumerate(rotors)]  # fmt: skip
    handles.append(Line2D([], [], marker=GAINED, color=DARK, label="none any more", **style))
    handles.append(Line2D([], [], marker=LOST, color=DARK, label="none before", **style))
    figure.legend(handles=handles, loc="outside upper center", ncols=5, frameon=False, handletextpad=0.3)
    return figure


def moved(before: float, after: float) -> float:
    """After - before; ±inf for what vanishes or appears, nan where there is nothing before or after."""
    return math.nan if math.isinf(before) and math.isinf(after) else after - before


def _draw(ax: Axes, panel: Effects, rotors: Sequence[str]) -> None:
    changes = {(option, name): moved(*pair) for option, row in panel.values.items() for name, pair in row.items()}
    largest = max([abs(x) for x in changes.values() if math.isfinite(x)] + [1e-6])
    ax.axvline(0.0, color=DARK, lw=0.6, zorder=1)
    for row, option in enumerate(panel.values):
        if row % 2:
            ax.axhspan(row - 0.5, row + 0.5, color="#F3F3F3", lw=0, zorder=0)
        for i, name in enumerate(rotors):
            change = changes.get((option, name), math.nan)
            if math.isnan(change):
                continue
            y = row + 0.72 * (i / max(len(rotors) - 1, 1) - 0.5)
            at = change if math.isfinite(change) else math.copysign(EDGE * largest, change)
            marker = MARKERS[i] if math.isfinite(change) else GAINED if change > 0 else LOST
            ax.plot([0.0, at], [y, y], color=COLOURS[i], lw=0.6, zorder=2)
            ax.plot([at], [y], marker, color=COLOURS[i], ms=3.4, mew=0.0, zorder=3, gid=f"{option}, {name}")
    ax.set_title(panel.title, loc="left")
    ax.set(xlim=(-1.25 * largest, 1.25 * largest), xlabel=r"change in $\mu$")
    ax.tick_params(axis="y", length=0)
    ax.locator_params(axis="x", nbins=3, symmetric=True)
