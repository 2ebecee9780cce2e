"""Root loci of families of rotors: figures 3 to 12 of NASA TP-1431.

====================  =================================================================================================
:func:`hover_loci`    modes at hover as a carpet: curves of a constant parameter, and of a constant Lock number
:func:`order_loci`    roots at hover of the TPP (solid) and of its reduced order (dashed), and how far they are apart
:func:`forward_loci`  paths with the advance ratio, a curve for each Lock number: Floquet solid, TPP dashed
====================  =================================================================================================

Colours run from dark to light with the parameter that is named in the legend or at the curves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from floquet.families import MODES, Carpet, Family
from floquet.plot.curves import Array, Complex, Rows, exact_curves, tpp_curves
from floquet.plot.labels import SIDES, Labels, along
from floquet.plot.parts import (
    DARK,
    DASHED,
    FOOTER_OF_ONE,
    MM,
    PAGE,
    SMALL,
    THIN,
    UNSTABLE,
    line_handles,
    new_figure,
    styled,
    write_footer,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["SYMBOLS", "forward_loci", "hover_loci", "order_loci", "shades"]

SYMBOLS = {"hinge_offset": r"$\varepsilon$", "hinge_stiffness": r"$\kappa$", "pitch_flap_coupling": "$K_1$"}
GREY, WIDE, DOT = "0.62", 1.5, 2.9
SLOW = 0.5  # per rev: 2.5 Hz at 300 rpm, the region that NASA TP-1431 looks at
AT_HOVER = (
    "At hover the TPP (tip-path plane) is exact. Of each pair of cyclic exponents the one of a\u2081 + i b\u2081 is "
    "drawn: with Im \u03b7 < 0 the disc precesses against the rotation."
)
FORWARD = (
    "Of each pair the member with Im \u03b7 \u2265 0 is drawn, where figures at hover draw the signed one of "
    "a\u2081 + i b\u2081. "
    "In a lock the exact exponents part along a horizontal line; where such curves lie on each other, the wider has "
    "the larger \u03b3. Each curve of the TPP (tip-path plane) is followed from hover."
)


def shades(count: int) -> list[str]:
    """Colours from dark to light that the colour-blind can tell apart and that are seen on white."""
    return [to_hex(matplotlib.colormaps["viridis"](x)) for x in np.linspace(0.0, 0.86, count)]


# ---------------------------------------------------------------------- hover
@styled
def hover_loci(family: Family, modes: Mapping[str, Carpet], *, width: float = PAGE) -> Figure:
    """All modes, the regressing one enlarged, and its undamped frequency against γ.

    Parameters
    ----------
    family : Family
    modes : mode → Carpet
        Of :func:`floquet.families.hover_roots`.
    """
    box, slow = _box([carpet.along for carpet in modes.values()]), _slow_box(modes["regressing"].along)
    left = 0.40 * width if box.width < 1.5 else 0.47 * width
    figure = new_figure(width, left * box.height / box.width + 22.0 * MM, FOOTER_OF_ONE)
    grid = figure.add_gridspec(2, 2, width_ratios=(left, 0.88 * width - left))
    whole, enlarged, frequency = (figure.add_subplot(grid[at]) for at in (np.s_[:, 0], np.s_[0, 1], np.s_[1, 1]))
    _draw_carpets(whole, modes)
    _draw_carpets(enlarged, {"regressing": modes["regressing"]})
    _draw_frequency(frequency, family, modes)
    for ax, inside, title in ((whole, box, "all modes"), (enlarged, slow, "regressing, enlarged")):
        turn = np.linspace(0.0, 2.0 * math.pi, 400)
        ax.plot(SLOW * np.cos(turn), SLOW * np.sin(turn), color=DARK, lw=0.8, ls=DASHED, zorder=1.5, gid="slow")
        _frame_plane(ax, inside, title)
    _head(figure, [*_value_handles(family), _gamma_handle(family, "constant")])
    write_footer(figure, f"{AT_HOVER} {_numbered(family, 0)}")
    _settle(figure)
    _label_whole(whole, family, modes)
    _label_enlarged(enlarged, family, modes["regressing"])
    return figure


def _draw_carpets(ax: Axes, modes: Mapping[str, Carpet]) -> None:
    for mode, carpet in modes.items():
        for k, z in enumerate(carpet.across):
            ax.plot(z.real, z.imag, color=GREY, lw=0.6, zorder=2, gid=f"across {mode} {k}")
        for k, colour in enumerate(shades(len(carpet.dots))):
            _curve(ax, carpet.along[k].real, carpet.along[k].imag, colour, f"along {mode} {k}")
            _dots(ax, carpet.dots[k].real, carpet.dots[k].imag, colour, f"dots {mode} {k}")


def _draw_frequency(ax: Axes, family: Family, modes: Mapping[str, Carpet]) -> None:
    """ω_n of the regressing mode, up to critical damping, beyond which no pair regresses."""
    carpet, over = modes["regressing"], modes["coning, faster"]
    for k, colour in enumerate(shades(len(family.values))):
        fine, at = (np.where(np.isnan(o[k].real), np.abs(z[k]), np.nan)
                    for z, o in ((carpet.along, over.along), (carpet.dots, over.dots)))  # fmt: skip
        _curve(ax, carpet.lock_numbers, fine, colour, f"frequency {k}")
        _dots(ax, family.lock_numbers, at, colour, f"frequency dots {k}")
        end = np.flatnonzero(np.isfinite(fine))[-1]
        if abs(modes["coning"].along[k, end].imag) < 1e-6:
            ax.annotate(r"$\zeta$ = 1", (carpet.lock_numbers[end], fine[end]), (-4.0, 1.0), textcoords="offset points",
                        ha="right", va="bottom", color=colour, fontsize=SMALL)  # fmt: skip
    ax.axhline(SLOW, color=DARK, lw=0.8, ls=DASHED, zorder=1.5)
    _frame_gamma(ax, family, "", r"regressing $\omega_n$ (per rev)")
    ax.set(yscale="log", ylim=(0.1, 2.0), xlabel=r"Lock number $\gamma$")
    ax.yaxis.set_major_locator(FixedLocator([0.1, 0.2, 0.5, 1.0, 2.0]))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())


def _label_whole(ax: Axes, family: Family, modes: Mapping[str, Carpet]) -> None:
    labels = Labels(ax)
    _label_stable(labels)
    for mode in MODES:
        last = modes[mode].along[-1]
        labels.put(mode, along(last.real, last.imag), sides=((1, 0), (0, 1), (0, -1)), distance=5.0, fontsize=SMALL)
    for mode in MODES:  # where pairs meet, at critical damping, one number is enough
        met = mode == "advancing" and np.isclose(modes["regressing"].dots[0], modes[mode].dots[0])
        _label_gamma(labels, family, np.where(met, np.nan, modes[mode].dots[0]))


def _label_enlarged(ax: Axes, family: Family, carpet: Carpet) -> None:
    labels = Labels(ax)
    turn = math.pi * np.linspace(0.55, 1.45, 80)
    at = list(zip(SLOW * np.cos(turn), SLOW * np.sin(turn), strict=True))
    labels.put(r"$\omega_n$ = 0.5", at, sides=((-1, 1), (-1, 0), (-1, -1), (1, 0)), fontsize=SMALL, color=DARK)
    _label_stable(labels)
    _label_gamma(labels, family, carpet.dots[0])


# ---------------------------------------------------------------------- reduced order
@styled
def order_loci(family: Family, modes: Mapping[str, Carpet], *, width: float = PAGE) -> Figure:
    """The low-frequency roots of the TPP and of its reduced order, their distance, and the decay of coning.

    Parameters
    ----------
    family : Family
    modes : mode → Carpet
        Of :func:`floquet.families.reduced_roots`.
    """
    full, reduced = modes["cyclic"], modes["cyclic, reduced"]
    box, left = _box([full.along, reduced.along]), 0.5 * width
    figure = new_figure(width, left * box.height / box.width + 26.0 * MM)
    grid = figure.add_gridspec(2, 2, width_ratios=(left, 0.88 * width - left))
    locus, error, decay = (figure.add_subplot(grid[at]) for at in (np.s_[:, 0], np.s_[0, 1], np.s_[1, 1]))
    for between in zip(full.dots.T.ravel(), reduced.dots.T.ravel(), strict=True):
        locus.plot(np.real(between), np.imag(between), color=GREY, lw=0.6, zorder=2, gid="between")
    fine, at = full.lock_numbers, family.lock_numbers
    for k, colour in enumerate(shades(len(family.values))):
        for name, carpet in (("full", full), ("reduced", reduced)):
            _curve(locus, carpet.along[k].real, carpet.along[k].imag, colour, f"{name} {k}")
            _dots(locus, carpet.dots[k].real, carpet.dots[k].imag, colour, f"{name} dots {k}")
        _curve(error, fine, _percent_apart(full.along[k], reduced.along[k]), colour, f"error {k}")
        _dots(error, at, _percent_apart(full.dots[k], reduced.dots[k]), colour, f"error dots {k}")
        for name, mode in (("full", "coning"), ("faster", "coning, faster"), ("reduced", "coning, reduced")):
            _curve(decay, fine, -modes[mode].along[k].real, colour, f"{name} {k}")
            _dots(decay, at, -modes[mode].dots[k].real, colour, f"{name} dots {k}")
    _frame_plane(locus, box, "regressing")
    _frame_gamma(error, family, "regressing", "error of the root (%)")
    error.set_ylim(0.0, 55.0)
    error.tick_params(labelbottom=False)
    _frame_gamma(decay, family, "coning", r"$-$Re $\eta$ (per rev)")
    decay.set(yscale="log", ylim=(0.05, 10.0), xlabel=r"Lock number $\gamma$")
    decay.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    _head(figure, [*_value_handles(family), *_order_handles(), _gamma_handle(family, "one")])
    write_footer(figure, f"{AT_HOVER} {_numbered(family, -1)}")
    _settle(figure)
    labels = Labels(locus)
    _label_stable(labels)
    _label_gamma(labels, family, full.dots[-1])
    _label_decay(decay, family, modes["coning"])
    return figure


def _percent_apart(full: Complex, reduced: Complex) -> Array:
    return np.asarray(100.0 * np.abs(reduced - full) / np.abs(full))


def _label_decay(ax: Axes, family: Family, coning: Carpet) -> None:
    """Say so where the curves of all values are one, and up to which γ if one of them leaves."""
    gamma, one = coning.lock_numbers, np.isclose(coning.along.real, coning.along[-1].real).all(axis=0)
    if one[0]:
        anchors = along(gamma, np.where(one, -coning.along[-1].real, np.nan))
        end = "" if one.all() else rf" up to $\gamma$ = {gamma[one].max():.1f}"
        text = f"TPP, every {SYMBOLS[family.parameter]}{end}"
        Labels(ax).put(text, anchors, sides=((1, -1),), fontsize=SMALL, color=DARK)


def _order_handles() -> list[Any]:
    dots: dict[str, Any] = {"color": DARK, "marker": "o", "ms": DOT}
    return [
        Line2D([], [], lw=WIDE, mew=0.0, label="TPP", **dots),
        Line2D([], [], lw=THIN, ls=DASHED, mfc="white", mew=0.7, label=r"reduced order, $\ddot a$ = 0", **dots),
    ]


# ---------------------------------------------------------------------- forward flight
class _Path(NamedTuple):
    """One mode of one rotor: exponents (n, 2) of both models along μ and those (m, 2) at 0, 0.1 …; Im η of the lock."""

    exact: Complex
    simple: Complex
    exact_dots: Complex
    simple_dots: Complex
    line: float

    @property
    def start(self) -> complex:
        """At hover."""
        return complex(self.exact_dots[0, 0])

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Which of the exact exponents are in a lock."""
        return np.isfinite(self.exact[:, 1].real)


