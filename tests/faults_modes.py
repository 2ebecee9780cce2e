"""The faults that ``make mutants`` injects into rates of exponents, tracks of modes and dissimilar blades."""

from __future__ import annotations

from tests.faults import Mutant

__all__ = ["MODES"]

RATES, MADE = "floquet/sensitivity.py", "tests/test_sensitivity.py"
sensitivity = (
    Mutant("rates across jumps", RATES, "lost = moved.reshape", "lost = False & moved.reshape", f"{MADE} -k jump"),
    Mutant("pieces of no length jump", RATES, "period - apart) < JUMP",
           "period - apart) < 2.0 * np.eye(begins.shape[-1]) - 1.0", f"{MADE} -k jump"),
    Mutant("rates of τ without the damping's", RATES,
           "tau = total(k * M[..., 0, 1] + 0.5 * d", "tau = total(k * M[..., 0, 1] + 0.0 * d", MADE),
    Mutant("a pair's rates change places", RATES, "np.where(phi_21 < 0.0, 1.0j, -1.0j)", "1.0j", MADE),
    Mutant("rates of odd locks change places", RATES, "np.where(tau > 0.0, 1.0, -1.0)", "1.0", MADE),
    Mutant("m does not follow ε", RATES,
           'moves["hinge_offset"]["offset_mass_ratio"] = rotor.static_moment_ratio', "pass", MADE),
    Mutant("37 names listed", RATES, "FEW = 12", "FEW = 99", MADE),
    Mutant("a blade's parameter not found", RATES, "if own:", "if False:", MADE),
    Mutant("M is not carried to the nodes", RATES,
           "part(N) @ M[..., None, :, :] @ part(_inverse(N))", "M[..., None, :, :] + 0.0 * part(N)", MADE),
    Mutant("rates without the twist", RATES,
           "np.diag(np.ones(n) if system.twist is None else system.twist)", "np.eye(n)", MADE),
    Mutant("left modes taken for right ones", RATES,
           "left, w = np.linalg.inv(right),", "left, w = np.conj(np.swapaxes(right, -1, -2)),", MADE),
    Mutant("modes that meet are trusted", RATES, "norm / gap)", "0.0 / gap)", MADE),
    Mutant("the error of D forgotten", RATES, "+ np.abs(part) * relative +", "+", MADE),
    Mutant("constants of the plane have rates", RATES, "constant(x[i] - y)", "constant(x[i])", MADE),
    Mutant("a cutout at the hinge counts", "floquet/models/flapping.py",
           "np.real(cutout) > np.real(self.offset)", "np.real(cutout) >= np.real(self.offset)", MADE),
)  # fmt: skip
TRACKS, FOLLOWED = "floquet/tracking.py", "tests/test_tracking.py"
tracking = (
    Mutant("C without the left modes", TRACKS,
           "(a.left @ b.right) * (b.left @ a.right).T", "(a.right.T @ b.right) * (b.right.T @ a.right).T", FOLLOWED),
    Mutant("modes change places in locks", TRACKS,
           "swap = C[i, x] + C[j, y] < C[i, y] + C[j, x]", "swap = C[i, x] + C[j, y] > C[i, y] + C[j, x]", FOLLOWED),
    Mutant("the second of two locked modes grows more", TRACKS,
           "swap = step.b.exponents[x].real < step.b.exponents[y].real",
           "swap = step.b.exponents[x].real > step.b.exponents[y].real", FOLLOWED),
    Mutant("nobody looks ahead", TRACKS, "AHEAD = 0.3", "AHEAD = 0.0", FOLLOWED),
    Mutant("narrow veering taken for crossing", TRACKS, "TOUCH = 1e-7", "TOUCH = 1e-5", FOLLOWED),
    Mutant("frequencies not carried on", TRACKS,
           "np.round((last.imag - eta.imag) / step.b.strip)", "0.0 * last.imag", FOLLOWED),
    Mutant("β_d counted with the others", TRACKS, "own + 0.5j * blades, -0.5 * blades", "own, 0.0", FOLLOWED),
    Mutant("what is not clear is certain", TRACKS,
           "certain[[column[i] for i in (*step.unclear, *step.a.met)]] = False", "pass", FOLLOWED),
    Mutant("steps back are steps forth", TRACKS, "np.argsort(to), edges", "to, edges", FOLLOWED),
    Mutant("locks end where they begin", TRACKS, "if entering == upwards else", "if entering else", FOLLOWED),
    Mutant("tracks without the twist", TRACKS,
           "matrix if system.twist is None else system.twist[:, None] * matrix", "matrix", FOLLOWED),
    Mutant("whirls of the plane reversed", "floquet/modes.py",
           "forward = omega * whirl < 0 and", "forward = omega * whirl > 0 and", f"{FOLLOWED} tests/test_modes.py"),
    Mutant("rounding decides between equal shares", "floquet/modes.py",
           "TIE = 1e-6", "TIE = 0.0", "tests/test_modes.py"),
    Mutant("negative frequencies first", "floquet/modes.py",
           "omega + one[1] < 0.0)", "omega + one[1] > 0.0)", "tests/test_modes.py"),
    Mutant("modes in order of frequency", "floquet/modes.py",
           "key=lambda m: (*_rank(called[m]), *_within(complex(lifted[m])), m)", "key=lambda m: m",
           "tests/test_modes.py"),
    Mutant("order of modes the other way", TRACKS, "np.argsort(found.order)[", "found.order[", FOLLOWED),
)  # fmt: skip
MULTIBLADE, PLANE, VECTORS = "floquet/models/multiblade.py", "floquet/models/tip_path_plane.py", "floquet/modes.py"
EACH = "tests/test_dissimilar.py"
dissimilar = (
    Mutant("blades are identical if two are", MULTIBLADE,
           "return all(_same(b, blades[0]) for b in blades)", "return _same(blades[-1], blades[0])", EACH),
    Mutant("blades turn backwards", MULTIBLADE,
           "azimuths = [TWO_PI * i / N for i in range(N)]\n    models",
           "azimuths = [-TWO_PI * i / N for i in range(N)]\n    models", EACH),
    Mutant("all blades forced as the first", MULTIBLADE,
           "for b, a in zip(models, azimuths, strict=True) if (f := b.forcing)",
           "for b, a in zip(models, azimuths, strict=True) if (f := models[0].forcing)", EACH),
    Mutant("dissimilar blades with the symmetry of one", MULTIBLADE,
           "blade=models[0] if similar else None", "blade=models[0]", EACH),
    Mutant("any number of blades given", MULTIBLADE, "if b.blades not in (N, Rotor.blades)", "if False", EACH),
    Mutant("averages keep quiet", PLANE,
           "if len(blades) > 2 and not identical(blades)", "if len(blades) > 9 and not identical(blades)", EACH),
    Mutant("averages always complain", PLANE,
           "if len(blades) > 2 and not identical(blades)", "if len(blades) > 1", EACH),
    Mutant("T' left out of the blades' rates", VECTORS,
           "np.block([[t, np.zeros((N, N))], [slope, t]])", "np.block([[t, np.zeros((N, N))], [0 * slope, t]])", EACH),
    Mutant("modes called after the blade they are not on", VECTORS,
           "np.argmax(_shares(motion), axis=1)", "np.argmin(_shares(motion), axis=1)", EACH),
    Mutant("rates of blades in another order", RATES,
           "order = np.reshape([paired(a, b, 1.0) for a, b in pairs], own.shape)",
           "order = np.reshape([np.arange(len(b)) for a, b in pairs], own.shape)", EACH),
    Mutant("events of every blade in the first columns", TRACKS,
           "(event.modes[0] + 2 * i, event.modes[1] + 2 * i)", "(event.modes[0], event.modes[1])", EACH),
)  # fmt: skip
MODES: tuple[Mutant, ...] = (*sensitivity, *tracking, *dissimilar)
