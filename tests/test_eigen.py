"""Eigenvalues of many matrices and of products: in lanes beside LAPACK, and their bounds beside two hundred digits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from flint import acb_mat, arb_mat, ctx

from floquet.exponents.clusters import cluster_bounds
from floquet.exponents.products import _bounds as discs
from floquet.exponents.products import eigenvalues, multipliers, multipliers_of_lanes, size_of
from floquet.kernels import available
from tests.support import distances

EPS = float(np.finfo(float).eps)
compiled = pytest.mark.skipif(not available(), reason="numba is not to be used")
PATHS = [pytest.param(True, id="lanes", marks=compiled), pytest.param(False, id="numpy")]


def use(in_lanes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("floquet.exponents.products.worth_compiling", lambda points: in_lanes)


def matrices(kind: str, cases: int, n: int) -> np.ndarray:
    """Random matrices of a kind."""
    rng = np.random.default_rng([n, len(kind)])
    A = rng.normal(size=(cases, n, n))
    if kind == "graded":
        return A * np.exp(rng.uniform(-3, 3, (cases, n, 1)) + rng.uniform(-3, 3, (cases, 1, n)))
    if kind == "far from normal":
        return np.triu(2.0 * A, 1) + 0.1 * A
    if kind == "nearly orthogonal":
        return np.linalg.qr(A)[0] + 0.05 * A
    if kind == "real eigenvalues":
        return A @ np.swapaxes(A, -1, -2) / n
    return A


def exactly(A: np.ndarray) -> np.ndarray:
    """Eigenvalues to some two hundred digits (Arb)."""
    ctx.prec, before = 700, ctx.prec
    try:
        found = acb_mat(arb_mat(A.tolist())).eig(algorithm="approx")
        return np.array([complex(float(z.real), float(z.imag)) for z in found])
    finally:
        ctx.prec = before


def in_blocks(maps: np.ndarray, errors: np.ndarray) -> tuple[Any, Any]:
    """(cases, K, n, n) and (cases, K) with sixteen cases side by side."""
    cases = len(maps) // 16
    return (
        np.ascontiguousarray(np.moveaxis(maps.reshape(cases, 16, *maps.shape[1:]), 1, -1)),
        np.ascontiguousarray(np.moveaxis(errors.reshape(cases, 16, -1), 1, -1)),
    )


KINDS = ["normal", "graded", "far from normal", "nearly orthogonal", "real eigenvalues"]


# ---------------------------------------------------------------------- matrices
@pytest.mark.parametrize("in_lanes", PATHS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [2, 3, 4, 6, 9, 14, 20])
def test_eigenvalues_are_within_their_bounds_of_two_hundred_digits(
    n: int, kind: str, in_lanes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rounding alone: no error beyond its bound, and bounds a hundred times the errors, or eps |A|, in the median."""
    use(in_lanes, monkeypatch)
    A = matrices(kind, 36 if n < 14 else 18, n)
    values, bounds = eigenvalues(A, np.zeros(len(A)))
    error = np.stack([distances(found, exactly(a)) for found, a in zip(values, A, strict=True)])
    assert np.all(error <= bounds)
    assert np.median(bounds / np.maximum(error, EPS * np.linalg.norm(A, axis=(-2, -1))[:, None])) < 100


