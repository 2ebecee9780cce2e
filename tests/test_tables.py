"""Tables 1 to 4: formulas are parsed and held against code and closed forms, roots against other solvers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from matplotlib.axes import Axes
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from floquet import PeriodicSystem, Rotor, multiblade, tip_path_plane
from floquet.exhibits import Exhibit, load
from floquet.models import FORCING
from tests.support import distances
from tests.truth import closed_forms as truth

STUDIES = Path(__file__).parent.parent / "studies" / "tp1431"
LETTERS = ("c0", "cs1", "k0", "kc1", "ks1", "kc2", "ks2")
REFERENCE = {"gamma": 8.0, "eps": 0.05, "kappa": 0.1, "K1": 0.2, "mu": 0.3, "m": 0.075, "s": 1.5}
BLADES = {"table-1": 3, "table-2": 4}
OMEGA = 31.41
PAGE = 170.0 / 25.4
Harmonics = NDArray[np.float64]


def random_rotors() -> list[dict[str, float]]:
    rng = np.random.default_rng(1431)
    low = np.array([3.0, 0.02, 0.05, -0.4, 0.05, 0.02, 1.2])
    high = np.array([14.0, 0.25, 0.4, 0.4, 0.5, 0.4, 2.0])
    names = ("gamma", "eps", "kappa", "K1", "mu", "m", "s")
    return [dict(zip(names, map(float, rng.uniform(low, high)), strict=True)) for _ in range(2)]


ROTORS = [*random_rotors(), REFERENCE]


@cache
def exhibit(name: str) -> Exhibit:
    return load(STUDIES / f"{name}.py")


def as_rotor(p: Mapping[str, float], blades: int = 4) -> Rotor:
    return Rotor(
        lock_number=p["gamma"], hinge_offset=p["eps"], hinge_stiffness=p["kappa"], pitch_flap_coupling=p["K1"],
        offset_mass_ratio=p["m"], static_moment_ratio=p["s"], blades=blades,
    )  # fmt: skip


def homogeneous(p: Mapping[str, float]) -> truth.Coefficients:
    return truth.truncated(p["gamma"], p["eps"], p["kappa"], p["K1"], p["mu"], p["m"])


def forced(p: Mapping[str, float]) -> truth.Forcing:
    return truth.forcing(p["gamma"], p["eps"], p["mu"], p["m"], p["s"])


@cache
def parsed(formula: str) -> sympy.Expr:
    names = (*LETTERS, *truth.HARMONICS, "P2", "gamma", "eps", "kappa", "K1", "mu", "m", "s")
    expression = sympy.sympify(formula, locals={name: sympy.Symbol(name) for name in names}, rational=True)
    assert {str(x) for x in expression.free_symbols} <= set(names), formula
    return expression


def evaluated(formula: str, values: Mapping[str, float]) -> float:
    return float(parsed(formula).evalf(subs={str(x): values[str(x)] for x in parsed(formula).free_symbols}))


def letters(p: Mapping[str, float], column: str) -> dict[str, float]:
    """The letters' values, those of f for the input of a column."""
    c, f = homogeneous(p), forced(p)
    index = FORCING.index(column) if column in FORCING else 0
    return {name: float(c[name]) for name in LETTERS} | {name: float(f[name][index]) for name in truth.HARMONICS}


def transformed(sample: Any, highest: int = 6) -> Harmonics:
    """Means and sines (0) and coefficients of cos hψ and sin hψ, (2, highest+1, rows, columns), of a matrix by FFT."""
    c = np.fft.rfft(sample(np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)), axis=0)[: highest + 1] / 16.0
    c[0] /= 2.0
    return np.stack([c.real, -c.imag])


