"""An open database and what may be asked of it, streamed in bounded memory."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from floquet.chunks import in_order
from floquet.errors import DatabaseError, FloquetWarning, ParameterError, QueryError, did_you_mean, file_name
from floquet.query.between import LEAST, MOST, MU, Interpolated, interpolated, kinds, wanted
from floquet.query.frames import DERIVED, DESIGN, axes_columns, library, to_pandas, to_xarray
from floquet.query.grid import Axis, axes_of, between, checked_design, conditions, finite, speeds_of
from floquet.query.groups import Groups, reductions
from floquet.query.groups import keys as group_keys
from floquet.query.language import (
    FILE,
    ROTOR,
    ROTOR_NAME,
    Array,
    Column,
    Predicate,
    Rows,
    Scope,
    compile_expression,
    short,
)
from floquet.query.meanings import meaning
from floquet.query.selection import Best, Nearest, first, joined
from floquet.query.several import Reader, Several, check_once

if TYPE_CHECKING:
    from floquet.export import Answer

DEFAULT_COLUMNS = {
    "points": (
        ROTOR, ROTOR_NAME, "advance_ratio", "lock_number", "hinge_offset", "pitch_flap_coupling", "verdict", "lock",
        "error_regressing", "error_coning", "error_advancing",
    ),
    "limits": (
        ROTOR, ROTOR_NAME, "lock_number", "hinge_offset", "pitch_flap_coupling", "mode", "metric", "tolerance", "limit",
        "cause", "lock",
    ),
}  # fmt: skip
"""What a query returns when no columns are named, followed by the columns its expression and its sort name."""


class Database:
    """An open database: ``with open_database("validity.h5") as db: db.query("advance_ratio > 0.3")``."""

    def __init__(
        self, path: str | Path, reader: Reader, closing: ExitStack | None = None, sources: Sequence[str] | None = None
    ) -> None:
        self.path = str(path)
        self._sources = (self.path,) if sources is None else tuple(sources)
        self._open: Reader | None = reader
        self._closing = closing or ExitStack()

    def __enter__(self) -> Database:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Database({self.path!r})"

    def close(self) -> None:
        """Close the file; a second time does nothing."""
        self._open = None
        self._closing.close()

    @property
    def _reader(self) -> Reader:
        if self._open is None:
            raise DatabaseError(self.path, "the database is closed; open it again with open_database")
        return self._open

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the rotors, which the column ``rotor`` counts; empty if they have none."""
        return tuple(map(str, self._reader.names))

    @property
    def attributes(self) -> dict[str, Any]:
        """What the file says about itself: title, history, source, study."""
        return dict(self._reader.attributes)

    @property
    def tables(self) -> tuple[str, ...]:
        return tuple(self._reader.tables)

    def _table(self, table: str) -> str:
        if table not in self.tables:
            name, present = str(table), ", ".join(self.tables)
            raise QueryError(f"{short(name)!r} is no table; this file has {present}{did_you_mean(name, self.tables)}")
        return table

    def columns(self, table: str = "points") -> dict[str, Any]:
        """Name → column (dtype, units, long_name, flags) in the order of the file; complex columns once."""
        return dict(self._reader.columns(self._table(table)))

    def rows(self, table: str = "points") -> int:
        return int(self._reader.rows(self._table(table)))

    def describe(self, table: str = "points") -> list[tuple[str, str, str]]:
        """(name, units, long name) of every column."""
        return [(name, column.units, column.long_name) for name, column in self.columns(table).items()]

    def limits(self, expression: str = "", **options: Any) -> Rows:
        """``query`` on the table of limits."""
        return self.query(expression, table="limits", **options)

    def query(
        self,
        expression: str = "",
        *,
        table: str = "points",
        columns: str | Sequence[str] | None = None,
        sort: str | Sequence[str] | None = None,
        descending: bool = False,
        limit: int | None = None,
    ) -> Rows:
        """The rows for which ``expression`` holds (all, if it is empty), as one array a column.

        ``columns`` names what is returned, complex columns by their name or by their parts; None is a short list for
        printing and the columns that ``expression`` and ``sort`` name, "*" is all of them. ``rotor_name`` stands
        beside the index ``rotor`` (an empty text where a rotor has no name). ``sort`` is by a column, or by several,
        each between equals of those before; it is stable, with nan last in both directions. ``limit`` is the number of
        rows, after sorting. Memory holds a chunk and the answer.
        """
        pieces, wanted = self._rows(expression, table, columns, sort, descending, limit)
        found = joined(list(pieces))
        return {name: found[name] for name in wanted}

    def to_pandas(self, expression: str = "", *, table: str = "points", **options: Any) -> Any:
        """The answer of ``query``, with its options, as a pandas DataFrame: flags as categories in words.

        ``attrs`` has the file's title, and "units" and "long_name" by column.
        """
        library("pandas", "to_pandas")
        return to_pandas(self.query(expression, table=table, **options), self.columns(table), self.attributes)

    def to_xarray(
        self,
        expression: str = "",
        *,
        table: str = "points",
        columns: str | Sequence[str] | None = None,
        sort: str | Sequence[str] | None = None,
        descending: bool = False,
        limit: int | None = None,
    ) -> Any:
        """The answer of ``query`` as an xarray Dataset, each variable with its units and meaning.

        Rows that are every combination of some parameters (and advance ratios; modes, metrics and tolerances of limits)
        get these as axes, rows of other designs that have the same advance ratios the axes ``rotor`` and
        ``advance_ratio``, and all others the one dimension ``row``.
        """
        library("xarray", "to_xarray")
        present = self.columns(table)
        also = axes_columns(present)
        pieces, wanted = self._rows(expression, table, columns, sort, descending, limit, also)
        return to_xarray(joined(list(pieces)), wanted, present, self.attributes)

    def save(
        self,
        out: str | Path,
        expression: str = "",
        *,
        by: str | Sequence[str] | None = None,
        reduce: str | Sequence[str] | None = None,
        **options: Any,
    ) -> Path:
        """Write the answer of ``query``, or of ``groups`` with ``by`` or ``reduce``, as .csv, .json, .parquet or .nc.

        The ending of ``out`` decides; a file of that name is replaced when the new one is complete. Rows are streamed:
        memory holds a chunk, or what ``sort`` has to hold.
        """
        from floquet import export

        export.checked_format(out)
        return export.write(self.answer(expression, by=by, reduce=reduce, **options), out)

    def answer(
        self,
        expression: str = "",
        *,
        by: str | Sequence[str] | None = None,
        reduce: str | Sequence[str] | None = None,
        table: str = "points",
        columns: str | Sequence[str] | None = None,
        sort: str | Sequence[str] | None = None,
        descending: bool = False,
        limit: int | None = None,
    ) -> Answer:
        """The answer of ``query`` or ``groups`` on its way out: what its columns are, and its rows piece by piece."""
        from floquet import export, store

        order: dict[str, Any] = {"sort": sort, "descending": descending, "limit": limit}
        rows = None
        if by is None and reduce is None:
            pieces, wanted = self._rows(expression, table, columns, sort, descending, limit)
        elif columns is not None:
            raise ParameterError("columns", columns, "it names columns of rows, and by and reduce those of groups")
        else:
            found = self.groups(expression, by=by, reduce="count" if reduce is None else reduce, table=table, **order)
            pieces, wanted, rows = iter([found]), list(found), len(next(iter(found.values())))
        wholes = {f"{name}_{part}" for name in wanted for part in ("re", "im")}
        wanted = [name for name in wanted if name not in wholes]  # files have complex columns as parts
        beginning = next(pieces)  # every answer has a piece, be it without rows
        present = self.columns(table)
        about = {name: meaning(name, beginning[name].dtype, present) for name in wanted}
        return export.Answer(
            columns={name: store.Column(*entry) for name, entry in about.items()},
            pieces=({name: piece[name] for name in wanted} for piece in chain([beginning], pieces)),
            count=lambda: self._count(expression, table, limit) if rows is None else rows,
            names=self.names, attributes=self.attributes, sources=self._sources,
        )  # fmt: skip

    def _count(self, expression: str, table: str, limit: int | None) -> int:
        """How many rows a query has, by a pass over the columns of its expression."""
        if not expression.strip():
            rows = self.rows(table)
        else:
            counted = self.groups(expression, reduce="count", table=table)["count"]
            rows = int(counted.sum())
        return rows if limit is None else min(rows, limit)

    def _asked(self, expression: str, table: str) -> tuple[dict[str, Column], Scope, Predicate]:
        """The columns of a table, what an expression may name, and the expression, checked before a row is read."""
        present = self.columns(table)
        elsewhere = {name: other for other in self.tables if other != table for name in self.columns(other)}
        scope = Scope.of(present, self.names, self._reader.left_out(table), elsewhere)
        return present, scope, compile_expression(expression, scope)

    def _rows(
        self,
        expression: str,
        table: str,
        columns: str | Sequence[str] | None,
        sort: str | Sequence[str] | None,
        descending: bool,
        limit: int | None,
        also: Sequence[str] = (),
    ) -> tuple[Iterator[Rows], list[str]]:
        """The rows of a query in pieces, of which there is one at least, and which of their columns were asked for."""
        present, scope, predicate = self._asked(expression, table)
        key = tuple(map(scope.check, _sorted_by(sort, descending)))
        wanted = self._wanted(table, columns, present, scope, (*predicate.names, *key))
        limit = _checked_limit(limit)
        best = Best(key, bool(descending), limit) if key else None
        read = [ROTOR if name == ROTOR_NAME else name for name in (*wanted, *also)]
        pieces = self._pieces(table, self._settled(table, predicate), list(dict.fromkeys([*read, *key])), best, limit)
        if best is not None:
            for piece in pieces:
                best.add(piece)
            pieces = iter([best.result()])
        found = first(pieces, limit)
        return (self._with_names(found) if ROTOR_NAME in wanted else found), wanted

    def _with_names(self, pieces: Iterable[Rows]) -> Iterator[Rows]:
        for piece in pieces:
            yield piece | {ROTOR_NAME: self._named(piece[ROTOR])}

    def groups(
        self,
        expression: str = "",
        *,
        by: str | Sequence[str] | None = None,
        reduce: str | Sequence[str] = "count",
        table: str = "points",
        sort: str | Sequence[str] | None = None,
        descending: bool = False,
        limit: int | None = None,
    ) -> Rows:
        """One row a group of rows with equal values in the columns ``by``, of those for which ``expression`` holds.

        ``reduce`` names what is said of a group, ``"min(limit), mean(limit), count"``: min, max, mean and median pass
        over nan; count is of rows, count(x) of those where x is not nan; first(x) is of the first row in the file, and
        ``"rotor_name at min(limit)"`` of the first with the least limit. The answer has the columns ``by`` (and the
        rotors' names beside ``rotor``) and those reductions, under their names as written here. It is in the order of
        ``by``, or of ``sort``, some of its columns; nan comes last. Memory holds a chunk and the groups, and of a
        median the column it is of.
        """
        present, scope, predicate = self._asked(expression, table)
        reduced, keys = reductions(reduce, present, scope), group_keys(by, scope)
        if not any(self.names) and (nameless := [one for one in reduced if one.value == ROTOR_NAME]):
            other = nameless[0].name.replace(ROTOR_NAME, ROTOR)
            raise ParameterError("reduce", nameless[0].name, f"the rotors of this database have no names; take {other}")
        limit = _checked_limit(limit)
        names = [*keys, *(one.name for one in reduced)]
        order = _sorted_by(sort, descending)
        for name in order:
            if name not in names:
                near = did_you_mean(name, names)
                raise ParameterError("sort", name, f"{short(name)!r} is none of {', '.join(names)}{near}")
        whole = {name: np.dtype(column.dtype) for name, column in present.items()}
        groups = Groups(keys, reduced, {**scope.dtypes, **whole})
        read = groups.read or list(predicate.names) or list(present)[:1]
        for rows in self._pieces(table, self._settled(table, predicate), read, None, None):
            groups.add(rows, len(rows[read[0]]))
        found = groups.result()
        if order:
            for name in order:
                if name.startswith(f"{ROTOR_NAME} at "):
                    raise ParameterError("sort", name, f"{name} holds words; sort by another column")
                if np.iscomplexobj(found[name]):
                    raise ParameterError("sort", name, f"{name} is complex, which has no order; sort by another column")
            best = Best(order, bool(descending), None)
            best.add(found)
            found = best.result()
        found |= {one.name: self._named(found[one.name]) for one in reduced if one.value == ROTOR_NAME}
        if ROTOR in keys and any(self.names):
            names.insert(names.index(ROTOR) + 1, ROTOR_NAME)
            found[ROTOR_NAME] = self._named(found[ROTOR])
        return {name: found[name][:limit] for name in names}

    def at(
        self,
        expression: str = "",
        *,
        advance_ratio: float,
        columns: str | Sequence[str] | None = None,
        rows: int = 6,
        **design: float,
    ) -> Interpolated:
        """Columns of one design at an advance ratio between its rows, each with an estimate of its error.

        ``expression`` must hold for rows of one rotor: ``db.at('rotor == "Lynx"', advance_ratio=0.333)``. The value is
        that of the polynomial through the ``rows`` (3 to 12) nearest rows, the error the larger of its difference from
        the one through a row less and of that one's. Without ``columns`` it is all that have numbers. Where an edge of
        a lock lies between the rows about it, or the kind of a mode's pair changes, it is refused; rows beyond such are
        not taken.

        Of rotors that are a grid, ``db.at(advance_ratio=0.333, lock_number=7.3, hinge_offset=0.02)`` is for a design
        between them; it names every parameter in which the rotors of ``expression`` differ.
        """
        mu, design = finite(MU, advance_ratio), checked_design(design)
        if isinstance(rows, bool) or not isinstance(rows, int | np.integer) or not LEAST <= rows <= MOST:
            raise ParameterError("rows", rows, f"{short(repr(rows))} was given; it is a number from {LEAST} to {MOST}")
        present, scope, _ = self._asked(expression, "points")
        names = wanted([columns] if isinstance(columns, str) else columns, present, scope)
        if not names:
            raise ParameterError("columns", columns, "no column that is stored here has values between rows")
        watched = kinds(names, present)
        read = list(dict.fromkeys([ROTOR, MU, *watched, *names]))
        if design:
            rotor, axes = self._grid(expression, present, design)
            expression = _both(expression, conditions([axis.reach(int(rows)) for axis in axes]))
            if any(axis.node is None for axis in axes):
                speeds = speeds_of(self.query(_both(expression, f"rotor == {rotor}"), columns=MU)[MU], mu)
                box = [axis.reach(int(rows)) for axis in (*axes, speeds)]
                found = self.query(_both(expression, conditions(box[-1:])), columns=[*read, *(a.name for a in axes)])
                return between(found, names, watched, present, box, int(rows))
        rotors = self.groups(expression, by=ROTOR)[ROTOR].tolist()
        if len(rotors) != 1:
            listed = ", ".join(map(str, rotors[:6])) + (", …" if len(rotors) > 6 else "")
            or_design = ", or a design of a grid by its parameters, as in lock_number=7.3" if rotors else ""
            what = f"{len(rotors)} rotors have rows for which it holds ({listed})" if rotors else _NO_ROW
            raise ParameterError("expression", expression, f"{what}; name one, as in rotor == 0{or_design}")
        found = self.query(expression, columns=read)
        name = str(self._named(found[ROTOR][:1])[0])
        return interpolated(found, names, watched, present, mu, int(rows), name)

    def _grid(
        self, expression: str, present: Mapping[str, Column], design: Mapping[str, float]
    ) -> tuple[int, list[Axis]]:
        """The axes that the rotors of an expression form, and a rotor of the node nearest to the design."""
        known = [name for name in (*DESIGN, DERIVED) if name in present]
        found = self.groups(expression, by=ROTOR, reduce=[f"first({name})" for name in known])
        rotors = {ROTOR: found[ROTOR]} | {name: found[f"first({name})"] for name in known}
        if not rotors[ROTOR].size:
            raise ParameterError("expression", expression, f"{_NO_ROW}; name rows of some rotors, or leave it out")
        axes = axes_of(rotors, design)
        near = np.ones(rotors[ROTOR].size, dtype=bool)
        for axis in axes:
            near &= rotors[axis.name] == axis.nodes[np.argmin(np.abs(axis.nodes - axis.at))]
        return int(rotors[ROTOR][near][0]), axes

    def _wanted(
        self,
        table: str,
        columns: str | Sequence[str] | None,
        present: Mapping[str, Column],
        scope: Scope,
        used: Sequence[str],
    ) -> list[str]:
        named = (ROTOR_NAME,) if ROTOR in present else ()
        if columns is None:
            few = [FILE, *DEFAULT_COLUMNS.get(table, present), *used]
            known = {*present, *(named if any(self.names) else ())}
            return list(dict.fromkeys(name for name in few if name in known or name in used))
        wanted: dict[str, None] = {}
        if not isinstance(columns, Iterable):
            raise QueryError(f"columns is a text or a list of names, and {short(repr(columns))} was given")
        for name in [columns] if isinstance(columns, str) else columns:
            if name == "*":
                wanted |= dict.fromkeys([*present, *named])
            else:
                wanted[name if name in present or name in named else scope.check(str(name))] = None
        if not wanted:
            raise QueryError('no columns are asked for; name some, or "*" for all')
        return list(wanted)

    def _settled(self, table: str, predicate: Predicate) -> Predicate:
        """A first pass where rows are compared with a value nearest to a number, over the chunks that may hold it."""
        if not predicate.nearest:
            return predicate
        search = Nearest(predicate.nearest)
        for _, chunk in self._reader.chunks(table, search.columns, skip=search.skip):
            search.add(chunk)
        for sentence in search.beyond():
            warnings.warn(sentence, FloquetWarning, stacklevel=4)
        return predicate.settled(search.found)

    def _pieces(
        self, table: str, predicate: Predicate, read: Sequence[str], best: Best | None, limit: int | None
    ) -> Iterator[Rows]:
        """Rows that hold, a few chunks at a time; the columns that are not tested are read only where a row does."""
        early = list(dict.fromkeys([*predicate.names, *(best.keys if best else [])])) or list(read)
        late = [name for name in read if name not in early]
        yield self._nothing(table, read)
        if limit == 0:
            return
        reader = self._reader

        def tested(span: tuple[int, int]) -> tuple[Array, Rows]:
            chunk = joined([part for _, part in reader.chunks(table, early, *span)])
            hits = np.flatnonzero(predicate.holds(chunk, span[1] - span[0]))
            found = hits, {name: chunk[name][hits] for name in early}
            return found if best is not None else whole(span, *found)

        def whole(span: tuple[int, int], hits: Array, found: Rows) -> tuple[Array, Rows]:
            if late and hits.size:
                beside = joined([part for _, part in reader.chunks(table, late, *span)])
                found |= {name: values[hits] for name, values in beside.items()}
            return hits, found

        spans = reader.spans(table, skip=predicate.skip)
        for span, (hits, found) in in_order(((span, partial(tested, span)) for span in spans), large=False):
            if best is not None:
                admitted = best.admits(found)
                kept = {name: values[admitted] for name, values in found.items()}
                hits, found = whole(span, hits[admitted], kept)
            if hits.size:
                yield {name: found[name] for name in read}

    def _nothing(self, table: str, read: Sequence[str]) -> Rows:
        """No row, in the right dtypes."""
        present = self.columns(table)
        return {name: np.empty(0, np.dtype(present[name].dtype) if name in present else float) for name in read}

    def _named(self, rotor: Array) -> Array:
        """The names of rotor indices; an index without a name gives an empty string."""
        names = np.array([*self.names, ""], dtype=object)
        return names[np.where((rotor >= 0) & (rotor < len(self.names)), rotor, len(self.names))]


