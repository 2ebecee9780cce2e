"""The faults that ``make mutants`` injects into the physics and the numerics, each with the tests that must notice."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["FAULTS", "Mutant"]


class Mutant(NamedTuple):
    """What is broken: old text → new text in a file; the pytest selection that must notice."""

    what: str
    file: str
    old: str
    new: str
    tests: str


FLAPPING, TPP, MULTIBLADE = (
    "floquet/models/flapping.py",
    "floquet/models/tip_path_plane.py",
    "floquet/models/multiblade.py",
)
RECORDED, PAIRS = "floquet/period_map/recorded.py", "tests/test_pairs.py"
FORM, PRECISE, FACTOR_BOUNDS = (
    "floquet/period_map/form.py",
    "floquet/period_map/integers.py",
    "floquet/exponents/factors.py",
)
CLOSING, HILL, TAYLOR = "floquet/kernels/closing.py", "floquet/kernels/hill.py", "floquet/kernels/generate.py"
PIECES, PIECES_LANES = "floquet/kernels/pieces.py", "floquet/kernels/pieces_lanes.py"
MODELS, IN_PIECES = "tests/test_models.py", "tests/test_pieces.py"

#: One integral ∫ U_T^p x^j (x-ε)^k dx and the power b of u in it, with the coefficients it gives.
INTEGRALS = {
    (1, 0, 2, 0): "c0",
    (1, 0, 2, 1): "cs1",
    (1, 0, 1, 0): "kc1 (J1 of λ)",
    (1, 0, 1, 1): "ks2 (Q of λ)",
    (2, 0, 1, 0): "K₁ part of P² (J2 of θ₀)",
    (2, 0, 1, 1): "ks1 (J1 of θ₀)",
    (2, 0, 1, 2): "kc2 and μ² of k0 (Q of θ₀)",
    (2, 1, 1, 0): "J3 of θ_t",
    (2, 1, 1, 1): "J2 of θ_t",
    (2, 1, 1, 2): "J1 of θ_t",
    (1, 1, 1, 0): "J2 of the body rates",
    (1, 1, 1, 1): "J1 of the body rates",
}
FORWARD = "forward = [math.comb(p, b) * self._moment("

coefficients = tuple(
    Mutant(
        f"{name} +1 %", FLAPPING, FORWARD, FORWARD.replace("[", f"[(1.01 if (p, j, k, b) == {key} else 1.0) * "), MODELS
    )
    for key, name in INTEGRALS.items()
)
structure = tuple(
    Mutant(f"{what} +1 %", FLAPPING, old, new, MODELS)
    for what, old, new in (
        (
            "1 of P²",
            '_constant(1 + v["hinge_stiffness"] + v["offset_mass_ratio"])',
            '_constant(1.01 + v["hinge_stiffness"] + v["offset_mass_ratio"])',
        ),
        (
            "κ of P²",
            '_constant(1 + v["hinge_stiffness"] + v["offset_mass_ratio"])',
            '_constant(1 + 1.01 * v["hinge_stiffness"] + v["offset_mass_ratio"])',
        ),
        (
            "m of P²",
            '_constant(1 + v["hinge_stiffness"] + v["offset_mass_ratio"])',
            '_constant(1 + v["hinge_stiffness"] + 1.01 * v["offset_mass_ratio"])',
        ),
        ("K₁", 'v["pitch_flap_coupling"] * pitch', '1.01 * v["pitch_flap_coupling"] * pitch'),
        (
            "flap damping",
            '_constant(v["flap_damping"])',
            '_constant(1.01 * v["flap_damping"])',
        ),
        ("A₁c column", "-1.0 * (COSINE @ pitch)", "-1.01 * (COSINE @ pitch)"),
        ("B₁c column", "-1.0 * (SINE @ pitch)", "-1.01 * (SINE @ pitch)"),
        ("2(1+m)", "2.0 * (1.0 + m), (1.0 + m if", "2.02 * (1.0 + m), (1.0 + m if"),
        (
            "(1+m) of the body accelerations",
            "(1.0 + m if self.physics.kinematic_rates",
            "(1.01 + m if self.physics.kinematic_rates",
        ),
        ("ṗ_w column", "acceleration * SINE,", "1.01 * acceleration * SINE,"),
        ("q̇_w column", "acceleration * COSINE,", "1.01 * acceleration * COSINE,"),
        (
            "s",
            '_constant(self.values["static_moment_ratio"])',
            '_constant(1.01 * self.values["static_moment_ratio"])',
        ),
    )
)
physics = (
    Mutant(
        "Ω² left out of the rate terms (Ω = 27 rad/s)",
        FLAPPING,
        "half * self.integral(1, 1, 1)",
        "(half / 27.0**2) * self.integral(1, 1, 1)",
        MODELS,
    ),
    Mutant(
        "sign of 2Ω T' in the damping (B5)",
        MULTIBLADE,
        "Ti @ (2 * T.derivative() + A @ T)",
        "Ti @ (-2 * T.derivative() + A @ T)",
        MODELS,
    ),
    Mutant(
        "sign of 2Ω t' in the tip-path plane",
        TPP,
        "(ONE, 2.0 * t.first)",
        "(ONE, -2.0 * t.first)",
        MODELS,
    ),
    Mutant("A T' left out of K (B5)", MULTIBLADE, "A @ T.derivative() + B @ T", "B @ T", MODELS),
    Mutant("sign of β_d", MULTIBLADE, "(-1.0) ** np.arange(1, N + 1)", "(-1.0) ** np.arange(N)", MODELS),
    Mutant(
        "β_d not flipped by the passage",
        MULTIBLADE,
        "twist[[N - 1, 2 * N - 1]] = -1.0",
        "twist[[N - 1, 2 * N - 1]] = 1.0",
        MODELS,
    ),
    Mutant("signs of a₁ and b₁", TPP, "[[-1.0, 0.0]], [[0.0, -1.0]]", "[[1.0, 0.0]], [[0.0, 1.0]]", MODELS),
    Mutant("truncated where exact is asked", FLAPPING, "np.asarray(physics.exact_offset)", "np.asarray(False)", MODELS),
    Mutant("inner reversed region forgotten", FLAPPING, "- 2 * inboard[b]", "- 1 * inboard[b]", MODELS),
    Mutant("outer reversed region forgotten", FLAPPING, "(-1) * ahead]", "ahead]", MODELS),
    Mutant(
        "odd harmonics kept in teetering",
        "floquet/models/teetering.py",
        "(matrix + matrix.shifted(math.pi)) / 2",
        "matrix",
        MODELS,
    ),
)
branch = (
    Mutant(
        "lift: zeros not counted",
        HILL,
        "((a[0] < 0) != (b[0] < 0)) * 1.0",
        "0.0",
        "tests/test_exponents.py",
    ),
    Mutant(
        "lift: zeros counted twice",
        HILL,
        "((a[0] < 0) != (b[0] < 0)) * 1.0",
        "((a[0] < 0) != (b[0] < 0)) * 2.0",
        "tests/test_exponents.py",
    ),
    Mutant(
        "lift: parity of a complex pair",
        CLOSING,
        "select(locked, tau > 0.0, m[2] < 0.0)",
        "select(locked, tau > 0.0, m[2] > 0.0)",
        "tests/test_exponents.py",
    ),
    Mutant(
        "lift: parity of a lock",
        CLOSING,
        "select(locked, tau > 0.0, m[2] < 0.0)",
        "select(locked, tau < 0.0, m[2] < 0.0)",
        "tests/test_exponents.py",
    ),
    Mutant(
        "lift: which way a locked solution has gone",
        CLOSING,
        "locked & (m[2] * m[0] < 0.0)",
        "locked & (m[2] * m[0] > 0.0)",
        "tests/test_exponents.py tests/test_certified.py",
    ),
    Mutant(
        "lock claimed without growth",
        CLOSING,
        "locked = D > b",
        "locked = D > -b",
        "tests/test_exponents.py",
    ),
    Mutant(
        "kick at a jump of the damping",
        FORM,
        "kicks[j] = 0.5 * (after",
        "kicks[j] = 0.0 * (after",
        MODELS,
    ),
    Mutant(
        "Hill form: d'/2",
        FORM,
        "k - d.derivative() / 2",
        "k - d.derivative() / 2.1",
        "tests/test_exponents.py",
    ),
    Mutant(
        "Hill form in integers without the damping",
        PRECISE,
        "polynomial(d, k)",
        "polynomial(None, k)",
        "tests/test_exponents.py tests/test_pairs.py",
    ),
)
bounds = (
    Mutant(
        "bound of a blade divided by ten",
        CLOSING,
        "np.sqrt(size + b))) / T",
        "np.sqrt(size + b))) / (10.0 * T)",
        "tests/test_exponents.py",
    ),
    Mutant(
        "bound of factors divided by ten",
        FACTOR_BOUNDS,
        "np.log(values), radius / np.abs(values)",
        "np.log(values), 0.1 * radius / np.abs(values)",
        "tests/test_exponents.py",
    ),
    Mutant(
        "truncation left out of the bound",
        HILL,
        "delta = e + EPS",
        "delta = 0.0 * e + EPS",
        "tests/test_exponents.py tests/test_kernels.py",
    ),
    Mutant(
        "rounding left out of the bound",
        HILL,
        "ROUNDING = 2.0",
        "ROUNDING = 0.0",
        "tests/test_kernels.py tests/test_certified.py",
    ),
    Mutant(
        "gradient of D without adj F",
        HILL,
        "(abs(tau * w0 - f[3]) + abs(tau * w3 - f[0]))",
        "(abs(tau * w0) + abs(tau * w3))",
        "tests/test_exponents.py tests/test_kernels.py",
    ),
    Mutant(
        "square root at branch points",
        CLOSING,
        "np.sqrt(size) + np.sqrt(size + b)",
        "size + b",
        "tests/test_exponents.py",
    ),
    Mutant(
        "Liouville always content",
        CLOSING,
        "abs(m[0] * m[3] - m[1] * m[2] - 1.0)",
        "0.0 * m[0]",
        "tests/test_exponents.py",
    ),
    Mutant(
        "identical blades: shifted by one too many",
        "floquet/exponents/identical.py",
        "k = np.arange(blades)",
        "k = np.arange(blades) + 0.5",
        "tests/test_exponents.py",
    ),
)
PAIRING, FACTORS = "floquet/kernels/pairing.py", "floquet/kernels/quadratics.py"
COMPARED, SIMPLE = "tests/test_comparison.py", "tests/test_simple_model.py"
MIRROR = "mirror = -2.0 * lock - k"
pieces = (
    Mutant(
        "lanes: zeros not counted",
        PIECES_LANES,
        "abs(where(steps[n, 8] < 0.0, 1.0",
        "abs(where(steps[n, 8] < 0.0, 0.0",
        IN_PIECES,
    ),
    Mutant("lanes: rough panels not counted", PIECES_LANES, "flag > 0.0, 1.0", "flag > 0.0, 0.0", IN_PIECES),
    Mutant(
        "lanes: a point that waits moves on", PIECES_LANES, "where(live, product[0], m[0])", "product[0]", IN_PIECES
    ),
    Mutant(
        "lanes: errors of a point that waits",
        PIECES_LANES,
        "where(live, state[5] + w[1], state[5])",
        "state[5] + w[1]",
        IN_PIECES,
    ),
    Mutant("lanes: a kick at every panel", PIECES_LANES, "if s == 0 else", "if s >= 0 else", IN_PIECES),
    Mutant("lanes: angles of harmonics", PIECES_LANES, "sine * c + cosine * s", "sine * c - cosine * s", IN_PIECES),
    Mutant("lanes: centre of a panel", PIECES_LANES, "(2 * s + 1) * half", "(2 * s + 0.999) * half", IN_PIECES),
    Mutant("pieces: signs of the series", PIECES, "np.where(k % 4 < 2", "np.where(k % 4 < 3", IN_PIECES),
    Mutant("pieces: centre of a panel", PIECES, "(2 * place + 1) * half", "(2 * place + 0.999) * half", IN_PIECES),
    Mutant("bounds of short panels idle", HILL, "(g < 0.5) & (area < 1.0)", "(g < 0.0) & (area < 1.0)", IN_PIECES),
    Mutant("bounds of kicked panels", HILL, "(1.0 + g * abs(kick))", "(1.0 - g * abs(kick))", IN_PIECES),
    Mutant("kicks there and back again", FORM, "] += np.where(empty", "] += 0.0 * np.where(empty", IN_PIECES),
    Mutant(
        "forty digits without kicks",
        "floquet/period_map/hill.py",
        "make_precise(phi, system, kicked,",
        "make_precise(phi, system, None,",
        IN_PIECES,
    ),
    Mutant("two parts of ½π", "floquet/kernels/elementary.py", "- turns * QUARTER[2]", "- 0.0 * QUARTER[2]", IN_PIECES),
    Mutant("mean of a piece", "floquet/periodic/matrix.py", "(2.0 / (h * omega))", "(2.0 / omega)", IN_PIECES),
)
pairing = (
    *(
        Mutant(
            f"pairing rule of a lock at {rho}",
            PAIRING,
            MIRROR,
            f"mirror = np.where(lock == {rho}, {wrong}, -2.0 * lock - k)",
            COMPARED,
        )
        for rho, wrong in ((0.0, "9.0"), (0.5, "9.0"), (1.0, "9.0"), (1.5, "1.0 * k"))
    ),
    Mutant("mean of a lock", PAIRING, "mean = 0.5 * (s1 + s2)", "mean = 1.0 * s1", COMPARED),
    Mutant(
        "regressing above ρ",
        PAIRING,
        "frequency = select(reals, 0.0, rho + k)",
        "frequency = select(reals, 0.0, rho - k)",
        COMPARED,
    ),
    Mutant("pairing in order, not by cost", PAIRING, "(added < best) if p > 0", "(added < added) if p > 0", COMPARED),
    Mutant("two modes change places", PAIRING, "better, orders[p, i]", "better, orders[p, modes - 1 - i]", COMPARED),
    Mutant("reals in neighbouring twos only", PAIRING, "axis=1), 4, 6)", "axis=1), 7, 7)", COMPARED),
    Mutant(
        "largest of two distances",
        PAIRING,
        "absolute = larger(distance(s, t, x, y), distance(z, w, u, v))",
        "absolute = distance(s, t, x, y)",
        f"tests/test_validity.py {COMPARED}",
    ),
    Mutant("joint pairs unnamed", PAIRING, "(one > other + REAL)", "(one < other - REAL)", COMPARED),
    Mutant("ties decided by rounding", PAIRING, "TIE = 1e-9", "TIE = 0.0", SIMPLE),
    Mutant("nan hidden by a number", PAIRING, "select(a == a, b, a))", "b)", SIMPLE),
    Mutant("last steps left out", FACTORS, "STEPS = 18", "STEPS = 5", SIMPLE),
    Mutant("roots not seen from where they are", FACTORS, "swap = abs(x + large) < abs(x + small)",
           "swap = abs(x + large) > abs(x + small)", SIMPLE),
    Mutant("bounds without rounding", FACTORS, "ROUNDING = 1.0", "ROUNDING = 0.01", SIMPLE),
    Mutant("pairs that meet are trusted", FACTORS, "LOST = 1e-12", "LOST = 1e12", SIMPLE),
    Mutant("harmonics doubled in a mean", TPP, "0.5 * row for row", "1.0 * row for row", SIMPLE),
    Mutant("pieces turned backwards", TPP, "np.conj(G * (E[h - j] if", "(G * (E[h - j] if", SIMPLE),
)  # fmt: skip
RECORD, PROGRAM, TAPES = "floquet/tape/record.py", "floquet/tape/program.py", "tests/test_tape.py"
tapes = (
    Mutant("x - y and y - x are one", RECORD, 'sorted((x, y)) if kind == "+"', "sorted((x, y)) if True", TAPES),
    Mutant("sign lost in a difference", RECORD, 'self.entry("-" if kind == "+" else "+", x, inner)',
           'self.entry("+", x, inner)', TAPES),
    Mutant("divisors taken for powers of two", RECORD, "[0]) == 0.5", "[0]) <= 0.75", TAPES),
    Mutant("constants rounded once only", RECORD, "operate(*(c.double for c in constants))",
           "float(operate(*(c.exact for c in constants)))", TAPES),
    Mutant("rows given up too early", PROGRAM, "if last[p] == n and", "if last[p] <= n + 1 and", TAPES),
    Mutant("results overwritten", PROGRAM, " | {p: len(needed) for p in outputs}", "", TAPES),
    Mutant("one tape for whatever is zero", RECORDED, "    folded: tuple[tuple[str, float], ...]",
           "    folded: tuple[tuple[str, float], ...] = field(compare=False)", TAPES),
    Mutant("one tape for whatever varies", RECORDED, "    varying: tuple[str, ...]",
           "    varying: tuple[str, ...] = field(compare=False)", TAPES),
    Mutant("one tape for exact and truncated offsets", FLAPPING, '"flapping", physics.exact_offset, ',
           '"flapping", ', TAPES),
    Mutant("panels of another frequency", "floquet/kernels/form.py", "_wanted(q[i], (first, second), omega)",
           "_wanted(q[i], (first, second), 1.0)", TAPES),
)  # fmt: skip
DESIGNS, CURVES, LIMITS = (f"floquet/validity/{name}.py" for name in ("designs", "curves", "limits"))
atlas = (
    Mutant("an atlas of all metrics", "floquet/plot/__init__.py", "chosen = relative & (", "chosen = (",
           "tests/test_plot.py"),
    Mutant("an atlas of those that fail", "floquet/plot/atlas.py", "return 1.0 - np.searchsorted",
           "return np.searchsorted", "tests/test_plot.py"),
)  # fmt: skip
V, B, PLANE = "tests/test_validity.py", "tests/test_boundaries.py", "floquet/validity/boundaries.py"
roots = (
    Mutant("growth confused with lock", "floquet/validity/levels.py", "np.cosh(phi.mean * phi.period))\n", "1.0)\n", V),
    Mutant("locks at one end of τ", DESIGNS, 'self._value("lock"), (1.0, -1.0)', 'self._value("lock"), (1.0,)', V),
    Mutant(
        "slopes of the polynomial to the end",
        "floquet/validity/curves.py",
        "np.isfinite(chord) & (chord != 0.0)",
        "np.isnan(slope)",
        B,
    ),
    Mutant("tongues capped at every mesh", PLANE, "inner[1] + outer[1] + (side == other)", "inner[1] + outer[1]", B),
    Mutant("nothing is cut", PLANE, "DEPTH = 7", "DEPTH = 0", B),
    Mutant("a mesh without its left", PLANE, "level[j + 1][i], upright[i][j])", "level[j + 1][i], ())", B),
    Mutant("pairs only", DESIGNS, "np.triu_indices(roots.shape[-1])\n", "np.triu_indices(roots.shape[-1], 1)\n", V),
    Mutant(
        "growth in any part",
        DESIGNS,
        "grows = self._simple(case, 0.5 * (start + stop)).real.max(axis=-1) > 0.0",
        "grows = stop > start",
        V,
    ),
    Mutant("noise is distance", CURVES, "+ noise[which]", "", B),
    Mutant("roots found twice", CURVES, "SAME = 1e-12", "SAME = -1.0", B),
    Mutant("six secants", CURVES, "SECANTS = 60", "SECANTS = 6", B),
    Mutant("one level", PLANE, "            LEVELS,\n", "            (1.0,),\n", B),
    Mutant("no gap between two lines", PLANE, "if through[lowest] <= 0.0 and", "if False and", B + " -k pinched"),
    Mutant(
        "saddles the other way", PLANE, "(rising, falling) == (0, 2)", "(rising, falling) == (2, 2)", B + " -k pinched"
    ),
    Mutant("ends pass nothing", PLANE, "np.setdiff1d(some, along)", "some[:0]", B + " -k border"),
    Mutant(
        "a line in a boundary passes it",
        PLANE,
        "along = np.intersect1d(first, last)",
        "along = first[:0]",
        B + " -k border",
    ),
    Mutant("roots held back by an end", CURVES, "((x == a) | (x == b)) & beyond", "beyond & False", B + " -k piece"),
    Mutant("no doubt at an end", CURVES, "doubtful = ~passed &", "doubtful = passed & ~passed &", B + " -k piece"),
    Mutant("parts of a root are two", CURVES, ", 0.1 * least)", ", 0.0)", B + " -k strutt"),
    Mutant("growth for locks", PLANE, "BOUNDARIES[kind]\n", 'BOUNDARIES["growth"]\n', B),
    Mutant(
        "cells without a root kept out too early",
        CURVES,
        "half * (slope + 0.5 * half * by_theta[which])",
        "half * slope",
        V,
    ),
    Mutant("one root where the slope turns", CURVES, "(slope > half * by_theta[which])", "(slope > 0.0)", V),
    Mutant("touching curves pass", CURVES, "some = (width > 0.5 * least)", "some = (width >= 0.0)", V),
    Mutant("pieces that touch not cut", CURVES, "PARTED = 6", "PARTED = 0", V),
    Mutant("pieces left unresolved", CURVES, "rounding: float = 2e-14", "rounding: float = 2e-4", V),
    Mutant(
        "roots of polynomials left as they are",
        CURVES,
        "    for _ in range(2):\n        moved",
        "    for _ in range(0):\n        moved",
        V,
    ),
    Mutant("hidden extrema forgotten", LIMITS, "may |= (there > t) & (there - reach <= t)", "pass", V),
    Mutant("edges of the neighbour", LIMITS, "better = (edges.case[i] == case) & ", "better = ", V),
)

HOVER, DECOUPLING, TEETERING = "floquet/models/hover.py", "floquet/decoupling.py", "floquet/models/teetering.py"


def _erratum(number: int, what: str, file: str, old: str, new: str) -> Mutant:
    """The report's printed form in place of the right one."""
    return Mutant(f"erratum {number}: {what}", file, old, new, f"tests/test_errata.py -k erratum_{number:02d}")


