"""What the figures share: colours, sizes, style, titles, lock bands."""

from __future__ import annotations

import contextlib
import functools
import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from floquet.comparison import Cause
from floquet.plot.curves import Band, Complex, Failing, Rows
from floquet.plot.labels import Labels
from floquet.rotor import Hub

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_F = TypeVar("_F", bound=Callable[..., Any])

COLOURS = {"regressing": "#D55E00", "coning": "#0072B2", "advancing": "#009E73", "differential": "#CC79A7"}
"""One colour a mode, from the palette of Okabe and Ito, which the colour-blind can tell apart."""
WIDTHS = {"differential": 2.8, "regressing": 2.0, "coning": 1.2, "advancing": 1.2}
"""Line widths in points, in drawing order: of modes that share an exponent, the thinner lies on the wider."""
THIN = 1.3
DARK, LOCKED, UNSTABLE, FOLKLORE_COLOUR = "#333333", "#E6E6E6", "#F7DCD3", "#F0E442"
DASHED, DOTTED, DASH_DOT = (0, (4, 2)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5))
MM = 1.0 / 25.4
COLUMN, PAGE = 85.0 * MM, 170.0 * MM
"""Widths of a journal's column and page in inches."""
FOOTER = "No dynamic inflow in either model."
FOOTER_OF_ONE = "No dynamic inflow in the model."
MU_LABEL = r"advance ratio $\mu$ (dimensionless)"
SMALL = "small"
STYLE: Any = {
    "font.family": ["DejaVu Sans"], "font.size": 8.0, "axes.titlesize": 8.5, "axes.labelsize": 8.0,
    "xtick.labelsize": 7.5, "ytick.labelsize": 7.5, "legend.fontsize": 7.0, "axes.linewidth": 0.6, "axes.grid": False,
    "axes.facecolor": "white", "figure.facecolor": "white", "savefig.facecolor": "white", "savefig.bbox": None,
    "text.color": "black", "axes.labelcolor": "black", "text.usetex": False, "mathtext.fontset": "dejavusans",
    "hatch.linewidth": 0.5, "pdf.fonttype": 42, "svg.fonttype": "path", "svg.hashsalt": "floquet",
}  # fmt: skip
CAUSES = {
    Cause.NONE: "", Cause.DRIFT: "drift", Cause.LOCK: "Floquet locks", Cause.TPP_SPLIT: "TPP splits",
    Cause.DRIFT_IN_LOCK: "drift in the lock", Cause.STABILITY: "stability differs",
}  # fmt: skip


def styled(draw: _F) -> _F:
    """Draw in the house's style, whatever the user's matplotlibrc says, unless the Axes are the user's own."""

    @functools.wraps(draw)
    def inner(*args: Any, **options: Any) -> Any:
        own = options.get("ax") is None and options.get("axes") is None
        with matplotlib.rc_context(STYLE) if own else contextlib.nullcontext():
            return draw(*args, **options)

    return inner  # type: ignore[return-value]


def new_figure(width: float, height: float, footer: str = FOOTER) -> Figure:
    """An empty figure of a size in inches, with the footer; it needs no display."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    write_footer(figure, footer=footer)
    return figure


def write_footer(figure: Figure, more: str = "", *, footer: str = FOOTER) -> None:
    """Say what is not in the model; ``more`` goes before what the footer says already."""
    text = " ".join([more, figure.get_supxlabel().replace("\n", " ") or footer]).strip()
    room = int(20.0 * figure.get_figwidth())  # characters in a line
    figure.supxlabel(textwrap.fill(text, room), fontsize=6.5, color=DARK, x=0.99, ha="right")


def root_figure(ax: Axes) -> Figure:
    """The figure an Axes is in, through subfigures."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


def settle(ax: Axes) -> None:
    """Let the layout find the final places, on which labels depend."""
    root_figure(ax).draw_without_rendering()


def wide(figure: Figure) -> bool:
    """Whether a figure is wider than a column."""
    return bool(figure.get_figwidth() > 0.7 * PAGE)


def described(rows: Rows) -> str:
    """``N = 4, γ = 5.07, ν_β = 1.118 per rev``."""
    blades, gamma, nu = int(rows["blades"][0]), float(rows["lock_number"][0]), float(rows["flap_frequency"][0])
    hub = "teetering, " if int(rows["hub"][0]) == Hub.TEETERING else ""
    return rf"{hub}$N$ = {blades}, $\gamma$ = {gamma:.4g}, $\nu_\beta$ = {nu:.4g} per rev"


