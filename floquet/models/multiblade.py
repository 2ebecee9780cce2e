"""Multiblade coordinates for any number of blades, eqs. (3), (4) and (B1)–(B6) of NASA TP-1431.

``β_i = β₀ + Σ_n (β_nc cos nψ_i + β_ns sin nψ_i) [+ (-1)^i β_d for even N]``, ψ_i = ψ + 2π(i-1)/N, is β = T(ψ) q, and
the blades' equations become ``q'' + D q' + K q = F u`` with::

    D = T⁻¹ (2 T' + A T),    K = T⁻¹ (T'' + A T' + B T),    F = T⁻¹ f

(the scan prints Ȧ in K; it is A).  For identical blades A(ψ + 2π/N) = S A(ψ) S, with S changing the sign of β_d: the
motion is mapped over one passage 2π/N, and its exponents hold modulo N·i with no two modes aliased.  They are those of
one blade shifted by the whole numbers 0 … N-1, and that is how :func:`floquet.stability` finds them.

Dissimilar blades need no other transformation, each has its own A and B on the diagonals.  What differs by δ_i from
blade to blade is in row n and column m of T⁻¹ δ T::

    (w_n/N) Σ_i δ_i c_n(ψ_i) c_m(ψ_i),   c_n = 1, cos nψ_i, sin nψ_i or (-1)^i,   w_n = 1 for β₀ and β_d, else 2

so that one blade alone makes harmonics of 1 to n+m per rev between the coordinates, in hover too: the period is 2π,
there is no passage to map over, and the exponents are those of all blades, each modulo i.  Modes of equal blades are
whole numbers apart, in resonance with these harmonics: exponents move by the order of δ, which averaging loses (see
:func:`floquet.averaged`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError
from ..periodic import TWO_PI, Equation, PeriodicMatrix, PeriodicSystem, fractions
from ..rotor import PARAMETERS, Hub, Rotor, require_rotor
from .flapping import flapping
from .physics import PhysicsKeywords

__all__ = ["blades_of", "coordinates", "identical", "multiblade", "transformation"]

Array = NDArray[np.float64]


def multiblade(
    rotor: Rotor | Sequence[Rotor], advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]
) -> PeriodicSystem:
    """Flapping of all blades in the non-rotating frame.

    Parameters
    ----------
    rotor : Rotor or sequence of Rotor
        A rotor of ``rotor.blades`` identical blades, or one Rotor a blade in the order of ψ_i, whose parameters
        broadcast.  Blades that differ in any of them have the period 2π instead of 2π/N.
    advance_ratio, **options
        As in :func:`floquet.flapping`.

    Returns
    -------
    PeriodicSystem
        Coordinates β₀, β₁c, β₁s, …, and β_d for even N; the inputs of the blade, which act on all blades.  Exponents
        are modulo N·i of identical blades, modulo i of dissimilar ones.
    """
    blades = blades_of(rotor)
    N, similar = len(blades), identical(blades)
    azimuths = [TWO_PI * i / N for i in range(N)]
    models = [flapping(b, advance_ratio, **options) for b in (blades[:1] if similar else blades)] * (
        N if similar else 1
    )

    def build(values: Mapping[str, NDArray[Any]]) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        equations = [_of_blade(m, values, i) for i, m in enumerate(models[:1] if similar else models)]
        a, b = equations[0]
        if similar and a.edges is None and b.edges is None:
            return _of_identical_blades(N, a, b)
        shifted = zip(equations * (N if similar else 1), azimuths, strict=True)
        d, k = zip(*((d.shifted(a), k.shifted(a)) for (d, k), a in shifted), strict=True)
        return transformed(_diagonal(d), _diagonal(k))

    def forcing() -> PeriodicMatrix:
        rows = [f.shifted(a) for b, a in zip(models, azimuths, strict=True) if (f := b.forcing) is not None]
        return transformation(N)[1] @ PeriodicMatrix.assemble([[row] for row in rows])

    twist = np.ones(2 * N)
    if N % 2 == 0:
        twist[[N - 1, 2 * N - 1]] = -1.0
    return PeriodicSystem(
        period=TWO_PI / N if similar else TWO_PI,
        twist=twist if similar else None,
        equation=Equation(build=build, parameters=_parameters(models[:1] if similar else models), degrees=N),
        blade=models[0] if similar else None,
        blades=() if similar else tuple(models),
        inputs=forcing,
        input_names=models[0].input_names,
        coordinates=coordinates(N),
        name="multiblade",
    )


def blades_of(rotor: object) -> list[Rotor]:
    """One Rotor a blade, of a rotor or as they were given."""
    if isinstance(rotor, (Rotor, str, bytes)) or not isinstance(rotor, Iterable):
        blades = [require_rotor(rotor)] * require_rotor(rotor).blades
    else:
        blades = [require_rotor(b) for b in rotor]
    N = len(blades)
    if N < 2:
        raise ParameterError(
            "blades", N, f"multiblade coordinates need at least 2 blades, not {N}: use flapping for a single blade"
        )
    for b in blades:
        if b.blades not in (N, Rotor.blades):
            raise ParameterError(
                "blades",
                b.blades,
                f"{N} blades were given, and one of them is of a rotor of {b.blades}: give one Rotor for every blade, "
                f"each with blades={N} or without",
            )
        if b.hub == Hub.TEETERING:
            raise ParameterError(
                "hub",
                Hub.TEETERING,
                "the blades of a teetering rotor are one beam and do not flap each alone: use teetering",
            )
    try:
        np.broadcast_shapes(*(b.shape for b in blades))
    except ValueError:
        shapes = ", ".join(str(b.shape) for b in blades)
        raise ParameterError(
            "rotor",
            shapes,
            f"the blades' parameters have the shapes {shapes}, which do not broadcast: every blade has the same cases, "
            "so give arrays of one shape, or a number where all cases share a value",
        ) from None
    return blades


def identical(blades: Sequence[Rotor]) -> bool:
    """Whether all blades have the same parameters."""
    return all(_same(b, blades[0]) for b in blades)


def _parameters(models: Sequence[PeriodicSystem]) -> dict[str, NDArray[Any]]:
    """The parameters of all blades, blade i's with its number in their name."""
    return {
        f"{name} {i}": value
        for i, model in enumerate(models)
        if model.equation is not None
        for name, value in model.equation.parameters.items()
    }