_NO_ROW = "it holds for no row"


def _both(*expressions: str) -> str:
    """The expression that holds where all do; an empty one holds everywhere."""
    return " and ".join(f"({text})" for text in expressions if text.strip())


def _sorted_by(sort: object, descending: object) -> list[str]:
    """The columns of an order, given as one text with commas or as several."""
    names = [sort] if isinstance(sort, str) else [] if sort is None else sort
    if not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise ParameterError("sort", sort, f"{short(repr(sort))} was given; it is a column, or several")
    found = [name.strip() for text in names for name in text.split(",") if name.strip()]
    if words := [name for name in found if name.endswith((" desc", " asc"))]:
        raise ParameterError("sort", words[0], "an order goes up, and with descending down: name columns alone")
    if turned := [name for name in found if name.startswith("-")]:
        raise ParameterError("sort", turned[0], f"{turned[0]!r} is no column: descending turns the whole order round")
    if sort is not None and not found:
        raise ParameterError("sort", sort, "no column is named; name some, or leave it out")
    if descending and not found:
        raise ParameterError("descending", descending, "it turns an order round, and none is given: add sort")
    return found


def _checked_limit(limit: object) -> int | None:
    if limit is None:
        return None
    if isinstance(limit, bool) or not isinstance(limit, int | np.integer) or limit < 0:
        raise QueryError(f"limit is a number of rows, 0 or more, and {short(repr(limit))} was given")
    return int(limit)


def open_database(path: str | Path | Sequence[str | Path]) -> Database:
    """Open a database for reading; close it, or use it in a ``with`` statement.

    Several files, which must have the same columns, are one database with a column ``file`` of their names as given;
    the rotors of each are numbered on from those of the one before.
    """
    from floquet import store

    closing = ExitStack()
    if isinstance(path, str | Path) or not isinstance(path, Sequence) or not path:
        reader = closing.enter_context(store.open_file(path))  # type: ignore[arg-type]
        if not reader.tables:
            closing.close()
            raise DatabaseError(reader.path, store.NO_TABLES)
        return Database(reader.path, reader, closing)
    paths = [str(file_name(one)) for one in path]
    check_once(paths)
    with closing:
        readers = [closing.enter_context(store.open_file(one)) for one in paths]
        return Database(", ".join(paths), Several(paths, readers), closing.pop_all(), paths)
