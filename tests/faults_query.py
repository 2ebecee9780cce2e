"""The faults that ``make mutants`` injects into queries, exports and the digests of the file format."""

from __future__ import annotations

from tests.faults import Mutant

__all__ = ["QUERIES"]

GRID, GROUPS, DATABASE, PIECES, OUT, DIGESTS = (
    "floquet/query/grid.py",
    "floquet/query/groups.py",
    "floquet/query/database.py",
    "floquet/query/selection.py",
    "floquet/export.py",
    "floquet/store/digests.py",
)
BETWEEN, OPEN = "tests/test_grid.py", "tests/test_openness.py"

QUERIES: tuple[Mutant, ...] = (
    Mutant("carriage returns without quotes", "floquet/plain.py", 'lineterminator="\\r\\n"', 'lineterminator="\\n\\n"',
           "tests/test_cli.py -k lines_of_csv"),
    Mutant("ties by the last digit", PIECES, "TIE = 4 *", "TIE = 0 *", "tests/test_query.py -k two_as_near"),
    Mutant("links are other files", "floquet/query/several.py", "os.path.realpath(path) for", "path for",
           "tests/test_cli.py -k one_by_whatever"),
    Mutant("parts beside their whole", DATABASE, "for name in wanted if name not in wholes]", "for name in wanted]",
           "tests/test_cli.py -k in_the_whole"),
    Mutant("nothing near untold", "floquet/cli/queries.py", 'not rows and "nearest" in expression', "False",
           "tests/test_cli.py -k several_numbers"),
    Mutant("screens without end", "floquet/cli/queries.py", 'SCREEN if choice["limit"] is None else None', "None",
           "tests/test_cli.py -k screen"),
    Mutant("numbers beyond all values untold", PIECES, "not low <= number <= high", "False",
           "tests/test_query.py -k beyond_all"),
    Mutant("no count of nothing", GROUPS, "if not self._by and not self._number and not", "if False and not",
           "tests/test_query.py -k of_no_rows"),
    Mutant("no table for a column", "floquet/query/language.py", "if name in self.elsewhere:", "if False:",
           "tests/test_cli.py -k another_table"),
    Mutant("no more error at an edge", GRID, "AT_EDGE = 4.0", "AT_EDGE = 1.0", BETWEEN),
    Mutant("layers of another kind", GRID, "if (kind[layer] == own).all():", "if True:", BETWEEN),
    Mutant("cells of two kinds", GRID, "    _check_cell(axes, ends, kinds, present)\n", "", BETWEEN),
    Mutant("designs beyond the rotors", GRID, "not low < axis.at < high", "False", BETWEEN),
    Mutant("speeds beyond the rows", GRID, "not low < mu < high", "False", BETWEEN),
    Mutant("two nodes and no error", GRID, "high - low + 1 < LEAST", "high - low + 1 < 2", BETWEEN),
    Mutant("locks passed unseen between rotors", GRID, "np.floor(2 * values)", "np.floor(0 * values)", BETWEEN),
    Mutant("the error of the last axis", GRID, "error += float(", "error = float(", BETWEEN),
    Mutant("rotors that are no grid", GRID, "if count > 1 and not (names and is_grid(rotors, names)):", "if False:",
           BETWEEN),
    Mutant("rotors at other speeds", GRID,
           "if index.size != np.prod(shape) or np.unique(index).size != index.size:", "if False:", BETWEEN),
    Mutant("the first nodes for the nearest", GRID,
           'np.argsort(np.abs(x - at), kind="stable")[: x.size - drop]', "np.arange(x.size - drop)", BETWEEN),
    Mutant("rotors that differ in what is not named", GRID, "if name not in design and name != DERIVED:", "if False:",
           BETWEEN),
    Mutant("growth on one axis first", GRID, "(high - low, a, beside)", "(a, a, beside)", BETWEEN),
    Mutant("the lower of two in the middle", GROUPS, "for odd in (1, 0))", "for odd in (1, 1))", OPEN),
    Mutant("medians with nan", GROUPS, "        known = ~np.isnan(values)\n        kept",
           "        known = np.isfinite(values)\n        kept", OPEN),
    Mutant("names of nobody", DATABASE, "named if any(self.names) else", "named if self.names else", OPEN),
    Mutant("counts without the limit", DATABASE, "return rows if limit is None else min(rows, limit)", "return rows",
           OPEN),
    Mutant("a limit for each piece", PIECES, "left = None if left is None else max(left - rows, 0)", "left = limit",
           OPEN),
    Mutant("inf in JSON as Python writes it", OUT, "type(value) is float and math.isfinite(value)",
           "type(value) is float", OPEN),
    Mutant("numbers for words in Parquet", OUT, "enumerate(column.flags)}", "enumerate(sorted(column.flags)[::-1])}",
           OPEN),
    Mutant("a row group for each piece", OUT, ">= TOGETHER", ">= 0", OPEN),
    Mutant("the database written over", OUT, "if path.exists() and any(", "if False and any(", OPEN),
    Mutant("names beside their numbers in netCDF", OUT, "if name != ROTOR_NAME or ROTOR not in answer.columns",
           "if True", OPEN),
    Mutant("all waits for the end", OUT, "                waiting = []\n", "                pass\n", OPEN),
    Mutant("ranges in another order", DIGESTS, '(minima, "<f8"), (maxima, "<f8")', '(maxima, "<f8"), (minima, "<f8")',
           OPEN),
    Mutant("HDF5's own attributes digested", DIGESTS, "if k not in HDF5_ATTRIBUTES", "if True", OPEN),
)  # fmt: skip
