"""The flapping equation's coefficients, tables and hover formulas, each transcribed term by term.

One blade (eq. 1 of NASA TP-1431, tables re-derived because the published scan has lost them)::

    β'' + (c0 + cs1 sin ψ) β' + (k0 + kc1 cos ψ + ks1 sin ψ + kc2 cos 2ψ + ks2 sin 2ψ) β = f(ψ)
    f = f0 + Σ (fcn cos nψ + fsn sin nψ), n ≤ 3, each coefficient a row (10,) times
    u = (θ₀, A₁c, B₁c, θ_t, λ, p_w/Ω, q_w/Ω, ṗ_w/Ω², q̇_w/Ω², ((ẇ−uq+pv)−g)/(Ω²R))

The homogeneous coefficients use integers and the four operations only, so that they are as exact as the numbers they
are given: floats, NumPy arrays, fractions or multiple-precision numbers. Symbols: eps ε = e/R, kappa κ = K_β/(I_βΩ²),
K1 = tan δ₃, m = eM_β/I_β (default 1.5 ε), s = RM_β/I_β.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Number: TypeAlias = Any
"""float, NDArray, Fraction or mpf."""
Coefficients: TypeAlias = dict[str, Number]
"""c0, cs1, k0, kc1, ks1, kc2, ks2."""
Forcing: TypeAlias = dict[str, NDArray[np.float64]]
"""f0, fc1, fs1, fc2, fs2, fc3, fs3, each of shape (10,)."""
Matrix: TypeAlias = NDArray[np.float64]

HARMONICS = ("f0", "fc1", "fs1", "fc2", "fs2", "fc3", "fs3")


# ---------------------------------------------------------------------------------------------- one blade
def truncated(
    gamma: Number, eps: Number = 0, kappa: Number = 0, K1: Number = 0, mu: Number = 0, m: Number = None
) -> Coefficients:
    """Truncated at ε² as in the report, Q = (1 − ε)²/2::

    c0  = (γ/2)(1/4 − 2ε/3 + ε²/2)      cs1 = (γ/2) μ (1/3 − ε + ε²)
    k0  = P² + γK₁μ²Q/4,                P² = 1 + κ + m + (γK₁/8)(1 − 4ε/3)
    kc1 = (γ/2) μ (1/3 − ε/2)           ks1 = (γK₁/2) μ (2/3 − ε)
    kc2 = −γK₁μ²Q/4                     ks2 = γμ²Q/4
    """
    m = 3 * eps / 2 if m is None else m
    P2 = 1 + kappa + m + gamma * K1 / 8 * (3 - 4 * eps) / 3
    twice_Q = (1 - eps) ** 2
    return {
        "P2": P2,
        "c0": gamma / 2 * (3 - 8 * eps + 6 * eps**2) / 12,
        "cs1": gamma / 2 * mu * (1 - 3 * eps + 3 * eps**2) / 3,
        "k0": P2 + gamma * K1 * mu**2 * twice_Q / 8,
        "kc1": gamma / 2 * mu * (2 - 3 * eps) / 6,
        "ks1": gamma * K1 / 2 * mu * (2 - 3 * eps) / 3,
        "kc2": -gamma * K1 * mu**2 * twice_Q / 8,
        "ks2": gamma * mu**2 * twice_Q / 8,
    }


def exact(
    gamma: Number, eps: Number = 0, kappa: Number = 0, K1: Number = 0, mu: Number = 0, m: Number = None
) -> Coefficients:
    """Not truncated in ε::

        c0  = (γ/2)(1−ε)³(3+ε)/12           cs1 = (γ/2)μ(1−ε)³/3
        P²  = 1 + κ + m + (γK₁/2)(1−ε)²(3+2ε+ε²)/12
        kc1 = (γ/2)μ(1−ε)²(2+ε)/6           ks1 = (γK₁/2)μ(1−ε)²(2+ε)/3

    k0 − P², kc2 and ks2 as in ``truncated``, where they are exact.
    """
    m = 3 * eps / 2 if m is None else m
    P2 = 1 + kappa + m + gamma * K1 / 2 * (1 - eps) ** 2 * (3 + 2 * eps + eps**2) / 12
    twice_Q = (1 - eps) ** 2
    return {
        "P2": P2,
        "c0": gamma / 2 * (1 - eps) ** 3 * (3 + eps) / 12,
        "cs1": gamma / 2 * mu * (1 - eps) ** 3 / 3,
        "k0": P2 + gamma * K1 * mu**2 * twice_Q / 8,
        "kc1": gamma / 2 * mu * (1 - eps) ** 2 * (2 + eps) / 6,
        "ks1": gamma * K1 / 2 * mu * (1 - eps) ** 2 * (2 + eps) / 3,
        "kc2": -gamma * K1 * mu**2 * twice_Q / 8,
        "ks2": gamma * mu**2 * twice_Q / 8,
    }


def forcing(
    gamma: float,
    eps: float = 0.0,
    mu: float = 0.0,
    m: float | None = None,
    s: float = 1.5,
    *,
    exact_offset: bool = False,
    kinematic_rates: bool = False,
) -> Forcing:
    """The harmonics of f, each (10,): J1, J2, J3 = 1/3 − ε/2, 1/4 − ε/3, 1/5 − ε/4 truncated, or exact integrals."""
    m = 1.5 * eps if m is None else m
    Q = (1 - eps) ** 2 / 2
    J1, J2, J3 = 1 / 3 - eps / 2, 1 / 4 - eps / 3, 1 / 5 - eps / 4
    if exact_offset:
        J1 = (1 - eps) ** 2 * (2 + eps) / 6
        J2 = (1 - eps) ** 2 * (3 + 2 * eps + eps**2) / 12
        J3 = 1 / 5 - eps / 4 + eps**5 / 20
    a = 1 + m if kinematic_rates else 1.0
    g = gamma / 2
    columns: dict[int, dict[str, float]] = {
        0: {"f0": g * (J2 + mu**2 * Q / 2), "fs1": gamma * mu * J1, "fc2": -gamma * mu**2 * Q / 4},
        1: {"fc1": -g * (J2 + mu**2 * Q / 4), "fs2": -g * mu * J1, "fc3": gamma * mu**2 * Q / 8},
        2: {
            "f0": -g * mu * J1,
            "fs1": -g * (J2 + 3 * mu**2 * Q / 4),
            "fc2": g * mu * J1,
            "fs3": gamma * mu**2 * Q / 8,
        },
        3: {"f0": g * (J3 + mu**2 * J1 / 2), "fs1": gamma * mu * J2, "fc2": -gamma * mu**2 * J1 / 4},
        4: {"f0": g * J1, "fs1": g * mu * Q},
        5: {"f0": gamma * mu * J1 / 4, "fc1": 2 * (1 + m), "fs1": g * J2, "fc2": -gamma * mu * J1 / 4},
        6: {"fc1": g * J2, "fs1": -2 * (1 + m), "fs2": gamma * mu * J1 / 4},
        7: {"fs1": a},
        8: {"fc1": a},
        9: {"f0": s},
    }
    f = {name: np.zeros(10) for name in HARMONICS}
    for column, harmonics in columns.items():
        for name, value in harmonics.items():
            f[name][column] = value
    return f


def blade_damping(c: Coefficients, psi: float) -> float:
    """c0 + cs1 sin ψ."""
    return float(c["c0"] + c["cs1"] * np.sin(psi))


def blade_stiffness(c: Coefficients, psi: float) -> float:
    """k0 + kc1 cos ψ + ks1 sin ψ + kc2 cos 2ψ + ks2 sin 2ψ."""
    first = c["kc1"] * np.cos(psi) + c["ks1"] * np.sin(psi)
    return float(c["k0"] + first + c["kc2"] * np.cos(2 * psi) + c["ks2"] * np.sin(2 * psi))


def blade_forcing(f: Forcing, psi: float) -> NDArray[np.float64]:
    """f0 + Σ (fcn cos nψ + fsn sin nψ), (10,)."""
    return f["f0"] + sum(f[f"fc{n}"] * np.cos(n * psi) + f[f"fs{n}"] * np.sin(n * psi) for n in (1, 2, 3))


def reversed_flow(gamma: Number, eps: Number, K1: Number, mu: Number, sine: Number, region: int) -> tuple[Number, ...]:
    """(damping, spring / cos ψ, K₁ spring) with reversed flow and tip loss factor 1, exact in ε, at u = μ sin ψ.

    region 0 is u ≥ −ε (no reversed flow outboard of the hinge), 1 is −1 < u < −ε, 2 is u ≤ −1 (all reversed)::

        0: f        1: f_d + (u+ε)⁴/6, f_s − (u+ε)³/3, f_K − (u+ε)⁴/6        2: −f

    times γ/2, γμ/2 and γK₁/2, with f_d = (1−ε)³(3+ε)/12 + u(1−ε)³/3, f_s = (1−ε)²(2+ε)/6 + u(1−ε)²/2 and f_K =
    (1−ε)²(3+2ε+ε²)/12 + u(1−ε)²(2+ε)/3 + u²(1−ε)²/2. ``sine`` may be anything that adds and multiplies.
    """
    u = mu * sine
    fd = u * ((1 - eps) ** 3 / 3) + (1 - eps) ** 3 * (3 + eps) / 12
    fs = u * ((1 - eps) ** 2 / 2) + (1 - eps) ** 2 * (2 + eps) / 6
    fK = u * u * ((1 - eps) ** 2 / 2) + u * ((1 - eps) ** 2 * (2 + eps) / 3)
    fK = fK + (1 - eps) ** 2 * (3 + 2 * eps + eps**2) / 12
    if region == 1:
        v = u + eps
        fd, fs, fK = fd + v * v * v * v / 6, fs - v * v * v / 3, fK - v * v * v * v / 6
    sign = -1 if region == 2 else 1
    return fd * (sign * gamma / 2), fs * (sign * gamma * mu / 2), fK * (sign * gamma * K1 / 2)


def reversed_flow_region(eps: float, mu: float, psi: float) -> int:
    """0, 1 or 2: no part, the inner part, all of the blade outboard of the hinge meets the air backwards."""
    u = mu * np.sin(psi)
    return 0 if u >= -eps else 1 if u > -1 else 2


# ---------------------------------------------------------------------------------------------- teetering
def teetering(gamma: Number, kappa: Number = 0, K1: Number = 0, mu: Number = 0) -> Coefficients:
    """Eq. (2), two blades on one hinge; nothing is truncated.

    c0 = γ/8, k0 = P² + γK₁μ²/8, kc2 = −γK₁μ²/8, ks2 = γμ²/8, P² = 1 + κ + γK₁/8.
    """
    P2 = 1 + kappa + gamma * K1 / 8
    zero = 0 * gamma
    c: Coefficients = {"P2": P2, "c0": gamma / 8, "cs1": zero, "kc1": zero, "ks1": zero}
    return c | {"k0": P2 + gamma * K1 * mu**2 / 8, "kc2": -gamma * K1 * mu**2 / 8, "ks2": gamma * mu**2 / 8}


def teetering_forcing(gamma: float, mu: float = 0.0) -> Forcing:
    """The right-hand side of eq. (2): odd harmonics only."""
    f = {name: np.zeros(10) for name in HARMONICS}
    f["fs1"][[5, 6, 7, 0]] = gamma / 8, -2, 1, gamma * mu / 3
    f["fc1"][[6, 5, 8]] = gamma / 8, 2, 1
    f["fc1"][1], f["fc3"][1] = -gamma / 8 * (1 + mu**2 / 2), gamma / 8 * mu**2 / 2
    f["fs1"][2], f["fs3"][2] = -gamma / 8 * (1 + 3 / 2 * mu**2), gamma / 8 * mu**2 / 2
    f["fs1"][[3, 4]] = gamma * mu / 4
    return f


def teetering_tip_path_plane(gamma: float, kappa: float, K1: float, mu: float) -> tuple[Matrix, Matrix, Matrix]:
    """Eq. (7) as printed: D (2, 2), K (2, 2) and the forcing (2, 10) of (a₁, b₁)."""
    P2 = 1 + kappa + gamma * K1 / 8
    D = np.array([[gamma / 8, 2], [-2, gamma / 8]])
    K = np.array(
        [
            [P2 - 1 + gamma * K1 * mu**2 / 16, gamma / 8 * (1 + mu**2 / 2)],
            [-gamma / 8 * (1 - mu**2 / 2), P2 - 1 + 3 / 16 * gamma * K1 * mu**2],
        ]
    )
    F = np.zeros((2, 10))
    F[0, 1] = gamma / 8 * (1 + mu**2 / 2)
    F[1, [0, 3, 2, 4]] = -gamma * mu / 3, -gamma * mu / 4, gamma / 8 * (1 + 3 / 2 * mu**2), -gamma * mu / 4
    F[:, 5:9] = [[-2, -gamma / 8, 0, -1], [-gamma / 8, 2, -1, 0]]
    return D, K, F


def precone_forcing(gamma: float, K1: float, mu: float) -> NDArray[np.float64]:
    """What a built-in coning angle a₀ adds to the right-hand side of eq. (7): (γμ/6, γK₁μ/3), missing in the report."""
    return np.array([gamma * mu / 6, gamma * K1 * mu / 3])


# ---------------------------------------------------------------------------------------------- multiblade tables
def table_1(c: Coefficients, f: Forcing, psi: float) -> tuple[Matrix, Matrix, Matrix]:
    """Three blades, (β₀, β₁c, β₁s): D (3, 3), K (3, 3), f (3, 10) at azimuth psi."""
    c0, cs1, k0, kc1, ks1, kc2, ks2 = (c[name] for name in ("c0", "cs1", "k0", "kc1", "ks1", "kc2", "ks2"))
    S, C = np.sin(3 * psi), np.cos(3 * psi)
    D = np.array(
        [
            [c0, 0, cs1 / 2],
            [0, c0 + cs1 * S / 2, 2 - cs1 * C / 2],
            [cs1, -2 - cs1 * C / 2, c0 - cs1 * S / 2],
        ]
    )
    K11, K12, K13 = k0, (kc1 - cs1) / 2 + (kc2 * C + ks2 * S) / 2, ks1 / 2 + (kc2 * S - ks2 * C) / 2
    K21 = kc1 + kc2 * C + ks2 * S
    K22 = k0 - 1 + kc2 / 2 + (cs1 + kc1) * C / 2 + ks1 * S / 2
    K23 = c0 + ks2 / 2 + (cs1 + kc1) * S / 2 - ks1 * C / 2
    K31 = ks1 + kc2 * S - ks2 * C
    K32 = -c0 + ks2 / 2 + (cs1 + kc1) * S / 2 - ks1 * C / 2
    K33 = k0 - 1 - kc2 / 2 - (cs1 + kc1) * C / 2 - ks1 * S / 2
    K = np.array([[K11, K12, K13], [K21, K22, K23], [K31, K32, K33]])
    F = np.array(
        [
            f["f0"] + f["fc3"] * C + f["fs3"] * S,
            f["fc1"] + f["fc2"] * C + f["fs2"] * S,
            f["fs1"] + f["fc2"] * S - f["fs2"] * C,
        ]
    )
    return D, K, F


def table_2(c: Coefficients, f: Forcing, psi: float) -> tuple[Matrix, Matrix, Matrix]:
    """Four blades, (β₀, β₁c, β₁s, β_d): D (4, 4), K (4, 4), f (4, 10) at azimuth psi."""
    c0, cs1, k0, kc1, ks1, kc2, ks2 = (c[name] for name in ("c0", "cs1", "k0", "kc1", "ks1", "kc2", "ks2"))
    C2, S2, C4, S4 = np.cos(2 * psi), np.sin(2 * psi), np.cos(4 * psi), np.sin(4 * psi)
    D = np.array(
        [
            [c0, 0, cs1 / 2, 0],
            [0, c0, 2, -cs1 * S2],
            [cs1, -2, c0, cs1 * C2],
            [0, -cs1 * S2 / 2, cs1 * C2 / 2, c0],
        ]
    )
    K = np.array(
        [
            [k0, (kc1 - cs1) / 2, ks1 / 2, -kc2 * C2 - ks2 * S2],
            [
                kc1,
                k0 - 1 + kc2 / 2 + (kc2 * C4 + ks2 * S4) / 2,
                c0 + ks2 / 2 + (kc2 * S4 - ks2 * C4) / 2,
                -kc1 * C2 - ks1 * S2,
            ],
            [
                ks1,
                -c0 + ks2 / 2 + (kc2 * S4 - ks2 * C4) / 2,
                k0 - 1 - kc2 / 2 - (kc2 * C4 + ks2 * S4) / 2,
                -kc1 * S2 + ks1 * C2,
            ],
            [
                -kc2 * C2 - ks2 * S2,
                -(cs1 + kc1) * C2 / 2 - ks1 * S2 / 2,
                -(cs1 + kc1) * S2 / 2 + ks1 * C2 / 2,
                k0,
            ],
        ]
    )
    F = np.array(
        [
            f["f0"],
            f["fc1"] + f["fc3"] * C4 + f["fs3"] * S4,
            f["fs1"] + f["fc3"] * S4 - f["fs3"] * C4,
            -f["fc2"] * C2 - f["fs2"] * S2,
        ]
    )
    return D, K, F


# ---------------------------------------------------------------------------------------------- tip-path plane
def table_3(c: Coefficients) -> tuple[Matrix, Matrix]:
    """The tip-path plane (eq. 6), (a₀, a₁, b₁): D (3, 3), K (3, 3)."""
    c0, cs1, k0, kc1, ks1, kc2, ks2 = (c[name] for name in ("c0", "cs1", "k0", "kc1", "ks1", "kc2", "ks2"))
    D = np.array([[c0, 0, -cs1 / 2], [0, c0, 2], [-cs1, -2, c0]])
    K = np.array(
        [
            [k0, (cs1 - kc1) / 2, -ks1 / 2],
            [-kc1, k0 - 1 + kc2 / 2, c0 + ks2 / 2],
            [-ks1, -c0 + ks2 / 2, k0 - 1 - kc2 / 2],
        ]
    )
    return D, K


def table_3_forcing(
    gamma: float,
    eps: float = 0.0,
    mu: float = 0.0,
    m: float | None = None,
    s: float = 1.5,
    *,
    kinematic_rates: bool = False,
) -> Matrix:
    """The right-hand side of table 3, (3, 10), rows (a₀, a₁, b₁), truncated at ε²."""
    m = 1.5 * eps if m is None else m
    Q = (1 - eps) ** 2 / 2
    a = 1 + m if kinematic_rates else 1.0
    columns = [
        (gamma / 2 * (1 / 4 - eps / 3 + mu**2 * Q / 2), 0, -(gamma * mu / 2) * (2 / 3 - eps)),
        (0, gamma / 2 * (1 / 4 - eps / 3 + mu**2 * Q / 4), 0),
        (-(gamma * mu / 2) * (1 / 3 - eps / 2), 0, gamma / 2 * (1 / 4 - eps / 3 + 3 * mu**2 * Q / 4)),
        (
            gamma / 2 * (1 / 5 - eps / 4 + (mu**2 / 2) * (1 / 3 - eps / 2)),
            0,
            -(gamma * mu / 2) * (1 / 2 - 2 * eps / 3),
        ),
        (gamma / 2 * (1 / 3 - eps / 2), 0, -gamma * mu * Q / 2),
        ((gamma * mu / 8) * (2 / 3 - eps), -2 * (1 + m), -(gamma / 2) * (1 / 4 - eps / 3)),
        (0, -(gamma / 2) * (1 / 4 - eps / 3), 2 * (1 + m)),
        (0, 0, -a),
        (0, -a, 0),
        (s, 0, 0),
    ]
    return np.array(columns, dtype=float).T


def hover(
    gamma: float, eps: float = 0.0, kappa: float = 0.0, K1: float = 0.0, m: float | None = None
) -> dict[str, float | NDArray[np.complex128]]:
    """Eqs. (9) and (10), with the factor P the report leaves out, and their overdamped branch; needs P² > 0.

    ω_nc = P, ζ = (γ/(16P))(1 − 8ε/3 + 2ε²). For ζ ≤ 1: ω_n² = 1 + P² ± 2P√(1−ζ²) (advancing +, regressing −) and ζ_A =
    ζP/ω_nA, ζ_R = ζP/ω_nR. For ζ > 1 the cyclic exponents are −ζP ± P√(ζ²−1) ± i and nothing tells R from A. Gives P,
    zeta, frequencies and damping ratios (nan where they do not exist), and the exponents: coning (2,), cyclic (4,).
    """
    P = float(np.sqrt(truncated(gamma, eps, kappa, K1, 0.0, m)["P2"]))
    zeta = gamma / (16 * P) * (1 - 8 * eps / 3 + 2 * eps**2)
    if zeta > 1:
        real = -zeta * P + P * np.sqrt(zeta**2 - 1) * np.array([1, -1])
        missing = dict.fromkeys(("omega_A", "omega_R", "zeta_A", "zeta_R"), float("nan"))
        cyclic = np.concatenate([real + 1j, real - 1j])
        return {"P": P, "zeta": zeta, **missing, "coning": real.astype(complex), "cyclic": cyclic}
    root = np.sqrt(1 - zeta**2)
    omega_A, omega_R = np.sqrt(1 + P**2 + 2 * P * root), np.sqrt(1 + P**2 - 2 * P * root)
    zeta_A, zeta_R = zeta * P / omega_A, zeta * P / omega_R
    coning = _pair(P, zeta)
    cyclic = np.concatenate([_pair(omega_A, zeta_A), _pair(omega_R, zeta_R)])
    values = {"omega_A": omega_A, "omega_R": omega_R, "zeta_A": zeta_A, "zeta_R": zeta_R}
    return {"P": P, "zeta": zeta, **values, "coning": coning, "cyclic": cyclic}


def _pair(omega: float, zeta: float) -> NDArray[np.complex128]:
    """−ζω ± iω√(1−ζ²)."""
    imaginary = omega * np.sqrt(max(0.0, 1 - zeta**2))
    return np.array([complex(-zeta * omega, imaginary), complex(-zeta * omega, -imaginary)])
