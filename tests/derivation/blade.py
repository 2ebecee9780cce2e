"""Flapping of one blade, derived symbolically from the motion of its elements: Appendix A of NASA TP-1431.

Wind-hub axes: x upwind, y to the right, z down, unit vectors 𝐱 𝐲 𝐳. They roll and pitch with ω = (p_w, q_w, 0), and in
them the blade turns from downwind to the right, ψ' = Ω. With 𝐫 along the blade's azimuth, 𝐭 ahead of it and 𝐮 = −𝐳 up,
an element r outboard of the hinge is at ρ and flaps along 𝐧::

    ρ = e 𝐫 + r (cos β 𝐫 + sin β 𝐮)        𝐧 = −sin β 𝐫 + cos β 𝐮
    speed        = V + ω × ρ + ρ'          acceleration = V' + ω × V + ω' × ρ + ω × (ω × ρ) + 2 ω × ρ' + ρ''
    U_T ΩR       = (ρ' + ω × ρ − air)·𝐭     air = −μΩR 𝐱 + λΩR 𝐮
    U_P ΩR       = (air − ρ' − ω × ρ)·𝐧
    theta        = θ₀ − A₁c cos ψ − B₁c sin ψ + x θ_t − K₁ β,     x = (e + r)/R
    M_A          = I_β Ω² (γ/2) ∫ (U_T² theta + U_T U_P) (x − ε) dx   over [ε, 1]
    M_inertia    = ∫ r 𝐧·(g 𝐳 − acceleration) dm,    ∫ r dm = M_β,  ∫ r² dm = I_β
    0            = M_A + M_inertia − K_β β

to first order in β, β', the inputs and the accelerations. It is solved for β'' in the report's parameters, primes now
d/dψ: ``β'' + d β' + k β = f u``. Two choices are the report's: M_A is cut after ε² unless ``exact``, and its moment of
body angular acceleration has I_β for I_β + e M_β unless ``kinematic``.
"""

from __future__ import annotations

import functools

import sympy as sp

__all__ = [
    "INPUTS", "PARAMETERS", "aerodynamic_moment", "by_azimuth", "damping", "flap_acceleration", "forcing",
    "inertial_moment", "is_same", "linear", "speeds", "stiffness", "trigonometric",
]  # fmt: skip

# The parameters of the equation of motion; m = e M_β/I_β and s = R M_β/I_β are independent.
psi, gamma, eps, kappa, K1, mu, m, s = sp.symbols("psi gamma epsilon kappa K_1 mu m s", real=True)
PARAMETERS = (gamma, eps, kappa, K1, mu, m, s)

# What has units.
Omega, R, e, I_beta, M_beta, K_beta, g = sp.symbols("Omega R e I_beta M_beta K_beta g", positive=True)
x, r = sp.symbols("x r", real=True)

# The motion and the inputs; dots are d/dt.
beta, beta_dot, beta_ddot = sp.symbols("beta betadot betaddot", real=True)
theta_0, A_1c, B_1c, theta_t, inflow = sp.symbols("theta_0 A_1c B_1c theta_t lambda", real=True)
p_w, q_w, p_dot, q_dot = sp.symbols("p_w q_w pdot_w qdot_w", real=True)
u_w, v_w, w, u_dot, v_dot, w_dot = sp.symbols("u_w v_w w udot_w vdot_w wdot", real=True)
normal = sp.Symbol("n", real=True)  # ((ẇ − uq + pv) − g)/(Ω²R)

INPUTS = (theta_0, A_1c, B_1c, theta_t, inflow, p_w, q_w, p_dot, q_dot, normal)
MOTION = {psi: Omega, beta: beta_dot, beta_dot: beta_ddot}
SMALL = (beta, beta_dot, beta_ddot, *INPUTS[:-1], u_dot, v_dot, w_dot, g)

X, Y, Z = (sp.eye(3).col(i) for i in range(3))
UP = -Z
RADIAL = -sp.cos(psi) * X + sp.sin(psi) * Y
TANGENTIAL = sp.sin(psi) * X + sp.cos(psi) * Y
NORMAL = -sp.sin(beta) * RADIAL + sp.cos(beta) * UP
POSITION = e * RADIAL + r * (sp.cos(beta) * RADIAL + sp.sin(beta) * UP)
TURNING = p_w * X + q_w * Y


def rate_of_change(vector: sp.Matrix) -> sp.Matrix:
    """d/dt of a vector's components in wind-hub axes."""
    return sum((vector.diff(v) * v_dot for v, v_dot in MOTION.items()), sp.zeros(3, 1))


def linear(expression: sp.Expr) -> sp.Expr:
    """The terms of first order in the motion, the inputs and the accelerations; their products are dropped."""
    size = sp.Symbol("size")
    scaled = expression.subs({v: size * v for v in SMALL}, simultaneous=True)
    return sp.expand(scaled.diff(size).subs(size, 0))


