"""The compiled Hill engine: its generator, its arithmetic by order and in wide precision, compilation and cache."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from floquet.kernels import available, generate, hill, taylor
from floquet.models import flapping, teetering
from floquet.models.textbook import mathieu
from floquet.period_map import period_map
from floquet.periodic import TWO_PI, PeriodicSystem
from floquet.rotor import Hub, Rotor

EPS = float(np.finfo(float).eps)
compiled = pytest.mark.skipif(not available(), reason="numba is not to be used")
KERNELS = Path(taylor.__file__).parent


def blades(n: int, seed: int = 0, *, mu: float = 1.0) -> tuple[Rotor, np.ndarray]:
    """Random articulated blades."""
    rng = np.random.default_rng(seed)
    rotor = Rotor(
        lock_number=rng.uniform(2, 16, n),
        hinge_offset=rng.uniform(0, 0.2, n),
        hinge_stiffness=rng.uniform(0, 0.5, n),
        pitch_flap_coupling=rng.uniform(-0.5, 0.5, n),
    )
    return rotor, rng.uniform(0, mu, n)


# ---------------------------------------------------------------------- the generator and what it writes
def test_generated_file_is_up_to_date() -> None:
    """``python -m floquet.kernels.generate`` writes what is there."""
    assert generate.TARGET.read_text(encoding="utf-8") == generate.source()


@pytest.mark.parametrize("order", [8, 9, 14])
def test_panel_is_of_its_order(order: int) -> None:
    """y'' = -h²(1 + 0.3 cos) y: halving h divides F's error by 2^order at least, and never more than estimated."""
    names: dict[str, object] = {}
    exec(generate.source(order), names)
    errors, estimates = [], []
    for h in (0.8, 0.4):
        p = [-h * h * (0.3 * h**k * math.cos(0.5 + k * math.pi / 2) / math.factorial(k) + (k == 0)) for k in range(23)]
        exact, short = taylor.panel(*p), names["panel"](*p[: order - 1])  # type: ignore[operator]
        errors.append(max(abs(a - b) for a, b in zip(exact[:4], short[:4], strict=True)))
        estimates.append(short[4])
        assert errors[-1] < estimates[-1]  # never under-estimated
    assert math.log2(errors[0] / errors[1]) > order
    assert math.log2(estimates[0] / estimates[1]) > order - 2


@pytest.mark.parametrize("q", [1.0, -2.0, 0.0])
def test_constant_coefficients_have_a_closed_form(q: float) -> None:
    """cos and sin of the whole panel; det F = 1."""
    h = 0.5
    f = taylor.panel(-h * h * q, *[0.0] * 22)
    w = complex(q) ** 0.5 * 2 * h
    sine = (np.sin(w) / w if w else 1.0 + 0j) * 2
    expected = [np.cos(w), sine, -h * h * q * sine, np.cos(w)]
    np.testing.assert_allclose(f[:4], np.real(expected), atol=8 * EPS)


