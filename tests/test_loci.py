"""Figures 3 to 12: tables and numbers against closed forms, table 3, integration and 30 digits; and what is drawn."""

from __future__ import annotations

import functools
import json
import math
import re
from collections.abc import Iterator
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import linear_sum_assignment

from floquet.exhibits import Exhibit, load
from floquet.plot.parts import PAGE
from tests.support import REFERENCE, distances, oracle, oracle_exponents
from tests.truth import closed_forms

STUDIES = Path(__file__).parent.parent / "studies" / "tp1431"
GAMMAS = [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0]
EPS, KAPPA, K1 = [0.0, 0.05, 0.1, 0.15], [0.0, 0.1, 0.225], [-0.2, 0.0, 0.225, 0.5]
FAMILIES = {3: ("hinge_offset", EPS), 4: ("hinge_stiffness", KAPPA), 5: ("pitch_flap_coupling", K1)}
ORDERS = {n + 7: family for n, family in FAMILIES.items()}
FORWARD: dict[int, dict[str, float]] = {6: {}, 7: {"eps": 0.15}, 8: {"kappa": 0.225}, 9: {"K1": 0.225}}
NAMES = {"hinge_offset": "eps", "hinge_stiffness": "kappa", "pitch_flap_coupling": "K1"}
LETTERS = {"ε": "eps", "κ": "kappa", "K₁": "K1"}
ROUNDING = 1e-12  # a few dozen operations on numbers of order one
DOUBLE = 1e-7  # of a double root: √eps

Complex = NDArray[np.complex128]


@functools.cache
def study(number: int) -> Exhibit:
    return load(STUDIES / f"figure-{number}.py")


def parameters(row: dict[str, Any]) -> dict[str, float]:
    return {short: row[name] for name, short in NAMES.items()}


def given(key: str) -> dict[str, float]:
    """The parameters in the name of a number."""
    found = {short: re.search(rf"{letter} = ([-\d.]+)", key) for letter, short in {**LETTERS, "γ": "gamma"}.items()}
    return {short: float(match[1]) for short, match in found.items() if match}


def plane(gamma: float, mu: float = 0.0, **values: float) -> Complex:
    """The six eigenvalues of table 3."""
    D, K = closed_forms.table_3(closed_forms.truncated(gamma, mu=mu, **values))
    return np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [-K, -D]]))


def nearest(z: complex, values: Any) -> float:
    return float(np.abs(np.asarray(values) - z).min())


# ---------------------------------------------------------------------- figures 3 to 5
@pytest.mark.parametrize("number", FAMILIES)
def test_hover_records_are_the_closed_forms(number: int) -> None:
    name, values = FAMILIES[number]
    table = study(number).table
    expected = {(v, g, m) for v in values for g in GAMMAS for m in ("regressing", "coning", "advancing")}
    assert {(r[name], r["lock_number"], r["mode"]) for r in table} == expected and len(table) == len(expected)
    for r in table:
        true: dict[str, Any] = closed_forms.hover(r["lock_number"], **parameters(r))
        assert r["overdamped"] == (true["zeta"] > 1.0)
        pair = np.array([r["exponent_1"], r["exponent_2"]])
        if r["mode"] == "coning":
            assert r["frequency"] == pytest.approx(true["P"]) and r["damping_ratio"] == pytest.approx(true["zeta"])
            assert distances(pair, true["coning"]).max() < DOUBLE
        elif true["zeta"] > 1.0:
            cyclic = np.sort_complex(true["cyclic"])[slice(0, 2) if r["mode"] == "regressing" else slice(2, 4)]
            assert distances(pair, cyclic).max() < ROUNDING
            assert r["frequency"] == pytest.approx(abs(cyclic[0]))
            assert r["damping_ratio"] == pytest.approx(-cyclic[0].real / abs(cyclic[0]))
        else:
            letter = r["mode"][0].upper()
            assert r["frequency"] == pytest.approx(true[f"omega_{letter}"])
            assert r["damping_ratio"] == pytest.approx(true[f"zeta_{letter}"])
            assert distances(pair, true["cyclic"][slice(0, 2) if letter == "A" else slice(2, 4)]).max() < DOUBLE


