"""What a database already has of a study that has grown: its rows, copied, each chunk held against its digest.

A row is a pure function of its parameters and the engine, so a row of the same design, bit for bit, at the same advance
ratio, bit for bit, is the same row; only its design's number changes.  Limits are taken where a design's are for the
same tolerances in the same order up to the same advance ratio.  Rows of maps depend on all advance ratios of a design
beside: they are taken where those are the same.
"""

from __future__ import annotations

import contextlib
import json
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import store
from ..errors import DatabaseError, InputError
from ..kernels import POINTS
from ..studyfile import Study
from ..sweep import ENGINE, Plan, limits_at, points_at
from .alike import Marks, Runs, first_of, of_plan, runs

__all__ = ["Known", "known", "mapped"]

Array = NDArray[Any]
Rows = dict[str, Array]


@dataclass(frozen=True, eq=False)
class Known:
    """Where the rows of a plan's designs are in a database; −1 where they are not.

    Attributes
    ----------
    first, grid : (designs,) arrays
        First row of points of a design, and which row of ``places`` tells where its advance ratios are.
    places : (grids, m) array
        For every advance ratio of the plan the row, counted from the first of a design.
    limits : (designs, 2) array
        First row of limits, and the one after the last.
    digest : str
        Of the data, which are these as long as rows are taken.
    """

    path: Path
    digest: str
    first: NDArray[np.int64]
    grid: NDArray[np.intp]
    places: NDArray[np.int64]
    limits: NDArray[np.int64]

    @property
    def points(self) -> int:
        """How many rows of points there are."""
        each = (self.places >= 0).sum(axis=1)
        return int(each[self.grid[self.first >= 0]].sum())

    def rows(self, table: str, plan: Plan, start: int, stop: int, *columns: tuple[str, ...]) -> Rows:
        """Rows as :func:`floquet.sweep.point_rows` and :func:`floquet.sweep.limit_rows` make them."""
        if table == "limits":
            return self._limits(plan, start, stop)
        return self._points(plan, np.arange(start, stop), *columns)

    @contextlib.contextmanager
    def _opened(self) -> Iterator[store.File]:
        with store.open_file(self.path) as file:
            if file.data_digest() != self.digest:
                raise DatabaseError(self.path, "it was replaced while it was extended: run the same command again")
            yield file

    def _points(self, plan: Plan, index: NDArray[np.intp], columns: tuple[str, ...]) -> Rows:
        designs, mu = np.divmod(index, plan.advance_ratio.size)
        place = self.places[self.grid[designs], mu]
        at = np.where((self.first[designs] >= 0) & (place >= 0), self.first[designs] + place, -1)
        missing = np.flatnonzero(at < 0)
        parts = [(missing, points_at(plan, index[missing], columns))] if missing.size else []
        with self._opened() as file:
            parts += _copied(file, "points", list(columns), at)
        out = _joined(parts, len(index))
        return out | {"rotor": designs.astype(np.int32)}

    def _limits(self, plan: Plan, start: int, stop: int) -> Rows:
        spans = self.limits[start:stop]
        missing = np.flatnonzero(spans[:, 0] < 0)
        computed = limits_at(plan, start + missing)
        there = np.flatnonzero(spans[:, 0] >= 0)
        counts = np.diff(spans[there]).ravel()
        at = np.concatenate([np.arange(a, b) for a, b in spans[there].tolist()] or [np.zeros(0, int)])
        with self._opened() as file:
            parts = list(_copied(file, "limits", list(store.LIMITS), at))
        taken = _joined(parts, len(at)) if parts else {name: column[:0] for name, column in computed.items()}
        taken["rotor"] = np.repeat(start + there, counts).astype(np.int32)
        both = {name: np.concatenate([column, taken[name]]) for name, column in computed.items()}
        order = np.argsort(both["rotor"], kind="stable")
        return {name: column[order] for name, column in both.items()}