def trigonometric(expression: sp.Expr) -> sp.Expr:
    """A trigonometric polynomial expanded in exponentials, a form in which equal expressions are identical."""
    return sp.expand(sp.sympify(expression).rewrite(sp.exp))


def is_same(a: sp.Expr, b: sp.Expr) -> bool:
    """Whether two trigonometric polynomials are one."""
    return trigonometric(a - b) == 0


@functools.cache
def speeds() -> tuple[sp.Expr, sp.Expr]:
    """U_T and U_P of an element at x, in units of ΩR, for any β."""
    speed = rate_of_change(POSITION) + TURNING.cross(POSITION)
    air = -mu * Omega * R * X + inflow * Omega * R * UP
    U_T, U_P = (speed - air).dot(TANGENTIAL), (air - speed).dot(NORMAL)
    scaled = {e: eps * R, r: (x - eps) * R}
    return tuple(sp.trigsimp(sp.expand(U.subs(scaled) / (Omega * R))) for U in (U_T, U_P))


@functools.cache
def aerodynamic_moment(*, exact: bool) -> sp.Expr:
    """M_A / (I_β Ω² γ/2) = ∫ (U_T² theta + U_T U_P) (x − ε) dx over [ε, 1], eq. (A2), or cut after ε², eq. (A3)."""
    U_T, U_P = speeds()
    theta = theta_0 - A_1c * sp.cos(psi) - B_1c * sp.sin(psi) + x * theta_t - K1 * beta
    per_length = sp.Poly(linear((U_T**2 * theta + U_T * U_P) * (x - eps)), x)
    moment = sp.expand(sum(c * (1 - eps ** (n + 1)) / (n + 1) for (n,), c in per_length.terms()))
    return moment if exact else sum(moment.coeff(eps, n) * eps**n for n in range(3))


@functools.cache
def inertial_moment() -> sp.Expr:
    """∫ r 𝐧·(g 𝐳 − acceleration) dm for any β and body rate: the moments of eq. (A1) but M_A and M_R."""
    velocity, turning_rate = u_w * X + v_w * Y + w * Z, p_dot * X + q_dot * Y
    hub = u_dot * X + v_dot * Y + w_dot * Z + TURNING.cross(velocity)
    speed = rate_of_change(POSITION)
    frame = turning_rate.cross(POSITION) + TURNING.cross(TURNING.cross(POSITION)) + 2 * TURNING.cross(speed)
    acceleration = hub + frame + rate_of_change(speed)
    per_mass = sp.Poly(sp.expand(r * (g * Z - acceleration).dot(NORMAL)), r)
    return sp.expand(per_mass.coeff_monomial(r) * M_beta + per_mass.coeff_monomial(r**2) * I_beta)


@functools.cache
def flap_acceleration(*, exact: bool, kinematic: bool) -> sp.Expr:
    """β̈ [rad/s²] with units, as in eq. (A4): linear in β, β̇, the inputs, ẇ and g."""
    moment = I_beta * Omega**2 * gamma / 2 * aerodynamic_moment(exact=exact) + linear(inertial_moment()) - K_beta * beta
    if not kinematic:
        moment -= e * M_beta * (p_dot * sp.sin(psi) + q_dot * sp.cos(psi))
    moment = sp.expand(moment)
    return sp.expand(-moment.coeff(beta_ddot, 0) / moment.coeff(beta_ddot))


@functools.cache
def by_azimuth(*, exact: bool, kinematic: bool) -> sp.Expr:
    """β'' by azimuth in :data:`PARAMETERS` and :data:`INPUTS`: rates by Ω, ``beta_dot`` is β'."""
    with_normal = {w_dot: normal * Omega**2 * R + u_w * q_w - v_w * p_w + g}
    units = {
        e: m * I_beta / M_beta,  # e stands beside M_β only
        K_beta: kappa * I_beta * Omega**2,
        **{v: Omega * v for v in (beta_dot, p_w, q_w)},
        **{v: Omega**2 * v for v in (p_dot, q_dot)},
    }
    acceleration = flap_acceleration(exact=exact, kinematic=kinematic).subs(with_normal)
    return sp.expand((acceleration.subs(units, simultaneous=True) / Omega**2).subs(M_beta, s * I_beta / R))


def damping(*, exact: bool) -> sp.Expr:
    """d(ψ)."""
    return -by_azimuth(exact=exact, kinematic=False).coeff(beta_dot)


def stiffness(*, exact: bool) -> sp.Expr:
    """k(ψ)."""
    return -by_azimuth(exact=exact, kinematic=False).coeff(beta)


def forcing(*, exact: bool, kinematic: bool) -> sp.Matrix:
    """f(ψ), one row with a column for each of :data:`INPUTS`."""
    return sp.Matrix([[by_azimuth(exact=exact, kinematic=kinematic).coeff(v) for v in INPUTS]])