@pytest.mark.parametrize("number", FAMILIES)
def test_hover_numbers_are_the_closed_forms(number: int) -> None:
    for key, value in study(number).numbers.items():
        values = given(key)
        gamma = values.pop("gamma", value)
        true: dict[str, Any] = closed_forms.hover(gamma, **values)
        if key.startswith("regressing frequency"):
            assert value == pytest.approx(true["omega_R"], rel=ROUNDING)
        elif "does not precess" in key:
            assert true["P"] * math.sqrt(1.0 - true["zeta"] ** 2) == pytest.approx(1.0, rel=ROUNDING)
        elif key.startswith("critical"):
            assert true["zeta"] == pytest.approx(1.0, rel=ROUNDING)
        else:
            damping = sorted({-z.real for z in true["cyclic"]})
            assert value == pytest.approx(damping["faster" in key])


def test_large_offset_does_not_reduce_the_regressing_frequency_at_lock_number_2() -> None:
    """Against the text of the report; to four digits by hand from eq. (10b)."""
    slow = {(r["lock_number"], r["hinge_offset"]): r["frequency"] for r in study(3).table if r["mode"] == "regressing"}
    assert [slow[2.0, e] for e in EPS] == pytest.approx([0.1252, 0.1133, 0.1163, 0.1315], abs=5e-5)
    assert all(slow[g, a] > slow[g, b] for g in GAMMAS[1:] for a, b in pairwise(EPS))


# ---------------------------------------------------------------------- figures 6 to 9
def blade_map(gamma: float, mu: float, **values: float) -> NDArray[np.float64]:
    """Transition matrix of one blade over a revolution, by an integrator that knows nothing of the package."""
    c = closed_forms.truncated(gamma, mu=mu, **values)

    def rates(psi: float, x: NDArray[np.float64]) -> list[float]:
        damping, stiffness = closed_forms.blade_damping(c, psi), closed_forms.blade_stiffness(c, psi)
        return [x[1], -damping * x[1] - stiffness * x[0], x[3], -damping * x[3] - stiffness * x[2]]

    end = solve_ivp(rates, (0.0, 2.0 * math.pi), [1.0, 0.0, 0.0, 1.0], method="DOP853", rtol=1e-12, atol=1e-15)
    return np.asarray(end.y[:, -1].reshape(2, 2).T)


def half_trace(gamma: float, mu: float, **values: float) -> float:
    """Of the Hill form: beyond 1 in size the blade is locked, at whole per rev if positive."""
    c0 = closed_forms.truncated(gamma, **values)["c0"]
    return float(0.5 * np.trace(blade_map(gamma, mu, **values)) * math.exp(math.pi * c0))


@functools.cache
def followed(gamma: float, number: int) -> dict[float, dict[str, Complex]]:
    """Pairs of the plane by μ and mode, followed from hover in small steps by least distance of all six."""
    values = FORWARD[number]
    true: dict[str, Any] = closed_forms.hover(gamma, **values)
    here = np.concatenate([true["cyclic"][2:], true["coning"], true["cyclic"][:2]])
    apart = 1e-6j * np.array([-1, 1, 0, 0, 1, -1])  # γ = 16 without offset starts in a double root, and advancing rises
    out: dict[float, dict[str, Complex]] = {}
    for step in range(2001):
        found = plane(gamma, 2e-4 * step, **values)
        if step:
            here = found[linear_sum_assignment(np.abs((here + apart)[:, None] - found[None, :]))[1]]
        if step % 500 == 0:
            modes = ("regressing", "coning", "advancing")
            out[round(2e-4 * step, 10)] = {mode: here[2 * k : 2 * k + 2] for k, mode in enumerate(modes)}
    return out


@pytest.mark.parametrize("number", FORWARD)
def test_forward_records_hold_every_case_and_the_eigenvalues_of_table_3(number: int) -> None:
    table = study(number).table
    cases = {(g, round(0.1 * k, 10)) for g in GAMMAS for k in range(5)}
    assert {(r["lock_number"], round(r["advance_ratio"], 10)) for r in table} == cases and len(table) == 3 * len(cases)
    for gamma, mu in cases:
        rows = [r for r in table if r["lock_number"] == gamma and abs(r["advance_ratio"] - mu) < 1e-9]
        assert all(parameters(r) == {"eps": 0.0, "kappa": 0.0, "K1": 0.0} | FORWARD[number] for r in rows)
        pairs = [r[f"tpp_{k}"] for r in rows for k in (1, 2)]
        near = DOUBLE if (gamma, mu) == (16.0, 0.0) else 1e-11  # the first is a double root
        assert distances(pairs, plane(gamma, mu, **FORWARD[number])).max() < near


