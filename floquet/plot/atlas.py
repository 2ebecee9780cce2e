"""Many designs at once: how many of them a mode of the simple model holds for, by Lock number and advance ratio."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from floquet.errors import ParameterError
from floquet.plot.parts import DARK, DOTTED, FOLKLORE_COLOUR, PAGE, new_figure, percent, styled, write_footer
from floquet.plot.summary import FOLKLORE
from floquet.sweep import MODES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["ATLAS_COLUMNS", "validity_atlas"]

Array = NDArray[np.float64]
Rows = Mapping[str, NDArray[Any]]
#: Columns of the limits table that are drawn.
ATLAS_COLUMNS = ("mode", "tolerance", "metric", "lock_number", "limit", "mu_max", "rotor")
SHARES = {0.9: DOTTED, 0.5: "-", 0.1: "--"}  # of the designs: lines
FEWEST, MOST_BINS = 20, 60  # designs worth an atlas; Lock numbers that are told apart
STEPS = 240  # of μ
MARK, MOST_DOTS = 2.4, 20  # points; Lock numbers
ROUNDING = 1e-9  # of a number of designs
HEIGHT = 2.9  # inches


@styled
def validity_atlas(limits: Rows, *, width: float = PAGE) -> Figure:
    """A panel for each mode: the share of designs whose limit is beyond μ, in shades; 90, 50 and 10 % as lines.

    A line goes through the last μ up to which the share holds at each Lock number (of more than ``MOST_BINS``, in each
    of as many ranges), with dots there if they are few.  In between it is straight, and it ends where the share holds
    to the last μ.
    """
    modes = [k for k in range(len(MODES)) if np.any(limits["mode"] == k)]
    designs, tolerance = len(np.unique(limits["rotor"])), limits["tolerance"]
    if designs < FEWEST or len(np.unique(limits["lock_number"])) < 2:
        raise ParameterError(
            "kind",
            "validity-atlas",
            f"the limits table has {designs} designs: an atlas is of {FEWEST} or more, of several Lock numbers; "
            "draw validity-summary, or run a study with a grid of rotors",
        )
    figure = new_figure(width, HEIGHT)
    axes = np.atleast_1d(figure.subplots(1, len(modes), sharey=True))
    for ax, mode in zip(axes, modes, strict=True):
        own = limits["mode"] == mode
        image = _draw(ax, limits["lock_number"][own], limits["limit"][own], float(limits["mu_max"].min()))
        ax.set(title=MODES[mode], xlabel=r"advance ratio $\mu$")
    axes[0].set_ylabel(r"Lock number $\gamma$")
    bar = figure.colorbar(image, ax=list(axes), pad=0.01, aspect=30, ticks=[0.0, 0.5, 1.0])
    bar.ax.set_yticklabels(["0", "50", "100 %"])
    bar.set_label("designs within the tolerance")
    marks = _marks(limits["lock_number"])
    lines = [Line2D([], [], ls=style, label=f"{percent(s)} hold", **marks) for s, style in SHARES.items()]
    band = Patch(facecolor="none", edgecolor=FOLKLORE_COLOUR, linewidth=1.6, label="folklore: valid to 0.3 … 0.4")
    figure.legend(handles=[*lines, band], loc="outside upper center", ncols=4, frameon=False)
    words = (
        f"{designs} designs; the simple model fails from the first error above {percent(float(tolerance.min()))}. "
        f"Lines are straight between {_nodes(limits['lock_number'])}."
    )
    write_footer(figure, words)
    return figure


def _marks(gamma: Array) -> dict[str, Any]:
    """How lines are drawn: dots that are close would hide which line is dashed."""
    few = len(np.unique(gamma)) <= MOST_DOTS
    return {"color": DARK, "lw": 1.0, "marker": "o" if few else "None", "ms": MARK, "mew": 0}


def _nodes(gamma: Array) -> str:
    """What the lines are straight between."""
    count = len(np.unique(gamma))
    return (
        f"the {count} Lock numbers of the designs" if count <= MOST_BINS else f"{MOST_BINS} ranges of the Lock number"
    )


def _draw(ax: Axes, gamma: Array, limit: Array, end: float) -> Any:
    mu, values, marks = np.linspace(0.0, end, STEPS + 1), np.unique(gamma), _marks(gamma)
    if len(values) > MOST_BINS:
        edges = np.linspace(values[0], values[-1], MOST_BINS + 1)
        values, gamma = 0.5 * (edges[1:] + edges[:-1]), np.clip(np.searchsorted(edges, gamma) - 1, 0, MOST_BINS - 1)
        member = [gamma == k for k in range(MOST_BINS)]
    else:
        member = [gamma == value for value in values]
    there = [k for k, own in enumerate(member) if own.any()]
    held = np.stack([_holding(limit[member[k]], mu) for k in there])
    image = ax.pcolormesh(mu, values[there], held, cmap=_shades(), vmin=0.0, vmax=1.0, shading="nearest",
                          rasterized=True)  # fmt: skip
    for share, style in SHARES.items():
        ends = [_end(limit[member[k]], share) for k in there]
        at = np.where(np.array(ends) < end, ends, np.nan)
        ax.plot(at, values[there], ls=style, gid=f"share {share:g}", **marks)
    low, high = FOLKLORE
    for place in (low, high):
        ax.axvline(place, color=FOLKLORE_COLOUR, lw=1.6, zorder=3.0)
    ax.set(xlim=(0.0, end), ylim=(values[there[0]], values[there[-1]]))
    return image


def _end(limit: Array, share: float) -> float:
    """The last μ up to which a share of the limits lies beyond; inf where it does to the end."""
    return float(np.sort(limit)[min(math.floor((1.0 - share) * len(limit) + ROUNDING), len(limit) - 1)])


def _shades() -> ListedColormap:
    """White to a blue on which dark lines are seen."""
    return ListedColormap(matplotlib.colormaps["Blues"](np.linspace(0.0, 0.7, 256)))


def _holding(limit: Array, mu: Array) -> Array:
    """The share of limits beyond each μ."""
    return 1.0 - np.searchsorted(np.sort(limit), mu, side="right") / len(limit)
