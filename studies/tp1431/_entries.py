"""Entries of matrices with their formulas, as records and as matrices in letters: what tables 1 to 3 share."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquet import PeriodicSystem
from floquet.models import FORCING
from floquet.periodic import TWO_PI, PeriodicMatrix

GREEK = {"gamma": "γ", "kappa": "κ", "eps": "ε", "mu": "μ", "K1": "K₁", "P2": "P²", "**2": "²", "-": "−"}
SYMBOLS = {
    "beta_0": "β₀", "beta_1c": "β₁c", "beta_1s": "β₁s", "beta_d": "β_d", "a_0": "a₀", "a_1": "a₁", "b_1": "b₁",
    "theta_0": "θ₀", "A_1c": "A₁c", "B_1c": "B₁c", "theta_t": "θ_t", "lambda": "λ", "p_w": "p/Ω", "q_w": "q/Ω",
    "pdot_w": "ṗ/Ω²", "qdot_w": "q̇/Ω²", "normal_acceleration": "((ẇ−uq+pv)−g)/(Ω²R)",
}  # fmt: skip
#: The letters of one blade's equation; those of f by input.
BLADE = {
    "": {"c0": "gamma/2*(1/4 - 2*eps/3 + eps**2/2)", "cs1": "gamma*mu/2*(1/3 - eps + eps**2)",
         "k0": "1 + kappa + m + gamma*K1/8*(1 - 4*eps/3) + gamma*K1*mu**2/8*(1 - eps)**2",
         "kc1": "gamma*mu/2*(1/3 - eps/2)", "ks1": "gamma*K1*mu/2*(2/3 - eps)",
         "kc2": "-gamma*K1*mu**2/8*(1 - eps)**2", "ks2": "gamma*mu**2/8*(1 - eps)**2"},
    "theta_0": {"f0": "gamma/2*(1/4 - eps/3) + gamma*mu**2/8*(1 - eps)**2",
                "fs1": "gamma*mu*(1/3 - eps/2)", "fc2": "-gamma*mu**2/8*(1 - eps)**2"},
    "A_1c": {"fc1": "-gamma/2*(1/4 - eps/3) - gamma*mu**2/16*(1 - eps)**2",
             "fs2": "-gamma*mu/2*(1/3 - eps/2)", "fc3": "gamma*mu**2/16*(1 - eps)**2"},
    "B_1c": {"f0": "-gamma*mu/2*(1/3 - eps/2)", "fs1": "-gamma/2*(1/4 - eps/3) - 3*gamma*mu**2/16*(1 - eps)**2",
             "fc2": "gamma*mu/2*(1/3 - eps/2)", "fs3": "gamma*mu**2/16*(1 - eps)**2"},
    "theta_t": {"f0": "gamma/2*(1/5 - eps/4) + gamma*mu**2/4*(1/3 - eps/2)",
                "fs1": "gamma*mu*(1/4 - eps/3)", "fc2": "-gamma*mu**2/4*(1/3 - eps/2)"},
    "lambda": {"f0": "gamma/2*(1/3 - eps/2)", "fs1": "gamma*mu/4*(1 - eps)**2"},
    "p_w": {"f0": "gamma*mu/4*(1/3 - eps/2)", "fc1": "2*(1 + m)", "fs1": "gamma/2*(1/4 - eps/3)",
            "fc2": "-gamma*mu/4*(1/3 - eps/2)"},
    "q_w": {"fc1": "gamma/2*(1/4 - eps/3)", "fs1": "-2*(1 + m)", "fs2": "gamma*mu/4*(1/3 - eps/2)"},
    "pdot_w": {"fs1": "1"}, "qdot_w": {"fc1": "1"}, "normal_acceleration": {"f0": "s"},
}  # fmt: skip


def harmonics(matrix: PeriodicMatrix, n: int) -> NDArray[np.float64]:
    """Means and coefficients of cos nψ and sin nψ, (3, rows, columns)."""
    k = round(n * matrix.period / TWO_PI)  # identical blades repeat after each passage
    c = matrix.widened(k).coefficients[0]
    return c[[0, 2 * k - 1, 2 * k]]


def record(place: Sequence[str], n: int, formulas: Sequence[str], values: NDArray[np.float64]) -> dict[str, Any]:
    """Matrix, row and column, the harmonic n, and mean, cosine and sine as formulas and as values."""
    names, told = ("mean", "cosine", "sine"), [round(float(x), 14) + 0.0 for x in values]
    out = dict(zip(("matrix", "row", "column"), place, strict=True)) | {"per_rev": n}
    values_by_name = {f"{name}_value": value for name, value in zip(names, told, strict=True)}
    return out | dict(zip(names, formulas, strict=True)) | values_by_name


def entries(
    system: PeriodicSystem, formulas: Mapping[tuple[str, ...], tuple[int, str, str, str]], blades: int
) -> list[dict[str, Any]]:
    """The entries that are not zero; letters of f that an input does not have are left out.

    ``formulas`` are the harmonic n, the mean, and the coefficients of cos nψ and sin nψ; a row of f holds for every
    input.
    """
    q, matrices = system.coordinates, {"D": system.damping, "K": system.stiffness, "f": system.forcing}
    out = []
    for (matrix, row, *one), (n, *told) in formulas.items():
        for column in one or FORCING:
            place = q.index(row), (FORCING if matrix == "f" else q).index(column)
            values = harmonics(matrices[matrix], n or blades)[:, *place]
            shown = ["0" if matrix == "f" and abs(x) < 1e-14 else f for f, x in zip(told, values, strict=True)]
            if set(shown) != {"0"}:
                out.append(record((matrix, row, column), n if set(shown[1:]) != {"0"} else 0, shown, values))
    return out


# ---------------------------------------------------------------------- in letters
def typeset(formula: str) -> str:
    """``-gamma*mu**2/8*(1 - eps)**2`` → ``−γμ²/8 (1 − ε)²``."""
    for written, shown in GREEK.items():
        formula = formula.replace(written, shown)
    return re.sub(r"(?<=/\d)\*", " ", formula).replace("*(", " (").replace("*", "")


def harmonic(n: int, formulas: Sequence[str]) -> str:
    """``k0 − 1 + kc2/2 + (cs1 + kc1)/2 cos 3ψ + ks1/2 sin 3ψ``."""
    names = ("", f" cos {n}ψ", f" sin {n}ψ")
    told = [f"{formula}{name}" for formula, name in zip(formulas, names, strict=True) if formula != "0"]
    return typeset(" + ".join(told) or "0").replace("+ −", "− ")


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Cells in columns, two spaces apart."""
    widths = [max(map(_width, column)) for column in zip(*rows, strict=True)]
    padded = [[x + " " * (w - _width(x)) for x, w in zip(row, widths, strict=True)] for row in rows]
    return ["  ".join(row).rstrip() for row in padded]