@pytest.mark.parametrize("number", FORWARD)
def test_exact_damping_outside_locks_is_half_c0(number: int) -> None:
    free = [r for r in study(number).table if math.isnan(r["lock"])]
    assert len(free) > 60
    for r in free:
        c0 = closed_forms.truncated(r["lock_number"], **FORWARD[number])["c0"]
        near = 1e-7 if r["advance_ratio"] == 0.0 else ROUNDING  # at hover a blade may be critically damped
        assert [r["exact_1"].real, r["exact_2"].real] == pytest.approx([-0.5 * c0] * 2, abs=near)


def test_exact_exponents_are_those_of_thirty_digits() -> None:
    names = {"eps": "eps", "kbeta": "kappa", "K1": "K1"}
    checked = 0
    for case in oracle():
        p = case["params"]
        values = {names[n]: float(p[n]) for n in names if n in p}
        numbers = [n for n, v in FORWARD.items() if v == values]
        if case["kind"] != "single" or not numbers or p.get("eMI"):
            continue
        here = (float(p["gamma"]), float(p["mu"]))
        rows = [
            r for r in study(numbers[0]).table
            if r["lock_number"] == here[0] and abs(r["advance_ratio"] - here[1]) < 1e-9 and r["rule"] != "MEAN"
        ]  # fmt: skip
        found = {r[f"exact_{k}"] for r in rows for k in (1, 2)}
        true, strip = oracle_exponents(case)
        near = DOUBLE if here == (16.0, 0.0) else ROUNDING
        for z in found:
            assert min(abs(z - t - 1j * strip * round((z - t).imag / strip)) for t in true) < near
        for t in true if rows else []:
            assert min(abs(z - t - 1j * strip * round((z - t).imag / strip)) for z in found) < near
        checked += bool(rows)
    assert checked == 10  # seven without offset, spring and coupling, one of each of the others


@pytest.mark.parametrize("number", FORWARD)
def test_error_is_the_distance_of_eigenvalue_and_exponent(number: int) -> None:
    """Of the regressing mode at γ = 8, μ = 0.4, from table 3 and an integration."""
    values = FORWARD[number]
    exact = np.log(np.linalg.eigvals(blade_map(8.0, 0.4, **values)).astype(complex)) / (2.0 * math.pi)
    ours = followed(8.0, number)[0.4]["regressing"]
    pair = exact.real + 1j * (exact.imag - np.round(exact.imag))  # modulo 1 per rev the regressing one lies next to 0
    far = min(np.abs(ours - pair).max(), np.abs(ours[::-1] - pair).max())
    value = study(number).numbers["error of TPP regressing, γ = 8, μ = 0.4"]
    assert value == pytest.approx(far / math.sqrt(np.mean(np.abs(pair) ** 2)), rel=1e-8)


@pytest.mark.parametrize("number", FORWARD)
def test_errors_belong_to_the_pairs_beside_them(number: int) -> None:
    """Also where pairs have changed hands."""
    for r in study(number).table:
        exact, ours = (np.array([r[f"{model}_1"], r[f"{model}_2"]]) for model in ("exact", "tpp"))
        assert r["error"] == pytest.approx(
            np.abs(ours - exact).max() / math.sqrt(np.mean(np.abs(exact) ** 2)), abs=1e-15
        )


@pytest.mark.parametrize("number", FORWARD)
def test_modes_of_the_plane_are_followed_from_hover(number: int) -> None:
    """Also where compare() gives names by frequency."""
    for gamma in GAMMAS:
        true = followed(gamma, number)
        for r in study(number).table:
            if r["lock_number"] == gamma:
                mu = round(r["advance_ratio"], 10)
                pair, start = true[mu][r["mode"]], true[0.0][r["mode"]]
                double = (gamma, number) == (16.0, 6) and mu == 0.0
                assert distances([r["tpp_1"], r["tpp_2"]], pair).max() < (DOUBLE if double else 1e-10)
                far = min(np.abs(pair - start).max(), np.abs(pair[::-1] - start).max()) / abs(start[0])
                assert r["moved"] == pytest.approx(far, abs=DOUBLE)