# ---------------------------------------------------------------------- the maps
def extended(system: PeriodicSystem, panels: int) -> np.ndarray:
    """Φ (4, n) by the same series in 80 bits, three times the panels, without any of the code that chains panels."""
    D, K = system.damping, system.stiffness
    assert K is not None and D is not None
    q = (K - D.derivative() / 2 - (D @ D) / 4).coefficients[:, 0, :, 0, 0].T.astype(np.longdouble)
    pi = np.longdouble("3.14159265358979323846264338327950288")
    T, omega = pi * np.longdouble(round(system.period / math.pi)), round(TWO_PI / K.period)
    h = T / (2 * panels)
    y = [np.array([[1.0], [0.0]], np.longdouble) * np.ones(q.shape[1], np.longdouble), None]
    y[1] = y[0][::-1].copy()
    for s in range(panels):
        centre = (2 * s + 1) * h
        p = [np.zeros(q.shape[1], np.longdouble) for _ in range(23)]
        p[0] += q[0]
        for n in range(1, len(q) // 2 + 1):
            for k in range(23):
                c, sine = np.cos(n * omega * centre), np.sin(n * omega * centre)
                turn = [c, -sine, -c, sine]
                even = q[2 * n - 1] * turn[k % 4] + q[2 * n] * (-turn[(k + 1) % 4])
                p[k] += even * (n * omega * h) ** k / math.factorial(k)
        f = taylor.panel(*[-h * h * x for x in p])
        y = [np.stack([f[0] * a[0] + f[1] / h * (a[1] * h * h), f[2] / h * a[0] + f[3] * a[1]]) for a in y]
    return np.stack([y[0][0], y[1][0], y[0][1], y[1][1]])


@pytest.mark.parametrize("kind", ["flapping", "teetering", "mathieu"])
def test_maps_are_within_their_bounds_of_wide_precision(kind: str) -> None:
    """Trace and discriminant of 300 systems in 64-bit mantissas."""
    n = 300
    rotor, mu = blades(n, 1, mu=1.5)
    if kind == "flapping":
        system: PeriodicSystem = flapping(rotor, mu)
    elif kind == "teetering":
        system = teetering(Rotor(lock_number=rotor.lock_number, hub=Hub.TEETERING, blades=2), mu)
    else:
        rng = np.random.default_rng(3)
        system = mathieu(rng.uniform(-3, 20, n), rng.uniform(0, 8, n), 0.1)
    phi = period_map(system)
    assert phi.rows is not None
    a = extended(system.part(slice(None)), 3 * int(phi.panels.max()))
    tau, D = 0.5 * (a[0] + a[3]), (0.5 * (a[0] - a[3])) ** 2 + a[1] * a[2]
    for found, exact, bound in ((phi.half_trace, tau, phi.rows[4]), (phi.discriminant, D, phi.rows[5])):
        error = np.abs(found - exact).astype(float)
        assert np.all(error <= bound)
        assert np.median(bound / np.maximum(error, EPS * np.abs(found))) < 1e3  # and is not idle
    np.testing.assert_allclose(phi.rows[:4], a.astype(float), rtol=1e-12, atol=1e-12 * np.abs(a).max(axis=0).max())


def test_bits_do_not_depend_on_neighbours_or_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chunk of all, a third of it, and one thread or three."""
    rotor, mu = blades(40_000, 2)
    from floquet import stability

    monkeypatch.setenv("FLOQUET_THREADS", "3")
    whole = stability(flapping(rotor, mu))
    monkeypatch.setenv("FLOQUET_THREADS", "1")
    assert np.array_equal(whole.exponents, stability(flapping(rotor, mu)).exponents)
    some = np.arange(1, 40_000, 3)
    part = stability(flapping(rotor[some], mu[some]))
    assert np.array_equal(whole.exponents[some], part.exponents)
    assert np.array_equal(whole.exponent_errors[some], part.exponent_errors)


@compiled
def test_compiled_and_numpy_paths_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the rounding of fused multiply-adds, bounds and branches included."""
    from floquet import stability

    rotor, mu = blades(6000, 4, mu=1.5)
    fast = stability(flapping(rotor, mu))
    monkeypatch.setattr(hill, "worth_compiling", lambda points: False)
    monkeypatch.setattr("floquet.kernels.closing.worth_compiling", lambda points: False)
    slow = stability(flapping(rotor, mu))
    assert np.all(np.abs(fast.exponents - slow.exponents) <= fast.exponent_errors + slow.exponent_errors)
    ratio = fast.exponent_errors / slow.exponent_errors  # of large maps they hold the rounding that was met
    assert abs(np.median(ratio) - 1.0) < 0.01 and ratio.min() > 0.05 and ratio.max() < 20.0
    for name in ("lock", "verdict", "reason", "method", "panels"):
        np.testing.assert_array_equal(getattr(fast, name), getattr(slow, name))
    np.testing.assert_allclose(fast.rotation_number, slow.rotation_number, atol=1e-12)


def test_without_numba_nothing_of_it_is_loaded() -> None:
    code = """
        import sys, numpy as np
        from floquet import Rotor, flapping, stability
        s = stability(flapping(Rotor(lock_number=8.0), np.linspace(0.0, 1.0, 20_000)))
        assert "numba" not in sys.modules
        print(s.exponent_errors.max() < 1e-11)
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env={**os.environ, "FLOQUET_NO_NUMBA": "1"},
        capture_output=True,
        text=True,
    )
    assert run.stdout.strip() == "True", run.stderr


def test_elementary_functions_are_accurate_to_six_units() -> None:
    pytest.importorskip("numba")
    code = """
        import numpy as np
        from numba import njit
        from floquet.kernels import elementary

        @njit
        def tabulate(x, y, s, a):
            for i in range(len(x)):
                s[i] = elementary.arcsinh(y[i])
                a[i] = elementary.arctan2(y[i], x[i])

        rng = np.random.default_rng(0)
        x, y = rng.normal(size=200_000), 10 ** rng.uniform(-20, 3, 200_000)
        y[:1000] = 10 ** rng.uniform(3, 150, 1000)
        s, a = np.empty_like(x), np.empty_like(x)
        tabulate(x, y, s, a)
        for found, exact in ((s, np.arcsinh(y.astype(np.longdouble))), (a, np.arctan2(*np.longdouble([y, x])))):
            print(float(np.max(np.abs(found - exact) / np.spacing(found))) < 6)
    """
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True)
    assert run.stdout.split() == ["True", "True"], run.stderr


# ---------------------------------------------------------------------- compilation
#: The kernels that must be made of wide registers, and how many fused multiply-adds each has at least.
WIDE = {"forward": 400, "backward": 15, "close_block": 30}


@compiled
def test_kernels_run_on_wide_registers(tmp_path: Path) -> None:
    """Fused multiply-adds of the machine code: on the widest registers of this machine, single ones in a remainder."""
    flags = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    if " avx2" not in flags or " fma" not in flags:
        pytest.skip("this machine has no wide fused multiply-add")
    code = f"""
        import re
        import numpy as np
        from floquet import Rotor, flapping, stability
        from floquet.kernels import hill_lanes
        stability(flapping(Rotor(lock_number=8.0), np.linspace(0.0, 1.0, 5000)))
        for name in {list(WIDE)}:
            text = "".join(getattr(hill_lanes, name).inspect_asm().values())
            wide, single = (r"vfn?m(?:add|sub)\\w+pd\\s.*%[yz]mm", r"vfn?m\\w+sd\\s")
            print(len(re.findall(wide, text)), len(re.findall(single, text)))
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},  # compiled afresh: code from a cache has no listing
        capture_output=True,
        text=True,
        check=True,
    )
    counts = [tuple(map(int, line.split())) for line in run.stdout.splitlines()]
    for (wide, single), (kernel, least) in zip(counts, WIDE.items(), strict=True):
        assert wide > least and single <= wide, kernel