def _copied(file: store.File, table: str, columns: list[str], at: NDArray[np.int64]) -> Iterator[tuple[Array, Rows]]:
    """(places, rows) of the rows that stand at ``at`` in a file, chunk by chunk; −1 is left out."""
    size = store.schema.CHUNK_ROWS
    for chunk in np.unique(at[at >= 0] // size).tolist():
        some = np.flatnonzero((at >= chunk * size) & (at < (chunk + 1) * size))
        low, high = int(at[some].min()), int(at[some].max()) + 1
        for first, rows in file.chunks(table, columns, low, high):
            here = some[(at[some] >= first) & (at[some] < first + len(rows["rotor"]))]
            yield here, {name: column[at[here] - first] for name, column in rows.items()}


def _joined(parts: list[tuple[Array, Rows]], count: int) -> Rows:
    """Rows from groups of them."""
    out = {name: np.empty(count, column.dtype) for name, column in parts[0][1].items()}
    for places, rows in parts:
        for name, column in rows.items():
            out[name][places] = column
    return out


# ---------------------------------------------------------------------- finding them
def known(path: Path, study: Study) -> Known:
    """What a database has of a study; refused where none of it could be the same row."""
    plan = study.plan
    with store.open_file(path) as file:
        _check(file, study)
        if (of_maps := mapped(file)) != plan.map:
            word = "with" if of_maps else "without"
            raise InputError(f"{path} was computed {word} map = true and the study is not: its rows are other rows")
        _refuse_lost_columns(file, study)
        designs = of_plan(plan)
        found = runs(file, "points", ("advance_ratio",))
        _refuse_loss(path, plan, designs, found)
        where = first_of(designs, found.marks)
        places = np.array([_places(plan, ratios.ravel()) for ratios in found.beside])
        if (file.rows("points") < POINTS) != (plan.points < POINTS):
            where[:] = -1  # few points are computed another way, and have other last digits
        there = where >= 0
        first, grid = np.full(plan.designs, -1, np.int64), np.zeros(plan.designs, np.intp)
        first[there], grid[there] = found.start[where[there]], found.which[where[there]]
        limits = np.full((plan.designs, 2), -1, np.int64)
        if "limits" in file.tables:
            _refuse_lost_limits(file, plan)
        if plan.tolerances and "limits" in file.tables:
            limits = _known_limits(file, plan, designs)
        digest = file.data_digest()
    return Known(path, digest, first, grid, places, limits)


def _check(file: store.File, study: Study) -> None:
    about = file.attributes
    if int(about.get("engine_version", -1)) != ENGINE:
        raise InputError(
            f"{file.path} was computed by engine {about.get('engine_version')}, and this is {ENGINE}: its rows may "
            "differ, so run the study anew, to another output"
        )
    try:
        options = json.loads(about.get("options", ""))
    except ValueError:
        options = None
    if options != study.plan.options:
        raise InputError(
            f"{file.path} was computed with other options of [compare], so that no row of it is one of this study: "
            "choose another output"
        )
    if lost := [name for name in study.columns if name not in file.columns("points")]:
        raise InputError(
            f"{file.path} has no {', '.join(lost[:4])}, which the study stores: its rows cannot be taken, so name "
            "fewer columns, or choose another output"
        )


def _refuse_lost_columns(file: store.File, study: Study) -> None:
    """Columns stay."""
    if lost := [name for name in file.columns("points") if name not in study.columns]:
        raise InputError(
            f"{file.path} has columns that the study does not store, and they would be lost ({', '.join(lost[:4])}"
            f"{', …' if len(lost) > 4 else ''}): name them, too, or choose another output"
        )


def _refuse_loss(path: Path, plan: Plan, designs: Marks, found: Runs) -> None:
    """A database keeps every row that it has: the study must have all of its designs and advance ratios."""
    kept = plan.advance_ratio.astype("<f8").view("<i8")
    left = [int((~np.isin(ratios.ravel().view("<i8"), kept)).sum()) for ratios in found.beside]
    wanted = first_of(found.marks, designs) >= 0
    lost = int(np.where(wanted, np.array(left, np.int64)[found.which], found.stop - found.start).sum())
    if lost:
        raise InputError(
            f"{path} has {lost} rows of designs or advance ratios that the study has not, and they would be lost: "
            "put these into the study, too, or choose another output"
        )


def _refuse_lost_limits(file: store.File, plan: Plan) -> None:
    """Limits stay, too: for all their tolerances, and as far as they were sought."""
    sought: dict[tuple[float, float], float] = {}
    for _, rows in file.chunks("limits", ["metric", "tolerance", "mu_max"]):
        columns = [rows[name].astype(float) for name in ("metric", "tolerance", "mu_max")]
        for metric, tolerance, mu_max in np.unique(np.stack(columns, axis=1), axis=0).tolist():
            sought[metric, tolerance] = max(mu_max, sought.get((metric, tolerance), 0.0))
    wanted = {(float(metric), float(tolerance)) for metric, tolerance in plan.tolerances}
    if lost := [tolerance for metric, tolerance in sought if (metric, tolerance) not in wanted]:
        raise InputError(
            f"{file.path} has limits of the tolerance {lost[0]:g}, which the study has not, and they would be lost: "
            "put it into the study, too, or choose another output"
        )
    if (farthest := max(sought.values(), default=0.0)) > plan.mu_max:
        raise InputError(
            f"{file.path} has limits that were sought up to μ = {farthest:g}, and the study seeks them up to "
            f"{plan.mu_max:g}: give it mu_max = {farthest:g}, or choose another output"
        )


def mapped(file: store.File) -> bool:
    """Whether a database is of maps, by the study that it keeps."""
    try:
        return bool(tomllib.loads(file.attributes["input"]).get("compare", {}).get("map", False))
    except (KeyError, TypeError, AttributeError, tomllib.TOMLDecodeError):
        raise InputError(
            f"{file.path} is not of one study, as after floquet merge: --extend takes what floquet run has written"
        ) from None


def _places(plan: Plan, ratios: NDArray[np.float64]) -> NDArray[np.int64]:
    """Where the plan's advance ratios are among those of a design, −1 for nowhere."""
    wanted, there = plan.advance_ratio.astype("<f8").view("<i8"), ratios.view("<i8")
    if plan.map:
        return np.arange(len(wanted)) if np.array_equal(wanted, there) else np.full(len(wanted), -1)
    numbers = {bits: i for i, bits in reversed(list(enumerate(there.tolist())))}
    return np.array([numbers.get(bits, -1) for bits in wanted.tolist()], np.int64)


def _known_limits(file: store.File, plan: Plan, designs: Marks) -> NDArray[np.int64]:
    found = runs(file, "limits", ("metric", "tolerance", "mu_max"))
    where = first_of(designs, found.marks)
    wanted = np.array([[metric, tolerance, plan.mu_max] for metric, tolerance in plan.tolerances])
    same = [
        not len(rows) % len(wanted) and np.array_equal(rows, np.tile(wanted, (len(rows) // len(wanted), 1)))
        for rows in found.beside
    ]
    out = np.full((plan.designs, 2), -1, np.int64)
    good = np.flatnonzero(where >= 0)
    good = good[np.array(same, bool)[found.which[where[good]]]]
    out[good] = np.stack([found.start, found.stop], axis=1)[where[good]]
    return out