@pytest.mark.parametrize("number", FORWARD)
def test_moves_splits_and_locks_are_where_the_numbers_say(number: int) -> None:
    reference = json.loads((REFERENCE / "transitions.json").read_text())
    values = FORWARD[number]
    for key, value in study(number).numbers.items():
        gamma = given(key)["gamma"]
        if key.startswith("TPP regressing moved"):
            start, end = (followed(gamma, number)[mu]["regressing"] for mu in (0.0, 0.4))
            far = min(np.abs(end - start).max(), np.abs(end[::-1] - start).max())
            assert value == pytest.approx(far / abs(start[0]), rel=1e-9)
        elif "splits" in key:
            before, after = (plane(gamma, value + d, **values) for d in (-1e-7, 1e-7))
            assert np.sum(before.imag == 0.0) == 0 and np.sum(after.imag == 0.0) == 2
        elif "locks" in key:
            before, after = (half_trace(gamma, value + d, **values) for d in (-1e-6, 1e-6))
            assert abs(before) < 1.0 < abs(after)
            assert ("at 1 per rev" in key) == (after > 0.0) and ("at 0.5 per rev" in key) == (after < 0.0)
            edges = reference.get(f"single:fig{number}:{gamma:g}", {}).get("edges")
            assert edges is None or value == pytest.approx(edges[0]["mu"], abs=1e-11)
        else:
            assert key.startswith("error")


def test_what_the_captions_say_of_the_moves() -> None:
    def moved(number: int, mode: str) -> dict[float, float]:
        rows = [r for r in study(number).table if r["advance_ratio"] == 0.4 and r["mode"] == mode]
        return {r["lock_number"]: r["moved"] for r in rows}

    slow = moved(6, "regressing")
    assert max(slow[g] for g in (2.0, 4.0, 6.0)) == slow[2.0] == pytest.approx(0.08, abs=0.005)
    assert "up to 8 %, at γ = 2" in study(6).caption
    assert study(6).numbers["μ at which TPP regressing splits, γ = 2"] == pytest.approx(0.349, abs=5e-4)
    assert study(6).numbers["μ at which Floquet locks at 1 per rev, γ = 2"] == pytest.approx(0.377, abs=5e-4)
    assert max(moved(7, "regressing").values()) == pytest.approx(0.17, abs=0.005)
    assert max(moved(7, "advancing").values()) == pytest.approx(0.02, abs=0.0005)
    assert max(list(moved(7, "coning").values())[:-1]) < 0.05
    for number, whole, half in ((6, {2.0}, {12.0, 14.0, 16.0}), (7, {10.0, 12.0}, set()),
                                (8, {6.0, 8.0}, {14.0, 16.0}), (9, {6.0, 8.0}, {16.0})):  # fmt: skip
        end = {r["lock_number"]: r["lock"] for r in study(number).table if r["advance_ratio"] == 0.4}
        assert {g for g, lock in end.items() if lock == 1.0} == whole
        assert {g for g, lock in end.items() if lock == 0.5} == half
    for number, split in ((6, {2.0}), (7, {10.0, 12.0, 14.0}), (8, {8.0}), (9, {6.0, 8.0, 10.0})):
        end = [r for r in study(number).table if r["advance_ratio"] == 0.4 and r["mode"] == "regressing"]
        assert {r["lock_number"] for r in end if r["tpp_1"].imag == 0.0} == split


# ---------------------------------------------------------------------- figures 10 to 12
def reduced(gamma: float, **values: float) -> Complex:
    """The three eigenvalues of −D⁻¹K of table 3."""
    D, K = closed_forms.table_3(closed_forms.truncated(gamma, **values))
    return np.linalg.eigvals(-np.linalg.solve(D, K))


@pytest.mark.parametrize("number", ORDERS)
def test_reduced_records_are_eigenvalues_of_table_3(number: int) -> None:
    name, values = ORDERS[number]
    table = study(number).table
    assert [(r[name], r["lock_number"]) for r in table] == [(v, g) for v in values for g in GAMMAS]
    for r in table:
        gamma, p = r["lock_number"], parameters(r)
        three = [r["cyclic_reduced"], r["cyclic_reduced"].conjugate(), r["coning_reduced"]]
        assert distances(three, reduced(gamma, **p)).max() < DOUBLE
        true: dict[str, Any] = closed_forms.hover(gamma, **p)
        assert nearest(r["coning"], true["coning"]) < DOUBLE and r["overdamped"] == (true["zeta"] > 1.0)
        pairs = true["cyclic"]
        wanted = pairs[np.argmax(pairs.real)] if true["zeta"] > 1.0 else pairs[2]  # the slower, or regressing
        assert nearest(r["cyclic"], [wanted, wanted.conjugate()]) < DOUBLE
        assert nearest(r["advancing"], pairs[np.argsort(pairs.real)[2:]] if true["zeta"] > 1.0 else pairs[:1]) < DOUBLE


