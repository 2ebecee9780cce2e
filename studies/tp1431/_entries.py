"""Entries of matrices in multiblade coordinates with their formulas: what tables 1 and 2 share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquet import PeriodicSystem
from floquet.models import FORCING
from floquet.periodic import PeriodicMatrix


def harmonics(matrix: PeriodicMatrix, n: int) -> NDArray[np.float64]:
    """Means and coefficients of cos nψ and sin nψ, (3, rows, columns)."""
    c = matrix.widened(n).coefficients[0]
    middle = len(c) // 2
    return np.stack([c[middle].real, 2.0 * c[middle + n].real, -2.0 * c[middle + n].imag])


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
