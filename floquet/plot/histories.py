"""Responses in time: how the full periodic equations, the tip-path plane and its reduced order answer a step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from floquet.plot.parts import DARK, DASHED, DOTTED, MM, PAGE, THIN, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["History", "step_histories"]

Array = NDArray[np.float64]
MODELS = {
    "full": ("full periodic equations", "#56B4E9", 2.4, "-"),
    "unreduced": ("unreduced order: tip-path plane, eq. (6)", DARK, THIN, DASHED),
    "reduced": ("reduced order, eq. (11)", "#D55E00", 1.6, DOTTED),
}
"""Words, colour, width and line of each model, in drawing order."""


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """A panel: what it is called and shows, its values by model (``full``, ``unreduced``, ``reduced``)."""

    title: str
    label: str
    values: Mapping[str, Array]


@styled
def step_histories(seconds: Array, histories: Sequence[History], *, rotor_speed: float, title: str = "") -> Figure:
    """Histories in two columns against seconds, with revolutions above; ``rotor_speed`` in rad/s."""
    rows = -(-len(histories) // 2)
    figure = new_figure(PAGE, (20.0 + 50.0 * rows) * MM)
    figure.supxlabel("No dynamic inflow in any of the models.", fontsize=6.5, color=DARK, x=0.99, ha="right")
    axes = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for k, (ax, history) in enumerate(zip(axes.flat, histories, strict=False)):
        ax.axhline(0.0, color=DARK, lw=0.5, zorder=0.5)
        for model, (_, colour, width, line) in MODELS.items():
            ax.plot(seconds, history.values[model], color=colour, lw=width, ls=line, gid=model)
        ax.set(xlim=(seconds[0], seconds[-1]), ylabel=history.label)
        ax.set_title(f"({'abcdefgh'[k]}) {history.title}", loc="left")
        ax.margins(y=0.08)
        if k < 2:
            _revolutions(ax, rotor_speed)
        if k >= len(histories) - 2:
            ax.set_xlabel(r"time after the step (s)")
    handles = [Line2D([], [], color=c, lw=w, ls=line, label=words) for words, c, w, line in MODELS.values()]
    figure.legend(handles=handles, loc="outside upper left", ncols=len(handles), frameon=False, title=title,
                  title_fontsize=8.5, alignment="left", handlelength=2.6, borderaxespad=0.2)  # fmt: skip
    return figure


def _revolutions(ax: Axes, rotor_speed: float) -> None:
    rate = rotor_speed / (2.0 * math.pi)
    above = ax.secondary_xaxis("top", functions=(lambda t: rate * np.asarray(t), lambda n: np.asarray(n) / rate))
    above.set_xlabel("revolutions")
