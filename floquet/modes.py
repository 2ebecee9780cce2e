"""Floquet modes of coupled systems: periodic eigenvectors, their harmonics, lifted exponents and names.

A mode is ``x(ψ) = e^{ηψ} p(ψ)``, p periodic (with a twist, over two passages).  Its exponent is known modulo
i·2π/period; the branch is that of the dominant harmonic of the coordinates, h: ``η + i h`` is the frequency an
observer counts.  In the non-rotating frame a cyclic pair (β_nc, β_ns) whirls: seen from the blade its frequency ω is
ω - n or ω + n, whichever way it turns, and the mode is called after that::

    coning        β₀ dominates                 differential   β_d dominates
    advancing     forward whirl with ω ≥ n     regressing     every other whirl (with "-n" for n ≥ 2)

**Order and signs.**  Modes come in the order of :func:`~floquet.compare` (regressing, coning, advancing, regressing-2,
advancing-2, …, differential), whatever μ is; then by growth, the larger first; of a pair the member with Im η > 0
first.  Two places can have the same share, to :data:`TIE`: in a lock at a whole number per rev p is real and turns both
ways alike.  The first name of that order counts then, then the positive frequency; so a locked mode is σ₁ + iρ,
σ₂ + iρ, as it is of a blade.  What this cannot do: in a lock two modes can share four exponents, and all four have the
same dominant coordinate.  They have one name (of four blades, coning at 1 per rev, where β₀ and β_d have equal shares),
which can be another one elsewhere in the lock, and the other is missing: :func:`~floquet.track` follows both.

The single blade needs none of this: its branch is the rotation number (:mod:`floquet.exponents`).

A mode of dissimilar blades does not whirl: it stays on one blade, β = T(ψ) q, and has parts of equal size in all
multiblade coordinates.  It is called ``blade 2`` after its place among the blades, counted from 0, and its branch is
that of the dominant harmonic of that blade.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .errors import ParameterError
from .exponents import stability
from .models.multiblade import coordinates, transformation
from .passage import passage
from .periodic import TWO_PI, PeriodicSystem

__all__ = ["Modes", "characters", "modes", "numbered", "paired"]

Complex = NDArray[np.complex128]
TIE = 1e-6  # of the largest share: as large as that; vectors are right to 1e-9
STEPS = 64  # azimuths of the eigenvectors: harmonics up to 31 a span, far above any model's


@dataclass(frozen=True, eq=False, kw_only=True)
class Modes:
    """Modes of one system: regressing, coning, advancing, regressing-2, advancing-2, …, differential.

    Of one name the less damped first, of a pair the member with Im η > 0.  Those of dissimilar blades are in the order
    of the blades, those without names in the order of :class:`~floquet.exponents.Stability`.

    Attributes
    ----------
    names : tuple of str
        One a mode; the two members of a pair share it.
    exponents : complex (modes,)
        On the branch of the dominant harmonic, the positive one of two alike.
    order : int (modes,)
        Place of each in the exponents of its :class:`~floquet.exponents.Stability`.
    exponent_errors : float (modes,)
    azimuths : float (steps,)
    vectors : complex (modes, steps, states)
        p at the azimuths, of unit length on average.
    frequencies : float (harmonics,)
        Frequencies of the harmonics of p, per radian.
    participation : float (modes, coordinates, harmonics)
        Share of a coordinate's harmonic in the mode's displacement; sums to 1 a mode.
    closure : float (modes,)
        |p after the span - p at its start|: what the integration lost.
    blades : float (modes, N) or None
        Share of each blade in the mode's displacement; None where the coordinates are not those of several blades.
    """

    names: tuple[str, ...]
    exponents: Complex
    order: NDArray[np.intp]
    exponent_errors: NDArray[np.float64]
    azimuths: NDArray[np.float64]
    vectors: Complex
    frequencies: NDArray[np.float64]
    participation: NDArray[np.float64]
    closure: NDArray[np.float64]
    blades: NDArray[np.float64] | None = None


def modes(system: PeriodicSystem) -> Modes:
    """Modes of one periodic system (no cases); small multipliers beside large ones lose digits of their vectors."""
    if system.constant or system.cases:
        raise ParameterError(
            "system",
            system.name,
            "modes() takes one periodic system: for a constant one use numpy.linalg.eig, for cases index the rotor",
        )
    T, n = system.period, system.states
    twist = np.ones(n) if system.twist is None else system.twist
    span = T if system.twist is None else 2.0 * T
    psi = np.linspace(0.0, span, STEPS + 1)
    found_maps = passage(system, psi)
    states = found_maps.at_outputs(found_maps.fundamental())
    half = STEPS if system.twist is None else STEPS // 2
    values, V = _eigenvectors(system, twist[:, None] * states[half])
    found = stability(system)
    eta = np.asarray(found.exponents)
    order = paired(eta, np.asarray(np.log(values) / T, complex), 2.0 * math.pi / T)
    p = np.einsum("kij,jm->mki", states, V[:, order]) * np.exp(-eta[:, None] * psi)[:, :, None]
    p /= np.sqrt(np.mean(np.sum(np.abs(p[:, :-1]) ** 2, axis=-1), axis=-1))[:, None, None]
    q = p[:, :-1, : system.degrees]
    c = np.fft.fft(q, axis=1) / STEPS
    share = np.abs(np.swapaxes(c, 1, 2)) ** 2
    share /= share.sum(axis=(1, 2), keepdims=True)
    frequencies = np.asarray(np.fft.fftfreq(STEPS, 1.0 / STEPS) * 2.0 * math.pi / span, float)
    dominant = [_dominant(system.coordinates, frequencies, eta[m].imag, share[m], c[m]) for m in range(n)]
    names = [name for name, _ in dominant]
    lifted = eta + 1j * np.array([frequency for _, frequency in dominant])
    motion = _of_blades(system, q, psi[:-1])
    if motion is not None and system.blades:
        for m, i in enumerate(np.argmax(_shares(motion), axis=1)):
            own = np.abs(np.fft.fft(motion[m, :, i]))[None, :] ** 2
            names[m], lifted[m] = f"blade {i}", eta[m] + 1j * _dominant((), frequencies, eta[m].imag, own, own)[1]
    called = numbered(names)
    place = np.array(sorted(range(n), key=lambda m: (*_rank(called[m]), *_within(complex(lifted[m])), m)), np.intp)
    return Modes(
        names=tuple(called[m] for m in place),
        exponents=lifted[place],
        order=place,
        exponent_errors=np.asarray(found.exponent_errors)[place],
        azimuths=psi[:-1],
        vectors=p[place, :-1],
        frequencies=frequencies,
        participation=share[place],
        closure=np.abs(p[:, -1] - p[:, 0]).max(axis=-1)[place],
        blades=None if motion is None else _shares(motion)[place],
    )


def _dominant(
    coordinates: tuple[str, ...], frequencies: NDArray[np.float64], omega: float, share: NDArray[np.float64], c: Complex
) -> tuple[str, float]:
    """Name and frequency of the harmonic (coordinates, harmonics) with the largest share; of several the first."""
    places = np.argwhere(share >= (1.0 - TIE) * share.max()).tolist()
    found = [(_name(coordinates, i, h, omega + frequencies[h], c), float(frequencies[h])) for i, h in places]
    return min(found, key=lambda one: (*_rank(one[0]), round(abs(omega + one[1]), 9), omega + one[1] < 0.0))


def _rank(name: str) -> tuple[int, int]:
    """Place of a name: by the harmonic of its cyclic coordinates, then differential, blades, and what has none."""
    kind, _, order = name.partition("-" if "-" in name else " ")
    cyclic = ("regressing", "coning", "advancing")
    if kind in cyclic:
        return int(order or 1), cyclic.index(kind)
    others = ("differential", "blade")
    return (STEPS + others.index(kind), int(order or 0)) if kind in others else (2 * STEPS, 0)


def _within(eta: complex) -> tuple[float, float, bool]:
    """Place among modes of one name: by growth, then frequency, the positive one first."""
    return -round(eta.real, 9), round(abs(eta.imag), 9), eta.imag < 0.0


def _of_blades(system: PeriodicSystem, q: Complex, psi: NDArray[np.float64]) -> Complex | None:
    """Motion of the blades (modes, steps, N) by that of the multiblade coordinates; None where they are others."""
    N = system.degrees
    if N < 2 or system.coordinates != coordinates(N):
        return None
    if system.twist is not None:  # one blade after the other does the same a passage later
        return np.ones((*q.shape[:2], N), complex)
    if not math.isclose(system.period, TWO_PI):
        return None
    return np.asarray(np.einsum("kij,mkj->mki", transformation(N)[0].sample(psi), q))


def _shares(motion: Complex) -> NDArray[np.float64]:
    """Of each blade in each mode, (modes, N)."""
    share = np.mean(np.abs(motion) ** 2, axis=1)
    return np.asarray(share / share.sum(axis=1, keepdims=True))


def _eigenvectors(system: PeriodicSystem, M: NDArray[np.float64]) -> tuple[Complex, Complex]:
    """Eigenvalues and vectors of the map over a period from ψ = 0 on.

    Of dissimilar blades blade by blade: (β, β') = (T q, T' q + T q') are not coupled, and where two blades are alike
    their modes would otherwise be any mixture.
    """
    if not system.blades:
        values, V = np.linalg.eig(M.astype(complex))
        return np.asarray(values), np.asarray(V)
    N, T = system.degrees, transformation(system.degrees)[0]
    t, slope = (matrix.sample(np.zeros(1))[0] for matrix in (T, T.derivative()))
    S = np.block([[t, np.zeros((N, N))], [slope, t]])
    own, values, V = S @ M @ np.linalg.inv(S), np.empty(2 * N, complex), np.zeros((2 * N, 2 * N), complex)
    for i in range(N):
        here, pair = [i, N + i], [2 * i, 2 * i + 1]
        values[pair], V[np.ix_(here, pair)] = np.linalg.eig(own[np.ix_(here, here)].astype(complex))
    return values, np.linalg.solve(S, V)


def characters(system: PeriodicSystem, exponents: Complex, vectors: Complex) -> tuple[str, ...]:
    """Names of the modes of a constant system from its eigenvectors (states, modes), "" for other coordinates.

    (a₀, a₁, b₁) are multiblade coordinates.
    """
    known = {"a_0": "beta_0", "a_1": "beta_1c", "b_1": "beta_1s"}
    places = tuple(known.get(name, name) for name in system.coordinates)
    q = vectors[: system.degrees].T[:, None, :]
    dominant = np.argmax(np.abs(q[:, 0]), axis=-1)
    return tuple(_name(places, int(i), 0, eta.imag, c) for i, eta, c in zip(dominant, exponents, q, strict=True))


def paired(eta: Complex, found: Complex, strip: float) -> NDArray[np.intp]:
    """Which of ``found`` belongs to which exponent, modulo i·strip (inf: as they are)."""
    from scipy.optimize import linear_sum_assignment

    d = eta[:, None] - found[None, :]
    turns = strip * np.round(d.imag / strip) if math.isfinite(strip) else 0.0
    return np.asarray(linear_sum_assignment(np.hypot(d.real, d.imag - turns))[1])


def _name(coordinates: tuple[str, ...], i: int, h: int, omega: float, c: Complex) -> str:
    """Name of a mode after its dominant coordinate i and harmonic h, of frequency omega; "" for other coordinates."""
    coordinate = coordinates[i] if i < len(coordinates) else ""
    if coordinate in ("beta_0", "beta_d"):
        return "coning" if coordinate == "beta_0" else "differential"
    if not coordinate.startswith("beta_") or coordinate[-1] not in "cs":
        return ""
    n = int(coordinate[5:-1])
    j = coordinates.index(f"beta_{n}c")
    backward = (
        abs(c[h, j] - 1j * c[h, j + 1]),
        abs(c[h, j] + 1j * c[h, j + 1]),
    )  # amplitudes of e^{+inψ} and e^{-inψ} in the blade
    whirl = 1.0 if backward[0] > backward[1] else -1.0
    forward = omega * whirl < 0 and abs(omega) >= n
    return ("advancing" if forward else "regressing") + ("" if n == 1 else f"-{n}")


def numbered(names: Sequence[str]) -> tuple[str, ...]:
    """Names, with "mode k" where there is none."""
    counts: Counter[str] = Counter()
    out = []
    for name in names:
        counts[name] += 1
        out.append(name or f"mode {(counts[name] + 1) // 2}")
    return tuple(out)