def heading(figure: Figure, rows: Rows, name: str) -> str:
    """Name and parameters, on two lines where the figure is narrow; hinge offset and coupling where there is room."""
    if not wide(figure):
        return f"{name}\n{described(rows)}" if name else described(rows)
    more = [(r"$\varepsilon$", float(rows["hinge_offset"][0])), ("$K_1$", float(rows["pitch_flap_coupling"][0]))]
    text = ", ".join([described(rows), *(f"{symbol} = {value:.3g}" for symbol, value in more if value)])
    return f"{name}:  {text}" if name else text


def headline(ax: Axes, rows: Rows, name: str, handles: Sequence[Any], *, narrow: int = 2) -> None:
    """Title, and under it what lines and shades mean, above the Axes, in ``narrow`` columns if it is narrow."""
    columns = len(handles) if wide(root_figure(ax)) else narrow
    lines = -(-len(handles) // columns) if handles else 0
    ax.set_title(heading(root_figure(ax), rows, name), loc="left", pad=4.0 + 11.5 * lines)
    if handles:
        ax.legend(
            handles=list(handles), loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False,
            borderaxespad=0.2, handlelength=2.2, columnspacing=1.2, handletextpad=0.5,
        )  # fmt: skip


def line_handles() -> list[Any]:
    """Solid and dashed, for a legend."""
    return [
        Line2D([], [], color=DARK, lw=1.6, label="Floquet (exact)"),
        Line2D([], [], color=DARK, lw=THIN, ls=DASHED, label="TPP (simple)"),
    ]


def in_drawing_order(modes: Sequence[str]) -> list[str]:
    return [mode for mode in WIDTHS if mode in modes]


def draw_pair(
    ax: Axes, x: Any, y: Callable[[Complex], Any], pair: tuple[Any, Complex], mode: str, model: str
) -> Line2D:
    """Both members of a mode's pair as one broken line: Floquet solid, TPP dashed."""
    mu, z = pair
    gone = complex(np.nan, np.nan)
    z = np.r_[z[:, 0], gone, np.where(np.isfinite(z[:, 1].real), z[:, 1], gone)]
    solid = model == "Floquet"
    (line,) = ax.plot(
        np.r_[mu, np.nan, mu] if x is None else x(z), y(z), color=COLOURS[mode], lw=WIDTHS[mode] if solid else THIN,
        ls="-" if solid else DASHED, zorder=2.5 if solid else 3.5, label=f"{model}, {mode}", solid_capstyle="butt",
    )  # fmt: skip
    return line


def percent(tolerance: float) -> str:
    return f"{100.0 * tolerance:.3g} %"


def per_rev(lock: float) -> str:
    """``½ per rev``."""
    whole, half = divmod(lock, 1.0)
    return (f"{whole:g}" if whole or not half else "") + ("½" if half else "") + " per rev"


def limit_text(found: Failing, *, cause: bool = True) -> str:
    """``μ = 0.472 (drift)``."""
    why = f" ({CAUSES[found.cause]})" if cause and CAUSES[found.cause] else ""
    return rf"$\mu$ = {found.limit:.3f}{why}"


def pale(colour: str) -> tuple[float, float, float]:
    r, g, b = (0.28 * c + 0.72 for c in to_rgb(colour))
    return r, g, b


def shade(ax: Axes, bands: Sequence[Band], end: float) -> None:
    """Lock bands, full height."""
    for enter, leave, lock in bands:
        ax.axvspan(enter, min(leave, end), color=LOCKED, lw=0, zorder=0.1, gid=f"lock {lock:g}")


def name_bands(labels: Labels, bands: Sequence[Band], end: float, y: float) -> None:
    """Write each band's frequency at its top (y in the Axes), across or upright as it fits, or beside it."""
    ax = labels.ax
    high = float(ax.transData.inverted().transform(ax.transAxes.transform((0.0, y)))[1])
    for enter, leave, lock in bands:
        a, b = enter, min(leave, end)
        pixels = abs(float(np.diff(ax.transData.transform([(a, high), (b, high)])[:, 0])[0]))
        text = f"lock, {per_rev(lock)}"
        style: dict[str, Any] = {"fontsize": SMALL, "color": DARK}
        for turn in (0, 90):
            share = labels.size(text, rotation=turn, **style)[0] / pixels
            if share < 0.98:
                middles = [(0.5 * (a + b) + f * (1.0 - share) * (b - a), high) for f in (0.0, 0.25, -0.25, 0.45, -0.45)]
                labels.put(text, middles, sides=[(0, -1)], distance=1.0, rotation=turn, **style)
                break
        else:
            labels.put(text, [(b, high), (a, high)], sides=[(1, -1), (-1, -1)], rotation=90, **style)
