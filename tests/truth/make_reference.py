"""Write data/reference/exponents.json: exponents of random, near-branch, reversed-flow and dissimilar rotors.

    python -m tests.truth.make_reference [FILE]        about two minutes; the same bytes every time

Parameters are drawn from one seeded generator and stored as the shortest decimal that gives back the double; the double
is the parameter, exactly. Each exponent is computed twice by ``taylor``, with different orders and steps, at fifty
digits, and is given to thirty; the program fails when two results differ by more than 1e-27, or when SciPy's DOP853
disagrees by more than 1e-9 on the first cases of each set.

Sets: ``random`` (all parameters), ``near_branch`` (μ at 1e-4 … 1e-9 from a root of the discriminant, where the
exponents go as the square root of the distance), ``reversed_flow`` (exact offset, pieces between the kinks),
``dissimilar`` (three blades, one or more of another kind: uncoupled in the rotating frame, so that the rotor's
exponents are the blades').
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpmath import mp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.truth import blade_element, closed_forms, problems, taylor

SEED = 1431
TARGET = Path(__file__).resolve().parents[2] / "data" / "reference" / "exponents.json"
DIGITS_GIVEN = 30
AGREEMENT = mp.mpf("1e-27")
RUNS = ({"order": 56, "steps": 30}, {"order": 48, "steps": 42})
"""Two resolutions whose truncation errors have nothing in common."""

Case = dict[str, Any]
NAMES = {
    "lock_number": "gamma",
    "hinge_offset": "eps",
    "hinge_stiffness": "kappa",
    "pitch_flap_coupling": "K1",
    "offset_mass_ratio": "m",
    "flap_damping": "flap_damping",
    "advance_ratio": "mu",
}
"""Names in the file, names of ``problems.flapping``."""


def main(path: Path = TARGET) -> None:
    """Draw, compute, check, write."""
    mp.dps = taylor.DIGITS
    rng = np.random.default_rng(SEED)
    cases = [case | solve(case) for case in drawn(rng)]
    for case in cases:
        if case["checked_by_dop853"]:
            say(f"{case['id']}: DOP853 {check(case):.1e}")
    cases += [dissimilar(f"dissimilar-{i}", blades) for i, blades in enumerate(mixed_rotors(rng))]
    head = json.dumps(META, indent=1, ensure_ascii=False)
    lines = ",\n".join(json.dumps(case) for case in cases)
    path.write_text(f'{{"meta": {head},\n"cases": [\n{lines}\n]}}\n', encoding="utf-8")
    say(f"{len(cases)} cases in {path}")


def drawn(rng: np.random.Generator) -> Iterator[Case]:
    """The parameters of every set of single blades."""
    for i in range(150):
        parameters = random_rotor(rng, mu_max=1.5, uniform_mass=i % 3 == 2, damped=i >= 130)
        yield case_of("random", i, parameters, exact_offset=i % 2 == 1)
    yield from near_branch_points(rng, 30)
    for i in range(20):
        parameters = random_rotor(rng, mu_max=2.5, eps_max=0.15 if i % 4 else 0.0, uniform_mass=i % 2 == 1)
        yield case_of("reversed_flow", i, parameters, exact_offset=True, reversed_flow=True)


def random_rotor(
    rng: np.random.Generator,
    *,
    mu_max: float,
    eps_max: float = 0.2,
    uniform_mass: bool = False,
    damped: bool = False,
) -> dict[str, float]:
    """γ 2 … 24, ε 0 … eps_max, κ 0 … 0.5, K₁ −0.5 … 0.5, μ 0 … mu_max, to six decimals; m = 1.5 ε or 1.5 ε/(1 − ε)."""
    low, high = [2, 0, 0, -0.5, 0, 0], [24, eps_max, 0.5, 0.5, 0.2 if damped else 0, mu_max]
    gamma, eps, kappa, K1, damping, mu = (round(float(x), 6) for x in rng.uniform(low, high))
    m = 1.5 * eps / (1 - eps) if uniform_mass else 1.5 * eps
    return dict(zip(NAMES, (gamma, eps, kappa, K1, m, damping, mu), strict=True))


def near_branch_points(rng: np.random.Generator, count: int) -> Iterator[Case]:
    """Rotors whose discriminant changes sign at some μ, moved there and then away by 1e-4 … 1e-9, to either side."""
    found = 0
    while found < count:
        parameters = random_rotor(rng, mu_max=1.0)
        root = branch_point(parameters)
        if root is None:
            continue
        distance = 10.0 ** -(4 + found % 6) * (1 if found % 2 else -1) * (-1) ** (found // 6)
        parameters["advance_ratio"] = root + distance
        yield case_of("near_branch", found, parameters) | {"distance": distance}
        found += 1


def branch_point(parameters: dict[str, float]) -> float | None:
    """A root of the discriminant in 0.1 < μ < 1.4, to the nearest double or two; None without a change of sign."""

    def discriminant(mu: float) -> float:
        with mp.workdps(25):
            pieces = problems.flapping(**arguments(parameters | {"advance_ratio": mu}))
            return float(taylor.scalar_exponents(pieces, order=22, steps=24).discriminant)

    grid = np.linspace(0.1, 1.4, 7)
    values = [discriminant(float(mu)) for mu in grid]
    for a, b, left, right in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
        if left * right < 0:
            return float(brentq(discriminant, a, b, xtol=1e-15, rtol=1e-14))
    return None


def case_of(name: str, index: int, parameters: dict[str, float], **options: bool) -> Case:
    """A row of the file, without its results."""
    defaults = {"exact_offset": False, "reversed_flow": False}
    case = {"id": f"{name}-{index}", "set": name, "parameters": parameters, "options": defaults | options}
    return case | {"period": "2pi", "checked_by_dop853": index < 4}


def arguments(parameters: dict[str, float]) -> dict[str, float]:
    """The keywords of problems.flapping and of Blade."""
    return {NAMES[name]: value for name, value in parameters.items()}


def solve(case: Case) -> Case:
    """Exponents, rotation number and lock, from two resolutions that agree."""
    pieces = problems.flapping(**arguments(case["parameters"]), **case["options"])
    fine, other = (taylor.scalar_exponents(pieces, **run) for run in RUNS)
    differences = [abs(a - b) for a, b in zip(fine.exponents, other.exponents, strict=True)]
    difference = max([*differences, abs(fine.rotation_number - other.rotation_number)])
    if difference > AGREEMENT:
        raise ArithmeticError(f"{case['id']}: two resolutions differ by {mp.nstr(difference, 3)}; raise the order")
    say(f"{case['id']}: agreement {mp.nstr(difference, 2)}")
    return {
        "exponents": [[digits(eta.real), digits(eta.imag)] for eta in fine.exponents],
        "rotation_number": digits(fine.rotation_number),
        "lock": float(mp.nint(2 * fine.rotation_number) / 2) if fine.locked else None,
        "half_trace": digits(fine.half_trace),
        "discriminant": digits(fine.discriminant),
    }


def check(case: Case) -> float:
    """Difference of trace and determinant of Φ from DOP853, relative to the larger multiplier; fails at 1e-9."""
    motion = equation_of_motion(case)
    pieces = problems.flapping(**arguments(case["parameters"]), **case["options"])
    phi = np.eye(2)
    for piece in pieces:  # a kink inside a step would cost DOP853 its order
        span = (float(piece.start), float(piece.stop))
        columns = [solve_ivp(motion, span, y, method="DOP853", rtol=1e-12, atol=1e-14) for y in phi.T]
        phi = np.array([solution.y[:, -1] for solution in columns]).T
    exponents = np.array([complex(float(re), float(im)) for re, im in case["exponents"]])
    multipliers = np.exp(2 * np.pi * exponents)
    size = np.abs(multipliers).max()
    trace, determinant = multipliers.sum() - np.trace(phi), np.prod(multipliers) - np.linalg.det(phi)
    error = float(max(abs(trace) / size, abs(determinant) / size**2))
    if error > 1e-9:
        raise ArithmeticError(f"{case['id']}: DOP853's trace or determinant differs by {error:.1e}")
    return error


def equation_of_motion(case: Case) -> Callable[[float, Any], list[float]]:
    """(β', β'') in doubles: by quadrature along the blade for the exact offset, else by the truncated polynomials."""
    values, options = arguments(case["parameters"]), case["options"]
    if options["exact_offset"]:
        blade = blade_element.Blade(**values, reversed_flow=options["reversed_flow"])
        return lambda psi, y: [y[1], blade_element.hinge_moment(blade, psi, beta=y[0], rate=y[1])]
    mechanical = values.pop("flap_damping")
    c = closed_forms.truncated(**values)
    return lambda psi, y: [
        y[1],
        -(mechanical + closed_forms.blade_damping(c, psi)) * y[1] - closed_forms.blade_stiffness(c, psi) * y[0],
    ]


def mixed_rotors(rng: np.random.Generator) -> Iterator[list[dict[str, float]]]:
    """Three blades at one advance ratio: one of another Lock number, spring or coupling, then all three different."""
    for change in ("lock_number", "hinge_stiffness", "pitch_flap_coupling"):
        usual, other = random_rotor(rng, mu_max=0.6), random_rotor(rng, mu_max=0.6)
        yield [usual | {change: other[change]}, usual, usual]
    blades = [random_rotor(rng, mu_max=0.6) for _ in range(3)]
    yield [blade | {"advance_ratio": blades[0]["advance_ratio"]} for blade in blades]


def dissimilar(name: str, blades: list[dict[str, float]]) -> Case:
    """A rotor of uncoupled blades: the union of their exponents, modulo i."""
    options = {"exact_offset": False, "reversed_flow": False}
    each = [solve({"id": f"{name}.{i}", "parameters": blade, "options": options}) for i, blade in enumerate(blades)]
    exponents = [eta for blade in each for eta in blade["exponents"]]
    head: Case = {"id": name, "set": "dissimilar", "blades": blades, "options": options, "period": "2pi"}
    return head | {"exponents": exponents, "rotation_numbers": [blade["rotation_number"] for blade in each]}


def digits(value: taylor.Mpf) -> str:
    """Thirty significant digits, or every digit of a short number."""
    return str(mp.nstr(value, DIGITS_GIVEN, strip_zeros=True))


def say(text: str) -> None:
    """Progress, to stderr."""
    print(text, file=sys.stderr, flush=True)


META = {
    "title": "Floquet exponents of flapping blades, computed here",
    "program": "python -m tests.truth.make_reference",
    "seed": SEED,
    "equation": "beta'' + d(psi) beta' + k(psi) beta = 0; time is azimuth, so exponents are per rev, in units of Omega",
    "parameters": "the double nearest to each number is the exact parameter; offset_mass_ratio is always given",
    "options": "exact_offset: integrals not truncated at eps^2; reversed_flow: U_T|U_T| for U_T^2, exact in eps",
    "exponents": "[alpha + i rho, alpha - i rho]; in a lock [sigma_1 + i rho, sigma_2 + i rho], sigma_1 >= sigma_2; "
    "rho, the rotation number, has no integer or sign ambiguity; dissimilar blades have as many pairs, modulo i",
    "half_trace": "tau = tr(Phi) exp(-alpha T) / 2; |tau| > 1 is a lock",
    "discriminant": "(((Phi11 - Phi22)/2)^2 + Phi12 Phi21) exp(-2 alpha T) = tau^2 - 1",
    "distance": "of the advance ratio from the root of the discriminant (near_branch)",
    "how": "computed here: Taylor series in 50-digit arithmetic, order 56 with 30 steps a revolution against order 48 "
    "with 42 steps, which agree to 1e-27 or better; cases marked checked_by_dop853 also agree with SciPy's DOP853 in "
    "trace and determinant to 1e-9, with exact_offset on a quadrature along the blade at every evaluation",
    "digits": DIGITS_GIVEN,
}

if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