@pytest.mark.parametrize("number", ORDERS)
def test_roots_are_those_of_the_complex_tilt(number: int) -> None:
    """η belongs to a₁ + i b₁ if its eigenvector has b₁ = −i a₁; of −η* it is b₁ = i a₁."""
    for r in study(number).table:
        D, K = closed_forms.table_3(closed_forms.truncated(r["lock_number"], **parameters(r)))
        tilt = np.array([0.0, 1.0, -1j])
        for s in (r["cyclic"], r["advancing"]):
            assert np.abs((s**2 * np.eye(3) + s * D + K) @ tilt).max() < 1e-11
        assert np.abs((r["cyclic_reduced"] * D + K) @ tilt).max() < 1e-11


@pytest.mark.parametrize("number", ORDERS)
def test_reduced_numbers_and_the_law_of_their_error(number: int) -> None:
    for r in study(number).table:
        c0 = closed_forms.truncated(r["lock_number"], **parameters(r))["c0"]
        assert r["cyclic_error"] == pytest.approx(abs(r["cyclic"]) / math.sqrt(4.0 + c0**2), rel=1e-7)
    for key, value in study(number).numbers.items():
        values = given(key)
        gamma = values.pop("gamma")
        c = closed_forms.truncated(gamma, **values)
        if "coning" in key:
            assert value == pytest.approx(-c["P2"] / c["c0"])
        else:
            true: dict[str, Any] = closed_forms.hover(gamma, **values)
            slow = max(true["cyclic"], key=lambda z: z.real) if true["zeta"] > 1.0 else true["cyclic"][2]
            assert value == pytest.approx(abs(slow) / math.sqrt(4.0 + c["c0"] ** 2), rel=1e-7)


# ---------------------------------------------------------------------- drawings
def lines(ax: Axes, gid: str) -> Iterator[Complex]:
    for line in ax.lines:
        if line.get_gid() == gid:
            yield np.asarray(line.get_xdata(), float) + 1j * np.asarray(line.get_ydata(), float)


def drawn(ax: Axes, gid: str) -> Complex:
    """What lines of one name show together, without gaps."""
    z = np.concatenate([*lines(ax, gid), np.empty(0)])
    return z[np.isfinite(z.real)]


def upper(z: Complex) -> Complex:
    return z.real + 1j * np.abs(z.imag)


@pytest.mark.parametrize("number", FAMILIES)
def test_carpets_show_every_root_and_join_it(number: int) -> None:
    name, values = FAMILIES[number]
    whole, enlarged, frequency = study(number).figure.axes
    for k, value in enumerate(values):
        of = {m: [r for r in study(number).table if r[name] == value and r["mode"] == m] for m in
              ("regressing", "coning", "advancing")}  # fmt: skip
        for mode, rows in of.items():
            for ax in (whole, enlarged) if mode == "regressing" else (whole,):
                dots, curve = drawn(ax, f"dots {mode} {k}"), drawn(ax, f"along {mode} {k}")
                assert np.allclose(upper(dots), [r["exponent_1"] for r in rows], atol=DOUBLE)
                assert all(nearest(z, curve) < 1e-6 for z in dots[[0, -1]])
                assert all(nearest(z, curve) < 0.02 for z in dots)  # points of a curve are 0.06 in γ apart
                for i, z in enumerate(dots):
                    assert nearest(z, drawn(ax, f"across {mode} {i}")) < 0.02
                assert np.abs(np.diff(curve)).max() < 0.1  # also through critical damping
        slow = [r["frequency"] for r in of["regressing"] if not r["overdamped"]]
        assert np.allclose(drawn(frequency, f"frequency dots {k}").imag, slow)
    fast = drawn(whole, "dots coning, faster 0")
    assert np.allclose(np.sort(fast.real), [-1.6325, -1.215], atol=1e-3) if number == 5 else not fast.size