def _of_blade(
    model: PeriodicSystem, values: Mapping[str, NDArray[Any]], i: int
) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    """d and k of blade i for :func:`_parameters` of it."""
    assert model.equation is not None
    return model.equation.build({name: values[f"{name} {i}"] for name in model.equation.parameters})


def coordinates(N: int) -> tuple[str, ...]:
    """Names of the multiblade coordinates of N blades."""
    cyclic = tuple(f"beta_{n}{x}" for n in range(1, (N - 1) // 2 + 1) for x in "cs")
    return ("beta_0", *cyclic, *(("beta_d",) if N % 2 == 0 else ()))


def transformation(N: int) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    """T (B2) and T⁻¹ (B3) of N blades, each N×N."""
    angle = TWO_PI * np.arange(N) / N
    constant, weight = np.zeros((N, N)), np.ones(N)
    constant[:, 0] = 1.0
    if N % 2 == 0:
        constant[:, -1] = (-1.0) ** np.arange(1, N + 1)
    T = PeriodicMatrix.constant(constant)
    for n in range(1, (N - 1) // 2 + 1):
        cosine, sine = np.zeros((N, N)), np.zeros((N, N))
        cosine[:, 2 * n - 1], sine[:, 2 * n - 1] = np.cos(n * angle), -np.sin(n * angle)
        cosine[:, 2 * n], sine[:, 2 * n] = np.sin(n * angle), np.cos(n * angle)
        T = T + PeriodicMatrix.harmonic(n, cosine, sine)
        weight[[2 * n - 1, 2 * n]] = 2.0
    return T, PeriodicMatrix.constant(np.diag(weight / N)) @ T.transpose()


def transformed(A: PeriodicMatrix, B: PeriodicMatrix) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    """D and K of blades with damping A and stiffness B, diagonal matrices: eq. (B5)."""
    T, Ti = transformation(A.shape[0])
    D = Ti @ (2 * T.derivative() + A @ T)
    K = Ti @ (T.derivative().derivative() + A @ T.derivative() + B @ T)
    return D, K


def _of_identical_blades(N: int, a: PeriodicMatrix, b: PeriodicMatrix) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    """D and K from the coefficients of one blade, in which they are linear."""
    coefficients = [np.ones(()), *(c.coefficients[..., 0, r, 0, 0] for c in (a, b) for r in range(2 * c.order + 1))]
    D, K = (_superposed(coefficients, shares) for shares in _shares(N, a.order, b.order))
    return PeriodicMatrix(D, TWO_PI / _repeats(N)), PeriodicMatrix(K, TWO_PI / _repeats(N))


def _repeats(N: int) -> int:
    """How often D and K of identical blades repeat in a revolution: every passage, those of β_d every second one."""
    return N if N % 2 else N // 2


@cache
def _shares(N: int, damping_order: int, stiffness_order: int) -> tuple[Array, Array]:
    """What 1 and each coefficient of a blade add to the coefficients of D and K, (1 + coefficients, 2H+1, N, N).

    They are halves of whole numbers, and there is no harmonic that does not repeat with the blades.
    """
    counts = [2 * damping_order + 1, 2 * stiffness_order + 1]
    units = np.split(np.eye(1 + sum(counts), k=-1)[:, : sum(counts), None, None], counts[:1], axis=1)
    azimuths = [TWO_PI * i / N for i in range(N)]
    A, B = (_diagonal([PeriodicMatrix(unit[:, None]).shifted(x) for x in azimuths]) for unit in units)
    out = []
    for part in transformed(A, B):
        c = np.round(2.0 * part.coefficients[:, 0]) / 2.0
        c[1:] -= c[0]
        h = range(_repeats(N), part.order + 1, _repeats(N))
        out.append(c[:, [0, *(row for k in h for row in (2 * k - 1, 2 * k))]])
    return out[0], out[1]


def _superposed(coefficients: Sequence[NDArray[Any]], shares: Array) -> NDArray[Any]:
    """Σ coefficients · shares, (cases, 1, 2H+1, N, N) with the cases side by side in memory."""
    cases, dtype = np.broadcast_shapes(*(c.shape for c in coefficients)), np.result_type(*coefficients)
    out = np.zeros((*shares.shape[1:], *cases), dtype)
    for share, c in zip(shares, coefficients, strict=True):  # in order: a case's bits do not depend on its neighbours
        entries = np.nonzero(share)
        weights = fractions(share[entries]) if dtype.kind == "O" else share[entries]
        out[entries] += weights.reshape(-1, *[1] * len(cases)) * c
    return np.moveaxis(out, (0, 1, 2), (-3, -2, -1))[..., None, :, :, :]


def _same(a: Rotor, b: Rotor) -> bool:
    """Whether two blades have the same parameters."""
    return a is b or all(np.array_equal(getattr(a, p.name), getattr(b, p.name)) for p in PARAMETERS)


def _diagonal(entries: Sequence[PeriodicMatrix]) -> PeriodicMatrix:
    return PeriodicMatrix.assemble(
        [[entry if i == j else None for j in range(len(entries))] for i, entry in enumerate(entries)]
    )
