"""Families of rotors and their roots: what figures 3 to 12 of NASA TP-1431 plot.

In a :class:`Family` one parameter and the Lock number vary, and the other parameters of figures 3 to 12 are zero::

    hover_roots, hover_records        the tip-path plane at hover, eqs. (9) and (10)
    reduced_roots, reduced_records    the same of reduced order, eq. (11), beside it
    forward_rows, forward_records     in forward flight, exact and tip-path plane, by μ

At hover coning is decoupled, and a₁ and b₁ are one complex coordinate a₁ + i b₁ = z, with (9)'s P and c₀ and eq. (11)::

    z'' + (c₀ − 2i) z' + (P² − 1 − i c₀) z = 0      η = −c₀/2 + i (1 ± √(P² − c₀²/4))       + advancing, − regressing
    (c₀ − 2i) z' + (P² − 1 − i c₀) z = 0            η = −(P² − 1 − i c₀)/(c₀ − 2i)

Of each pair of exponents this is the one whose sign tells the direction: with Im η > 0 the disc precesses with the
rotation, with Im η < 0 against it.  They change over at c₀² = 4 (P² − 1), of reduced order at c₀² = 2 (P² − 1).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .comparison import Rule
from .models import hover_modes, tip_path_plane
from .models.hover import HoverMode
from .response import reduced_order
from .rotor import Rotor
from .sweep import sweep

__all__ = [
    "LOCK_NUMBERS", "MODES", "Carpet", "Family", "carpets", "forward_records", "forward_rows", "hover_records",
    "hover_roots", "reduced_records", "reduced_roots",
]  # fmt: skip

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Roots = dict[str, Complex]
Rows = Mapping[str, NDArray[Any]]

LOCK_NUMBERS = tuple(np.arange(2.0, 17.0, 2.0).tolist())
MODES = ("regressing", "coning", "advancing")
FINE = 241  # points of a curve
HALVINGS = 50
PARAMETERS = ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling")


@dataclass(frozen=True, kw_only=True)
class Family:
    """Values of one parameter of the rotor, by its name in :class:`Rotor`, times Lock numbers."""

    parameter: str
    values: tuple[float, ...]
    lock_numbers: tuple[float, ...] = LOCK_NUMBERS

    def rotors(self, values: ArrayLike | None = None, lock_numbers: ArrayLike | None = None) -> Rotor:
        """All of them as one Rotor of shape (values, Lock numbers); others than its own where some are given."""
        down = np.asarray(self.values if values is None else values, float)[:, None]
        across = np.asarray(self.lock_numbers if lock_numbers is None else lock_numbers, float)
        varied: dict[str, Any] = {"lock_number": across, self.parameter: down}
        return Rotor(blades=3, **varied).broadcast()


@dataclass(frozen=True, kw_only=True, eq=False)
class Carpet:
    """Roots of one mode.

    Attributes
    ----------
    dots : (values, Lock numbers)
    along : (values, n)
        Curves of constant value, at the Lock numbers ``lock_numbers`` (n,).
    across : (Lock numbers, n)
        Curves of constant Lock number.
    """

    dots: Complex
    along: Complex
    across: Complex
    lock_numbers: Array


def carpets(family: Family, roots: Callable[[Rotor], Roots]) -> dict[str, Carpet]:
    """Mode → roots of a family and the curves through them, which go through critical damping itself."""

    def overdamped(values: ArrayLike | None, lock_numbers: ArrayLike | None) -> NDArray[np.bool_]:
        return np.asarray(hover_modes(family.rotors(values, lock_numbers)).overdamped)

    gamma = _with_changes(
        np.linspace(min(family.lock_numbers), max(family.lock_numbers), FINE), lambda t: overdamped(None, t)
    )
    value = _with_changes(np.linspace(min(family.values), max(family.values), FINE), lambda t: overdamped(t, None).T)
    dots, along = roots(family.rotors()), roots(family.rotors(lock_numbers=gamma))
    across = roots(family.rotors(values=value))
    return {m: Carpet(dots=dots[m], along=along[m], across=across[m].T, lock_numbers=gamma) for m in dots}


def _with_changes(t: Array, state: Callable[[Array], NDArray[np.bool_]]) -> Array:
    """The points t and those between them where one of the states (curves, points) changes, by bisection."""
    found: list[float] = []
    for curve, i in zip(*np.nonzero(np.diff(state(t), axis=1)), strict=True):
        low, high = float(t[i]), float(t[i + 1])
        start = state(t[i : i + 1])[curve, 0]
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if state(np.array([middle]))[curve, 0] == start else (low, middle)
        found += [low, high]
    return np.unique(np.concatenate([t, found]))


# ---------------------------------------------------------------------- hover
def hover_roots(rotor: Rotor) -> Roots:
    """Mode → root (…) of the tip-path plane at hover, which is exact there; ``coning, faster`` is nan unless ζ > 1."""
    found = hover_modes(rotor)
    coning, advancing = found.coning.exponents, found.advancing.exponents[..., 0]
    faster = np.where(found.overdamped, coning[..., 1], complex(np.nan, np.nan))
    regressing = found.regressing.exponents[..., 0].real + 1j * (2.0 - advancing.imag)
    return {"regressing": regressing, "coning": coning[..., 0], "coning, faster": faster, "advancing": advancing}


def hover_records(family: Family) -> list[dict[str, Any]]:
    """A record for every rotor and mode of eqs. (9) and (10)."""
    rotors = family.rotors()
    found = hover_modes(rotors)
    over = np.asarray(found.overdamped)
    return [
        {
            **_parameters(rotors, at),
            "mode": mode,
            "overdamped": bool(over[at]),
            **_mode_columns(getattr(found, mode), at),
        }
        for at in np.ndindex(rotors.shape)
        for mode in MODES
    ]


def _mode_columns(mode: HoverMode, at: tuple[int, ...]) -> dict[str, Any]:
    first, second = mode.exponents[at]
    return {"frequency": float(mode.frequency[at]), "damping_ratio": float(mode.damping_ratio[at]),
            "exponent_1": complex(first), "exponent_2": complex(second)}  # fmt: skip


def _parameters(rotors: Rotor, at: tuple[int, ...]) -> dict[str, float]:
    return {name: float(np.broadcast_to(getattr(rotors, name), rotors.shape)[at]) for name in PARAMETERS}


# ---------------------------------------------------------------------- reduced order
def reduced_roots(rotor: Rotor) -> Roots:
    """The roots of :func:`hover_roots` and those of eq. (11), ``cyclic, reduced`` and ``coning, reduced``.

    ``cyclic`` is the unreduced root that the reduced one stands for: regressing or, above critical damping, where
    neither pair regresses, the slower.
    """
    system = reduced_order(tip_path_plane(rotor, 0.0))
    A = system.sample(np.zeros(1))[..., 0, :, :]
    roots = hover_roots(rotor)
    over = np.isfinite(roots["coning, faster"].real)
    return roots | {
        "cyclic": np.where(over, roots["advancing"], roots["regressing"]),
        "cyclic, reduced": A[..., 1, 1] - 1j * A[..., 1, 2],
        "coning, reduced": A[..., 0, 0] + 0j,
    }


def reduced_records(family: Family) -> list[dict[str, Any]]:
    """A record for every rotor: the roots of reduced order, those they stand for, and their relative distance.

    Of the cyclic root it is ω_n/√(4 + c₀²): eq. (11) leaves out η² of the equation that η solves.
    """
    rotors = family.rotors()
    roots = reduced_roots(rotors)
    error = np.abs(roots["cyclic, reduced"] - roots["cyclic"]) / np.abs(roots["cyclic"])
    return [
        {**_parameters(rotors, at), "overdamped": bool(np.isfinite(roots["coning, faster"][at].real)),
         "cyclic_reduced": complex(roots["cyclic, reduced"][at]), "cyclic": complex(roots["cyclic"][at]),
         "cyclic_error": float(error[at]), "coning_reduced": float(roots["coning, reduced"][at].real),
         "coning": complex(roots["coning"][at]), "advancing": complex(roots["advancing"][at])}
        for at in np.ndindex(rotors.shape)
    ]  # fmt: skip


# ---------------------------------------------------------------------- forward flight
def forward_rows(advance_ratio: ArrayLike, lock_numbers: Sequence[float] = LOCK_NUMBERS, **values: Any) -> list[Rows]:
    """Columns of the points table of each Lock number, the other parameters of the rotor being ``values``.

    Of a lock at ½ per rev, where regressing and coning share their exact exponents, :func:`~floquet.compare` gives the
    regressing name to the tip-path plane's pair of lower frequency, and the frequencies may cross.  Here a mode keeps
    the pair that it has in the first row: where pairs change hands, the columns of both modes do.
    """
    mu = np.asarray(advance_ratio, float)
    return [_followed(sweep(Rotor(lock_number=g, blades=3, **values), mu)) for g in lock_numbers]


def _followed(rows: Rows) -> Rows:
    """Exchange regressing and coning where they are joint and the other's pair is nearer to where their own was."""
    rows = {name: np.array(column) for name, column in rows.items()}
    a, b = ([name for name in rows if mode in name.split("_")] for mode in ("regressing", "coning"))
    for i in range(1, len(rows["advance_ratio"])):
        if rows["rule_regressing"][i] == Rule.JOINT:
            last, here = ([_shape(rows, mode, j) for mode in ("regressing", "coning")] for j in (i - 1, i))
            kept, changed = (sum(np.abs(x - y).sum() for x, y in zip(last, z, strict=True)) for z in (here, here[::-1]))
            if changed < kept:
                for one, other in zip(a, b, strict=True):
                    rows[one][i], rows[other][i] = rows[other][i], rows[one][i]
    return rows