def test_curves_go_through_critical_damping_itself() -> None:
    """At γ = 13.117 with K₁ = −0.2, where both cyclic pairs meet at Im η = 1."""
    gamma = study(5).numbers["critical Lock number, K₁ = -0.2"]
    meeting = complex(-gamma / 16.0, 1.0)
    whole = study(5).figure.axes[0]
    for mode in ("regressing", "advancing"):
        assert nearest(meeting, drawn(whole, f"along {mode} 0")) < 1e-6


@pytest.mark.parametrize("number", FORWARD)
def test_paths_show_every_mode_and_lock_number(number: int) -> None:
    table, axes = study(number).table, study(number).figure.axes
    by_title = {ax.get_title(loc="left"): ax for ax in axes}
    assert set(by_title) >= {"regressing", "coning", "advancing"}
    for title, ax in by_title.items():
        mode = title.split(",")[0]
        count = sum(str(line.get_gid()).startswith("hover") for line in ax.lines)
        assert count == 8 or title == "regressing, enlarged"
        for k, gamma in enumerate(GAMMAS[:count]):
            rows = [r for r in table if r["lock_number"] == gamma and r["mode"] == mode]
            simple = np.array([r[f"tpp_{i}"] for r in rows for i in (1, 2)])
            dots, curve = drawn(ax, f"TPP dots {k}"), drawn(ax, f"TPP {k}")
            assert all(nearest(z, dots) < DOUBLE and nearest(z, curve) < DOUBLE for z in upper(simple))
            assert all(nearest(z, upper(simple)) < DOUBLE for z in dots)
            free = np.array([r[f"exact_{i}"] for r in rows for i in (1, 2) if math.isnan(r["lock"])])
            dots, curve = drawn(ax, f"Floquet dots {k}"), drawn(ax, f"Floquet {k}")
            assert all(nearest(z, dots) < DOUBLE for z in upper(free))
            c0 = closed_forms.truncated(gamma, **FORWARD[number])["c0"]
            assert np.abs(curve.real + 0.5 * c0).max() < 1e-6  # vertical
            locked = [r for r in rows if r["lock"] >= 0.0]
            ticks = drawn(ax, f"Floquet locked dots {k}")
            assert len(ticks) == 2 * len(locked) and (not locked or len(drawn(ax, f"Floquet locked {k}")) > 2)
            if locked and locked[0]["rule"] in ("REALS", "JOINT"):
                assert all(nearest(z, ticks) < DOUBLE for r in locked for z in upper(np.array([r["exact_1"]])))
        words = [text.get_text() for text in ax.texts]
        assert [w for w in words if w.isdigit()] == [f"{g:g}" for g in GAMMAS[:count]]


@pytest.mark.parametrize("number", FORWARD)
def test_paths_of_the_plane_have_no_gaps_and_locked_ones_do_not_hide_each_other(number: int) -> None:
    overlaps = 0
    for ax in study(number).figure.axes:
        for k in range(8):
            for z in lines(ax, f"TPP {k}"):
                there = np.flatnonzero(np.isfinite(z.real))
                assert not there.size or np.abs(np.diff(z[there[0] : there[-1] + 1])).max(initial=0.0) < 0.08
        spans: dict[int, Complex] = {}
        widths = {str(line.get_gid()): line.get_linewidth() for line in ax.lines}
        depths = {str(line.get_gid()): line.get_zorder() for line in ax.lines}
        for k in range(8):
            here = drawn(ax, f"Floquet locked {k}") if f"Floquet locked {k}" in widths else np.empty(0, complex)
            for j, other in spans.items():
                covered = (
                    other.real.max() > here.real.min() and other.real.min() < here.real.max() if here.size else False
                )
                if covered and other.imag[0] == here.imag[0]:
                    assert widths[f"Floquet locked {k}"] > widths[f"Floquet locked {j}"] + 1.0
                    assert depths[f"Floquet locked {k}"] < depths[f"Floquet locked {j}"]
                    overlaps += 1
            if here.size:
                spans[k] = here
    assert (overlaps > 0) == (number != 9)