@styled
def forward_loci(rows: Sequence[Rows], name: str, *, enlarged: int = 0, width: float = PAGE) -> Figure:
    """Paths of the exponents with μ, Floquet and TPP, a curve for each Lock number.

    Parameters
    ----------
    rows : sequence of rows
        Of one Lock number each, of :func:`floquet.families.forward_rows`.
    name : str
        The other parameters.
    enlarged : int
        So many of the first Lock numbers are shown once more, enlarged, of the regressing mode.
    """
    paths = {mode: [_path(one, mode) for one in rows] for mode in MODES}
    figure, panels = _forward_panels(paths, enlarged, width)
    gammas, colours = [float(one["lock_number"][0]) for one in rows], shades(len(rows))
    for ax, mode, count in panels:
        for k in range(count):
            _draw_path(ax, paths[mode][k], colours[k], k, _under(paths[mode], k))
    _head(figure, _forward_handles(), title=rf"{name}; numbers beside curves are Lock numbers $\gamma$")
    write_footer(figure, FORWARD)
    _settle(figure)
    for ax, mode, count in panels:
        _label_paths(ax, paths[mode][:count], gammas, colours)
    return figure


def _forward_panels(
    paths: Mapping[str, Sequence[_Path]], enlarged: int, width: float
) -> tuple[Figure, list[tuple[Axes, str, int]]]:
    """Axes, mode and number of paths: the regressing mode over the whole width, unless it is tall."""
    count = len(paths["regressing"])
    whole, few = _with_axis(_around(paths["regressing"])), _around(paths["regressing"][: enlarged or count])
    others = _alike(_around(paths["coning"]), _around(paths["advancing"]))
    tall = whole.height > 0.5 * whole.width
    wide = [] if tall else [whole, few] if enlarged else [whole]
    pairs = [(whole, few), others] if tall else [others]
    heights = [(width - 18.0 * MM) * box.height / box.width for box in wide]
    heights += [(0.5 * width - 18.0 * MM) * max(box.height / box.width for box in pair) for pair in pairs]
    figure = new_figure(width, sum(heights) + (22.0 + 18.0 * len(heights)) * MM)
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
    cells = [(grid[k, :], box) for k, box in enumerate(wide)]
    cells += [(grid[len(wide) + i, j], pair[j]) for i, pair in enumerate(pairs) for j in (0, 1)]
    more = [("regressing", enlarged, "regressing, enlarged")] if enlarged or tall else []
    kinds = [("regressing", count, "regressing"), *more, *((mode, count, mode) for mode in MODES[1:])]
    panels = []
    for (cell, box), (mode, shown, title) in zip(cells, kinds, strict=True):
        ax = figure.add_subplot(cell)
        _frame_plane(ax, box, title)
        panels.append((ax, mode, shown))
    return figure, panels