def _width(text: str) -> int:
    """Characters, but for accents, which stand on the one before."""
    return sum(not unicodedata.combining(x) for x in text)


def in_letters(
    coordinates: Sequence[str], formulas: Mapping[tuple[str, ...], tuple[int, str, str, str]],
    names: Sequence[str] = ("D", "K"),
) -> str:  # fmt: skip
    """D and K as matrices and f as a column, which holds for every input."""
    blocks = []
    for name, matrix in zip(names, "DK", strict=True):
        cells = [
            [harmonic(*_split(formulas.get((matrix, row, column)))) for column in coordinates] for row in coordinates
        ]
        head = [name, *(SYMBOLS[x] for x in coordinates)]
        lines = aligned([head, *([SYMBOLS[row], *line] for row, line in zip(coordinates, cells, strict=True))])
        blocks.append("\n".join(lines))
    forcing = [(SYMBOLS[row], harmonic(*_split(formulas["f", row]))) for row in coordinates if ("f", row) in formulas]
    return "\n\n".join([*blocks, "\n".join(aligned([("f", "every input"), *forcing]))] if forcing else blocks)


def _split(told: tuple[int, str, str, str] | None) -> tuple[int, Sequence[str]]:
    return (told[0], told[1:]) if told else (0, ("0", "0", "0"))


def by_input(coordinates: Sequence[str], formulas: Mapping[tuple[str, str], str]) -> str:
    """f with a row for each input and a column for each coordinate's equation."""
    rows = [[SYMBOLS[x], *(typeset(formulas.get((row, x), "0")) for row in coordinates)] for x in FORCING]
    return "\n".join(aligned([["f̃", *(SYMBOLS[x] for x in coordinates)], *rows]))


def spelled_out(letters: Mapping[str, Mapping[str, str]]) -> str:
    """The letters in the rotor's parameters, those of f by input."""
    rows = [(SYMBOLS.get(x, ""), f"{name} = {typeset(f)}") for x, some in letters.items() for name, f in some.items()]
    return "\n".join(aligned([("letters", "of one blade's equation, those of f by input"), *rows]))
