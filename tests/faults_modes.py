"""The faults that ``make mutants`` injects into rates of exponents and the tracking of modes."""

from __future__ import annotations

from tests.faults import Mutant

__all__ = ["MODES"]

RATES, MADE = "floquet/sensitivity.py", "tests/test_sensitivity.py"
sensitivity = (
    Mutant("rates of τ without the damping's", RATES,
           "tau = total(k * M[..., 0, 1] + 0.5 * d", "tau = total(k * M[..., 0, 1] + 0.0 * d", MADE),
    Mutant("a pair's rates change places", RATES, "np.where(phi_21 < 0.0, 1.0j, -1.0j)", "1.0j", MADE),
    Mutant("rates of odd locks change places", RATES, "np.where(tau > 0.0, 1.0, -1.0)", "1.0", MADE),
    Mutant("m does not follow ε", RATES,
           'moves["hinge_offset"]["offset_mass_ratio"] = rotor.static_moment_ratio', "pass", MADE),
    Mutant("M is not carried to the nodes", RATES,
           "part(N) @ M[..., None, :, :] @ part(_inverse(N))", "M[..., None, :, :] + 0.0 * part(N)", MADE),
    Mutant("rates without the twist", RATES,
           "np.diag(np.ones(n) if system.twist is None else system.twist)", "np.eye(n)", MADE),
    Mutant("left modes taken for right ones", RATES,
           "left, w = np.linalg.inv(right),", "left, w = np.conj(np.swapaxes(right, -1, -2)),", MADE),
    Mutant("modes that meet are trusted", RATES, "norm / gap)", "0.0 / gap)", MADE),
    Mutant("the error of D forgotten", RATES, "+ np.abs(part) * relative +", "+", MADE),
    Mutant("a cutout at the hinge counts", "floquet/models/flapping.py",
           "np.real(cutout) > np.real(self.offset)", "np.real(cutout) >= np.real(self.offset)", MADE),
)  # fmt: skip
MODES: tuple[Mutant, ...] = (*sensitivity,)
