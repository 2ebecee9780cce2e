"""Texts that cover neither the data nor each other.

Every text has candidates: points beside which it may stand, and sides.  Its cost there is the length of line it would
cover, a large price for overlapping a text or leaving the frame, and a small one for its rank; the cheapest is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.text import Annotation

__all__ = ["Labels", "along"]

Array = NDArray[np.float64]
Side = tuple[int, int]
SIDES: tuple[Side, ...] = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1))
ABOVE_BELOW: tuple[Side, ...] = ((0, 1), (0, -1))
STEP = 2.0  # pixels between the points that stand for a line
PAD = 1.0  # points kept free around a text
COVERED, OVERLAP, OUTSIDE, RANK, TURN = 10.0, 1e5, 1e4, 0.2, 0.01
CLEAR = 20.0  # the cost, ranks apart, up to which an optional text is written


class _Place(NamedTuple):
    cost: float
    anchor: tuple[float, float]
    offset: tuple[float, float]
    side: Side
    box: Bbox


class Labels:
    """Places texts in one Axes, whose limits and layout must be final."""

    def __init__(self, ax: Axes, *, avoid_lines: bool = True, margin: float = 0.0) -> None:
        self.ax = ax
        self.boxes: list[Bbox] = []
        self.point = ax.get_figure(root=True).dpi / 72.0  # type: ignore[union-attr]  # pixels
        lines = ax.lines if avoid_lines else ()
        found = [_pixels(line) for line in lines] + [_dots(line, self.point) for line in lines]
        covered = np.concatenate([*found, np.empty((0, 2))])
        self.x, self.y = covered[np.argsort(covered[:, 0])].T  # of what is not to be covered
        self.frame = ax.get_window_extent().padded(margin * self.point)

    def size(self, text: str, **style: Any) -> tuple[float, float]:
        """Width and height of a text in pixels."""
        artist = self.ax.text(0.0, 0.0, text, **style)
        box = artist.get_window_extent()
        artist.remove()
        return box.width, box.height

    def put(self, text: str, anchors: Sequence[tuple[float, float]], *, sides: Sequence[Side] = SIDES,
            distance: float = 3.0, optional: bool = False, apart: float = PAD,
            **style: Any) -> Annotation | None:  # fmt: skip
        """Write beside one of some points in data coordinates, best first; an optional text only where it is clear.

        ``apart`` is what other texts keep away in points.
        """
        size = self.size(text, **style)
        places = [self._place(rank, anchor, turn, side, size, distance * self.point, apart * self.point)
                  for rank, anchor in enumerate(anchors) for turn, side in enumerate(sides)]  # fmt: skip
        places = [place for place in places if math.isfinite(place.cost)]
        if not places:
            return None
        best = min(places, key=lambda place: place.cost)
        if optional and best.cost > CLEAR + RANK * len(anchors):
            return None
        self.boxes.append(best.box)
        across, up = best.side
        artist = self.ax.annotate(
            text, best.anchor, (best.offset[0] / self.point, best.offset[1] / self.point), annotation_clip=False,
            textcoords="offset points", ha=("center", "left", "right")[across], va=("center", "bottom", "top")[up],
            **style,
        )  # fmt: skip
        artist.set_in_layout(False)
        return artist

    def _place(self, rank: int, anchor: tuple[float, float], turn: int, side: Side, size: tuple[float, float],
               distance: float, apart: float) -> _Place:  # fmt: skip
        x, y = self.ax.transData.transform(anchor)
        if not math.isfinite(x + y):
            return _Place(math.inf, anchor, (0.0, 0.0), side, Bbox.null())
        diagonal = math.sqrt(2.0) if side[0] and side[1] else 1.0
        offset = (side[0] * distance / diagonal, side[1] * distance / diagonal)
        # (0, 1, -1) as an index: centred, right of or above the anchor, left of or below it
        left = x + offset[0] - (0.5, 0.0, 1.0)[side[0]] * size[0]
        low = y + offset[1] - (0.5, 0.0, 1.0)[side[1]] * size[1]
        box = Bbox.from_bounds(left, low, *size)
        return _Place(self._cost(box, apart) + RANK * rank + TURN * turn, anchor, offset, side, box)

    def _cost(self, box: Bbox, apart: float) -> float:
        wide = box.padded(PAD * self.point)
        y = self.y[slice(*np.searchsorted(self.x, [wide.x0, wide.x1]))]
        covered = np.count_nonzero((y > wide.y0) & (y < wide.y1))
        overlaps = sum(bool(box.padded(apart).overlaps(other)) for other in self.boxes)
        out = max(self.frame.x0 - box.x0, box.x1 - self.frame.x1, self.frame.y0 - box.y0, box.y1 - self.frame.y1, 0.0)
        return COVERED * float(covered) + OVERLAP * overlaps + OUTSIDE * min(out, 10.0)


def along(x: Array, y: Array, count: int = 40) -> list[tuple[float, float]]:
    """Some points along a curve, from its right end to its left."""
    good = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not good.size:
        return []
    return [(float(x[i]), float(y[i])) for i in good[np.linspace(good.size - 1, 0, min(count, good.size)).astype(int)]]


def _corners(line: Line2D) -> Array:
    xy = np.column_stack([np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)])
    return np.clip(line.get_transform().transform(xy), -1e4, 1e4)


def _pixels(line: Line2D) -> Array:
    """Points along a line, every few pixels."""
    if line.get_linestyle() in ("None", "", " "):
        return np.empty((0, 2))
    xy = _corners(line)
    length = np.hypot(*np.diff(xy, axis=0).T)
    counts = np.where(np.isfinite(length), np.maximum(length / STEP, 1.0), 0.0).astype(int)
    pieces = [np.linspace(a, b, n) for a, b, n in zip(xy[:-1], xy[1:], counts, strict=True) if n]
    return np.concatenate([*pieces, np.empty((0, 2))])


def _dots(line: Line2D, point: float) -> Array:
    """Points around a line's markers."""
    if line.get_marker() in ("None", "", " ", None):
        return np.empty((0, 2))
    turn = np.linspace(0.0, 2.0 * math.pi, 9)[:-1]
    ring = 0.5 * line.get_markersize() * point * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    around = _corners(line)[:, None, :] + ring
    return np.asarray(around[np.isfinite(around).all(axis=-1)])