@compiled
def test_a_changed_kernel_source_is_compiled_again(tmp_path: Path) -> None:
    """A copy of the package whose generated arithmetic is changed does not find the old code in the cache."""
    package = tmp_path / "code" / "floquet"
    shutil.copytree(KERNELS.parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    code = """
        import numpy as np
        from floquet import Rotor, flapping, stability
        print(stability(flapping(Rotor(lock_number=8.0), np.linspace(0.0, 1.0, 5000))).exponents[2500])
    """

    def run() -> str:
        return subprocess.run(
            [sys.executable, "-c", textwrap.dedent(code)],
            cwd=package.parent,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(package.parent)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout

    before = run()
    assert run() == before
    source = package / "kernels" / "taylor.py"
    source.write_text(source.read_text().replace("v3 = (p0) * 0.1666", "v3 = (p0) * 0.2666"))
    assert run() != before
    assert len(list((tmp_path / "cache").glob("kernels-*"))) == 2  # below the user's own folder


def test_the_bound_covers_a_wrong_map() -> None:
    """Panels that are too few: the bounds of τ and D grow with the error."""
    rotor, mu = blades(200, 5)
    fine = period_map(flapping(rotor, mu))
    for panels in (1, 2, 3, 4):
        coarse = period_map(flapping(rotor, mu), panels=panels)
        assert fine.rows is not None and coarse.rows is not None
        assert np.all(np.abs(coarse.half_trace - fine.half_trace) <= coarse.rows[4] + fine.rows[4])
        assert np.all(np.abs(coarse.discriminant - fine.discriminant) <= coarse.rows[5] + fine.rows[5])


def test_ladder_resolves_what_the_fit_did_not_see() -> None:
    """Stiff, fast, strongly modulated equations: every panel resolved, zeros counted (ρ of constant coefficients)."""
    rng = np.random.default_rng(6)
    a, q = 10 ** rng.uniform(-3, 4, 300), 10 ** rng.uniform(-3, 3.5, 300)
    phi = period_map(mathieu(a, np.minimum(q, 0.4 * a), 0.0))
    assert phi.rows is not None and not np.any(phi.rows[7])
    from floquet import stability

    constant = stability(mathieu(a, 0.0, 0.0))
    np.testing.assert_allclose(constant.rotation_number, np.sqrt(a), rtol=1e-12, atol=1e-13)
    assert TWO_PI / 2 == constant.period
