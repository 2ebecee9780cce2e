"""How stable a rotor is in forward flight, exactly, and where the tip-path-plane (TPP) model stops being valid.

A blade's flapping in forward flight is a linear differential equation with periodic coefficients.  Floquet's theorem
gives its exponents exactly; design practice replaces it by the constant-coefficient tip-path-plane model (R. T. N.
Chen, *Effects of Primary Rotor Parameters on Flapping Dynamics*, NASA TP-1431, 1979).  This package computes both,
compares them mode by mode and finds the advance ratio from which the simple model no longer holds.  Dynamic inflow is
not in the model.

Symbols.  Time is azimuth ψ = Ωt, so rates are per rev: in units of the rotor speed Ω, per radian of azimuth.

=======  ======================  =====================================================================================
symbol   name                    meaning
=======  ======================  =====================================================================================
ψ        ``psi``                 azimuth, 0 downwind, positive with rotation; blade i is at ψ + 2π(i − 1)/N
β        ``beta``                flap angle, positive up [rad]
γ        ``lock_number``         ρ a c R⁴ / I_β
ε        ``hinge_offset``        e/R
κ        ``hinge_stiffness``     K_β/(I_β Ω²)
K₁       ``pitch_flap_coupling`` tan δ₃; positive reduces pitch for flap up
m        ``offset_mass_ratio``   e M_β/I_β; 1.5 ε unless given
s        ``static_moment_ratio`` R M_β/I_β
μ        ``advance_ratio``       V cos α/(ΩR)
N        ``blades``              number of blades
ν_β      ``flap_frequency``      √(1 + κ + m), structural only [per rev]; P² adds the pitch-flap coupling's spring
a₀ a₁ b₁                         β = a₀ − a₁ cos ψ − b₁ sin ψ, so a₁ = −β₁c and b₁ = −β₁s
Λ        ``multipliers``         eigenvalues of the transition matrix over one period
η        ``exponents``           σ + iρ [per rev]: Λ = exp(η T); σ < 0 is stable
σ        real part of η          damping; the damping ratio is ζ = −σ/|η|, nan for a pair of reals
ρ        ``rotation_number``     mean rate at which a real solution turns in the phase plane: Im η without ambiguity
lock     ``lock``                ρ inside a lock (0, ½, 1, … per rev: two exponents share one frequency), nan outside
=======  ======================  =====================================================================================

Modes of the rotor in the non-rotating frame, with η = σ ± iρ of one blade: ``regressing`` σ ± i(ρ − 1), ``coning``
σ ± iρ, ``advancing`` σ ± i(ρ + 1), and for even N ``differential``.  A mode has two exponents: a locked one has
two reals.

Inputs of a rotor (controls, inflow, body motion) have names and units in :mod:`floquet.models.inputs`.

Reading order, which is the order in which data flow (nothing imports against it)::

    errors, environment, plain, tomlfile, rotorfile, rotor → verdict → periodic → models → kernels → collocation
                            → period_map → passage → koopman → certify → exponents → modes → comparison
                            → sensitivity → tracking
                            → validity → response → decoupling
                            → sweep → families → chunks → store → studyfile → cluster → study → export
                            → query → plot → report → judgement → exhibits → cli

Names below are loaded when they are first used: ``import floquet`` itself loads no NumPy, SciPy, h5py or matplotlib.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from floquet.comparison import compare
    from floquet.decoupling import control_mixing, rate_feedback
    from floquet.exponents import stability
    from floquet.models import averaged, flapping, hover_modes, multiblade, teetering, tip_path_plane
    from floquet.periodic import PeriodicMatrix, PeriodicSystem
    from floquet.query import open_database
    from floquet.response import periodic_response, reduced_order, steady_state, step_response
    from floquet.rotor import Hub, Rotor, load_rotor
    from floquet.sensitivity import sensitivities
    from floquet.sweep import sweep
    from floquet.tracking import track
    from floquet.validity import (
        boundaries,
        instability_onset,
        lock_windows,
        transitions,
        validity_intervals,
        validity_limit,
    )

__version__ = "0.1.0"

__all__ = [
    "Rotor", "Hub", "load_rotor",
    "PeriodicSystem", "PeriodicMatrix",
    "flapping", "teetering", "multiblade", "tip_path_plane", "averaged", "hover_modes",
    "stability", "compare", "validity_limit", "validity_intervals", "lock_windows", "instability_onset",
    "transitions", "boundaries",
    "sensitivities", "track",
    "steady_state", "periodic_response", "step_response", "reduced_order", "control_mixing", "rate_feedback",
    "sweep", "open_database",
]  # fmt: skip

_HOME = {
    "Rotor": "rotor", "Hub": "rotor", "load_rotor": "rotor",
    "PeriodicSystem": "periodic", "PeriodicMatrix": "periodic",
    "flapping": "models", "teetering": "models", "multiblade": "models", "tip_path_plane": "models",
    "averaged": "models", "hover_modes": "models",
    "stability": "exponents",
    "compare": "comparison",
    "validity_limit": "validity", "validity_intervals": "validity", "lock_windows": "validity",
    "instability_onset": "validity", "transitions": "validity", "boundaries": "validity",
    "sensitivities": "sensitivity", "track": "tracking",
    "steady_state": "response", "periodic_response": "response", "step_response": "response",
    "reduced_order": "response",
    "control_mixing": "decoupling", "rate_feedback": "decoupling",
    "sweep": "sweep",
    "open_database": "query",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import the home of a public name at its first use (PEP 562) and keep the name."""
    if name not in _HOME:
        raise AttributeError(f"module 'floquet' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"floquet.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Package(ModuleType):
    """``sweep`` is a function that lives in a room of the same name: importing the room must not hide the function."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "sweep" and isinstance(value, ModuleType):
            value = value.sweep
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