errata = (
    _erratum(
        1,
        "hover damping with ε/3",
        HOVER,
        "zeta = 0.5 * c0 / P\n",
        "e = np.asarray(rotor.hinge_offset)\n    zeta = rotor.lock_number / P * (1 / 16 - e / 3 + e**2 / 8)\n",
    ),
    _erratum(
        2,
        "ζ_A and ζ_R without P",
        HOVER,
        "zeta * P - spread, swing + 1.0),\n        regressing=_mode(regressing, zeta * P + spread,",
        "zeta - spread, swing + 1.0),\n        regressing=_mode(regressing, zeta + spread,",
    ),
    _erratum(
        3,
        "(20) with the numerator of ε = 0",
        DECOUPLING,
        "    return plain(-2.0 * (1.0 + np.asarray(rotor.offset_mass_ratio)) / c0)\n",
        "    spring, gamma = np.asarray(required_spring(rotor, **options)), np.asarray(rotor.lock_number)\n"
        "    return plain(-(gamma / 4 + gamma / 8 * spring) / (spring**2 + c0**2))\n",
    ),
    _erratum(
        4,
        "b₁ due to q_w as a₁ due to p_w",
        DECOUPLING,
        "[[cross, direct], [direct, -cross]]",
        "[[cross, direct], [direct, cross]]",
    ),
    _erratum(
        6,
        "M_BA without e M_β",
        FLAPPING,
        "(1.0 + m if self.physics.kinematic_rates else np.ones_like(m))",
        "(np.ones_like(m) if self.physics.kinematic_rates else np.ones_like(m))",
    ),
    _erratum(7, "uniform blade with m = 1.5 ε", DECOUPLING, "1.5 * offset / (1.0 - offset)", "1.5 * offset"),
    _erratum(
        9,
        "k₁ and k₂ by the sticks of appendix C",
        DECOUPLING,
        "[0, 0, self.longitudinal], [0, self.lateral, 0]",
        "[0, self.longitudinal, 0], [0, 0, self.lateral]",
    ),
    _erratum(
        9,
        "k₁ and k₂ exchanged in (C4)",
        DECOUPLING,
        "k0, k1, k2 = _sens",
        "k0, k2, k1 = _sens",
    ),
    _erratum(
        10,
        "mixing of wind axes in body axes",
        DECOUPLING,
        "E, R = _effectiveness(plane.forcing.mean(), inflow_gradient), axes(sideslip)",
        "E, R = _effectiveness(plane.forcing.mean(), inflow_gradient), axes(0.0 * np.asarray(sideslip))",
    ),
    _erratum(10, "feedback of wind axes in body axes", DECOUPLING, "np.asarray(R @ K @ R)", "np.asarray(K + 0.0 * R)"),
    _erratum(
        11,
        "averaged model of any harmonics is the plane",
        TPP,
        "count = int(harmonics)",
        "count = 1",
    ),
    _erratum(
        12,
        "no forcing by the precone",
        TEETERING,
        "-1.0 * _odd(blade_equation.whole()[1])",
        "0.0 * _odd(blade_equation.whole()[1])",
    ),
    _erratum(
        13,
        "weight and normal acceleration with the sign of (A1)",
        FLAPPING,
        '_constant(self.values["static_moment_ratio"]),',
        '_constant(-self.values["static_moment_ratio"]),',
    ),
)

