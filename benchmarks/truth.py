"""Write data/reference/benchmark.json: the 200 blades and their exponents to thirty digits.

    python -m benchmarks truth          a minute and a half; the same bytes every time; needs mpmath

The arithmetic is that of :mod:`tests.truth`, which shares none with the package: Taylor series at fifty digits, done
twice with different orders and steps, which must agree to 1e-27.
"""

from __future__ import annotations

import json

from mpmath import mp

from benchmarks.points import COUNT, NAMES, RANGES, SEED, STORED, draw
from tests.truth import make_reference, taylor

META = {
    "title": "Floquet exponents of 200 random flapping blades, computed here",
    "program": "python -m benchmarks truth",
    "seed": SEED,
    "ranges": dict(zip(NAMES, RANGES, strict=True)),
    "equation": "beta'' + d(psi) beta' + k(psi) beta = 0, eq. (1) of NASA TP-1431; exponents are per rev",
    "parameters": "the double nearest to each number is the exact parameter; offset_mass_ratio = 1.5 hinge_offset",
    "columns": [*NAMES, "Re eta_1", "Im eta_1", "Re eta_2", "Im eta_2"],
    "exponents": "alpha + i rho, alpha - i rho; in a lock sigma_1 + i rho, sigma_2 + i rho; rho is the rotation number",
    "how": "Taylor series in 50-digit arithmetic, order 56 with 30 steps a revolution against order 48 with 42 steps, "
    "which agree to 1e-27 or better",
    "digits": make_reference.DIGITS_GIVEN,
}


def main() -> None:
    """Draw, compute, write."""
    mp.dps = taylor.DIGITS
    rows = ",\n".join(json.dumps(row(i, blade)) for i, blade in enumerate(draw(COUNT, SEED).tolist()))
    head = ",\n".join(f" {json.dumps(key)}: {json.dumps(value)}" for key, value in META.items())
    STORED.write_text(f'{{"meta": {{\n{head}\n}},\n"blades": [\n{rows}\n]}}\n', encoding="utf-8")
    print(f"{COUNT} blades in {STORED.name}")


def row(index: int, blade: list[float]) -> list[float | str]:
    """Parameters and exponents of one blade."""
    case = {"id": f"blade {index}", "parameters": dict(zip(NAMES, blade, strict=True)), "options": {}}
    (a, b), (c, d) = make_reference.solve(case)["exponents"]
    return [*blade, a, b, c, d]
