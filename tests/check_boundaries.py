"""Every lock of thousands of random designs against a brute-force scan: ``make check-boundaries``.

The scan takes D in steps of 1e-4 in μ.  Wherever its sign changes the edge is bisected; wherever |τ| has a least or
greatest value between steps that may reach 1 its turning point is found, in as many digits as it takes, so that windows
and gaps far narrower than a step are seen.  What it finds and what :func:`floquet.validity.locks` finds must be the
same: edges to 1e-9, and no window wider than 1e-9 more or less.  Exit status 1 if one differs.
"""

from __future__ import annotations

import math
import sys
import time

import numpy as np
from numpy.typing import NDArray

from floquet import Hub, Rotor
from floquet.validity.designs import WIDTH, Designs

Array = NDArray[np.float64]
Places = NDArray[np.intp]
COUNT, TOGETHER, STEP, MU_MAX, SEED = 10_000, 100, 1e-4, 1.0, 5
NEAR = 1e-5  # of |τ| to 1, from which a turning point is looked at
TOLERANCE = 1e-9


def rotors(count: int, seed: int, *, teetering: bool) -> Rotor:
    """Random designs."""
    rng = np.random.default_rng([SEED, seed])
    gamma, kappa = rng.uniform(2.0, 18.0, count), rng.uniform(0.0, 0.5, count)
    K1, offset = rng.uniform(-0.5, 0.5, count), rng.uniform(0.0, 0.2, count)
    if teetering:
        return Rotor(lock_number=gamma, hinge_stiffness=kappa, pitch_flap_coupling=K1, hub=Hub.TEETERING, blades=2)
    return Rotor(lock_number=gamma, hinge_stiffness=kappa, pitch_flap_coupling=K1, hinge_offset=offset)


def scanned(designs: Designs) -> tuple[Places, Array]:
    """Case and place of every edge."""
    mu = np.arange(0.0, MU_MAX + 0.5 * STEP, STEP)
    case = np.repeat(np.arange(designs.count), len(mu))
    phi = designs.map(case, np.tile(mu, designs.count))
    D, tau = (x.reshape(designs.count, -1) for x in (phi.discriminant, phi.half_trace))
    which, i = np.nonzero((D[:, 1:] > 0.0) != (D[:, :-1] > 0.0))
    found = [(which, _bisected(designs, which, mu[i], mu[i + 1], D[which, i] > 0.0))]
    # a turning point of |τ| between steps, and the two edges about it
    size = np.abs(tau)
    middle, sides = size[:, 1:-1], (size[:, :-2], size[:, 2:])
    for sign in (1.0, -1.0):
        turning = (sign * middle >= sign * sides[0]) & (sign * middle >= sign * sides[1])
        turning &= (sign * (middle - 1.0) <= 0.0) & (np.abs(middle - 1.0) < NEAR)
        which, i = np.nonzero(turning)
        top = _turning(designs, which, mu[i], mu[i + 2])
        beyond = sign * designs.map(which, top).discriminant > 0.0
        which, i, top = which[beyond], i[beyond], top[beyond]
        for end in (mu[i], mu[i + 2]):
            inside = sign * designs.map(which, end).discriminant > 0.0
            found.append((which[~inside], _bisected(designs, which[~inside], end[~inside], top[~inside], sign < 0.0)))
    case, x = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.lexsort((x, case))
    return case[order], x[order]


def _bisected(designs: Designs, case: Places, low: Array, high: Array, locked: NDArray[np.bool_] | bool) -> Array:
    """Where D changes its sign; ``locked`` at ``low``."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        same = (designs.map(case, middle).discriminant > 0.0) == locked
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def _turning(designs: Designs, case: Places, low: Array, high: Array) -> Array:
    """Where |D| is least or greatest, by thirds; there D is τ² - 1 without its cancellation."""
    sign = np.sign(designs.map(case, 0.5 * (low + high)).discriminant - designs.map(case, low).discriminant)
    for _ in range(60):
        left, right = low + (high - low) / 3.0, high - (high - low) / 3.0
        rising = sign * designs.map(case, right).discriminant > sign * designs.map(case, left).discriminant
        low, high = np.where(rising, left, low), np.where(rising, high, right)
    return 0.5 * (low + high)


def compared(designs: Designs) -> list[str]:
    """What differs."""
    windows = designs.windows()
    case = np.tile(windows.case, 2)
    x = np.concatenate([windows.enter, windows.leave])
    inner = (x > 0.0) & (x < math.inf)
    order = np.lexsort((x[inner], case[inner]))
    ours, theirs = (case[inner][order], x[inner][order]), scanned(designs)
    out = []
    for k in range(designs.count):
        a, b = ours[1][ours[0] == k], theirs[1][theirs[0] == k]
        while len(b) > len(a) and (np.diff(b) < 1.01 * WIDTH).any():  # windows that are not reported
            i = int(np.argmin(np.diff(b)))
            b = np.delete(b, [i, i + 1])
        if len(a) != len(b) or (len(a) and np.abs(a - b).max() > TOLERANCE):
            out.append(f"{designs.at(np.array([k]))}: {a.tolist()} is not {b.tolist()}")
    return out


def main(count: int) -> int:
    wrong, edges, began = 0, 0, time.monotonic()
    for n, start in enumerate(range(0, count, TOGETHER)):
        designs = Designs(rotors(min(TOGETHER, count - start), start, teetering=n % 5 == 4), MU_MAX, None, {})
        for line in compared(designs):
            print(line, flush=True)
            wrong += 1
        edges += len(designs.windows().case)
    print(f"{count} designs, {edges} locks, {wrong} differ ({time.monotonic() - began:.0f} s)")
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else COUNT))
