"""Constant-coefficient models: the tip-path plane (table 3, eqs. 6 and 7) and averages with more harmonics.

Put β = t(ψ) a into the blade's equation, with t a row of harmonics, and keep the same harmonics of the result, t⁺::

    D̃ = mean of t⁺ (2 t' + d t),    K̃ = mean of t⁺ (t'' + d t' + k t),    F̃ = mean of t⁺ f

With t = (1, -cos ψ, -sin ψ), a = (a₀, a₁, b₁) this is the tip-path plane; with M harmonics it is the averaged
multiblade model of 2M+1 blades, which is the tip-path plane only for M = 1 (N = 3 and 4).

Of dissimilar blades the mean of T⁻¹ δ T over a revolution (:mod:`floquet.models.multiblade`) is the mean of all δ_i on
the diagonal and, of an even number of blades, the mean of (-1)^i δ_i between β₀ and β_d; two blades have nothing else.

d and k are numbers, so that D̃ = 2 mean t⁺t' + mean d t⁺t and so on: the mean of a number times a matrix of
trigonometric polynomials takes only those harmonics of the number that the matrix has, and t⁺t is the same for every
rotor.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FloquetWarning, ParameterError
from ..periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from ..rotor import Hub, Rotor
from .flapping import blade
from .multiblade import blades_of, coordinates, identical, multiblade
from .physics import PhysicsKeywords, advance_ratios
from .teetering import teetering

__all__ = ["averaged", "averaged_of", "plane_of", "tip_path_plane"]

Array = NDArray[np.float64]
ONE = PeriodicMatrix.scalar(mean=1.0)


def tip_path_plane(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> PeriodicSystem:
    """The tip-path plane a = (a₀, a₁, b₁), table 3; (a₁, b₁), eq. (7), for a teetering hub.

    Arguments as in :func:`floquet.flapping`; a constant system, whose exponents are eigenvalues.
    """
    advance_ratios(advance_ratio, rotor)
    teeters = rotor.hub == Hub.TEETERING
    return plane_of((teetering if teeters else blade)(rotor, advance_ratio, **options), teeters=teeters)


def plane_of(one: PeriodicSystem, *, teeters: bool) -> PeriodicSystem:
    """The tip-path plane of the equation of a blade, or of a rotor that teeters."""
    names = ("a_1", "b_1") if teeters else ("a_0", "a_1", "b_1")
    return _projected(one, _tip_path(teeters), names, "tip path plane")


def averaged(
    rotor: Rotor | Sequence[Rotor],
    advance_ratio: ArrayLike,
    harmonics: int | None = None,
    **options: Unpack[PhysicsKeywords],
) -> PeriodicSystem:
    """The averaged multiblade model of 2·harmonics+1 identical blades (1 by default), in β₀, β₁c, β₁s, …

    Its modes are approximations of the rotor's for any number of blades, better with every harmonic.

    One Rotor a blade gives the mean over a revolution of :func:`floquet.multiblade` of these blades, β_d included.  A
    warning says that it does not know what is different about each of three blades or more: its exponents are those
    of blades that are all like the mean, or like the means of every other blade.
    """
    if isinstance(rotor, Rotor):
        return averaged_of(blade(rotor, advance_ratio, **options), 1 if harmonics is None else harmonics)
    blades = blades_of(rotor)
    own = (len(blades) - 1) // 2
    if harmonics not in (None, own):
        raise ParameterError(
            "harmonics",
            harmonics,
            f"{len(blades)} blades that are given one by one have {own} harmonics, not {harmonics!r}: leave it out, or "
            "average each blade alone with as many as you like",
        )
    if len(blades) > 2 and not identical(blades):
        warnings.warn(
            "averaging over a revolution keeps the mean of the blades"
            + (" and the difference between every other blade and the rest" if len(blades) % 2 == 0 else "")
            + "; their other differences are harmonics of 1 per rev and more and are lost, though exponents move by "
            "the order of them: average each blade alone and take the exponents of all, or use multiblade",
            FloquetWarning,
            stacklevel=2,
        )
    return replace(multiblade(blades, advance_ratio, **options).mean(), name="averaged over a revolution")


def averaged_of(one: PeriodicSystem, harmonics: int) -> PeriodicSystem:
    """The averaged multiblade model of blades with the equation ``one``."""
    if isinstance(harmonics, bool) or not isinstance(harmonics, (int, np.integer)) or not 1 <= harmonics <= 16:
        raise ParameterError(
            "harmonics",
            harmonics,
            f"{harmonics!r} is not a whole number from 1 to 16: 1 is the tip-path plane, "
            "each further one adds two modes",
        )
    count = int(harmonics)
    return _projected(one, _multiblade(count), coordinates(2 * count + 1), f"averaged over {harmonics} harmonics")


# ---------------------------------------------------------------------- projection
class _Kept(NamedTuple):
    """t⁺, t⁺t, t⁺t' and t⁺t''."""

    plus: PeriodicMatrix
    still: PeriodicMatrix
    first: PeriodicMatrix
    second: PeriodicMatrix