def told(table: Iterable[Mapping[str, Any]], matrix: str, rows: tuple[str, ...], columns: tuple[str, ...],
         p: Mapping[str, float]) -> Harmonics:  # fmt: skip
    """What the formulas of a matrix say, in the layout of ``transformed``; zero where there is no record."""
    out = np.zeros((2, 7, len(rows), len(columns)))
    for r in table:
        if r["matrix"] == matrix:
            place, values = (rows.index(r["row"]), columns.index(r["column"])), letters(p, r["column"])
            out[0, 0, *place] = evaluated(r["mean"], values)
            if r["per_rev"]:
                out[0, r["per_rev"], *place] = evaluated(r["cosine"], values)
                out[1, r["per_rev"], *place] = evaluated(r["sine"], values)
            else:
                assert (r["cosine"], r["sine"]) == ("0", "0")
    return out


def parts(system: PeriodicSystem) -> dict[str, Any]:
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    return {"D": system.damping, "K": system.stiffness, "f": system.forcing}


# ---------------------------------------------------------------------- tables 1 and 2
@pytest.mark.parametrize("p", ROTORS, ids=["random", "another", "reference"])
@pytest.mark.parametrize("name", BLADES)
def test_formulas_give_every_harmonic_of_the_code_and_no_entry_is_missing(name: str, p: dict[str, float]) -> None:
    system, table = multiblade(as_rotor(p, BLADES[name]), p["mu"]), exhibit(name).table
    for matrix, code in parts(system).items():
        columns = FORCING if matrix == "f" else system.coordinates
        expected = told(table, matrix, system.coordinates, columns, p)
        np.testing.assert_allclose(transformed(code.sample), expected, rtol=0, atol=1e-13)  # rounding of numbers of 1


@pytest.mark.parametrize("name", BLADES)
def test_formulas_give_the_closed_forms(name: str) -> None:
    p, q = ROTORS[0], multiblade(as_rotor(REFERENCE, BLADES[name]), 0.3).coordinates
    closed = {3: truth.table_1, 4: truth.table_2}[BLADES[name]]
    for psi in (0.3, 1.9, 4.4):
        phase = np.arange(7) * psi
        for matrix, expected in zip("DKf", closed(homogeneous(p), forced(p), psi), strict=True):
            h = told(exhibit(name).table, matrix, q, FORCING if matrix == "f" else q, p)
            found = np.einsum("h,hij->ij", np.cos(phase), h[0]) + np.einsum("h,hij->ij", np.sin(phase), h[1])
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", BLADES)
def test_no_record_is_empty_or_given_twice(name: str) -> None:
    table = exhibit(name).table
    assert len({(r["matrix"], r["row"], r["column"]) for r in table}) == len(table)
    assert all((r["mean"], r["cosine"], r["sine"]) != ("0", "0", "0") for r in table)


@pytest.mark.parametrize("name", BLADES)
def test_values_are_the_formulas_of_the_reference_rotor(name: str) -> None:
    for r in exhibit(name).table:
        values = letters(REFERENCE, r["column"]) | REFERENCE
        for part in ("mean", "cosine", "sine"):
            assert r[f"{part}_value"] == pytest.approx(evaluated(r[part], values), rel=0, abs=1e-13), r


@pytest.mark.parametrize("p", ROTORS, ids=["random", "another", "reference"])
def test_letters_of_the_blade_are_spelled_out_in_its_parameters(p: dict[str, float]) -> None:
    found = {(r["row"], r["column"]): r["mean"] for r in exhibit("table-1").table if r["matrix"] == "blade"}
    c, f = homogeneous(p), forced(p)
    expected = {(name, ""): c[name] for name in LETTERS}
    expected |= {(h, x): f[h][i] for h in truth.HARMONICS for i, x in enumerate(FORCING) if f[h][i]}
    assert set(found) == set(expected)
    for key, formula in found.items():
        assert evaluated(formula, p) == pytest.approx(expected[key], rel=1e-13), key


