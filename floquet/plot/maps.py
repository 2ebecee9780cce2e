"""The plane of Lock number and advance ratio: how large the error of each mode is, and where Floquet is locked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from floquet.plot.parts import DARK, FOLKLORE_COLOUR, PAGE, new_figure, per_rev, styled
from floquet.plot.summary import FOLKLORE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["LEVELS", "ErrorMap", "validity_maps"]

Array = NDArray[np.float64]
#: Errors at which the colour changes, in per cent.
LEVELS = (1.0, 2.0, 5.0, 10.0, 20.0)
COLOURS = ("#ffffff", "#fdf1df", "#fbd7a5", "#f3a866", "#d9703f", "#a33b2a")
HATCHES = {0.0: "....", 0.5: "////", 1.0: "\\\\\\\\", 1.5: "xxxx"}
HEIGHT = 3.0  # inches


@dataclass(frozen=True, eq=False, kw_only=True)
class ErrorMap:
    """One mode: ``errors`` (γ, μ) as parts of the exact exponents, ``lock`` (γ, μ) per rev, nan outside locks."""

    title: str
    lock_number: Array
    advance_ratio: Array
    errors: Array
    lock: Array


@styled
def validity_maps(maps: Sequence[ErrorMap], *, width: float = PAGE) -> Figure:
    """Modes side by side: errors in colours, 5 % as a line, locks hatched, the folklore band between two lines."""
    figure = new_figure(width, HEIGHT)
    axes = np.atleast_1d(figure.subplots(1, len(maps), sharey=True))
    for ax, one in zip(axes, maps, strict=True):
        _draw(ax, one)
    axes[0].set_ylabel(r"Lock number $\gamma$")
    locks = sorted({float(x) for one in maps for x in np.unique(one.lock[~np.isnan(one.lock)])})
    shades = [Patch(facecolor=colour, edgecolor=DARK, linewidth=0.4, label=label)
              for colour, label in zip(COLOURS, _labels(), strict=True)]  # fmt: skip
    hatched = [Patch(facecolor="none", edgecolor=DARK, hatch=_hatch(x), linewidth=0.4, label=f"locked at {per_rev(x)}")
               for x in locks]  # fmt: skip
    band = Patch(facecolor="none", edgecolor=FOLKLORE_COLOUR, linewidth=1.6, label="folklore: valid to 0.3 … 0.4")
    figure.legend(handles=[*shades, *hatched, band], loc="outside upper center", ncols=5, frameon=False)
    return figure


def _draw(ax: Axes, one: ErrorMap) -> None:
    x, y, percent = one.advance_ratio, one.lock_number, 100.0 * one.errors
    norm = BoundaryNorm([0.0, *LEVELS, np.inf], len(COLOURS))
    ax.pcolormesh(x, y, percent, cmap=ListedColormap(COLOURS), norm=norm, shading="nearest", rasterized=True)
    ax.contour(x, y, percent, levels=[5.0], colors=DARK, linewidths=1.2)
    for rho in np.unique(one.lock[~np.isnan(one.lock)]):
        inside = (one.lock == rho).astype(float)
        ax.contourf(x, y, inside, levels=[0.5, 1.5], colors="none", hatches=[_hatch(float(rho))])
        ax.contour(x, y, inside, levels=[0.5], colors=DARK, linewidths=0.5)
    low, high = FOLKLORE
    box = (low, y[0]), high - low, y[-1] - y[0]
    ax.add_patch(Rectangle(*box, fill=False, edgecolor=FOLKLORE_COLOUR, linewidth=1.6, zorder=5.0))
    ax.set(title=one.title, xlabel=r"advance ratio $\mu$", xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))


def _labels() -> list[str]:
    """Of the colours."""
    between = [f"{a:g} to {b:g} %" for a, b in pairwise(LEVELS)]
    return [f"below {LEVELS[0]:g} %", *between, f"above {LEVELS[-1]:g} %"]


def _hatch(rho: float) -> str:
    return HATCHES.get(rho, "++")
