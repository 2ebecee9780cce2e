"""Entries of the equations' matrices, each in the place it has in its matrix, and characteristic roots.

==============================  ======================================================================================
:func:`entries_over_azimuth`    D and K over azimuth, each entry less its mean: what the tip-path plane leaves out
:func:`entries_against_mu`      D̃ and K̃ of some rotors against μ, each entry less its value at hover
:func:`characteristic_roots`    roots of the unreduced and the reduced order beside Floquet exponents
==============================  ======================================================================================
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, MultipleLocator
from numpy.typing import NDArray

from floquet.periodic import PeriodicMatrix
from floquet.plot.labels import SIDES, Labels
from floquet.plot.parts import (
    COLOURS,
    DARK,
    DASHED,
    FOOTER_OF_ONE,
    MM,
    MU_LABEL,
    PAGE,
    SMALL,
    new_figure,
    pale,
    settle,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Root", "characteristic_roots", "entries_against_mu", "entries_over_azimuth"]

Array = NDArray[np.float64]
Place = tuple[str, int, int]
MATRICES = ("D", "K")
DROPPED, KEPT, EMPTY = "#D55E00", "#0072B2", "#F2F2F2"
SERIES = (("#999999", 2.8), ("#0072B2", 1.2), ("#D55E00", 1.2))
SYMBOLS = {
    "beta_0": r"\beta_0", "beta_1c": r"\beta_{1c}", "beta_1s": r"\beta_{1s}", "beta_d": r"\beta_d",
    "a_0": "a_0", "a_1": "a_1", "b_1": "b_1",
}  # fmt: skip
NOTHING = 1e-12  # of an entry: what rounding leaves of zero


# ---------------------------------------------------------------------- entries
@styled
def entries_over_azimuth(
    damping: PeriodicMatrix,
    stiffness: PeriodicMatrix,
    coordinates: Sequence[str],
    *,
    revolution: float,
    title: str = "",
) -> Figure:
    """Entries of D and K less their means over a part of a ``revolution``, all at one scale, with mean ± amplitude."""
    psi = np.linspace(0.0, 2.0 * math.pi * revolution, 181)
    samples = {name: m.sample(psi) for name, m in zip(MATRICES, (damping, stiffness), strict=True)}
    means = {name: m.mean() for name, m in zip(MATRICES, (damping, stiffness), strict=True)}
    largest = max(float(np.abs(samples[name] - means[name]).max()) for name in MATRICES)
    figure, axes = _matrices(coordinates, ("D", "K"))
    for (name, i, j), ax in axes.items():
        mean, swing = float(means[name][i, j]), samples[name][:, i, j] - means[name][i, j]
        amplitude = float(np.abs(swing).max())
        if max(abs(mean), amplitude) > NOTHING:
            _zero_line(ax)
        else:
            ax.set_facecolor(EMPTY)
        if amplitude > NOTHING:
            ax.fill_between(np.degrees(psi), swing, color=pale(DROPPED), lw=0, zorder=1)
            ax.plot(np.degrees(psi), swing, color=DARK, lw=1.0, zorder=3, gid=f"{name} {i} {j}")
            _say(ax, f"{_number(mean)} ± {amplitude:.2f}")
        else:
            _say(ax, _number(mean))
    for ax in axes.values():
        ax.set(xlim=(0.0, 360.0 * revolution), ylim=(-1.2 * largest, 1.75 * largest))
        ax.set_xticks([0.0, 180.0 * revolution, 360.0 * revolution])
        ax.yaxis.set_major_locator(MaxNLocator(3, symmetric=True))
    _name_axes(figure, axes, r"azimuth $\psi$ (degrees)", "entry less its mean (dimensionless)")
    handles = [
        Line2D([], [], color=DARK, lw=1.0, label="entry"),
        Line2D([], [], color=KEPT, lw=1.0, ls=DASHED, label="its mean, which the tip-path plane keeps"),
        Patch(color=pale(DROPPED), label="periodic part, which it drops"),
    ]
    _head(figure, f"{title};  numbers: mean ± amplitude", handles)
    return figure


@styled
def entries_against_mu(
    mu: Array, rotors: Mapping[str, tuple[Array, Array]], coordinates: Sequence[str],
    formulas: Mapping[tuple[str, str, str], str], *, title: str = ""
) -> Figure:  # fmt: skip
    """Entries of D̃ and K̃ (μ, n, n) of each rotor less their values at μ[0], all at one scale, with their formulas."""
    changes = {label: {n: m - m[0] for n, m in zip(MATRICES, pair, strict=True)} for label, pair in rotors.items()}
    every = [change for pair in changes.values() for change in pair.values()]
    low, high = min(float(x.min()) for x in every), max(float(x.max()) for x in every)
    room = high - low
    figure, axes = _matrices(coordinates, (r"\tilde{D}", r"\tilde{K}"))
    for (name, i, j), ax in axes.items():
        formula = formulas.get((name, coordinates[i], coordinates[j]))
        if formula is None:
            ax.set_facecolor(EMPTY)
        else:
            _zero_line(ax, DARK)
        for label, (colour, width) in zip(rotors, SERIES, strict=False):
            change = changes[label][name][:, i, j]
            if np.abs(change).max() > NOTHING:
                ax.plot(mu, change, color=colour, lw=width, zorder=3, gid=f"{name} {i} {j} {label}")
        _say(ax, f"${_mathematical(formula or '0')}$")
        ax.set(xlim=(mu[0], mu[-1]), ylim=(low - 0.08 * room, high + 0.35 * room))
        ax.set_xticks([mu[0], 0.5 * (mu[0] + mu[-1]), mu[-1]])
        ax.yaxis.set_major_locator(MaxNLocator(4))
    _name_axes(figure, axes, MU_LABEL, "entry less its value at hover (dimensionless)")
    handles = [Line2D([], [], color=c, lw=w, label=x) for x, (c, w) in zip(rotors, SERIES, strict=False)]
    _head(figure, title, [*handles, Line2D([], [], color=DARK, lw=1.0, ls=DASHED, label="value at hover")])
    return figure


def _matrices(coordinates: Sequence[str], names: Sequence[str]) -> tuple[Figure, dict[Place, Axes]]:
    """Axes by matrix, row and column: two matrices beside each other, rows and columns named by their coordinates."""
    n = len(coordinates)
    figure = new_figure(PAGE, (20.0 * n + 36.0) * MM, FOOTER_OF_ONE)
    grid = figure.subplots(n, 2 * n + 1, sharex=True, sharey=True, width_ratios=[1.0] * n + [0.1] + [1.0] * n)
    for gap in grid[:, n]:
        gap.remove()
    axes = {(MATRICES[k], i, j): grid[i, k * (n + 1) + j] for k, i, j in product((0, 1), range(n), range(n))}
    beside: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    for (matrix, i, j), ax in axes.items():
        if i == 0:
            prime = "'" if matrix == "D" else ""
            ax.set_title(rf"$\times\,{SYMBOLS[coordinates[j]]}{prime}$", fontsize=8.0, pad=3.0)
        if (i, j) == (0, 0):
            ax.annotate(f"${names[MATRICES.index(matrix)]}$", (0.0, 1.0), (0.0, 13.0), fontsize=9.5, **beside)
        if (matrix, j) == ("K", n - 1):
            ax.annotate(f"${SYMBOLS[coordinates[i]]}''$", (1.0, 0.5), (4.0, 0.0), va="center", fontsize=8.0, **beside)
        ax.tick_params(length=2.0, labelsize=6.5, pad=2.0)
    return figure, axes


def _name_axes(figure: Figure, axes: Mapping[Place, Axes], across: str, up: str) -> None:
    """A label under each matrix, one for both on the left."""
    n = 1 + max(j for _, _, j in axes)
    for matrix in MATRICES:
        for j in range(n):
            _inward(axes[matrix, n - 1, j])
        axes[matrix, n - 1, (n - 1) // 2].set_xlabel(across, x=0.5 if n % 2 else 1.05)
    figure.supylabel(up, fontsize=8.0)


def _inward(ax: Axes) -> None:
    """The first and the last label of the horizontal axis stay within it."""
    first, *_, last = ax.get_xticklabels()
    first.set_horizontalalignment("left")
    last.set_horizontalalignment("right")


def _zero_line(ax: Axes, colour: str = KEPT) -> None:
    ax.axhline(0.0, color=colour, lw=1.0, ls=DASHED, zorder=2)


def _say(ax: Axes, text: str) -> None:
    ax.text(0.03, 0.96, text, transform=ax.transAxes, va="top", fontsize=6.2, zorder=5)


def _number(x: float) -> str:
    return "0" if abs(x) < NOTHING else f"{x:.2f}".replace("-", "\N{MINUS SIGN}")


def _mathematical(formula: str) -> str:
    """``(cs1 - kc1)/2`` → ``(c_{s1} - k_{c1})/2``."""
    return re.sub(r"\b([ck])([cs]?\d)\b", r"\1_{\2}", formula)


def _head(figure: Figure, title: str, handles: Sequence[Any], columns: int | None = None) -> None:
    """Title above everything, and under it what lines and shades mean."""
    legend = figure.legend(
        handles=list(handles), loc="outside upper left", ncols=columns or len(handles), frameon=False, title=title,
        title_fontsize=8.5, alignment="left", handlelength=2.0, columnspacing=1.4, handletextpad=0.5, borderaxespad=0.2,
    )  # fmt: skip
    legend.get_title().set_position((0.0, 0.0))


# ---------------------------------------------------------------------- roots
@dataclass(frozen=True, kw_only=True)
class Root:
    """A root of the upper half plane by three models, nan where one has none; ``label`` tells rotors apart.

    ``exact_is_mean`` where the exact exponents are two and ``exact`` is their mean, which is none of them.
    """

    label: str
    mode: str
    unreduced: complex
    reduced: complex
    exact: complex
    exact_is_mean: bool = False


@styled
def characteristic_roots(gammas: Sequence[Root], families: Sequence[Root], *, title: str = "") -> Figure:
    """Roots of rotors that differ in γ, all and regressing; below, regressing ones of other rotors, a panel each."""
    slow = [root for root in gammas if root.mode == "regressing"]
    named: dict[str, list[Root]] = {}
    for root in families:
        if root.mode == "regressing":
            named.setdefault(root.label, []).append(root)
    figure = new_figure(PAGE, 146.0 * MM)
    grid = figure.add_gridspec(2, 1, height_ratios=[1.9, 1.0])
    above, below = grid[0].subgridspec(1, 2, width_ratios=[1.0, 1.12]), grid[1].subgridspec(1, len(named))
    right = above[1].subgridspec(2, 1, height_ratios=[0.75, 1.0])
    panels = {"all": figure.add_subplot(above[0]), "slow": figure.add_subplot(right[1])}
    _draw_roots(panels["all"], gammas, (-2.25, 0.12, -0.3, 2.14))
    _draw_roots(panels["slow"], slow, (-1.66, 0.06, -0.07, 0.69))
    panels["all"].set_title(r"all modes, with $\gamma$", loc="left")
    panels["slow"].set_title(r"regressing, with $\gamma$", loc="left")
    for place, (label, some) in enumerate(named.items()):
        ax = figure.add_subplot(below[place])
        _draw_roots(ax, some, (-0.57, -0.28, -0.025, 0.225), linked=True)
        ax.set_title(f"regressing\n{label}", loc="left")
        if place:
            ax.set_ylabel("")
            ax.tick_params(labelleft=False)
    _root_legend(figure.add_subplot(right[0]), title)
    settle(panels["all"])
    for ax, roots in ((panels["all"], gammas), (panels["slow"], slow)):
        _label_roots(ax, roots, regressing=ax is panels["slow"])
    return figure


def _root_legend(ax: Axes, title: str) -> None:
    dot: dict[str, Any] = {"color": DARK, "lw": 0.0}
    handles = [
        Line2D([], [], marker="o", ms=3.2, label="exact (Floquet)", **dot),
        Line2D([], [], marker="+", ms=5.0, mew=1.0, label="mean of a locked pair", **dot),
        Line2D([], [], marker="o", ms=6.0, mfc="none", mew=1.0, label="unreduced order (TPP)", **dot),
        Line2D([], [], marker="D", ms=4.2, mfc="none", mew=1.0, label="reduced order", **dot),
        *(Patch(color=COLOURS[mode], label=mode) for mode in ("regressing", "coning", "advancing")),
    ]
    ax.axis("off")
    found = ax.legend(handles=handles, loc="upper left", ncols=2, frameon=False, title=title, title_fontsize=8.5,
                      alignment="left", borderaxespad=0.0, handlelength=1.4, columnspacing=1.0)  # fmt: skip
    found.set_in_layout(False)


def _draw_roots(
    ax: Axes, roots: Sequence[Root], frame: tuple[float, float, float, float], *, linked: bool = False
) -> None:
    """Roots, ``linked`` with a line from the exact one to that of either model."""
    for root in roots:
        colour = COLOURS[root.mode]
        for other in (root.unreduced, root.reduced) if linked else ():
            ends = np.array([root.exact, other])
            ax.plot(ends.real, np.abs(ends.imag), color=pale(colour), lw=0.8, zorder=1)
        marker: dict[str, Any] = {"marker": "+", "ms": 5.0} if root.exact_is_mean else {"marker": "o", "ms": 3.2}
        ax.plot(root.exact.real, root.exact.imag, color=colour, lw=0.0, zorder=3, gid=f"exact {root.label}", **marker)
        for z, shape, size, name in ((root.unreduced, "o", 6.0, "unreduced"), (root.reduced, "D", 4.2, "reduced")):
            ax.plot(
                z.real, z.imag, shape, mfc="none", mec=colour, ms=size, mew=1.0, zorder=4, gid=f"{name} {root.label}"
            )
    ax.axhline(0.0, color=DARK, lw=0.5, zorder=0.5)
    ax.axvline(0.0, color=DARK, lw=0.5, zorder=0.5)
    ax.set(xlim=frame[:2], ylim=frame[2:], xlabel=r"real part (per rev)", ylabel="imaginary part\n(per rev)")
    for axis, length in ((ax.xaxis, frame[1] - frame[0]), (ax.yaxis, frame[3] - frame[2])):
        axis.set_major_locator(MultipleLocator(0.1 if length < 0.5 else 0.2 if length < 1.0 else 0.5))
    ax.set_aspect("equal")


def _label_roots(ax: Axes, roots: Sequence[Root], *, regressing: bool) -> None:
    """γ beside exact exponents, and beside reduced roots where they are far; a root left of the frame in words."""
    labels, left = Labels(ax), ax.get_xlim()[0]
    for root in roots:
        style: dict[str, Any] = {"fontsize": SMALL, "color": COLOURS[root.mode], "distance": 4.5}
        if root.mode != "regressing" or regressing:
            places = [z for z in (root.exact, root.unreduced) if np.isfinite(z)]
            labels.put(
                root.label, [(z.real, z.imag) for z in places], sides=((0, 1), *SIDES) if regressing else SIDES, **style
            )
        if regressing and root.reduced.imag > 0.25:  # below, exact and reduced roots are near each other
            labels.put(root.label, [(root.reduced.real, root.reduced.imag)], sides=[(1, 0)], **style)
        if root.mode == "coning" and root.reduced.real > left:
            at, below = [(root.reduced.real, 0.0)], {**style, "sides": [(0, -1)]}
            if labels.put(root.label, at, optional=True, **below) is None:  # in a second row
                labels.put(root.label, at, **{**below, "distance": 13.0})
        elif root.mode == "coning":
            text = f"\N{LEFTWARDS ARROW} {_number(root.reduced.real)} for {root.label}"
            labels.put(text, [(left, 0.0)], sides=[(1, 1)], **style)