def _path(rows: Rows, mode: str) -> _Path:
    exact, (mu, simple) = exact_curves(rows), tpp_curves(rows)[mode]
    z = exact.mode(mode)
    locked = z.imag[np.isfinite(z[:, 1].real), 0]
    return _Path(z, simple, _marked(exact.mu, z), _marked(mu, simple), float(locked[-1]) if locked.size else math.nan)


def _marked(mu: Array, z: Complex) -> Complex:
    """Those at μ = 0, 0.1, 0.2 …"""
    return z[np.isclose(10.0 * mu, np.round(10.0 * mu), atol=1e-9)]


def _under(paths: Sequence[_Path], k: int) -> int:
    """How many curves of lower Lock numbers lie on this one in its lock."""
    here = paths[k].exact[paths[k].locked].real
    there = [path.exact[path.locked].real for path in paths[:k] if path.line == paths[k].line]
    return sum(bool(z.max() > here.min() and z.min() < here.max()) for z in there)


def _draw_path(ax: Axes, path: _Path, colour: str, k: int, rank: int) -> None:
    """Floquet solid, wider where locked if ``rank`` thinner ones lie on it, with ticks for dots; TPP dashed."""
    locked, split = path.locked, np.isfinite(path.exact_dots[:, 1].real)
    free = np.where(locked, np.nan, path.exact[:, 0])
    _curve(ax, free.real, free.imag, colour, f"Floquet {k}", zorder=2.5)
    for member in (0, 1):
        z, s = np.where(locked, path.exact[:, member], np.nan), path.simple[:, member]
        _curve(ax, z.real, z.imag, colour, f"Floquet locked {k}", lw=WIDE + 1.4 * rank, zorder=2.4 - 0.1 * rank)
        _curve(ax, s.real, s.imag, colour, f"TPP {k}")
    exact, ticks, simple = (np.ravel(z) for z in (path.exact_dots[~split], path.exact_dots[split], path.simple_dots))
    _dots(ax, exact.real, exact.imag, colour, f"Floquet dots {k}")
    _dots(ax, ticks.real, ticks.imag, colour, f"Floquet locked dots {k}", marker="|", ms=5.0 + 1.4 * rank, mew=0.7)
    _dots(ax, simple.real, simple.imag, colour, f"TPP dots {k}")
    _dots(ax, [path.start.real], [path.start.imag], colour, f"hover {k}", ms=3.4, mec="black", mew=0.8, zorder=5.0)