@compiled
@pytest.mark.parametrize("n", [2, 3, 5, 8, 13, 20])
def test_lanes_agree_with_lapack(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both within the bounds of both; conjugate pairs side by side, exactly conjugate, real ones exactly real."""
    use(True, monkeypatch)
    A = matrices("normal", 200, n)
    values, bounds = eigenvalues(A, np.zeros(len(A)))
    for found, own, a in zip(values, bounds, A, strict=True):
        assert np.all(distances(found, np.linalg.eigvals(a)) <= own + 20 * EPS * np.linalg.norm(a) * own / own.min())
        first = np.flatnonzero(found.imag > 0)
        np.testing.assert_array_equal(found[first + 1], np.conj(found[first]))
        assert np.sum(found.imag != 0) == 2 * len(first)


@pytest.mark.parametrize("in_lanes", PATHS)
@pytest.mark.parametrize("gap", [1.0, 1e-2, 1e-4, 1e-5, 1e-6, 0.0])
def test_bounds_cover_the_worst_perturbation_and_are_near_it(
    gap: float, in_lanes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Move a matrix by its stated error, 1e-9, in many directions: far eigenvalues, near ones, and a defective pair."""
    use(in_lanes, monkeypatch)
    A = np.array([[0.5, 1.0, 0.2], [gap**2, 0.5, -0.3], [0.0, 0.0, -0.7]])
    values, bounds = eigenvalues(np.broadcast_to(A, (17, 3, 3)), np.full(17, 1e-9))
    assert np.all(bounds == bounds[0])
    moved = np.zeros(3)
    for delta in np.random.default_rng(1).normal(size=(3000, 3, 3)):
        moved = np.maximum(moved, distances(values[0], np.linalg.eigvals(A + 1e-9 * delta / np.linalg.norm(delta, 2))))
    assert np.all(moved <= bounds[0])
    assert np.all(bounds[0] <= (2.0 if gap == 1.0 else 30.0) * moved)


def test_bounds_of_clusters_follow_henrici() -> None:
    """A Jordan block of three beside a simple eigenvalue: errors of ε move it by ε^(1/3), the simple one by ε."""
    A = np.diag([0.3, 0.3, 0.3, -0.5]) + np.diag([1.0, 1.0, 0.5], 1)
    values = np.array([0.3, 0.3, 0.3, -0.5], complex)
    for error in (1e-12, 1e-9):
        bounds = cluster_bounds(A, values, error)
        moved = np.zeros(4)
        for delta in np.random.default_rng(2).normal(size=(2000, 4, 4)):
            at = np.linalg.eigvals(A + error * delta / np.linalg.norm(delta, 2))
            moved = np.maximum(moved, distances(values, at))
        assert np.all(moved <= bounds) and np.all(bounds <= 30 * moved)
    assert np.all(np.isfinite(cluster_bounds(np.eye(3), np.ones(3, complex), 1e-15)))


def test_clusters_that_are_near_others_are_not_bounded_alone() -> None:
    """A simple eigenvalue 1e-6 beside a defective pair: errors of 1e-9 couple them, and it moves by much more."""
    A = np.array([[0.3, 1.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3 + 1e-6]])
    values, moved = np.array([0.3, 0.3, 0.3 + 1e-6], complex), np.zeros(3)
    bounds = cluster_bounds(A, values, 1e-9)
    for delta in np.random.default_rng(3).normal(size=(2000, 3, 3)):
        at = np.linalg.eigvals(A + 1e-9 * delta / np.linalg.norm(delta, 2))
        moved = np.maximum(moved, distances(values, at))
    assert np.all(moved <= bounds) and np.all(bounds < 1e-2)


@pytest.mark.parametrize("size", [1e-3, 1e-2, 1e-1])
def test_discs_hold_what_entries_can_do(size: float) -> None:
    """Λ + E with |E_ij| = G_ij, G of all sizes: eigenvalues in clear discs, in joined ones, and under Elsner's cap."""
    rng = np.random.default_rng(6)
    values = rng.normal(size=(200, 4)) + 1j * rng.normal(size=(200, 4))
    G = size * np.exp(rng.uniform(-8, 0, (200, 4, 4)))
    largest = np.linalg.norm(G, axis=(-2, -1))
    bounds = discs(values, G, np.full(200, np.inf), np.ones(200))
    capped = discs(values, G, largest, np.abs(values).max(axis=-1))
    assert np.all(capped <= bounds) and np.isfinite(bounds).all()
    for k in range(200):
        for phase in np.exp(2j * math.pi * rng.uniform(size=(60, 4, 4))):
            at = np.linalg.eigvals(np.diag(values[k]) + G[k] * phase)
            # an eigenvalue of the sum in every connected set of discs for each of its own
            assert np.all(distances(values[k], at) <= bounds[k])
            assert np.all(distances(values[k], at) <= capped[k])
    if size == 1e-3:  # far from each other, most are moved by their own entries
        assert np.median(bounds) < 3.0 * np.median(np.diagonal(G, axis1=-2, axis2=-1))


@compiled
@pytest.mark.parametrize("n", [3, 5, 8])
def test_cycles_need_unusual_shifts(n: int) -> None:
    """The roots of unity: QR steps with the usual shifts leave a cyclic permutation as it is, and give it up."""
    cycle = np.broadcast_to(np.roll(np.eye(n), 1, axis=0), (16, 1, n, n))
    (values, bounds, scale), clear = multipliers_of_lanes(np.ones(n), *in_blocks(cycle, np.zeros((16, 1))), 16)
    assert clear.all()  # what is given up is not
    factor = math.exp(scale[0])
    error = distances(factor * values[0], np.exp(2j * math.pi * np.arange(n) / n))
    assert np.all(error <= factor * bounds[0]) and factor * bounds.max() < 1e-13


@compiled
def test_a_matrix_alone_gives_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is beside it: more difficult matrices, and some that are not finite."""
    use(True, monkeypatch)
    A = matrices("graded", 40, 7)
    A[3, 0, 0], A[20, 2, 1], A[33] = np.nan, np.inf, 1e200
    with np.errstate(all="ignore"):
        values, bounds = eigenvalues(A, np.full(40, 1e-12))
        assert np.all(np.isnan(values[[3, 20]])) and np.all(np.isinf(bounds[[3, 20]]))
        for some in (slice(5, 6), slice(1, 40, 3), slice(19, 35)):
            alone, own = eigenvalues(A[some], np.full(len(A[some]), 1e-12))
            assert alone.tobytes() == values[some].tobytes() and own.tobytes() == bounds[some].tobytes()


# ---------------------------------------------------------------------- products
@compiled
@pytest.mark.parametrize("panels", [1, 2, 7])
@pytest.mark.parametrize("n", [2, 5, 8])
def test_products_in_lanes_are_those_of_numpy(n: int, panels: int) -> None:
    """Eigenvalues within their bounds, and bounds alike, with a twist and errors of 1e-13 a factor."""
    rng = np.random.default_rng([n, panels])
    maps = np.linalg.qr(rng.normal(size=(32, panels, n, n)))[0] + 0.1 * rng.normal(size=(32, panels, n, n))
    errors, twist = rng.uniform(0.5e-13, 1e-13, (32, panels)), np.where(np.arange(n) == 1, -1.0, 1.0)
    slow, slow_bound, slow_scale = multipliers(np.diag(twist)[None], maps, errors)
    (fast, fast_bound, fast_scale), clear = multipliers_of_lanes(twist, *in_blocks(maps, errors), 32)
    assert clear.all()
    for k in range(32):
        a, b = fast[k] * math.exp(fast_scale[k]), slow[k] * math.exp(slow_scale[k])
        bound = fast_bound[k] * math.exp(fast_scale[k])
        assert np.all(distances(a, b) <= bound)
        # conditions are found from vectors, which other LAPACKs round to some per cent of these bounds
        np.testing.assert_allclose(np.sort(bound), np.sort(slow_bound[k] * math.exp(slow_scale[k])), rtol=0.2)


@pytest.mark.parametrize("in_lanes", PATHS)
def test_bounds_of_products_cover_perturbed_factors(in_lanes: bool) -> None:
    """Move all factors by their stated errors, which differ a thousandfold, in many directions."""
    rng, e = np.random.default_rng(4), np.array([1e-9, 1e-12, 3e-10])
    maps = np.linalg.qr(rng.normal(size=(3, 4, 4)))[0] * np.array([1e3, 1e-2, 0.1])[:, None, None]
    maps = maps + 0.2 * rng.normal(size=(3, 4, 4)) * np.array([1e3, 1e-2, 0.1])[:, None, None]
    e = e * np.array([1e3, 1e-2, 0.1])
    many, errors = np.broadcast_to(maps, (16, 3, 4, 4)), np.broadcast_to(e, (16, 3))
    if in_lanes:
        (values, bounds, scale), _ = multipliers_of_lanes(np.ones(4), *in_blocks(many, errors), 16)
    else:
        values, bounds, scale = multipliers(np.eye(4)[None], many, errors)
    found, bound = values[0] * math.exp(scale[0]), bounds[0] * math.exp(scale[0])
    moved = np.zeros(4)
    for delta in rng.normal(size=(3000, 3, 4, 4)):
        F = maps + e[:, None, None] * delta / np.linalg.norm(delta, 2, axis=(-2, -1))[:, None, None]
        moved = np.maximum(moved, distances(found, np.linalg.eigvals(F[2] @ F[1] @ F[0])))
    assert np.all(moved <= bound) and np.all(bound <= 5.0 * moved)


@pytest.mark.parametrize("in_lanes", PATHS)
def test_products_beyond_the_range_of_doubles(in_lanes: bool) -> None:
    """Sixty factors of 1e±150: logarithms are right to the last digits."""
    rng = np.random.default_rng(5)
    maps = np.broadcast_to(np.linalg.qr(rng.normal(size=(5, 5)))[0], (16, 60, 5, 5)) * 1.0
    scales = 10.0 ** rng.choice([-150.0, 150.0], (16, 60))
    maps, errors = maps * scales[..., None, None], 1e-15 * scales
    if in_lanes:
        (values, bounds, scale), _ = multipliers_of_lanes(np.ones(5), *in_blocks(maps, errors), 16)
    else:
        values, bounds, scale = multipliers(np.eye(5)[None], maps, errors)
    expected = np.log10(scales).sum(axis=1) * math.log(10.0)
    np.testing.assert_allclose(np.log(np.abs(values)) + scale[:, None], np.tile(expected[:, None], 5), atol=1e-9)
    assert np.all(bounds < 1e-12)


def test_size_is_no_less_than_the_two_norm() -> None:
    A = matrices("graded", 100, 6)
    assert np.all(size_of(A) >= np.linalg.norm(A, 2, axis=(-2, -1)) * (1 - 4 * EPS))
