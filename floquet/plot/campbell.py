"""Campbell diagrams: frequencies and damping of a rotor's modes in hertz and per second against its speed in rpm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from floquet.plot.curves import Band
from floquet.plot.labels import Labels, along
from floquet.plot.parts import (
    COLOURS,
    DARK,
    DASHED,
    LOCKED,
    PAGE,
    SMALL,
    THIN,
    line_handles,
    name_bands,
    new_figure,
    settle,
    shade,
    styled,
    write_footer,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Campbell", "campbell"]

Array = NDArray[np.float64]
WIDE = 1.8
GREY = "#808080"
SHARED = "The exact modes are one blade's and share its damping, which has two values in a lock."
SLOWEST = "regressing"


@dataclass(frozen=True, eq=False, kw_only=True)
class Campbell:
    """A rotor by its speed, at one flight speed.

    Attributes
    ----------
    title : str
    rpm, advance_ratio : (k,)
    frequency : mode → (k,)
        Exact, in Hz.
    damping : (k, 2)
        Exact, of every mode, -σ in 1/s.
    plane_frequency, plane_damping : mode → (k, 2)
        Of the tip-path plane.
    bands : (enter, leave, per rev)
        Locks in rpm.
    orders : sequence of int
        Multiples of the rotor speed that are drawn as lines.
    nominal : float
        Rpm.
    """

    title: str
    rpm: Array
    advance_ratio: Array
    frequency: Mapping[str, Array]
    damping: Array
    plane_frequency: Mapping[str, Array]
    plane_damping: Mapping[str, Array]
    bands: Sequence[Band]
    orders: Sequence[int]
    nominal: float


@styled
def campbell(one: Campbell, *, width: float = PAGE) -> Figure:
    """Frequencies, the slowest once more, damping: exact solid, tip-path plane dashed, n per rev thin, locks shaded."""
    figure = new_figure(width, 6.4)
    write_footer(figure, SHARED)
    upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=(1.9, 0.8, 1.3))
    _draw_frequencies(upper, one)
    _draw_slowest(middle, one)
    _draw_damping(lower, one)
    for ax in (upper, middle, lower):
        shade(ax, one.bands, float(one.rpm[-1]))
        ax.axvline(one.nominal, color=DARK, lw=0.8, ls=(0, (6, 2, 1, 2)), zorder=1.5, gid="nominal")
    lower.set(xlabel="rotor speed (rpm)", xlim=(one.rpm[0], one.rpm[-1]))
    _mark_advance_ratios(upper, one)
    handles = [
        *line_handles(),
        Line2D([], [], color=GREY, lw=0.6, label="multiples of the rotor speed"),
        Line2D([], [], color=DARK, lw=0.8, ls=(0, (6, 2, 1, 2)), label="nominal speed"),
        Patch(color=LOCKED, lw=0, label="Floquet locked"),
    ]
    figure.legend(
        handles=handles, loc="outside upper left", ncols=len(handles), frameon=False, title=one.title, alignment="left",
        title_fontsize=8.5, handlelength=2.4,
    )  # fmt: skip
    settle(upper)
    _name_frequencies(upper, one)
    _name_slowest(middle, one)
    _name_damping(lower, one)
    return figure


def _draw_frequencies(ax: Axes, one: Campbell) -> None:
    for order in one.orders:
        ax.plot(one.rpm, order * one.rpm / 60.0, color=GREY, lw=0.6, zorder=1.2, gid=f"{order} per rev")
    for mode, hertz in one.frequency.items():
        ax.plot(one.rpm, hertz, color=COLOURS[mode], lw=WIDE, zorder=2.5, gid=f"Floquet {mode}")
        _dashed(ax, one.rpm, one.plane_frequency[mode], mode)
    top = max(float(hertz.max()) for hertz in one.frequency.values())
    ax.set(ylabel="frequency (Hz)", ylim=(-0.03 * top, 1.17 * top))


def _draw_slowest(ax: Axes, one: Campbell) -> None:
    ax.plot(one.rpm, one.frequency[SLOWEST], color=COLOURS[SLOWEST], lw=WIDE, zorder=2.5, gid=f"Floquet {SLOWEST}")
    _dashed(ax, one.rpm, one.plane_frequency[SLOWEST], SLOWEST)
    ax.set_ylabel("frequency (Hz)")
    ax.margins(y=0.12)


def _draw_damping(ax: Axes, one: Campbell) -> None:
    for member in (0, 1):
        ax.plot(one.rpm, one.damping[:, member], color=DARK, lw=WIDE, zorder=2.5, gid=f"Floquet {member}")
    for mode, rates in one.plane_damping.items():
        _dashed(ax, one.rpm, rates, mode)
    ax.set_ylabel(r"damping $-\sigma$ (1/s)")
    ax.margins(y=0.12)


def _dashed(ax: Axes, x: Array, pair: Array, mode: str) -> None:
    """Both members of a pair, the larger first; one line where they are equal."""
    pair = -np.sort(-pair, axis=1)
    second = np.where(np.abs(np.diff(pair, axis=1)[:, 0]) > 1e-9, pair[:, 1], np.nan)
    for member, values in enumerate((pair[:, 0], second)):
        ax.plot(x, values, color=COLOURS[mode], lw=THIN, ls=DASHED, zorder=3.5, gid=f"TPP {mode} {member}")


def _mark_advance_ratios(ax: Axes, one: Campbell) -> None:
    """μ above, which goes as 1/rpm."""
    product = float(one.rpm[0] * one.advance_ratio[0])

    def inverse(x: Any) -> Any:
        return product / np.maximum(np.asarray(x, float), 1e-9)

    top = ax.secondary_xaxis("top", functions=(inverse, inverse))
    low, high = sorted((float(one.advance_ratio[0]), float(one.advance_ratio[-1])))
    top.set_xticks([k / 20.0 for k in range(1, 40) if low <= k / 20.0 <= high])
    top.set_xlabel(r"advance ratio $\mu$")


def _name_frequencies(ax: Axes, one: Campbell) -> None:
    labels = Labels(ax)
    name_bands(labels, one.bands, float(one.rpm[-1]), 0.985)
    _name_nominal(labels, one)
    top = ax.get_ylim()[1]
    for order in one.orders:
        hertz = order * one.rpm / 60.0
        at = along(one.rpm, np.where(hertz < top, hertz, np.nan))
        labels.put(f"{order} per rev", at, sides=((-1, 1), (1, -1)), distance=2.0, fontsize=SMALL, color=GREY)
    for mode, hertz in one.frequency.items():
        labels.put(mode, along(one.rpm, hertz)[::-1], sides=((0, 1), (0, -1), (1, 1), (1, -1)), distance=3.0,
                   fontsize=SMALL, color=COLOURS[mode])  # fmt: skip


def _name_nominal(labels: Labels, one: Campbell) -> None:
    low, high = labels.ax.get_ylim()
    at = [(one.nominal, low + f * (high - low)) for f in np.linspace(0.23, 0.9, 15)]
    text = f"{one.nominal:.0f} rpm"
    labels.put(text, at, sides=((1, 0), (-1, 0)), distance=3.0, rotation=90, fontsize=SMALL, color=DARK)


def _name_slowest(ax: Axes, one: Campbell) -> None:
    labels = Labels(ax)
    exact, simple = one.frequency[SLOWEST], one.plane_frequency[SLOWEST].max(axis=1)
    style: dict[str, Any] = {"distance": 3.0, "fontsize": SMALL, "color": COLOURS[SLOWEST]}
    labels.put(f"{SLOWEST}, enlarged", [(float(one.rpm[-1]), ax.get_ylim()[1])], sides=((-1, -1),), **style)
    still = exact < 1e-9
    for text, hertz, part in (
        ("exact: no frequency in the lock", exact, still),
        ("exact", exact, ~still),
        ("TPP", simple, simple > 1e-9),
    ):
        at = along(np.where(part, one.rpm, np.nan), hertz)
        labels.put(text, at[len(at) // 2 :] + at[: len(at) // 2], sides=((0, 1), (1, 1), (-1, -1)), **style)


def _name_damping(ax: Axes, one: Campbell) -> None:
    labels = Labels(ax)
    places = along(one.rpm, one.damping[:, 0])[::-1]
    labels.put("all modes, exact", places, sides=((0, 1), (0, -1)), distance=3.0, fontsize=SMALL, color=DARK)
    for mode, rates in one.plane_damping.items():
        at = [p for member in (0, 1) for p in along(one.rpm, rates[:, member])]
        labels.put(f"{mode}, TPP", at, distance=3.0, fontsize=SMALL, color=COLOURS[mode])