def _label_paths(ax: Axes, paths: Sequence[_Path], gammas: Sequence[float], colours: Sequence[str]) -> None:
    """γ at the start of every path, on the side away from the line that it is locked to."""
    labels = Labels(ax)
    if ax.viewLim.x1 > 0.0:
        _label_stable(labels)
    for path, gamma, colour in zip(paths, gammas, colours, strict=False):
        z, sides = path.start, SIDES
        if math.isfinite(path.line):
            away = 1 if z.imag > path.line else -1
            sides = ((0, away), (1, away), (-1, away), (1, 0), (-1, 0))
        labels.put(f"{gamma:g}", [(z.real, z.imag)], sides=sides, color=colour, distance=3.5, fontsize=SMALL)


def _forward_handles() -> list[Any]:
    dot: dict[str, Any] = {"color": DARK, "marker": "o", "lw": 0}
    marks = r"$\mu$ = 0.1, 0.2, 0.3, 0.4 (open: TPP; tick: Floquet in a lock)"
    return [
        *line_handles(),
        Line2D([], [], ms=3.4, mew=0.8, mfc=GREY, mec="black", label=r"hover", **dot),
        Line2D([], [], ms=DOT, mew=0.0, label=marks, **dot),
    ]


# ---------------------------------------------------------------------- parts
def _curve(ax: Axes, x: Any, y: Any, colour: str, gid: str, **style: Any) -> None:
    """Solid, or thin and dashed for the simpler of two models."""
    simple = gid.startswith(("TPP", "reduced"))
    usual: dict[str, Any] = {"lw": THIN, "ls": DASHED, "zorder": 3.2} if simple else {"lw": WIDE, "zorder": 3.0}
    ax.plot(x, y, color=colour, gid=gid, solid_capstyle="butt", **{**usual, **style})