SCHEMA, FILES, WRITING, READING = (f"floquet/store/{name}.py" for name in ("schema", "files", "writing", "reading"))
FOLDER, MERGING, PACKING, SHARDS, WORKERS = (
    f"floquet/study/{name}.py" for name in ("folder", "merging", "packing", "shards", "workers")
)
QUERY = "floquet/query/language.py"
CHUNKS, PLOT = "floquet/chunks.py", "floquet/plot/__init__.py"
KEPT, RUNS, ASKED, PACKED = (f"tests/test_{name}.py" for name in ("store", "study", "query", "chunks"))
COLUMNS, CUTS = f"{RUNS} -k columns", f"{RUNS} -k shards"
SYNC, RENAME = "        _sync(temporary)\n", "        os.replace(temporary, path)\n"
storage = (
    Mutant("digest not checked", READING, "if digest(part) != digests", "if False and digest(part) != digests", KEPT),
    Mutant(
        "digest of ranges not checked",
        READING,
        "        if not sound:\n            raise",
        "        if False:\n            raise",
        KEPT,
    ),
    Mutant("rename before fsync", FILES, SYNC + RENAME, RENAME + SYNC.replace("temporary", "path"), KEPT),
    Mutant("no fsync", FILES, SYNC + RENAME, RENAME, KEPT),
    Mutant(
        "schema digest not checked",
        READING,
        "        if not sound:\n            yield",
        "        if False:\n            yield",
        KEPT,
    ),
    Mutant("newer schema read", READING, "> SCHEMA[0]:", "> SCHEMA[0] + 1:", KEPT),
    Mutant("write error forgotten", FILES, "if self.error is not None:", "if False:", KEPT),
    Mutant("imaginary part lost", READING, "out.real, out.imag = real, imaginary", "out.real, out.imag = real, 0",
           KEPT),
    Mutant("damaged shards kept", SHARDS, "return file.intact()", "return True", RUNS),
    Mutant("another study's folder", FOLDER, 'about.get("study_id") != study.id:', "False:", RUNS),
    Mutant("shards of another study packed", PACKING, "    if wrong:\n", "    if False:\n", RUNS),
    Mutant("shards packed unchecked", READING, "!= stored[at].tobytes():", "!= stored[at].tobytes() and False:", KEPT),
    Mutant("parts packed unfinished", PACKING, "    if missing:\n", "    if False:\n", RUNS),
    Mutant("rotors not numbered on", WRITING, 'rows["rotor"] + np.int32(rotor_offset)', 'rows["rotor"]', RUNS),
    Mutant("rotors of copied chunks not numbered on", WRITING, "                if rotor_offset:\n",
           "                if False:\n", KEPT),
    Mutant("chunks of another cut copied", WRITING,
           "whole = not rows % schema.CHUNK_ROWS or self.at + rows == self.rows", "whole = True", KEPT),
    Mutant("chunks of other filters copied", READING, "all(_filters(d) == FILTERS and", "all(", KEPT),
    Mutant("a filter left out of a chunk", READING, 'b"" if left_out else bytes(data)', "bytes(data)", KEPT),
    Mutant("rows that wait are the caller's", WRITING, "[np.concatenate(pieces)] if pieces else []", "pieces", KEPT),
    Mutant("the last rows wait", WRITING, "last = self.at + self.kept == self.rows", "last = False", KEPT),
    Mutant("columns of the schema alone", SCHEMA, "name in wanted or name in ALWAYS or", "name in wanted or", KEPT),
    Mutant("other columns gone on with", FOLDER, "    if differences:\n", "    if False:\n", COLUMNS),
    Mutant("shards of other columns packed", SHARDS, 'tuple(file.columns("points")) == parts.columns', "True", COLUMNS),
    Mutant("blocks of the shards", SHARDS, "(shard.start // step + 1) * step",
           "shard.start + step // 2", CUTS),
    Mutant("shards of any size", SHARDS,
           'math.ceil(sizes["points"] / store.schema.CHUNK_ROWS) * store.schema.CHUNK_ROWS', 'sizes["points"]', CUTS),
    Mutant("threads times processes", WORKERS, 'os.environ["FLOQUET_THREADS"] = "1"', "pass", f"{RUNS} -k thread"),
    Mutant("left out without a word", QUERY, "        if name in self.left_out:\n", "        if False:\n", COLUMNS),
    Mutant("lost columns unsaid", MERGING, "    if lost:\n", "    if False:\n", COLUMNS),
    Mutant("figures of half a mode", PLOT, "for mode in MODES if mode not in whole}", "for mode in ()}", COLUMNS),
    Mutant("words low byte first", CHUNKS, "_folded(256 * weighted)", "_folded(weighted)", PACKED),
    Mutant("65535 is 0", CHUNKS, "total and (total - 1) % 65535 + 1", "total % 65535", PACKED),
    Mutant("planes that refer to others", CHUNKS, "stream.compress(plane) + stream.flush(zlib.Z_FULL_FLUSH)",
           "stream.compress(plane) + stream.flush(zlib.Z_SYNC_FLUSH)", PACKED),
    Mutant("noise deflated", CHUNKS, "if len(part) < WORTH * plane.size", "if True", PACKED),
    Mutant("stored blocks of any length", CHUNKS, "for i in range(0, len(data), 65535)]", "for i in (0,)]", PACKED),
    Mutant("ranges with nan", CHUNKS, "float(np.fmin.reduce(numbers))", "float(np.min(numbers))", PACKED),
    Mutant("jobs without end under way", CHUNKS, "AHEAD = 2 ", "AHEAD = 200 ", PACKED),
    Mutant("results as they come", CHUNKS, "yield _result(under_way.popleft())\n        while",
           "yield _result(under_way.pop())\n        while", PACKED),
    Mutant("names of a query unchecked", QUERY, "        if name in self.dtypes:\n", "        if True:\n", ASKED),
)  # fmt: skip

