"""The panel maps: identities of the rule, observed order, exact cases."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.linalg

from floquet.collocation import (
    first_order_nodes,
    first_order_panel,
    gauss_rule,
    second_order_nodes,
    second_order_panel,
)
from floquet.models import flapping
from floquet.passage import passage, through_nodes
from floquet.rotor import Rotor


@pytest.mark.parametrize("p", [2, 3, 6, 12, 16])
def test_rule_integrates_polynomials(p: int) -> None:
    rule, x = gauss_rule(p), gauss_rule(p).nodes
    for k in range(p):
        np.testing.assert_allclose(rule.once @ x**k, (x ** (k + 1) - (-1.0) ** (k + 1)) / (k + 1), atol=1e-14)
        twice = (x ** (k + 2) - (-1.0) ** (k + 2)) / ((k + 1) * (k + 2)) - (-1.0) ** (k + 1) * (x + 1) / (k + 1)
        np.testing.assert_allclose(rule.twice @ x**k, twice, atol=1e-14)
    for k in range(2 * p):
        assert rule.weights @ x**k == pytest.approx((1 - (-1.0) ** (k + 1)) / (k + 1), abs=1e-14)


def airy_like(h: float, p: int) -> np.ndarray:
    """y'' + 0.3 y' + (1 + ψ) y = 0 over [0, 2h]."""
    rule = gauss_rule(p)
    psi = h * (1 + rule.nodes)
    return second_order_panel(np.full((1, p, 1, 1), 0.3), (1.0 + psi)[None, :, None, None], np.array([h]), rule)[0]


@pytest.mark.parametrize("p", [2, 3, 4])
def test_order_is_twice_the_nodes(p: int) -> None:
    """One panel: the local error falls like h^(2p+1); halving h must show at least that minus a quarter."""
    truth = {h: airy_like(h, 14) for h in (0.4, 0.2, 0.1)}
    errors = [np.abs(airy_like(h, p) - truth[h]).max() for h in (0.4, 0.2, 0.1)]
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates[-1] > 2 * p + 1 - 0.25, rates


def test_constant_matrices_give_the_exponential() -> None:
    rng = np.random.default_rng(4)
    A, p, h = rng.normal(size=(5, 5)), 16, 0.25
    F = first_order_panel(np.broadcast_to(A, (1, p, 5, 5)), np.array([h]), gauss_rule(p))[0]
    np.testing.assert_allclose(F, scipy.linalg.expm(2 * h * A), atol=1e-13)


def test_second_order_is_first_order_of_the_state() -> None:
    rng = np.random.default_rng(5)
    n, p, h = 3, 14, 0.3
    psi = h * (1 + gauss_rule(p).nodes)
    D = rng.normal(size=(n, n)) + np.cos(psi)[:, None, None] * rng.normal(size=(n, n))
    K = rng.normal(size=(n, n)) + np.sin(psi)[:, None, None] * rng.normal(size=(n, n))
    A = np.zeros((p, 2 * n, 2 * n))
    A[:, :n, n:], A[:, n:, :n], A[:, n:, n:] = np.eye(n), -K, -D
    args = np.array([h]), gauss_rule(p)
    np.testing.assert_allclose(
        second_order_panel(D[None], K[None], *args), first_order_panel(A[None], *args), atol=1e-12
    )


def test_nodes_and_end() -> None:
    """Of constant matrices the exponential at every node; the end is the panel's."""
    rng = np.random.default_rng(6)
    n, p, h, rule = 2, 16, 0.25, gauss_rule(16)
    D, K, A = rng.normal(size=(n, n)), rng.normal(size=(n, n)), np.zeros((2 * n, 2 * n))
    A[:n, n:], A[n:, :n], A[n:, n:] = np.eye(n), -K, -D
    samples = [np.broadcast_to(m, (1, p, *m.shape)) for m in (D, K, A)]
    second = second_order_nodes(*samples[:2], np.array([h]), rule)[0]
    first = first_order_nodes(samples[2], np.array([h]), rule)[0]
    for k, x in enumerate([*rule.nodes, 1.0]):
        expected = scipy.linalg.expm(h * (1.0 + x) * A)
        np.testing.assert_allclose(second[k], expected, atol=1e-13)
        np.testing.assert_allclose(first[k], expected, atol=1e-13)
    np.testing.assert_array_equal(second[-1], second_order_panel(*samples[:2], np.array([h]), rule)[0])


@pytest.mark.parametrize("reversed_flow", [False, True])
def test_nodes_of_a_period(reversed_flow: bool) -> None:
    """Φ at the nodes is that of a passage to them, and the weights integrate: ∫ sin² = π."""
    system = flapping(Rotor(lock_number=9.0, hinge_offset=0.05), 0.8, reversed_flow=reversed_flow)
    nodes = through_nodes(system, 2.0 * math.pi)
    assert np.sum(nodes.weights * np.sin(nodes.azimuths) ** 2) == pytest.approx(math.pi, rel=1e-14)
    k, before = len(nodes.transitions) // 2, np.eye(2)
    for F in nodes.transitions[:k]:
        before = F @ before
    for j in (0, 7, 15):
        direct = passage(system, np.array([0.0, nodes.azimuths[k, j]])).fundamental()[-1]
        np.testing.assert_allclose(nodes.within[k, j] @ before, direct, atol=1e-13)


def test_a_panel_without_length_is_the_identity() -> None:
    rule = gauss_rule(12)
    F = second_order_panel(None, np.full((1, 12, 1, 1), 3.0), np.zeros(1), rule)
    assert np.array_equal(F[0], np.eye(2)) and math.isfinite(F.sum())