def _dots(ax: Axes, x: Any, y: Any, colour: str, gid: str, **style: Any) -> None:
    """Full, or open for the simpler of two models."""
    simple = gid.startswith(("TPP", "reduced"))
    usual: dict[str, Any] = {"marker": "o", "ms": DOT, "mew": 0.7 if simple else 0.0, "zorder": 4.0}
    ax.plot(x, y, color=colour, mfc="white" if simple else colour, lw=0, gid=gid, **{**usual, **style})


def _box(curves: Sequence[Complex]) -> Bbox:
    """Around the roots and 0, with some of the unstable half plane."""
    z = np.concatenate([np.ravel(c) for c in curves])
    z = z[np.isfinite(z.real)]
    low, high = min(z.imag.min(), 0.0), z.imag.max()
    space = 0.06 * (high - low)
    return Bbox.from_extents(z.real.min() - space, low - space, space, high + space)


def _slow_box(curves: Complex) -> Bbox:
    """Around the roots of a frequency up to ``SLOW``, and where its circle crosses the real axis."""
    slow = curves[np.abs(curves) < 1.02 * SLOW]
    return Bbox.from_extents(-1.2 * SLOW, slow.imag.min() - 0.05, 0.04, slow.imag.max() + 0.08)


def _around(paths: Sequence[_Path]) -> Bbox:
    """A box with room for a label below and above."""
    z = np.concatenate([np.ravel(part) for path in paths for part in (path.exact, path.simple)])
    z = z[np.isfinite(z.real)]
    aside = 0.05 * np.ptp(z.real)
    above = max(0.12 * np.ptp(z.imag), 0.06 * np.ptp(z.real))
    low, high = complex(z.real.min(), z.imag.min()), complex(z.real.max(), z.imag.max())
    return Bbox.from_extents(low.real - aside, low.imag - above, high.real + 1.5 * aside, high.imag + above)