def _shape(rows: Rows, mode: str, i: int) -> Array:
    """Mean and squared half difference of a pair: smooth where it splits, whatever the order of its members."""
    first, second = (rows[f"tpp_{mode}_{k}"][i] for k in (1, 2))
    return np.array([(first + second).real / 2.0, ((first - second) ** 2).real / 4.0])


def forward_records(rows: Sequence[Rows], advance_ratio: ArrayLike) -> list[dict[str, Any]]:
    """A record for every rotor, mode and some advance ratios of its rows: both models' pairs and what parts them.

    ``moved`` is how far the tip-path plane's pair has gone from the first row's, relative to the latter.
    """
    wanted = np.asarray(advance_ratio, float)
    return [
        {**{name: float(one[name][i]) for name in PARAMETERS}, "advance_ratio": float(one["advance_ratio"][i]),
         "mode": mode, "lock": float(one["lock"][i]), "rule": Rule(int(one[f"rule_{mode}"][i])).name,
         **{f"{model}_{k}": complex(one[f"{model}_{mode}_{k}"][i]) for model in ("exact", "tpp") for k in (1, 2)},
         "error": float(one[f"error_{mode}"][i]), "moved": _moved(one, mode, int(i))}
        for one in rows
        for i in np.flatnonzero(np.isclose(one["advance_ratio"][:, None], wanted, atol=1e-12).any(axis=1))
        for mode in MODES
    ]  # fmt: skip


def _moved(rows: Rows, mode: str, i: int) -> float:
    """The larger distance of two members from those of the first row, over the size of the latter."""
    here, start = (np.array([rows[f"tpp_{mode}_{k}"][j] for k in (1, 2)]) for j in (i, 0))
    far = min(np.abs(here - start).max(), np.abs(here[::-1] - start).max())
    return float(far / np.abs(start[0]))