def test_sizes_of_what_the_tip_path_plane_drops() -> None:
    c = homogeneous(REFERENCE)
    first = {"D": c["cs1"] / 2, "K": max(np.hypot(c["cs1"] + c["kc1"], c["ks1"]) / 2, np.hypot(c["kc2"], c["ks2"]))}
    numbers = exhibit("table-1").numbers
    assert numbers == pytest.approx({
        "largest periodic term of D": first["D"], "largest periodic term of K": first["K"],
        "largest periodic term of D over c0": first["D"] / c["c0"],
        "largest periodic term of K over k0": first["K"] / c["k0"],
    }, rel=1e-12)  # fmt: skip
    assert exhibit("table-2").numbers == pytest.approx({
        "largest periodic term within the plane": np.hypot(c["kc2"], c["ks2"]) / 2,
        "largest periodic term of the coupling with beta_d": max(c["cs1"], np.hypot(c["kc1"], c["ks1"])),
        "largest periodic term of three blades": first["K"],
    }, rel=1e-12)  # fmt: skip


# ---------------------------------------------------------------------- table 3
@pytest.mark.parametrize("p", ROTORS, ids=["random", "another", "reference"])
@pytest.mark.parametrize("words", ["mean", "in_parameters"])
def test_tip_path_plane_in_letters_and_in_parameters_is_the_code_and_the_closed_form(
    words: str, p: dict[str, float]
) -> None:
    system, c = tip_path_plane(as_rotor(p), p["mu"]), homogeneous(p)
    forcing = truth.table_3_forcing(p["gamma"], p["eps"], p["mu"], p["m"], p["s"])
    for matrix, closed in zip("DKf", (*truth.table_3(c), forcing), strict=True):
        columns = FORCING if matrix == "f" else system.coordinates
        found = np.zeros(closed.shape)
        for r in exhibit("table-3").table:
            if r["matrix"] == matrix:
                values = {**p, "P2": c["P2"]} if words == "in_parameters" else letters(p, r["column"])
                place = system.coordinates.index(r["row"]), columns.index(r["column"])
                found[place] = evaluated(r[words], values)
                if p is REFERENCE:
                    assert r["mean_value"] == pytest.approx(closed[place], rel=0, abs=1e-13), r
        np.testing.assert_allclose(found, closed, rtol=0, atol=1e-13)
        np.testing.assert_allclose(parts(system)[matrix].mean(), closed, rtol=0, atol=1e-13)


def test_numbers_of_the_tip_path_plane() -> None:
    c = homogeneous(REFERENCE)
    lift = -8.0 * 0.3 * 0.05 * (1.0 - 2.0 * 0.05) / 8.0
    expected = {name: c[name] for name in ("kc1", "cs1", "ks1")}
    expected |= {"a1 in the equation of a0": lift, "det K": np.linalg.det(truth.table_3(c)[1])}
    assert exhibit("table-3").numbers == pytest.approx(expected, rel=1e-12)


# ---------------------------------------------------------------------- matrices in letters
COORDINATES = {"β₀": "beta_0", "β₁c": "beta_1c", "β₁s": "beta_1s", "β_d": "beta_d", "a₀": "a_0", "a₁": "a_1",
               "b₁": "b_1"}  # fmt: skip
INPUTS = dict(zip(("θ₀", "A₁c", "B₁c", "θ_t", "λ", "p/Ω", "q/Ω", "ṗ/Ω²", "q̇/Ω²", "((ẇ−uq+pv)−g)/(Ω²R)"), FORCING,
                  strict=True))  # fmt: skip


def read_back(cell: str) -> sympy.Expr:
    """``−γμ²/8 (1 − ε)² cos 3ψ`` as an expression in letters, cosines and sines."""
    cell = re.sub(r" (cos|sin) (\d)ψ", r" * \1\2", cell)
    for shown, written in {"γ": " gamma ", "κ": " kappa ", "ε": " eps ", "μ": " mu ", "K₁": " K1 ", "P²": " P2 ",
                           "²": "**2 ", "−": "-"}.items():  # fmt: skip
        cell = cell.replace(shown, written)
    cell = re.sub(r"(?<=[\w)]) +(?=[\w(])", " * ", re.sub(r"(?<=\d)(?= (?:gamma|kappa|eps|mu|K1))", " *", cell))
    cell = re.sub(r"(\w) +\*\*", r"\1**", cell).replace("* *", "*")
    names = (*LETTERS, *truth.HARMONICS, "P2", "gamma", "eps", "kappa", "K1", "mu", "m", "s")
    names += tuple(f"{wave}{n}" for wave in ("cos", "sin") for n in (2, 3, 4))
    return sympy.sympify(cell, locals={name: sympy.Symbol(name) for name in names}, rational=True)


