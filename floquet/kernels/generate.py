"""Writes ``taylor.py``, the straight-line arithmetic of one panel: ``python -m floquet.kernels.generate``.

On a panel with centre c and half length h let ψ = c + hx and -h² q(ψ) = Σ p_k x^k.  The solutions u (u(0) = 1,
u'(0) = 0) and v (0, 1) of y'' = p y, primes d/dx, have the Taylor coefficients::

    (k+1)(k+2) y_{k+2} = Σ_{j≤k} p_j y_{k-j}

Loops over k and j cost more than the arithmetic in them, and an array of coefficients a point would live in memory: so
every coefficient gets a name of its own, products with 0 and 1 are left out, and the compiler keeps what it can in
registers.  There are more coefficients than registers, so the order of the lines decides how often they are fetched:
one order after the other would be held up by that, two at a time are not.

A test compares the file with what this program writes.
"""

from __future__ import annotations

from pathlib import Path

ORDER = 24
TARGET = Path(__file__).with_name("taylor.py")
HEADER = '''"""One panel of y'' = p(x) y from -1 to 1 by its Taylor series about 0, to order {order}.

Written by generate.py, which explains it; do not edit.
"""

from __future__ import annotations

from typing import Any

__all__ = ["ORDER", "panel", "two_harmonics", "weights"]

ORDER = {order}


def weights(table: Any) -> tuple[Any, ...]:
    """The rows of :func:`two_harmonics`' table (ORDER - 1, 2) as a tuple of numbers."""
    return ({table})  # fmt: skip


def two_harmonics(q0: Any, even_1: Any, odd_1: Any, even_2: Any, odd_2: Any, w: tuple[Any, ...]) -> tuple[Any, ...]:
    """The coefficients of p for a mean and two harmonics about the centre of the panel, and their weights."""
    return (  # fmt: skip
{coefficients}
    )


def panel({arguments}) -> tuple[Any, Any, Any, Any, Any]:  # fmt: skip
    """F = Y(1) Y(-1)⁻¹ by rows, and a bound of the sum of the changes of its entries without the last two orders.

    The arguments are the Taylor coefficients of p, numbers or arrays (one entry a point).
    """
'''
ONE, ZERO = {"u0", "v1"}, {"u1", "v0", "v2"}  # coefficients known beforehand


def times(y: str, factor: str) -> str:
    """``factor * y``, shorter where y is 1."""
    return factor if y in ONE else f"{factor} * {y}"


def series(order: int) -> list[str]:
    """The coefficients of u and v: those of two orders side by side, term by term.

    Order k + 1 does not need y_{k+2}, so both grow together: a p_j is fetched for four products, a y_k for two.
    """
    lines = []
    for first in range(0, order - 1, 2):
        orders = [k for k in (first, first + 1) if k < order - 1]
        terms = {(y, k): [j for j in range(k, -1, -1) if f"{y}{k - j}" not in ZERO] for y in "uv" for k in orders}
        for j in range(orders[-1], -1, -1):
            for (y, k), places in terms.items():
                if j in places:
                    name, term = f"{y}{k + 2}", times(f"{y}{k - j}", f"p{j}")
                    total = term if j == places[0] else f"{name} + {term}"
                    scale = 1.0 / ((k + 1) * (k + 2))
                    lines.append(f"{name} = ({total}) * {scale!r}" if j == places[-1] else f"{name} = {total}")
    return lines


def sums(order: int) -> list[str]:
    """Even and odd parts of y and y' at x = 1, from the smallest term to the largest."""
    lines = []
    for y in "uv":
        for parity, (value, rate) in enumerate((("e", "r"), ("o", "s"))):
            known = [k for k in range(order, -1, -1) if k % 2 == parity and f"{y}{k}" not in ZERO]
            lines.append(f"{y}{value} = " + " + ".join("1.0" if f"{y}{k}" in ONE else f"{y}{k}" for k in known))
            lines.append(f"{y}{rate} = " + " + ".join(times(f"{y}{k}", f"{k}.0") for k in known if k))
    return lines


def product() -> list[str]:
    """F = Y(1) adj Y(-1): the determinants of both are 1, and y' is even where y is odd."""
    lines = [f"{y}p, {y}m, {y}dp, {y}dm = {y}e + {y}o, {y}e - {y}o, {y}s + {y}r, {y}s - {y}r" for y in "uv"]
    entries = ("up * vdm - vp * udm", "vp * um - up * vm", "udp * vdm - vdp * udm", "vdp * um - udp * vm")
    return lines + [f"f{i} = {entry}" for i, entry in enumerate(entries)]


def change(order: int) -> list[str]:
    """|δY(1)| |Y(-1)| + |Y(1)| |δY(-1)|, entries added, with δY the last two orders."""
    last = " + ".join(f"{k}.0 * (abs(u{k}) + abs(v{k}))" for k in (order - 1, order))
    size = " + ".join(f"abs({y}{end})" for y in "uv" for end in ("p", "m", "dp", "dm"))
    return [f"e = ({last}) * ({size})"]


def source(order: int = ORDER) -> str:
    """The text of the file."""
    arguments = ", ".join(f"p{k}: Any" for k in range(order - 1))
    lines = series(order) + sums(order) + product() + change(order) + ["return f0, f1, f2, f3, e"]
    body = "".join(f"    {line}\n" for line in lines)
    table = ", ".join(f"table[{k}, 0], table[{k}, 1]" for k in range(order - 1))
    terms = [f"{x}_1 * w[{2 * k}] + {x}_2 * w[{2 * k + 1}]" for k in range(order - 1) for x in [("even", "odd")[k % 2]]]
    coefficients = "\n".join(f"        {'q0 * w[0] + ' if k == 0 else ''}{t}," for k, t in enumerate(terms))
    return HEADER.format(order=order, arguments=arguments, table=table, coefficients=coefficients) + body


if __name__ == "__main__":
    TARGET.write_text(source(), encoding="utf-8")
