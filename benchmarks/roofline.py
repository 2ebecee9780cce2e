"""How near the integration comes to what one core can do: floating-point operations a second against the measured peak.

Counting rule.  An addition, subtraction or multiplication is one operation, a fused multiply-add two, a division or
square root one.  Comparisons, sign changes, conversions, loads and stores are none; what a masked lane computes for
nothing counts as nothing.  So the peak is what independent multiply-adds reach when nothing leaves the registers.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
import textwrap
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers.ours import BATCH, rotor_of
from benchmarks.points import draw
from benchmarks.speed import OTHER_BLADES
from benchmarks.timing import Lap, interleave, plain, table
from floquet import flapping
from floquet.kernels import available, hill, taylor
from floquet.period_map import hill_form, period_map

__all__ = ["kernel", "main"]

CHAINS = 12  # multiply-adds under way: more than latency times units of any current core (4 × 2), fewer than registers
DEPTH = 48  # of them in a row before a value is stored, so that memory does not matter
LANES, REPEATS = 64, 400
REGISTERS = {"zmm": 512, "ymm": 256, "xmm": 128}


def main() -> None:
    """The table: the peak, and the kernel beside it."""
    chains, registers = peak()
    laps = {f"independent multiply-adds ({registers})": Lap(chains, 2 * CHAINS * DEPTH * LANES * REPEATS)}
    try:
        call, operations = kernel()
        laps[f"integration of {BATCH} blades"] = Lap(call, operations)
    except ImportError as error:
        print(f"SKIPPED the share of the kernel: {error}", file=sys.stderr, flush=True)
    interleave(list(laps.values()))
    top = next(iter(laps.values()))
    rows = [
        [name, plain(1e-9 / lap.best), plain(1e-9 / lap.median), f"{100 * top.best / lap.best:.0f} %"]
        for name, lap in laps.items()
    ]
    heads = ["one core", "best, 10⁹ operations a second", "median", "of the peak"]
    print(f"### Share of the processor's peak\n\n{table(heads, rows)}\n", flush=True)


def kernel() -> tuple[Callable[[], Any], int]:
    """Our integration kernel on a large batch, from prepared coefficients, and the operations that takes.

    Operations are counted by the rule above in the source of what a panel runs, times the panels of every point.
    """
    if not available():
        raise ImportError("numba is not to be used")
    points = draw(BATCH, OTHER_BLADES)
    system = flapping(rotor_of(points), points[:, 4])
    q = hill_form(system.part(slice(None))).q
    (terms,) = q.polynomials
    counts, out = period_map(system).panels.astype(np.int64), np.empty((len(hill.ROWS), BATCH))
    arguments = (terms, np.abs(terms).sum(axis=0), np.arange(BATCH), counts, q.turn, 1.0, out)
    return lambda: hill.map_equal_panels(*arguments), int(counts.sum()) * operations_of_a_panel()


def operations_of_a_panel() -> int:
    """Of the series and its sums, the products forwards and backwards, and the weighing of the errors."""
    parts = (taylor.two_harmonics, taylor.panel, hill.chained, hill.chained, hill.size_of, hill.weighed, hill.entrywise)
    turned = 4 * 3  # the coefficients of two harmonics about the centre
    return turned + sum(arithmetic(part) for part in parts)


def arithmetic(function: Callable[..., Any]) -> int:
    """Additions, subtractions, multiplications and divisions in a function's source."""
    counted = (ast.Add, ast.Sub, ast.Mult, ast.Div)
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    return sum(isinstance(node, ast.BinOp) and isinstance(node.op, counted) for node in ast.walk(tree))


def peak() -> tuple[Callable[[], Any], str]:
    """A call of independent chains of multiply-adds, and what its machine code uses: ``zmm: 1152 of 512 bits``."""
    import numba

    text: dict[str, Any] = {}
    exec(
        program(), text
    )  # straight-line code: a compiler does not unroll a loop this far, nor keep its sums in registers
    compiled = numba.njit(fastmath={"contract"}, error_model="numpy")(text["chains"])
    x = np.random.default_rng(0).random((CHAINS, LANES))
    compiled(x, 0.5, 0.1, 1)
    (assembly,) = compiled.inspect_asm().values()
    return lambda: compiled(x, 0.5, 0.1, REPEATS), used(assembly)


def program() -> str:
    """``s = s*a + b`` for all chains in turn, again and again; the compiler makes vectors of the lanes."""
    chains = range(CHAINS)
    lines = [f"s{c} = x[{c}, i]" for c in chains]
    lines += [f"s{c} = s{c} * a + b" for _ in range(DEPTH) for c in chains]
    lines += [f"x[{c}, i] = s{c}" for c in chains]
    loops = ["def chains(x, a, b, repeats):", "    for _ in range(repeats):", f"        for i in range({LANES}):"]
    return "\n".join([*loops, *(f"            {line}" for line in lines)])


def used(assembly: str) -> str:
    """The widest registers of packed multiply-adds, with a warning where the processor has wider ones."""
    from llvmlite.binding import get_host_cpu_features

    counts = {name: len(re.findall(rf"\bvfn?madd\w+pd\b.*%{name}", assembly)) for name in REGISTERS}
    widest = next((name for name, count in counts.items() if count >= CHAINS * DEPTH), None)
    if widest is None:
        print("the peak's loop was not compiled to packed multiply-adds of x86: it may be too low", file=sys.stderr)
        return "registers unknown"
    features = get_host_cpu_features()
    if features.get("avx512f") and widest != "zmm":
        print(
            f"the processor has 512-bit registers and the peak's loop uses {widest}: it may be too low", file=sys.stderr
        )
    return f"{widest}, {REGISTERS[widest]} bits"