def blocks(name: str) -> dict[str, list[list[str]]]:
    """Matrices of the text by name, cells of every line."""
    cells = [[re.split(r" {2,}", line) for line in block.splitlines()] for block in exhibit(name).text.split("\n\n")]
    return {block[0][0]: block for block in cells}


@pytest.mark.parametrize("name", [*BLADES, "table-3"])
def test_text_has_every_entry_that_is_not_zero(name: str) -> None:
    found = {}
    for matrix, block in blocks(name).items():
        if matrix == "f":
            found |= {("f", COORDINATES[row]): read_back(cell) for row, cell in block[1:]}
        elif matrix == "f̃":
            cells = [(row, zip(block[0][1:], line, strict=True)) for row, *line in block[1:]]
            found |= {("f", COORDINATES[a], INPUTS[row]): read_back(x) for row, line in cells for a, x in line}
        elif matrix != "letters":
            cells = [(row, zip(block[0][1:], line, strict=True)) for row, *line in block[1:]]
            found |= {
                (matrix[0], COORDINATES[row], COORDINATES[a]): read_back(x) for row, line in cells for a, x in line
            }
    expected: dict[Any, sympy.Expr] = {}
    for r in exhibit(name).table:
        place, n = (r["matrix"], r["row"], r["column"]), r.get("per_rev", 0)
        if name == "table-3":
            expected[place] = parsed(r["in_parameters" if r["matrix"] == "f" else "mean"])
        elif r["matrix"] in "DK":
            waves = sympy.Symbol(f"cos{n}"), sympy.Symbol(f"sin{n}")
            expected[place] = parsed(r["mean"]) + parsed(r["cosine"]) * waves[0] + parsed(r["sine"]) * waves[1]
        elif r["matrix"] == "f":  # letters that this input has
            told = str(found["f", r["row"]])
            assert all(x == "0" or x.removeprefix("-") in told for x in (r["mean"], r["cosine"], r["sine"]))
    if name != "table-3":
        assert all(place in expected for place, x in found.items() if len(place) == 3 and x != 0)
        assert sum(place[0] == "f" for place in found) == BLADES[name]
    for place, formula in expected.items():
        assert sympy.simplify(found[place] - formula) == 0, place
    assert max(map(len, exhibit(name).text.splitlines())) <= 150 and "*" not in exhibit(name).text


@pytest.mark.parametrize("name", [*BLADES, "table-3"])
def test_text_spells_out_the_letters(name: str) -> None:
    found = {(INPUTS.get(x, ""), told.split(" = ")[0]): told.split(" = ")[1] for x, told in blocks(name)["letters"][1:]}
    spelled = {(r["column"], r["row"]): r["mean"] for r in exhibit("table-1").table if r["matrix"] == "blade"}
    expected = {key: x for key, x in spelled.items() if name != "table-3" or not key[0]}
    assert set(found) == set(expected)
    for key, formula in expected.items():
        assert sympy.simplify(read_back(found[key]) - parsed(formula)) == 0, key


# ---------------------------------------------------------------------- table 4
def of_row(r: Mapping[str, Any]) -> dict[str, float]:
    names = {"gamma": "lock_number", "eps": "hinge_offset", "kappa": "hinge_stiffness", "K1": "pitch_flap_coupling"}
    return {letter: float(r[name]) for letter, name in names.items()} | {"mu": 0.3, "m": 1.5 * float(r["hinge_offset"])}