def _alike(*boxes: Bbox) -> list[Bbox]:
    """Boxes of one size, from the same left to the same right end."""
    left, right, half = min(b.x0 for b in boxes), max(b.x1 for b in boxes), 0.5 * max(b.height for b in boxes)
    middles = [0.5 * (b.y0 + b.y1) for b in boxes]
    return [Bbox.from_extents(left, middle - half, right, middle + half) for middle in middles]


def _with_axis(box: Bbox) -> Bbox:
    """The same box up to the imaginary axis and a little of what is behind it."""
    return Bbox.from_extents(box.x0, box.y0, max(box.x1, 0.06 * box.width), box.y1)


def _frame_plane(ax: Axes, box: Bbox, title: str) -> None:
    """Equal scales, the axes and the unstable half plane."""
    ax.set(xlim=(box.x0, box.x1), ylim=(box.y0, box.y1), xlabel=r"Re $\eta$ (per rev)", ylabel=r"Im $\eta$ (per rev)")
    ax.set_title(title, loc="left")
    ax.set_aspect("equal", adjustable="box")
    ax.axvspan(0.0, max(box.x1, 0.0), color=UNSTABLE, lw=0, zorder=0, gid="unstable")
    ax.axvline(0.0, color=DARK, lw=0.8, zorder=1)
    ax.axhline(0.0, color=DARK, lw=0.5, zorder=1)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))


def _frame_gamma(ax: Axes, family: Family, title: str, text: str) -> None:
    gamma = family.lock_numbers
    ax.set(xlim=(gamma[0] - 0.6, gamma[-1] + 0.6), ylabel=text)
    ax.set_title(title, loc="left")
    ax.xaxis.set_major_locator(FixedLocator(gamma))


def _value_handles(family: Family) -> list[Any]:
    """The parameter's values for a legend, with a minus and not a hyphen."""
    texts = [f"{SYMBOLS[family.parameter]} = {value:g}".replace("-", "\u2212") for value in family.values]
    return [Line2D([], [], color=c, lw=1.8, label=text) for c, text in zip(shades(len(texts)), texts, strict=True)]


def _numbered(family: Family, which: int) -> str:
    """Which curve has its Lock numbers beside it."""
    value = f"{family.values[which]:g}".replace("-", "\u2212")
    return rf"Numbers beside dots are $\gamma$, on the curve of {SYMBOLS[family.parameter]} = {value}."


def _gamma_handle(family: Family, word: str) -> Any:
    gamma = rf"{word} $\gamma$ = {family.lock_numbers[0]:g}, {family.lock_numbers[1]:g} … {family.lock_numbers[-1]:g}"
    return Line2D([], [], color=GREY, lw=0.8, marker="o", ms=DOT, mfc=DARK, mew=0.0, label=gamma)


def _head(figure: Figure, handles: Sequence[Any], *, title: str = "") -> None:
    figure.legend(
        handles=list(handles), loc="outside upper left", ncols=len(handles), frameon=False, borderaxespad=0.2,
        handlelength=2.0, columnspacing=1.4, handletextpad=0.5, title=title or None, title_fontsize=8.5,
        alignment="left",
    )  # fmt: skip


def _settle(figure: Figure) -> None:
    """Find the places on which labels depend, and keep them: with equal scales every round of layout moves them."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")


def _label_stable(labels: Labels) -> None:
    """Which side is stable, and which is not."""
    y0, y1 = labels.ax.get_ylim()
    at = [(0.0, y0 + f * (y1 - y0)) for f in (0.5, 0.35, 0.65, 0.2, 0.8)]
    for word, side in (("stable", -1), ("unstable", 1)):
        labels.put(word, at, sides=((side, 0),), distance=2.0, rotation=90, fontsize=SMALL, color=DARK)


def _label_gamma(labels: Labels, family: Family, dots: Complex) -> None:
    """γ beside the dots of one curve where there is room, the ends first."""
    count = len(family.lock_numbers)
    for i in (0, count - 1, *range(1, count - 1)):
        at = (float(dots[i].real), float(dots[i].imag))
        if labels.ax.viewLim.contains(*at):
            labels.put(f"{family.lock_numbers[i]:g}", [at], distance=2.5, optional=True, fontsize="x-small")
