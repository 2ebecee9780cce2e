"""Errors of one rotor at and beside the places where they have corners: ends of locks and splits of the TPP.

The rotor is made again from the parameters in its rows; lock edges and splits are those of :mod:`floquet.validity`, and
between the rows on either side of each the errors are computed in points graded to it, as their square roots want.  A
spike at an edge is so drawn to its tip, and a lock between two rows is seen.  Rows that the rotor does not reproduce
(of other physics, or without parameters) are drawn as they are, with the bands they show themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquet.comparison import compare, eigenvalues, exact_model, simple_model
from floquet.plot.curves import Array, Band, Rows, lock_bands, modes_of
from floquet.rotor import PARAMETERS, Hub, Rotor
from floquet.validity import lock_windows, split_edges

__all__ = ["Errors", "errors_of"]

SIDES = np.linspace(0.0, 1.0, 17)[:-1] ** 2  # of the way from an edge to the second row beside it
REPRODUCED = 1e-6  # of an error, and in itself: maps along μ are right to 1e-9
REAL = 1e-9  # of an imaginary part that is none


class Errors(NamedTuple):
    """μ, errors and rules by mode, locks, and the ranges in which a pair of the TPP is split into two reals."""

    mu: Array
    error: Mapping[str, Array]
    rule: Mapping[str, NDArray[np.int8]]
    bands: Sequence[Band]
    splits: Sequence[tuple[float, float]]


def errors_of(rows: Rows, options: Mapping[str, Any]) -> Errors:
    """The errors in rows in the order of μ, and between them at edges."""
    modes, mu = modes_of(rows), np.asarray(rows["advance_ratio"], float)
    error = {mode: np.asarray(rows[f"error_{mode}"], float) for mode in modes}
    rule = {mode: np.asarray(rows[f"rule_{mode}"], np.int8) for mode in modes}
    rotor = _rotor(rows)
    if rotor is None or not _reproduced(rotor, mu, error, options):
        return Errors(mu, error, rule, lock_bands(rows), ())
    bands = [band for band in lock_windows(rotor, float(mu[-1]), **options) if band[1] > mu[0]]
    edges = [edge for edge in split_edges(rotor, float(mu[-1]), **options) if edge > mu[0]]
    more = _beside(mu, [*edges, *(edge for band in bands for edge in band[:2])])
    if more.size:
        found = compare(rotor, more, **options)
        order = np.argsort(np.concatenate([mu, more]), kind="stable")
        mu = np.concatenate([mu, more])[order]
        error = {mode: np.concatenate([error[mode], found[mode].error])[order] for mode in modes}
        rule = {mode: np.concatenate([rule[mode], found[mode].rule])[order] for mode in modes}
    return Errors(mu, error, rule, bands, _split(rotor, [float(mu[0]), *edges, float(mu[-1])], options))


def _rotor(rows: Rows) -> Rotor | None:
    """The rotor of the rows; None where its parameters are not all there."""
    names = [parameter.name for parameter in PARAMETERS]
    if not all(name in rows for name in (*names, "hub", "blades")):
        return None
    values: dict[str, Any] = {name: float(np.asarray(rows[name])[0]) for name in names}
    return Rotor(hub=Hub(int(rows["hub"][0])), blades=int(rows["blades"][0]), **values)


def _reproduced(rotor: Rotor, mu: Array, error: Mapping[str, Array], options: Mapping[str, Any]) -> bool:
    """Whether first, middle and last error are those of the rotor."""
    places = np.array([0, len(mu) // 2, len(mu) - 1])
    found = compare(rotor, mu[places], **options)
    known = [mode.name for mode in found.modes]
    return all(mode in known for mode in error) and all(
        np.allclose(values[places], found[mode].error, rtol=REPRODUCED, atol=REPRODUCED, equal_nan=True)
        for mode, values in error.items()
    )


def _beside(mu: Array, edges: Sequence[float]) -> Array:
    """Edges between the first and the last row, and points from them to the second rows on both sides."""
    inner = np.array([edge for edge in edges if mu[0] < edge < mu[-1]])
    right = np.searchsorted(mu, inner, side="right")
    left = np.searchsorted(mu, inner, side="left") - 1
    ways = [mu[np.maximum(left - 1, 0)] - inner, mu[np.minimum(right + 1, len(mu) - 1)] - inner]
    points = np.concatenate([(inner[:, None] + way[:, None] * SIDES).ravel() for way in ways])
    return np.setdiff1d(points, mu)


def _split(rotor: Rotor, edges: Sequence[float], options: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Ranges between edges in which some pair of the simple model is real."""
    low, high = np.array(edges[:-1]), np.array(edges[1:])
    given = {**options, "model": exact_model(rotor, options.get("model"))}
    roots = eigenvalues(simple_model(rotor, 0.5 * (low + high), **given))
    real = (np.abs(roots.imag) < REAL).any(axis=-1)
    out: list[tuple[float, float]] = []
    for a, b in zip(low[real].tolist(), high[real].tolist(), strict=True):
        if out and out[-1][1] == a:  # another pair splits
            out[-1] = (out[-1][0], b)
        else:
            out.append((a, b))
    return out