def _kept(rows: Sequence[PeriodicMatrix]) -> _Kept:
    """For t with these harmonics."""
    t = PeriodicMatrix.assemble([rows])
    plus = PeriodicMatrix.constant(np.diag(1.0 / (t.transpose() @ t).mean().diagonal())) @ t.transpose()
    return _Kept(plus, plus @ t, plus @ t.derivative(), plus @ t.derivative().derivative())


@cache
def _tip_path(teeters: bool) -> _Kept:
    """t = (1, -cos ψ, -sin ψ); without the 1 for a rotor that teeters."""
    cyclic = PeriodicMatrix.harmonic(1, [[-1.0, 0.0]], [[0.0, -1.0]])
    return _kept([cyclic] if teeters else [PeriodicMatrix.constant([[1.0]]), cyclic])


@cache
def _multiblade(harmonics: int) -> _Kept:
    """t = (1, cos ψ, sin ψ, cos 2ψ, …)."""
    waves = [PeriodicMatrix.harmonic(n, [[1.0, 0.0]], [[0.0, 1.0]]) for n in range(1, harmonics + 1)]
    return _kept([PeriodicMatrix.constant([[1.0]]), *waves])


def _projected(one: PeriodicSystem, t: _Kept, names: tuple[str, ...], name: str) -> PeriodicSystem:
    """Keep the harmonics of t in the blade's equation."""
    assert one.damping is not None and one.stiffness is not None and one.inputs is not None
    d, k, inputs = one.damping, one.stiffness, one.inputs
    D = _mean((ONE, 2.0 * t.first), (d, t.still))
    K = _mean((ONE, t.second), (d, t.first), (k, t.still))
    return PeriodicSystem(
        period=math.nan,
        damping=PeriodicMatrix.constant(D),
        stiffness=PeriodicMatrix.constant(K),
        inputs=lambda: PeriodicMatrix.constant((t.plus @ inputs()).mean()),
        input_names=one.input_names,
        coordinates=names,
        name=name,
    )


def _mean(*terms: tuple[PeriodicMatrix, PeriodicMatrix]) -> Array:
    """Σ mean g M for 1×1 matrices g (..., 1, 1) and matrices M (n, n) without cases, (..., n, n)."""
    n = terms[0][1].shape[0]
    cases = np.broadcast_shapes(*(g.cases for g, _ in terms))
    out = np.zeros((n, n, *cases))  # the cases side by side
    for g, M in terms:
        weights = M.coefficients[0]
        for moment, weight in zip(_moments(g, M.order), weights, strict=True):
            if np.any(moment):
                for i, j in zip(*np.nonzero(weight), strict=True):
                    out[i, j] += weight[i, j] * moment
    return np.moveaxis(out, (0, 1), (-2, -1))


def _moments(g: PeriodicMatrix, order: int) -> list[Array]:
    """Means of g, g cos ψ, g sin ψ, g cos 2ψ, … (...)."""
    if g.edges is None:
        known = [g.coefficients[..., 0, row, 0, 0] for row in range(2 * min(g.order, order) + 1)]
        return [known[0], *(0.5 * row for row in known[1:]), *([np.zeros(())] * (2 * order + 1 - len(known)))]
    return _moments_of_pieces(g, order)


def _moments_of_pieces(g: PeriodicMatrix, order: int) -> list[Array]:
    """The same for pieces with g = G₀ + 2 Re Σ G_h e^{ihψ} on each, from the parts E_h of the mean of e^{ihψ}.

    mean g e^{ijψ} = Σ G₀ E_j + Σ (G_h E_{j+h} + conj(G_h E_{h-j})) over the pieces
    """
    assert g.edges is not None
    edges = TWO_PI / g.period * np.moveaxis(g.edges, -1, 0)
    rows = np.moveaxis(g.coefficients[..., 0, 0], (-2, -1), (1, 0))  # (terms, pieces, ...)
    wave = np.exp(1j * edges)
    E, power = [np.diff(edges, axis=0) / TWO_PI], np.ones(())
    for h in range(1, g.order + order + 1):
        power = power * wave
        E.append(np.diff(power, axis=0) / (1j * h * TWO_PI))
    found = []
    for j in range(order + 1):
        total = rows[0] * E[j]
        for h in range(1, g.order + 1):
            G = 0.5 * (rows[2 * h - 1] - 1j * rows[2 * h])
            total = total + G * E[j + h] + np.conj(G * (E[h - j] if h >= j else np.conj(E[j - h])))
        mean = sum(total[1:], total[0])  # in order: a case's bits must not depend on how many there are
        found += [mean.real, mean.imag] if j else [mean.real]
    return found
