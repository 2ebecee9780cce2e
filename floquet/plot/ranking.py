"""Bars of two models side by side, ranked by the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from matplotlib.patches import Patch

from floquet.plot.parts import COLOURS, DARK, PAGE, new_figure, pale, styled, write_footer

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Ranking", "ranking_figure"]

EXACT, SIMPLE = COLOURS["coning"], COLOURS["regressing"]
BAR = 0.36
ROW = 0.21  # inches


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking:
    """Name → (exact, simple, whether both are trusted), in the order drawn."""

    title: str
    values: Mapping[str, tuple[float, float, bool]]


@styled
def ranking_figure(rows: Sequence[Sequence[Ranking]], *, xlabel: str, note: str = "", width: float = PAGE) -> Figure:
    """Rankings in rows of equal length; bars that are not trusted are hatched and crossed, others ticked."""
    most = max(len(one.values) for row in rows for one in row)
    figure = new_figure(width, 0.7 + len(rows) * (0.45 + ROW * most))
    write_footer(figure, note)
    axes = figure.subplots(len(rows), len(rows[0]), squeeze=False)
    for i, row in enumerate(rows):
        for j, one in enumerate(row):
            _draw(axes[i, j], one)
            if i == len(rows) - 1:
                axes[i, j].set_xlabel(xlabel)
    handles: list[Any] = [Patch(color=EXACT, label="Floquet (exact)"), Patch(color=SIMPLE, label="TPP (simple)")]
    handles.append(Patch(fc="none", ec="none", label="✓ rate trusted to 1e-8, ✗ and hatched: not"))
    figure.legend(handles=handles, loc="outside upper center", ncols=3, frameon=False, handlelength=1.4)
    return figure


def _draw(ax: Axes, one: Ranking) -> None:
    ax.set_title(one.title, loc="left")
    ax.spines[["top", "right"]].set_visible(False)
    ax.axvline(0.0, color=DARK, lw=0.6, zorder=3)
    for i, (exact, simple, trusted) in enumerate(one.values.values()):
        for value, colour, shift in ((exact, EXACT, -0.5 * BAR), (simple, SIMPLE, 0.5 * BAR)):
            style: dict[str, Any] = (
                {"color": colour} if trusted else {"fc": pale(colour), "ec": colour, "hatch": "////"}
            )
            ax.barh(i + shift, value, height=BAR, lw=0, zorder=2, **style)
        ax.text(1.0, i, "✓" if trusted else "✗", transform=ax.get_yaxis_transform(), va="center", ha="left",
                fontsize=7.0, color=DARK)  # fmt: skip
    ax.set_yticks(range(len(one.values)), list(one.values))
    ax.set_ylim(len(one.values) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0)