PASSAGE, RESPONSE, EXHIBITS = "floquet/passage.py", "floquet/response.py", "floquet/exhibits.py"
R, D, E = "tests/test_response.py", "tests/test_decoupling.py", "tests/test_exhibits.py"
FAMILIES, L = "floquet/families.py", "tests/test_loci.py"
responses = (
    Mutant("inputs without the panel's length", "floquet/collocation.py", "h[:, None, None, None] * F]", "F]", R),
    Mutant("a push moves no rate", "floquet/collocation.py", "out[:, n:, 2 * n :] = rate[..., 2 * n :]",
           "out[:, n:, 2 * n :] = 0.0", R),
    Mutant("a push without the panel's length", "floquet/collocation.py", "2 * n :] = h1 * F", "2 * n :] = F", R),
    Mutant("too few nodes", PASSAGE, "< EPS * math", "< 1e9 * EPS * math", R),
    Mutant("kinks forgotten", PASSAGE, "    if not kinks:\n", "    if True:\n", R),
    Mutant("kinks of the first turn only", PASSAGE, "math.ceil(last / period))", "math.floor(first / period) + 1)", R),
    Mutant("panel by panel without inputs", PASSAGE, "@ x + pushes[..., k, :, :]", "@ x + 0 * pushes[..., k, :, :]", R),
    Mutant("rounding is not passed on", PASSAGE, "E = Phi @ E @ np.swapaxes(Phi, -1, -2) +", "E =", R),
    Mutant("the start of a revolution is exact", RESPONSE, "fine.rounding(x, E)[0]", "fine.rounding(x)[0]", R),
    Mutant("too few samples of high harmonics", RESPONSE, "2 ** math.ceil(", "0 * math.ceil(", R),
    Mutant("I + Φ", RESPONSE, "np.eye(n) - Phi, 1.0", "np.eye(n) + Phi, 1.0", R),
    Mutant("harmonics not doubled", RESPONSE, "c[..., 1:, :] *= 2.0", "c[..., 1:, :] *= 1.0", R),
    Mutant("b₁ with the sign of a₁", RESPONSE, "-first.real, first.imag]", "-first.real, -first.imag]", R),
    Mutant("a₁ is β₁c", RESPONSE, '"beta_1c": -1.0', '"beta_1c": 1.0', R),
    Mutant("no bound on what lies beyond", RESPONSE, "bound + beyond.max(axis=-1)", "0.0 * beyond.max(axis=-1)", R),
    Mutant("bound over a thousand", PASSAGE, "added = ROUNDING * EPS", "added = 1e3 * ROUNDING * EPS", R),
    Mutant("resonance not seen", RESPONSE, "RESONANT = 1e-13", "RESONANT = 1e-33", R),
    Mutant("no word of instability", RESPONSE, "> 1.0 + 1e-9))", "> 1e9))", R),
    Mutant("reduced order without D̃⁻¹ of F̃", RESPONSE, "-np.linalg.solve(D, K), np.linalg.solve(D, F)",
           "-np.linalg.solve(D, K), F", R),
    Mutant("blade seen from b₁", RESPONSE, "- a[..., -1] * np.sin(psi)", "+ a[..., -1] * np.sin(psi)", R),
    Mutant("initial state forgotten", RESPONSE, "ends = fine.states(start[", "ends = fine.states(0.0 * start[", R),
    Mutant("P² of hover +1 %", "floquet/models/hover.py", "1.0 + P2 + 2.0 * swing", "1.0 + 1.01 * P2 + 2.0 * swing", R),
    Mutant("(13b) with the sign of c₀", "floquet/models/hover.py", "M_a - c0 * M_b", "M_a + c0 * M_b", R),
    Mutant("swash plate turned backwards", DECOUPLING, "arctan2(P2 - 1.0, c0)", "arctan2(1.0 - P2, c0)", D),
    Mutant("(16) with one coupling for both", DECOUPLING, "3.0 * coupling * mu2", "coupling * mu2", D),
    Mutant("Λ forgotten", DECOUPLING, "E[..., 0] += _number(", "E[..., 0] += 0.0 * _number(", D),
    Mutant("(19) without 1 + m", DECOUPLING, "/ (2.0 * (1.0 + np.asarray(rotor.offset_mass_ratio))))", "/ 2.0)", D),
    Mutant("(28) without p and q of the air", DECOUPLING, "k_3 * (P2 - 1.0) / C - 1.0", "k_3 * (P2 - 1.0) / C", D),
    Mutant("residual of the promise", DECOUPLING, "got - self.promised).max", "0.0 * (got - self.promised)).max", D),
    Mutant("coupling of what is promised", DECOUPLING, "self.promised == 0.0, np", "self.promised != 0.0, np", D),
    Mutant("disc that precesses the wrong way", FAMILIES, "(2.0 - advancing.imag)", "np.abs(2.0 - advancing.imag)", L),
    Mutant("reduced order turned over", FAMILIES, "A[..., 1, 1] - 1j", "A[..., 1, 1] + 1j", L),
    Mutant("pairs not followed", FAMILIES, "if changed < kept:", "if changed > 2e9 + kept:", L),
    Mutant("tables in any order", EXHIBITS, "KINDS.index(match[1]), int(match[2])", "0, int(match[2])", E),
    Mutant("a fault ends all studies", EXHIBITS, "if isinstance(error, StorageError):", "if error is not None:", E),
    Mutant("captions as HTML", EXHIBITS, "return html.escape(text, quote=True)", "return text", E),
)  # fmt: skip
GRID, GRID_LANES, TILES = "floquet/kernels/grid.py", "floquet/kernels/grid_lanes.py", "floquet/period_map/grid.py"
NODES, TENSOR, C = "floquet/period_map/chebyshev.py", "floquet/period_map/tensor.py", "tests/test_chebyshev.py"
maps = (
    Mutant("D without det Φ", GRID, " + abs(diagonal - product - 1.0)", "", C),
    Mutant("D without τ", GRID, "(2.0 * abs(tau) + tau_error) * tau_error + ", "", C),
    Mutant("first solution a quadrant off", GRID, "step = first - quadrant + 1.0", "step = first - quadrant", C),
    Mutant("ω taken as it is", GRID, "turns = np.floor(away + 0.5)", "turns = np.floor(away + 0.75)", C),
    Mutant("no branch in doubt", GRID, "(abs(away - turns) < DOUBTFUL)", "(abs(away - turns) < 9.0)", C),
    Mutant("bounds without τ between", GRID, "select(D > 0.0, 0.0, tau_error * tau_error)", "0.0", C),
    Mutant("bound of rows signed", GRID, "mixed[:, -1] = summed(np.abs(across)", "mixed[:, -1] = summed(across", C),
    Mutant("nodes are not all of a point at one", GRID, "NONE = 1e-100", "NONE = 0.0", C),
    Mutant("no error of the mean damping", "floquet/period_map/chebyshev.py", "return np.asarray(weights * error)",
           "return np.zeros(len(alpha))", C),
    Mutant("mean damping not compared at spots", "floquet/period_map/chebyshev.py",
           "near &= np.abs(signed[5] - self.direct_alpha)", "near &= 0.0 * np.abs(signed[5] - self.direct_alpha)", C),
    Mutant("maps of equations in pieces", "floquet/period_map/tensor.py", "not axes or _in_pieces(system)",
           "not axes", C),
    Mutant("others along the axis", "floquet/period_map/tensor.py", "if alone and other.size > len(x):",
           "if False:", C),
    Mutant("bounds of hopeless matrices", "floquet/period_map/factors.py", "HOPELESS = 16.0", "HOPELESS = 1e300",
           "tests/test_factors.py"),
    Mutant("discs that touch are apart", "floquet/kernels/quadratics.py", "if somewhere(total > 0.0):", "if False:",
           "tests/test_simple_model.py"),
    Mutant("scales by exp", "floquet/exponents/products.py", "np.ldexp(values.real, power)",
           "values.real * np.exp(scale)[:, None]", "tests/test_factors.py"),
    Mutant("Hill's matrix as it is", "floquet/koopman.py", "np.exp2(np.round(0.5 *", "np.exp2(np.round(0.0 *",
           "tests/test_koopman.py"),
    Mutant("a check of any size", "floquet/koopman.py", "if groups * n > CYCLIC:", "if groups == math.inf:",
           "tests/test_koopman.py"),
    Mutant("a check that says little is silent", "floquet/exponents/evidence.py", "COARSER = 1e5", "COARSER = 1e50",
           "tests/test_koopman.py"),
    Mutant("overflow is the program's fault", "floquet/exponents/evidence.py",
           " | ~np.isfinite(found.exponent_errors)", "", "tests/test_exponents.py"),
    Mutant("sums of any order", GRID, "for column, part in zip(matrix.T, parts, strict=True):",
           "for column, part in ((np.ones(len(matrix)), np.tensordot(matrix, parts, axes=1)),):", C),
    Mutant("compiled bound signed", GRID_LANES, "bound + r[6, j] * abs(e)", "bound + r[6, j] * e", C),
    Mutant("compiled rows' bound signed", GRID_LANES, "factor = e if f < SIGNED else abs(e)", "factor = e", C),
    Mutant("points side by side in any order", GRID_LANES, "and np.all(places[1:] > places[:-1])", "", C),
    Mutant("columns apart written together", GRID_LANES, "together = places[count - 1] - places[0] == count - 1 and",
           "together = ", C),
    Mutant("Φ of the last row of nodes", GRID_LANES, "tile.x[r], tile.x_nodes", "tile.x[0], tile.x_nodes", C),
    Mutant("D as if products were exact", HILL, "+ rounding + defect", "+ rounding", "tests/test_certified.py"),
    Mutant("rows of a design cut wrongly", "floquet/sweep.py", "wanted = (places >= start) & (places < stop)",
           "wanted = (places >= start) & (places <= stop)", "tests/test_sweep.py"),
    Mutant("maps forgotten in studies", "floquet/studyfile.py", "map=compare.map", "map=False", "tests/test_study.py"),
    Mutant("heads alone", "floquet/kernels/pairs.py", "return normal(s, e + f)", "return s, 0.0", PAIRS),
    Mutant("tails of products forgotten", "floquet/kernels/pairs.py", "normal(p, e + (a[0] * b[1] + a[1] * b[0]))",
           "normal(p, e + a[0] * b[1])", PAIRS),
    Mutant("tails of long sums forgotten", "floquet/kernels/pairs.py", "total[1] + (e + (", "total[1] + (0.0 * e + (",
           PAIRS),
    Mutant("a cutout sends all to integers", "floquet/period_map/pairs.py", "FOLDED, 2.0) for v",
           "FOLDED, 2.0) * 0.0 for v", PAIRS),
    Mutant("a fused multiply-add of its own", "floquet/kernels/compiler.py", "return _kept(function, {})",
           'return _kept(function, {"fastmath": True})', PAIRS),
    Mutant("constants rounded", "floquet/period_map/pairs.py", "return head, float(x - Fraction(head))",
           "return head, 0.0", PAIRS),
    Mutant("series of pairs cut short", "floquet/kernels/doubled.py", "ORDER = 44", "ORDER = 28", PAIRS),
    Mutant("errors of pairs not weighed", "floquet/kernels/doubled.py", "SCALE = 2.0**48", "SCALE = 2.0**80", PAIRS),
    Mutant("a panel's centre at its end", "floquet/period_map/pairs.py", "cosine_and_sine(n * (2 * s + 1) * half)",
           "cosine_and_sine(n * (2 * s + 2) * half)", PAIRS),
    Mutant("no tail in the bound", NODES, "bound = bound + _tail(", "bound = bound + 0.0 * _tail(", C),
    Mutant("bound of nodes forgotten", NODES, "bound = self.values[6] + ROUNDING", "bound = ROUNDING", C),
    Mutant("slack forgotten", NODES, "    if slack:\n", "    if False:\n", C),
    Mutant("resolved too early", NODES, "RESOLVED = 5e-15", "RESOLVED = 5e-9", C),
    Mutant("no spots", NODES, "            elif not agrees[i]:\n", "            elif False:\n", C),
    Mutant("no corners", NODES, "zip(*corners, *within_it, strict=True)", "zip(*within_it, strict=True)", C),
    Mutant("turns not looked at", NODES, "            elif not turns[i]:\n", "            elif False:\n", C),
    Mutant("growth not cut", NODES, "            elif rough[i]:\n", "            elif False:\n", C),
    Mutant("ω of the wrong turn", NODES, "omega += 2.0 * math.pi * np.round((first - omega) / (2.0 * math.pi))",
           "pass", C),
    Mutant("nodes at equal distances", NODES, "0.5 * (b - a) * np.cos(math.pi * (np.arange(m) + 0.5) / m)",
           "0.5 * (b - a) * (1.0 - (2.0 * np.arange(m) + 1.0) / m)", C),
    Mutant("cut leaves a value out", TENSOR, "slice(middle, span.stop)", "slice(middle + 1, span.stop)", C),
    Mutant("values not in order", TENSOR, "added = (axis.order[s] * steps",
           "added = (np.sort(axis.order)[s] * steps", C),
    Mutant("any function is straight", TENSOR, "if not off <= AFFINE * EPS * size:", "if False:", C),
    Mutant("first place on axes without nodes", TENSOR, "return np.asarray(value(self._where(), 0))",
           "return np.asarray(value([0 * w for w in self._where()], 0))", C),
    Mutant("tiny grids get nodes", TENSOR, "LEAST = 4096", "LEAST = 40", C),
    Mutant("points next to branch points kept", TILES, "most=TOLERANCE", "most=1.0", C),
    
    Mutant("planes of three axes signed", TILES, "weight[:, -1] = np.abs(e)", "pass", C),
    Mutant("exactness lost in parts", "floquet/periodic/system.py",
           "return replace(self, damping=None, stiffness=None, equation=equation, blade=None, blades=())",
           "D, K = equation.whole()\n"
           "                return replace(self, damping=D, stiffness=K, equation=None, blade=None, blades=())", C),
)  # fmt: skip
PANELS, EIGEN, JOINED, SWEEPS = (f"floquet/kernels/{name}.py" for name in ("factors", "eigen", "products", "sweeps"))
SERIES, COLLOCATED = "floquet/period_map/series.py", "floquet/period_map/collocated.py"
PRODUCTS, CLUSTERS = "floquet/exponents/products.py", "floquet/exponents/clusters.py"
SEVERAL, VALUES = "tests/test_factors.py", "tests/test_eigen.py"
states = (
    Mutant("sine turned the other way", PANELS,
           "out[s + 1] = cosine * values[s + 1] - sine * values[s]",
           "out[s + 1] = cosine * values[s + 1] + sine * values[s]", SEVERAL),
    Mutant("a term of the waves forgotten", PANELS,
           "a1 += w * y[j - 4, 1]",
           "a1 += w * y[j - 3, 1]", SEVERAL),
    Mutant("last order left out of the sums", PANELS,
           "for k in range(order, 0, -2):\n            v, w = power[k - 1], power[k]",
           "for k in range(order - 2, 0, -2):\n            v, w = power[k - 1], power[k]", SEVERAL),
    Mutant("truncation left out of a panel's bound", PANELS,
           "errors_[b, p] = truncation + (rounding",
           "errors_[b, p] = 0.0 * truncation + (rounding", SEVERAL),
    Mutant("rounding left out of a panel's bound", PANELS,
           "rounding = (1.0 + 2.0 / n) * EPS",
           "rounding = 0.01 * EPS", SEVERAL),
    Mutant("growth of the inverse left out of a panel's bound", PANELS,
           "+ norm(inverse, n, room)) * back",
           "+ norm(inverse, n, room))", SEVERAL),
    Mutant("every block turned like the first", PANELS,
           "own = 0 if shared else b",
           "own = 0", SEVERAL),
    Mutant("panels of one piece", SERIES,
           "np.repeat(np.arange(len(counts)), counts)",
           "0 * np.repeat(np.arange(len(counts)), counts)", SEVERAL),
    Mutant("probe too hopeful, and nobody looks", SERIES,
           "times = np.where(excess <= 1.0, 1.0,",
           "times = np.where(excess <= 1e30, 1.0,", SEVERAL),
    Mutant("rescaled one way only", SERIES,
           "values *= s[layout.column] / s[layout.row]",
           "values *= s[layout.column]", SEVERAL),
    Mutant("mean trace of another sign", SERIES,
           "* (-1.0 if system.second_order else 1.0)",
           "* 1.0", SEVERAL),
    Mutant("collocation's difference left out", COLLOCATED,
           "_norm(difference) + ROUNDING",
           "0.0 * _norm(difference) + ROUNDING", f"tests/test_exponents.py {SEVERAL}"),
    Mutant("collocation scaled the other way", COLLOCATED,
           "(s[..., None, :] / s[..., None])",
           "(s[..., None] / s[..., None, :])", SEVERAL),
    Mutant("what came first counts", FACTOR_BOUNDS,
           "owner[group.cases] = k",
           "owner[group.cases] = np.minimum(owner[group.cases], k)", SEVERAL),
    Mutant("twist left out in lanes", JOINED,
           "B[i, j] = twist[i] * now[i, j]",
           "B[i, j] = now[i, j]", SEVERAL),
    Mutant("twist left out of the bounds", JOINED,
           "Y[i, j] * twist[j]",
           "Y[i, j]", VALUES),
    Mutant("errors of one factor counted", JOINED,
           "for k in range(len(F) - 1, -1, -1):\n        row_lengths",
           "for k in range(len(F) - 1, len(F) - 2, -1):\n        row_lengths", VALUES),
    Mutant("residuals not counted", JOINED,
           "G[i, j] = x[i] * (size[j] + more)",
           "G[i, j] = 0.01 * x[i] * (size[j] + more)", VALUES),
    Mutant("discs that meet are taken for clear", JOINED,
           "clear = clear & (x * x + y * y > reach * reach)",
           "clear = clear & (x * x + y * y > -1.0)", VALUES),
    Mutant("pairs not measured together", EIGEN,
           "pair = im[i] > 0.0\n",
           "pair = im[i] > 1e300\n", VALUES),
    Mutant("shifts never unusual", EIGEN,
           "UNUSUAL = 10",
           "UNUSUAL = 10000", VALUES),
    Mutant("blocks cut too early", EIGEN,
           "EPS * beside, 0.0",
           "1e-6 * beside, 0.0", VALUES),
    Mutant("steps in all lanes", EIGEN,
           "active = (low <= k) & (high > k)",
           "active = high > k - 100.0", VALUES),
    Mutant("left vectors of the neighbour", EIGEN,
           "re[j] - re[i], im[j] - im[i], floor)\n    for k in range(1, n):\n"
           "        a, b, c, d, p, q, s = x[k - 1], y[k - 1], x[k], y[k], turn[0, k], turn[1, k], "
           "turn[2, k]\n        x[k - 1], y[k - 1] = p * a + q * b",
           "re[j] - re[i], im[j] + im[i], floor)\n    for k in range(1, n):\n"
           "        a, b, c, d, p, q, s = x[k - 1], y[k - 1], x[k], y[k], turn[0, k], turn[1, k], "
           "turn[2, k]\n        x[k - 1], y[k - 1] = p * a + q * b", VALUES),
    Mutant("exponents of two forgotten", JOINED,
           "exponent[lane] += power",
           "exponent[lane] += 0.0 * power", VALUES),
    Mutant("noise of products left out", PRODUCTS,
           "return (1.0 + 6.0 / n) * EPS",
           "return 0.05 * EPS", VALUES),
    Mutant("discs of NumPy that meet are clear", PRODUCTS,
           "clear = ((distance > reach) |",
           "clear = ((distance > 0.0 * reach) |", VALUES),
    Mutant("bounds of a row without the rest of it", PRODUCTS,
           "stretch = np.maximum((rows - own) / (SHARE * own), 1.0)",
           "stretch = 0.0 * rows", VALUES),
    Mutant("clusters without their projectors", CLUSTERS,
           "bound = 2.0 * p * error",
           "bound = 2.0 * error", VALUES),
    Mutant("clusters without Henrici", CLUSTERS,
           "return float((2 * m - 1) * d)",
           "return float(bound)", VALUES),
    Mutant("clusters though others are near", CLUSTERS,
           "<= reach + bound:",
           "<= -1.0:", VALUES),
    Mutant("too few sweeps", FACTOR_BOUNDS,
           "SWEEPS = 12",
           "SWEEPS = 1", SEVERAL),
    Mutant("projectors taken for orthogonal", FACTOR_BOUNDS,
           "own = oblique[..., c] * (errors[some]",
           "own = 1.0 * (errors[some]", f"tests/test_exponents.py {SEVERAL}"),
    Mutant("sweeps of lanes without the twist", SWEEPS,
           "twisted(twist, now, n, now)\n            for k in range(panels):",
           "twisted(0.0 * twist + 1.0, now, n, now)\n            for k in range(panels):", SEVERAL),
    Mutant("reflections of one side", SWEEPS,
           "Q[i, j] -= total * v[j]",
           "Q[i, j] -= 0.5 * total * v[j]", SEVERAL),
    Mutant("shares of blades not rounded to halves", MULTIBLADE,
           "np.round(2.0 * part.coefficients[:, 0]) / 2.0",
           "np.round(part.coefficients[:, 0])", MODELS),
    Mutant("what repeats with β_d left out", MULTIBLADE,
           "return N if N % 2 else N // 2",
           "return N", MODELS),
)  # fmt: skip
FAULTS: tuple[Mutant, ...] = (
    *atlas,
    *coefficients,
    *structure,
    *physics,
    *branch,
    *bounds,
    *pieces,
    *pairing,
    *tapes,
    *roots,
    *errata,
    *responses,
    *storage,
    *maps,
    *states,
)
