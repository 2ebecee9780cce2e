"""Root locus through locks: where two modes meet, part along one frequency, meet again and go on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from floquet.plot.curves import Band
from floquet.plot.labels import Labels, Side
from floquet.plot.parts import (
    COLOURS,
    DARK,
    DASHED,
    MU_LABEL,
    PAGE,
    SMALL,
    THIN,
    UNSTABLE,
    line_handles,
    new_figure,
    per_rev,
    settle,
    shade,
    styled,
    write_footer,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Locus", "through_locks"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
WIDTHS = {"regressing": 3.4, "coning": 1.3}
"""Where both modes share their exponents, the thinner lies on the wider."""
HALO = [withStroke(linewidth=2.0, foreground="white")]
ASIDE = 0.013  # of the width: an arrow's distance from the path


@dataclass(frozen=True, eq=False, kw_only=True)
class Locus:
    """Exponents of a rotor along the advance ratio.

    Attributes
    ----------
    title : str
    mu : (k,)
    exact : mode → complex (k, 2)
        In the upper half plane; both members are one outside locks.
    plane : mode → complex (k, 2)
        Of the tip-path plane, nan below the real axis.
    bands : (enter, leave, per rev)
        Locks, leave beyond ``mu`` where the last one does not end.
    marks : (m,)
        Advance ratios that are marked on the paths.
    """

    title: str
    mu: Array
    exact: Mapping[str, Complex]
    plane: Mapping[str, Complex]
    bands: Sequence[Band]
    marks: Array


@styled
def through_locks(one: Locus, *, width: float = PAGE) -> Figure:
    """The complex plane above; frequency and damping against μ below."""
    figure = new_figure(width, 6.6)
    write_footer(figure, "Where both modes share their exponents, a thin line lies on a wide one. No reversed flow.")
    grid = figure.add_gridspec(2, 2, height_ratios=(1.9, 1.0))
    plane = figure.add_subplot(grid[0, :])
    below = [figure.add_subplot(grid[1, k]) for k in (0, 1)]
    _draw_plane(plane, one)
    for ax, part, text in zip(below, (np.imag, np.real), ("frequency", "damping"), strict=True):
        _draw_against_mu(ax, one, part)
        ax.set(xlabel=MU_LABEL, ylabel=rf"{text}, {'Im' if part is np.imag else 'Re'} $\eta$ (per rev)")
    figure.legend(
        handles=_handles(), loc="outside upper left", ncols=5, frameon=False, title=one.title, alignment="left",
        title_fontsize=8.5, handlelength=2.4,
    )  # fmt: skip
    settle(plane)
    _name_plane(plane, one)
    for ax in below:
        _name_bands(ax, one)
    return figure


def _handles() -> list[Any]:
    modes = [Line2D([], [], color=COLOURS[mode], lw=lw, label=mode) for mode, lw in WIDTHS.items()]
    ring = Line2D([], [], color="black", marker="o", mfc="white", ms=5.0, lw=0, label="enters or leaves a lock")
    return [*modes, *line_handles(), ring]


# ---------------------------------------------------------------------- the complex plane
def _draw_plane(ax: Axes, one: Locus) -> None:
    for mode, lw in WIDTHS.items():
        for member in (0, 1):
            z, s = one.exact[mode][:, member], one.plane[mode][:, member]
            ax.plot(z.real, z.imag, color=COLOURS[mode], lw=lw, zorder=2.5, gid=f"Floquet {mode} {member}")
            ax.plot(s.real, s.imag, color=COLOURS[mode], lw=THIN, ls=DASHED, zorder=2.2, gid=f"TPP {mode} {member}")
        for mu in one.marks:
            _mark(ax, one, mode, float(mu))
    for mode in WIDTHS:
        for mu in _edges(one):
            z = _at(one, mode, mu)[0]
            ax.plot([z.real], [z.imag], "o", color="black", mfc="white", ms=5.0, zorder=5, gid=f"edge {mu:.4f}")
        z = one.exact[mode][0, 0]
        style: dict[str, Any] = {"color": COLOURS[mode], "mec": "black", "mew": 0.8, "ms": 4.0, "zorder": 5}
        ax.plot([z.real], [z.imag], "o", gid=f"hover {mode}", **style)
    z = np.concatenate([values.ravel() for values in one.exact.values()])
    left, right, top = z.real.min(), max(z.real.max(), 0.0), z.imag.max()
    ax.set(xlim=(left - 0.1, right + 0.08), ylim=(-0.09 * top, 1.12 * top))
    ax.set(xlabel=r"Re $\eta$ (per rev)", ylabel=r"Im $\eta$ (per rev)")
    ax.axvspan(0.0, right + 0.08, color=UNSTABLE, lw=0, zorder=0)
    ax.axvline(0.0, color=DARK, lw=0.8, zorder=1)
    ax.axhline(0.0, color=DARK, lw=0.5, zorder=1)


def _at(one: Locus, mode: str, mu: float) -> Complex:
    """Both members at the place nearest to an advance ratio."""
    return np.asarray(one.exact[mode][int(np.argmin(np.abs(one.mu - mu)))])


def _edges(one: Locus) -> list[float]:
    return [edge for band in one.bands for edge in band[:2] if edge <= one.mu[-1]]


def _locked(one: Locus, mu: float) -> bool:
    return any(enter < mu < leave for enter, leave, _ in one.bands)


def _mark(ax: Axes, one: Locus, mode: str, mu: float) -> None:
    """Ticks across the path of the exact exponents, dots on that of the tip-path plane."""
    for z in _at(one, mode, mu)[: 2 if _locked(one, mu) else 1]:
        marker = "|" if _locked(one, mu) else "_"
        ax.plot([z.real], [z.imag], marker, color=DARK, ms=6.0, mew=1.0, zorder=4, gid=f"mark {mode} {mu:g}")
    for s in one.plane[mode][int(np.argmin(np.abs(one.mu - mu)))]:
        ax.plot([s.real], [s.imag], "o", color=COLOURS[mode], mfc="white", ms=2.6, mew=0.8, zorder=4, gid="TPP mark")


def _name_plane(ax: Axes, one: Locus) -> None:
    """Arrows beside the free ways, texts at the edges of locks, advance ratios at the marks."""
    for mode in WIDTHS:
        _arrows(ax, one, mode)
    labels = Labels(ax, margin=-1.0)
    style: dict[str, Any] = {"fontsize": SMALL, "path_effects": HALO, "zorder": 7.0}
    _name_edges(labels, one, style)
    for mode in WIDTHS:
        z = one.exact[mode][0, 0]
        at = [(float(z.real), float(z.imag))]
        labels.put(
            f"{mode}, hover", at, sides=((-1, 0), (-1, 1), (-1, -1)), distance=14.0, color=COLOURS[mode], **style
        )
    for mode in WIDTHS:
        _name_marks(labels, one, mode)
    for mode in WIDTHS:
        s = one.plane[mode][one.mu > 0.25, 0]
        at = [(float(v.real), float(v.imag)) for v in s[s.real > ax.get_xlim()[0]][::4]]
        labels.put(f"{mode}, TPP", at, distance=6.0, color=COLOURS[mode], **style)
    middle = [(0.0, 0.5 * sum(ax.get_ylim()))]
    labels.put("unstable", middle, sides=((1, 0),), distance=2.0, rotation=90, color=DARK, **style)


def _free(one: Locus) -> list[tuple[float, float]]:
    """Ranges of the advance ratio between the locks."""
    ends = [0.0, *(edge for band in one.bands for edge in band[:2]), float(one.mu[-1])]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=False) if b <= one.mu[-1] and a < b]


def _arrows(ax: Axes, one: Locus, mode: str) -> None:
    """One arrow a free way, on the left of the path for the first, on the right for the next."""
    low, high = ax.get_xlim()
    for k, (a, b) in enumerate(_free(one)):
        side = -1.0 if k % 2 == 0 else 1.0
        start, end = (_at(one, mode, mu)[0] for mu in (a, b))
        x = start.real + side * ASIDE * (high - low)
        y0, y1 = (start.imag + f * (end.imag - start.imag) for f in (0.12, 0.88))
        style = {"arrowstyle": "->", "color": COLOURS[mode], "lw": 1.1, "shrinkA": 0.0, "shrinkB": 0.0}
        ax.annotate("", (x, y1), (x, y0), arrowprops=style, zorder=4).set_in_layout(False)


def _name_edges(labels: Labels, one: Locus, style: dict[str, Any]) -> None:
    """Lock and its ends where two members meet, and the end of the way out and back at its tip."""
    sides: tuple[Side, ...] = ((1, -1), (1, 1), (-1, 1), (-1, -1))
    named: set[tuple[float, float]] = set()
    for enter, leave, rho in one.bands:
        ends = rf"from $\mu$ = {enter:.3f}" + (f"\nto {leave:.3f}" if leave <= one.mu[-1] else "")
        for mode in WIDTHS:
            z = _at(one, mode, enter)[0]
            at = (float(np.round(z.real, 6)), float(np.round(z.imag, 6)))
            if at not in named:
                labels.put(f"locked at {per_rev(rho)}\n{ends}", [at], sides=sides, distance=16.0, **style)
            if at not in named and leave <= one.mu[-1]:
                inside = (one.mu > enter) & (one.mu < leave)
                k = int(np.argmax(np.where(inside, one.exact[mode].real.max(axis=1), -math.inf)))
                tip = max(one.exact[mode][k], key=lambda value: value.real)
                text = rf"turns at $\mu$ = {one.mu[k]:.2f}"
                labels.put(text, [(float(tip.real), float(tip.imag))], sides=((1, 0), (1, -1)), distance=6.0, **style)
            named.add(at)


def _name_marks(labels: Labels, one: Locus, mode: str) -> None:
    """μ at ticks where there is room: in locks above where members part, below where they come together again."""
    style: dict[str, Any] = {"fontsize": "x-small", "color": DARK, "zorder": 7.0, "optional": True, "apart": 2.0}
    first = _free(one)[0][1]
    for mu in one.marks.tolist():
        members, side = _at(one, mode, mu)[:1], (-1, 0) if mu < first else (1, 0)
        if _locked(one, mu):
            gap, later = (abs(np.diff(_at(one, mode, x).real)[0]) for x in (mu - 0.02, mu + 0.02))
            members, side = _at(one, mode, mu), (0, 1) if later > gap or mu == one.mu[-1] else (0, -1)
        for z in members:
            labels.put(f"{mu:.1f}", [(float(z.real), float(z.imag))], sides=(side,), distance=5.0 + 6.0 * abs(side[0]),
                       **style)  # fmt: skip


# ---------------------------------------------------------------------- against μ
def _draw_against_mu(ax: Axes, one: Locus, part: Any) -> None:
    end = float(one.mu[-1])
    for mode, lw in WIDTHS.items():
        for member in (0, 1):
            z, s = one.exact[mode][:, member], one.plane[mode][:, member]
            ax.plot(one.mu, part(z), color=COLOURS[mode], lw=lw, zorder=2.5, gid=f"Floquet {mode} {member}")
            ax.plot(one.mu, part(s), color=COLOURS[mode], lw=THIN, ls=DASHED, zorder=3.0, gid=f"TPP {mode} {member}")
    shade(ax, one.bands, end)
    values = np.concatenate([part(z).ravel() for z in one.exact.values()])
    low, high = float(values.min()), float(values.max())
    ax.set(xlim=(0.0, end), ylim=(low - 0.08 * (high - low), high + 0.3 * (high - low)))


def _name_bands(ax: Axes, one: Locus) -> None:
    """The frequency of each lock at its top, on two lines where it is narrow."""
    labels = Labels(ax)
    for enter, leave, rho in one.bands:
        end = min(leave, float(one.mu[-1]))
        narrow = end - enter < 0.25 * one.mu[-1]
        text = per_rev(rho).replace(" rev", "\nrev") if narrow else f"locked at {per_rev(rho)}"
        at = [(0.5 * (enter + end), ax.get_ylim()[1])]
        labels.put(text, at, sides=((0, -1),), distance=3.0, fontsize=SMALL, color=DARK)