@pytest.mark.parametrize("number", ORDERS)
def test_orders_are_drawn_side_by_side(number: int) -> None:
    name, values = ORDERS[number]
    locus, error, decay = study(number).figure.axes
    assert len(list(lines(locus, "between"))) == 8 * len(values)
    for k, value in enumerate(values):
        rows = [r for r in study(number).table if r[name] == value]
        for gid, column in (("full", "cyclic"), ("reduced", "cyclic_reduced")):
            assert np.allclose(drawn(locus, f"{gid} dots {k}"), [r[column] for r in rows], atol=DOUBLE)
            assert all(nearest(r[column], drawn(locus, f"{gid} {k}")) < 0.02 for r in rows)
        for r in rows:
            assert any(nearest(r["cyclic"], z) < DOUBLE and nearest(r["cyclic_reduced"], z) < DOUBLE
                       for z in lines(locus, "between"))  # fmt: skip
        assert np.allclose(drawn(error, f"error dots {k}").imag, [100.0 * r["cyclic_error"] for r in rows])
        assert np.allclose(drawn(decay, f"reduced dots {k}").imag, [-r["coning_reduced"] for r in rows])
        assert np.allclose(drawn(decay, f"full dots {k}").imag, [-r["coning"].real for r in rows], atol=DOUBLE)


@pytest.mark.parametrize("number", [*FAMILIES, *FORWARD, *ORDERS])
def test_pages_name_their_axes_values_and_limits_and_no_text_covers_another(number: int) -> None:
    figure = study(number).figure
    figure.draw_without_rendering()
    assert figure.get_figwidth() == pytest.approx(PAGE)
    footer = figure.get_supxlabel().replace("\n", " ")
    assert footer.endswith(f"No dynamic inflow in {'the' if number in FAMILIES else 'either'} model.")
    assert ("member with Im η ≥ 0" in footer) == (number in FORWARD)
    legend = " ".join(
        [*(t.get_text() for t in figure.legends[0].get_texts()), figure.legends[0].get_title().get_text()]
    )
    for value in {**FAMILIES, **ORDERS}.get(number, ("", FORWARD.get(number, {}).values()))[1]:
        assert f"= {value:g}".replace("-", "−") in legend
    assert {"stable", "unstable"} <= {text.get_text() for text in figure.axes[0].texts}
    pieces = [figure.legends[0].get_window_extent(), *(ax.get_tightbbox() for ax in figure.axes)]
    assert not any(a.overlaps(b) for a, b in combinations(pieces, 2))
    assert all(figure.bbox.x0 <= b.x0 and b.x1 <= figure.bbox.x1 and b.y1 <= figure.bbox.y1 for b in pieces)
    for ax in figure.axes:
        label = ax.get_ylabel()
        assert label.endswith("(per rev)") or label == "error of the root (%)"
        if label.startswith("Im"):
            assert ax.get_xlabel().endswith("(per rev)") and ax.get_aspect() == 1.0
        boxes = [text.get_window_extent() for text in ax.texts if isinstance(text, Annotation)]
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


@pytest.mark.parametrize("number", [*FAMILIES, *FORWARD, *ORDERS])
def test_captions_say_what_was_chosen(number: int) -> None:
    shown = study(number)
    assert shown.title.startswith(f"Figure {number}. ") and shown.equations
    assert "hosen here" in shown.caption and "\n" not in shown.caption and "{" not in shown.caption
    assert "scan" not in shown.caption and not re.search(r"\d%", shown.caption) and len(shown.caption.split()) < 150


@pytest.mark.parametrize("number", ORDERS)
def test_captions_say_the_errors_of_their_own_figure(number: int) -> None:
    caption, (name, values) = study(number).caption, ORDERS[number]
    for gamma in (2.0, 8.0):
        true = [(closed_forms.hover(gamma, **{NAMES[name]: x}), closed_forms.truncated(gamma, **{NAMES[name]: x})["c0"])
                for x in values]  # fmt: skip
        errors = [100.0 * abs(t["cyclic"][2]) / math.sqrt(4.0 + c0**2) for t, c0 in true]  # type: ignore[index]
        assert f"{min(errors):.1f} to {max(errors):.1f} % at γ = {gamma:g}" in caption
        if gamma == 2.0:
            times = [t["P"] ** 2 / c0 / (c0 / 2.0) for t, c0 in true]  # type: ignore[operator]
            assert f"{min(times):.0f} to {max(times):.0f} times too fast at γ = 2" in caption


@pytest.mark.parametrize("number", ORDERS)
def test_one_label_for_every_coning_curve_where_they_are_one(number: int) -> None:
    decay = study(number).figure.axes[2]
    words = [text.get_text() for text in decay.texts if text.get_text().startswith("TPP, every")]
    assert words == {10: [], 11: [r"TPP, every $\kappa$"], 12: [r"TPP, every $K_1$ up to $\gamma$ = 13.1"]}[number]
