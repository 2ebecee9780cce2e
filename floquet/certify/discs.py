"""Theorem 3: the eigenvalues of a matrix of balls, in disjoint discs with the number of eigenvalues in each.

**Theorem 3 (Pellet).**  If p(c+z) = Σ c_k z^k and |c_m| r^m > Σ_{k≠m} |c_k| r^k, then p has exactly m zeros with
|z-c| < r.  *Proof.*  Rouché, against c_m z^m on |z| = r.  ∎

With p the characteristic polynomial, disjoint discs that hold n zeros in all hold every eigenvalue.  Midpoints only
guess where: guesses that cannot be told apart, as those of a Jordan block, are put together until the theorem holds.
If a lone eigenvalue's disc meets the real axis, and the disc's mirror image none of the others, then its conjugate,
an eigenvalue too, can only be itself: it is real.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

from flint import acb, acb_mat, acb_poly, arb, arb_mat, ctx

from .exact import Unproved
from .series import plus_minus

__all__ = ["enclosed_eigenvalues"]


class _Disc(NamedTuple):
    """Exactly ``zeros`` eigenvalues lie less than ``radius`` from ``centre``."""

    centre: acb
    radius: arb
    zeros: int

    def meets(self, other: _Disc) -> bool:
        """Whether the two are not proven to be disjoint."""
        return not abs(self.centre - other.centre) > self.radius + other.radius


def enclosed_eigenvalues(M: arb_mat) -> list[tuple[acb, int]]:
    """Disjoint balls that hold every eigenvalue of a real matrix, and how many each holds; real ones have Im = 0."""
    if not all(x.is_finite() for x in M.entries()):
        raise Unproved
    p = acb_poly(M.charpoly())
    groups = [[z.mid()] for z in acb_mat(M.mid()).eig(algorithm="approx")]
    while True:
        found = [_pellet(p, group) for group in groups]
        discs = [disc for disc in found if disc is not None]
        pair = _first_meeting(discs) if len(discs) == len(found) else _first_lost(found, groups)
        if pair is None:
            return [(_ball(disc, discs), disc.zeros) for disc in discs]
        groups = [g for i, g in enumerate(groups) if i not in pair] + [groups[pair[0]] + groups[pair[1]]]


def _first_meeting(discs: Sequence[_Disc]) -> tuple[int, int] | None:
    pairs = ((i, j) for i in range(len(discs)) for j in range(i))
    return next(((i, j) for i, j in pairs if discs[i].meets(discs[j])), None)


def _first_lost(found: Sequence[_Disc | None], groups: Sequence[Sequence[acb]]) -> tuple[int, int]:
    """A group without a disc, and the one nearest to it."""
    if len(groups) == 1:
        raise Unproved
    lost = found.index(None)
    distances = {j: abs(_mean(g) - _mean(groups[lost])).mid() for j, g in enumerate(groups) if j != lost}
    return lost, min(distances, key=lambda j: distances[j])


def _mean(group: Sequence[acb]) -> acb:
    return (sum(group, acb(0)) / len(group)).mid()


def _pellet(p: acb_poly, group: Sequence[acb]) -> _Disc | None:
    """A disc about the mean of ``group`` with as many zeros of p, if theorem 3 gives one."""
    m, centre = len(group), _mean(group)
    sizes = [abs(c) for c in p(acb_poly([centre, 1])).coeffs()]
    main = sizes[m].lower()
    if not main > 0:
        return None
    # this radius leaves the terms below m half of the main one; it must not be 0
    roots = ((2 * m * sizes[k].upper() / main).root(m - k) for k in range(m))
    radius = reduce(arb.max, roots, arb(2) ** -ctx.prec).upper()
    others = sum((size * radius**k for k, size in enumerate(sizes) if k != m), arb(0))
    return _Disc(centre, radius, m) if others < main * radius**m else None


def _ball(disc: _Disc, discs: Sequence[_Disc]) -> acb:
    """The square around a disc, or the interval if its eigenvalue is real."""
    mirror = disc._replace(centre=disc.centre.conjugate())
    real = disc.zeros == 1 and disc.meets(mirror) and not any(mirror.meets(d) for d in discs if d is not disc)
    spread = plus_minus(disc.radius)
    return acb(disc.centre.real + spread, arb(0) if real else disc.centre.imag + spread)