def by_rotor() -> list[tuple[dict[str, float], list[Mapping[str, Any]]]]:
    table = exhibit("table-4").table
    rotors = list(dict.fromkeys(tuple(of_row(r).items()) for r in table))
    return [(dict(p), [r for r in table if tuple(of_row(r).items()) == p]) for p in rotors]


def with_conjugates(z: Iterable[complex]) -> NDArray[np.complex128]:
    """Roots of a table in which a row stands for its conjugate too, unless that has a row."""
    given = [x for x in z if np.isfinite(x)]
    more = [x.conjugate() for x in given if x.imag and not np.any(np.abs(np.array(given) - x.conjugate()) < 1e-9)]
    return np.array([*given, *more])


def multipliers(p: Mapping[str, float]) -> NDArray[np.complex128]:
    c = homogeneous(p)

    def rate(psi: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
        q, v = x.reshape(2, 2)
        return np.concatenate([v, -truth.blade_damping(c, psi) * v - truth.blade_stiffness(c, psi) * q])

    end = solve_ivp(rate, (0.0, 2.0 * np.pi), np.eye(2).ravel(), method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    return np.linalg.eigvals(end.reshape(2, 2)).astype(complex)


def test_table_4_has_the_rotors_it_names() -> None:
    zero = {"eps": 0.0, "kappa": 0.0, "K1": 0.0, "mu": 0.3, "m": 0.0}
    expected = [{**zero, "gamma": gamma} for gamma in range(2, 17, 2)]
    expected += [{**zero, "gamma": 8, **x} for x in ({"eps": 0.15, "m": 0.225}, {"kappa": 0.225}, {"K1": 0.225})]
    assert [p for p, _ in by_rotor()] == [pytest.approx(x) for x in expected]


def test_roots_of_both_orders_are_those_of_the_closed_form() -> None:
    for p, rows in by_rotor():
        D, K = truth.table_3(homogeneous(p))
        companion = np.block([[np.zeros((3, 3)), np.eye(3)], [-K, -D]])
        unreduced = with_conjugates(r["unreduced"] for r in rows)
        reduced = with_conjugates(r["reduced"] for r in rows)
        assert distances(unreduced, np.linalg.eigvals(companion)).max() < 1e-7  # near a double root, √ of rounding
        assert distances(reduced, np.linalg.eigvals(-np.linalg.solve(D, K))).max() < 1e-7
        assert len(unreduced) == 6 and len(reduced) == 3


def test_exact_exponents_are_logarithms_of_multipliers() -> None:
    for p, rows in by_rotor():
        Lambda = multipliers(p)
        for r in rows:
            if r["exact_is_mean"]:
                assert r["exact"].real == pytest.approx(np.log(np.abs(Lambda)).mean() / (2.0 * np.pi), abs=1e-9)
                assert 2.0 * r["exact"].imag == pytest.approx(round(2.0 * r["exact"].imag), abs=1e-9)
            else:
                assert np.abs(np.exp(2.0 * np.pi * r["exact"]) / Lambda - 1.0).min() < 1e-7
            assert abs(r["exact"] - r["unreduced"]) < 0.3, "the branch of the mode"
            for model in ("unreduced", "reduced", "exact"):
                np.testing.assert_allclose(r[f"{model}_rad_s"], OMEGA * r[model], rtol=1e-14)


def test_published_reference_points_at_lock_number_8() -> None:
    ((_, rows),) = [(p, rows) for p, rows in by_rotor() if p["gamma"] == 8 and not p["eps"] + p["kappa"] + p["K1"]]
    found = {r["mode"]: (r["unreduced"], r["reduced"]) for r in rows}
    expected = {"regressing": (-0.5131 + 0.1403j, -0.3993 + 0.2092j), "coning": (-0.4982 + 0.8428j, -0.9982),
                "advancing": (-0.4887 + 1.8548j, np.nan)}  # fmt: skip
    for mode, (unreduced, reduced) in expected.items():
        np.testing.assert_allclose(found[mode][0], unreduced, atol=6e-5)  # four digits
        np.testing.assert_allclose(found[mode][1], reduced, atol=6e-5)


def test_distances_of_both_orders_from_the_exact_regressing_exponents() -> None:
    expected = {}
    for gamma in (2, 8, 16):
        p = {"gamma": gamma, "eps": 0.0, "kappa": 0.0, "K1": 0.0, "mu": 0.3, "m": 0.0}
        D, K = truth.table_3(homogeneous(p))
        companion = np.block([[np.zeros((3, 3)), np.eye(3)], [-K, -D]])
        slow = np.linalg.eigvals(-np.linalg.solve(D, K))
        fast_damped = np.log(multipliers(p)[np.argmin(np.abs(multipliers(p)))]) / (2.0 * np.pi)
        # ρ is next to 1 from below, or ½: the regressing exponent turns with 1 − ρ
        eta = complex(fast_damped.real, abs(fast_damped.imag))
        for model, z in (("unreduced", np.linalg.eigvals(companion)), ("reduced", slow[slow.imag > 0])):
            near = z[z.imag > 0][np.argmin(np.abs(z[z.imag > 0] - eta))]
            expected[f"{model} order, regressing, from the exact one, γ = {gamma}"] = abs(near - eta) / abs(eta)
            if gamma == 8 and model == "reduced":
                expected["damping of the slow pair, reduced order, γ = 8"] = near.real
                expected["frequency of the slow pair, reduced order, γ = 8"] = near.imag
    assert exhibit("table-4").numbers == pytest.approx(expected, rel=1e-6)


# ---------------------------------------------------------------------- figures
def drawn(ax: Axes) -> dict[str, Any]:
    return {str(line.get_gid()): line for line in ax.lines if line.get_gid()}


@pytest.mark.parametrize("name", BLADES)
def test_figure_shows_every_periodic_entry_less_its_mean_and_says_both(name: str) -> None:
    n = BLADES[name]
    found = {gid: (line, ax) for ax in exhibit(name).figure.axes for gid, line in drawn(ax).items()}
    closed = {3: truth.table_1, 4: truth.table_2}[n]
    psi = np.radians(next(iter(found.values()))[0].get_xdata())
    assert psi[0] == 0.0 and psi[-1] == pytest.approx(2.0 * np.pi * (1 / 3 if n == 3 else 1 / 2))
    samples = [closed(homogeneous(REFERENCE), forced(REFERENCE), x)[:2] for x in psi]
    for k, matrix in enumerate("DK"):
        entries = np.array([sample[k] for sample in samples])
        means = entries[:-1].mean(axis=0)  # over whole periods of every harmonic
        for i, j in np.ndindex(n, n):
            swing = entries[:, i, j] - means[i, j]
            if np.abs(swing).max() > 1e-12:
                line, ax = found.pop(f"{matrix} {i} {j}")
                np.testing.assert_allclose(line.get_ydata(), swing, atol=1e-12)
                (text,) = (t.get_text() for t in ax.texts if "±" in t.get_text())
                mean, amplitude = (float(x.replace("\N{MINUS SIGN}", "-")) for x in text.split("±"))
                assert mean == pytest.approx(means[i, j], abs=0.006)  # two decimals
                assert amplitude == pytest.approx(np.abs(swing).max(), abs=0.006)
    assert not found


def test_figure_of_table_3_shows_what_forward_flight_adds() -> None:
    found = {gid: line for ax in exhibit("table-3").figure.axes for gid, line in drawn(ax).items()}
    for changed, label in (({}, r"$\varepsilon$ = $K_1$ = 0"), ({"eps": 0.15}, r"$\varepsilon$ = 0.15"),
                           ({"K1": 0.225}, r"$K_1$ = 0.225")):  # fmt: skip
        mu = next(iter(found.values())).get_xdata()
        planes = [truth.table_3(truth.truncated(**{"gamma": 8.0, "mu": x, **changed})) for x in mu]
        for k, matrix in enumerate("DK"):
            change = np.array([plane[k] - planes[0][k] for plane in planes])
            for i, j in np.ndindex(3, 3):
                if np.abs(change[:, i, j]).max() > 1e-12:
                    line = found.pop(f"{matrix} {i} {j} {label}")
                    np.testing.assert_allclose(line.get_ydata(), change[:, i, j], atol=1e-12)
    assert not found
    formulas = [t.get_text() for ax in exhibit("table-3").figure.axes for t in ax.texts]
    assert {"$(c_{s1} - k_{c1})/2$", "$-c_{0} + k_{s2}/2$", "$-2$"} <= set(formulas)


def test_figure_of_table_4_shows_every_root() -> None:
    axes = {ax.get_title(loc="left"): ax for ax in exhibit("table-4").figure.axes}
    table = exhibit("table-4").table
    series = [r for r in table if not r["hinge_offset"] + r["hinge_stiffness"] + r["pitch_flap_coupling"]]
    for model in ("exact", "unreduced", "reduced"):
        shown = [line for line in axes[r"all modes, with $\gamma$"].lines if str(line.get_gid()).startswith(model)]
        z = np.array([complex(line.get_xdata()[0], line.get_ydata()[0]) for line in shown])
        np.testing.assert_array_equal(z, [r[model] for r in series])
    assert [title for title in axes if "=" in title][1:] == [
        "regressing\n" + x for x in (r"$\varepsilon$ = 0.15", r"$\kappa$ = 0.225", r"$K_1$ = 0.225")
    ]


@pytest.mark.parametrize("name", ["table-1", "table-2", "table-3", "table-4"])
def test_figure_is_a_page_wide_and_every_text_is_inside(name: str) -> None:
    figure = exhibit(name).figure
    figure.draw_without_rendering()
    assert figure.get_figwidth() == pytest.approx(PAGE)
    texts = [t for ax in figure.axes for t in (*ax.texts, ax.title, ax._left_title, ax.xaxis.label, ax.yaxis.label)]
    legends = [x for x in (*figure.legends, *(ax.get_legend() for ax in figure.axes)) if x is not None]
    for artist in [*(t for t in texts if t.get_text() and t.get_visible()), *legends]:
        box = artist.get_window_extent()
        assert box.x0 > -1 and box.x1 < figure.bbox.width + 1 and box.y0 > -1 and box.y1 < figure.bbox.height + 1, (
            artist
        )


def test_captions_say_the_numbers() -> None:
    c = homogeneous(REFERENCE)
    first = max(np.hypot(c["cs1"] + c["kc1"], c["ks1"]) / 2, np.hypot(c["kc2"], c["ks2"]))
    said = {
        "table-1": (f"{c['cs1'] / 2:.2f} in D", f"c0 is {c['c0']:.2f}", f"{first:.2f} in K", f"k0 is {c['k0']:.2f}"),
        "table-2": (f"{np.hypot(c['kc2'], c['ks2']) / 2:.2f} at most", f"have {first:.2f}",
                    f"up to {np.hypot(c['kc1'], c['ks1']):.2f}"),
        "table-3": (*(f"−{x} = −{c[x]:.2f}" for x in ("kc1", "cs1", "ks1")), "= −0.0135 alone"),
        "table-4": ("22 % away", "order's 3.4 %", "6.4 % at γ = 2", "61 % at γ = 16"),  # of the numbers tested above
    }  # fmt: skip
    for name, words in said.items():
        assert all(word in exhibit(name).caption for word in words), name


@pytest.mark.parametrize("name", ["table-1", "table-2", "table-3", "table-4"])
def test_study_says_what_it_shows(name: str) -> None:
    found = exhibit(name)
    assert found.title.startswith(f"Table {name[-1]}.") and "{" not in found.caption and "\n" not in found.caption
    assert ("econstructed" in found.caption) == (name == "table-4")
    assert "scan" not in found.caption and not re.search(r"\d%", found.caption)
