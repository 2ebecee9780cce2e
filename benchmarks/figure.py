"""The work-precision diagram: error against time, a line a contender, a dot a setting; the lower left is best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from floquet.plot import write_figure
from floquet.plot.labels import Labels
from floquet.plot.parts import DARK, DASHED, DOTTED, PAGE, SMALL, new_figure, root_figure, settle, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from benchmarks.speed import Result

__all__ = ["work_precision", "write_work_precision"]

ROOT = Path(__file__).resolve().parents[1]
SHARPNESS = 200
STYLES: dict[str, dict[str, Any]] = {
    "floquet": {"color": "#D55E00", "lw": 2.2, "ms": 7.0},
    "floquet without numba": {"color": "#E69F00", "lw": 2.2, "ms": 7.0},
    "heyoka, Hill form": {"color": "#0072B2"},
    "heyoka, as written": {"color": "#56B4E9"},
    "numbalsoda DOP853": {"color": "#009E73"},
    "numbalsoda LSODA": {"color": "#009E73", "ls": DASHED},
    "diffrax Dopri8": {"color": "#CC79A7"},
    "SciPy DOP853": {"color": "black"},
    "SciPy LSODA": {"color": "black", "ls": DASHED},
    "NumPy RK4": {"color": "#888888"},
}
"""The palette of Okabe and Ito; one colour a library, its second method dashed."""
USUAL: dict[str, Any] = {"lw": 1.3, "ms": 4.5, "ls": "-"}
MEDIANS: dict[str, Any] = {"lw": 0.8, "mfc": "white", "mew": 0.9, "zorder": 3}
LEAST = 3e-17  # what is nearer to the truth is drawn here
ROUNDING = float(np.finfo(float).eps)
FOOTER = "From parameters to both exponents, one core of one processor, at the size of batch that suits each."


def write_work_precision(results: Sequence[Result]) -> Path:
    """Draw the measured contenders; the page's picture is replaced only by one with everybody in it."""
    complete = set(STYLES) <= {result.contender.name for result in results}
    path = ROOT / ("docs/images" if complete else "results") / "work-precision.png"
    path.parent.mkdir(exist_ok=True)
    write_figure(root_figure(work_precision(results)), path, SHARPNESS)
    return path.relative_to(ROOT)


@styled
def work_precision(results: Sequence[Result]) -> Axes:
    """One Axes with everybody, in the order of STYLES, ours on top."""
    curves: dict[str, list[Result]] = {name: [] for name in STYLES}
    for result in results:
        if result.contender.answers:
            curves[result.contender.name].append(result)
    ax = new_figure(PAGE, 0.68 * PAGE, FOOTER).subplots()
    for name, curve in reversed(curves.items()):
        if curve:
            draw(ax, curve, USUAL | STYLES[name])
    frame(ax)
    settle(ax)
    label(ax, {name: curve for name, curve in curves.items() if curve})
    return ax


def draw(ax: Axes, curve: Sequence[Result], style: Mapping[str, Any]) -> None:
    """Largest errors as dots on a line, medians as rings on a thin one, and a pale band between."""
    x = np.array([1e6 * result.best for result in curve])
    worst, middle = (np.array([max(f(result.errors), LEAST) for result in curve]) for f in (np.max, np.median))
    ax.plot(x, worst, marker="o", mec="white", mew=0.5, zorder=4, **style)
    ax.plot(x, middle, marker="o", **(dict(style) | MEDIANS | {"ms": style["ms"] - 1.0}))
    ax.vlines(x, middle, worst, color=style["color"], lw=0.6, alpha=0.5, zorder=2)
    ax.fill_between(x, middle, worst, color=style["color"], alpha=0.07, lw=0, zorder=1)


def frame(ax: Axes) -> None:
    """Logarithmic scales a factor of ten a step, the rounding of a number, what dots and rings mean."""
    ax.set(xscale="log", yscale="log", xlabel="time for one blade (µs)", ylabel="error of its exponents (per rev)")
    low, high = ax.get_xlim()
    ax.set(xlim=(0.5 * low, 2.2 * high), ylim=(2e-17, 2e-4))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    ax.yaxis.set_major_locator(LogLocator(numticks=20))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_minor_locator(NullLocator())
    ax.grid(color="#EEEEEE", lw=0.6, zorder=0)
    ax.axhline(ROUNDING, color=DARK, lw=0.7, ls=DOTTED, zorder=1.5)
    style: dict[str, Any] = {"color": DARK, "ls": "", "marker": "o", "ms": 4.5}
    handles = [
        Line2D([], [], **style, label="worst of 200 random blades"),
        Line2D([], [], **style | {"mfc": "white"}, label="median"),
        Line2D([], [], ls="", label="at the dots: relative tolerance asked for, or steps"),
    ]
    ax.set_title("Floquet exponents of a flapping blade: error against time", loc="left", pad=16.0)
    ax.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2,
        handlelength=1.0, handletextpad=0.3,
    )  # fmt: skip
    ax.annotate(
        "better", (0.02, 0.86), (0.05, 0.95), "axes fraction", "axes fraction", color=DARK,
        arrowprops={"arrowstyle": "->", "color": DARK, "lw": 0.8},
    )  # fmt: skip


def label(ax: Axes, curves: Mapping[str, Sequence[Result]]) -> None:
    """Names beside their lines, settings beside the dots."""
    labels = Labels(ax)
    right = ax.get_xlim()[1]
    labels.put("rounding of a number", [(right, ROUNDING)], sides=[(-1, 1), (-1, -1)], fontsize=SMALL, color=DARK)
    for name, curve in curves.items():
        ends = [(1e6 * r.best, float(f(r.errors))) for f in (np.max, np.median) for r in (curve[0], *curve[::-1])]
        labels.put(name, ends, color=STYLES[name]["color"], weight="bold" if name == "floquet" else "normal")
    for name, curve in curves.items():
        for result in curve if len(curve) > 1 else ():
            text = "ε" if result.contender.setting == "eps" else result.contender.setting
            places = [(1e6 * result.best, float(np.max(result.errors)))]
            labels.put(text, places, optional=True, fontsize=5.5, color=STYLES[name]["color"], distance=2.5)
