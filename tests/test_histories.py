"""Figures 13 and 14: responses against another integrator of transcribed equations, steady states in closed form."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from floquet import Rotor, multiblade
from floquet.exhibits import Exhibit, load
from floquet.plot.parts import DASHED, DOTTED
from floquet.response import step_response
from tests.truth import closed_forms as truth

STUDIES = Path(__file__).parent.parent / "studies" / "tp1431"
OFFSETS = {"figure-13": 0.0, "figure-14": 0.15}
OMEGA, GAMMA, MU, B_1C = 31.41, 8.0, 0.3, 2
PLANE, MODELS = ("a_0", "a_1", "b_1"), ("full", "unreduced", "reduced")
CLOSE = 1e-8  # of numbers of 1: solve_ivp at a relative tolerance of 1e-10
Array = NDArray[np.float64]

pytestmark = pytest.mark.parametrize("name", OFFSETS)


@cache
def exhibit(name: str) -> Exhibit:
    return load(STUDIES / f"{name}.py")


def lines(name: str) -> dict[str, dict[str, Any]]:
    """Coordinate → model → the line of the figure."""
    axes = [ax for ax in exhibit(name).figure.axes if ax.lines]
    return {
        coordinate: {str(line.get_gid()): line for line in ax.lines if line.get_gid() in MODELS}
        for coordinate, ax in zip((*PLANE, "beta"), axes, strict=True)
    }


def seconds(name: str) -> Array:
    return np.asarray(lines(name)["a_0"]["full"].get_xdata())


def solved(rate: Callable[[float, Array], Array], start: Array, psi: Array) -> Array:
    found = solve_ivp(rate, (psi[0], psi[-1]), start, method="DOP853", t_eval=psi, rtol=1e-10, atol=1e-12)
    return np.asarray(found.y.T)


def second_order(D: Callable[[float], Array], K: Callable[[float], Array], f: Callable[[float], Array],
                 psi: Array) -> Array:  # fmt: skip
    """Positions (k, n) of q'' + D q' + K q = f from rest."""
    n = len(f(0.0))

    def rate(at: float, x: Array) -> Array:
        return np.concatenate([x[n:], f(at) - D(at) @ x[n:] - K(at) @ x[:n]])

    return solved(rate, np.zeros(2 * n), psi)[:, :n]


def plane_matrices(eps: float) -> tuple[Array, Array, Array]:
    D, K = truth.table_3(truth.truncated(GAMMA, eps, mu=MU))
    return D, K, truth.table_3_forcing(GAMMA, eps, MU)[:, B_1C]


@cache
def truths(name: str) -> dict[str, dict[str, Array]]:
    """Coordinate → model → values at the figure's times, integrated here from tables 2 and 3 and eq. (1)."""
    eps, psi = OFFSETS[name], OMEGA * seconds(name)
    c, f = truth.truncated(GAMMA, eps, mu=MU), truth.forcing(GAMMA, eps, MU)
    D, K, F = plane_matrices(eps)
    parts: list[Callable[[float], Array]] = [lambda at, k=k: truth.table_2(c, f, at)[k] for k in range(3)]  # type: ignore[misc]
    four = second_order(parts[0], parts[1], lambda at: parts[2](at)[:, B_1C], psi)
    slope, push = -np.linalg.solve(D, K), np.linalg.solve(D, F)
    values = {
        "full": four[:, :3] * [1.0, -1.0, -1.0],
        "unreduced": second_order(lambda at: D, lambda at: K, lambda at: F, psi),
        "reduced": solved(lambda at, x: slope @ x + push, np.zeros(3), psi),
    }
    out = {n: {model: x[:, i] for model, x in values.items()} for i, n in enumerate(PLANE)}
    around = np.stack([np.ones_like(psi), -np.cos(psi), -np.sin(psi)], axis=-1)
    out["beta"] = {model: np.sum(around * x, axis=-1) for model, x in values.items()}
    out["beta"]["full"] = second_order(
        lambda at: np.array([[truth.blade_damping(c, at)]]), lambda at: np.array([[truth.blade_stiffness(c, at)]]),
        lambda at: truth.blade_forcing(f, at)[B_1C : B_1C + 1], psi,
    )[:, 0]  # fmt: skip
    return out


# ---------------------------------------------------------------------- curves
def test_every_curve_is_what_an_independent_integrator_gives(name: str) -> None:
    for coordinate, models in truths(name).items():
        for model, expected in models.items():
            found = lines(name)[coordinate][model]
            np.testing.assert_array_equal(found.get_xdata(), seconds(name))
            np.testing.assert_allclose(found.get_ydata(), expected, rtol=0, atol=CLOSE, err_msg=f"{coordinate} {model}")


def test_the_table_is_the_curves_in_seconds_and_revolutions(name: str) -> None:
    table = exhibit(name).table
    times = np.array([row["seconds"] for row in table])
    assert times[0] == 0.0 and times[-1] == seconds(name)[-1] and np.allclose(np.diff(times), 0.02)
    np.testing.assert_allclose([row["revolutions"] for row in table], OMEGA * times / (2.0 * np.pi), rtol=1e-14)
    places = np.searchsorted(seconds(name), times - 1e-9)
    for coordinate, models in truths(name).items():
        for model, expected in models.items():
            column = [row[f"{coordinate}_{model}"] for row in table]
            np.testing.assert_allclose(column, expected[places], rtol=0, atol=CLOSE)


def test_four_blades_solved_one_by_one_are_the_multiblade_equations(name: str) -> None:
    some = seconds(name)[:17:4]
    rotor = Rotor(lock_number=GAMMA, hinge_offset=OFFSETS[name], blades=4)
    found = step_response(multiblade(rotor, MU), {"B_1c": 1.0}, OMEGA * some).values[:, :3] * [1.0, -1.0, -1.0]
    for i, coordinate in enumerate(PLANE):
        np.testing.assert_allclose(lines(name)[coordinate]["full"].get_ydata()[:17:4], found[:, i], rtol=0, atol=1e-11)


# ---------------------------------------------------------------------- numbers
def test_steady_values_of_the_simple_models_are_the_solution_of_table_3(name: str) -> None:
    _, K, F = plane_matrices(OFFSETS[name])
    for coordinate, expected in zip(PLANE, np.linalg.solve(K, F), strict=True):
        assert exhibit(name).numbers[f"steady {coordinate}, simple models"] == pytest.approx(expected, rel=1e-12)


def test_steady_values_of_the_full_equations_are_the_first_harmonics_of_a_motion_that_repeats(name: str) -> None:
    """x₀ = (I − Φ)⁻¹ Γ over a revolution, then the blade's mean, cosine and sine."""
    c, f = truth.truncated(GAMMA, OFFSETS[name], mu=MU), truth.forcing(GAMMA, OFFSETS[name], MU)

    def rate(at: float, x: Array, push: float = 1.0) -> Array:
        force = push * truth.blade_forcing(f, at)[B_1C]
        return np.array([x[1], force - truth.blade_damping(c, at) * x[1] - truth.blade_stiffness(c, at) * x[0]])

    psi = np.linspace(0.0, 2.0 * np.pi, 129)
    Phi = np.stack([solved(lambda at, x: rate(at, x, 0.0), start, psi)[-1] for start in np.eye(2)], axis=-1)
    start = np.linalg.solve(np.eye(2) - Phi, solved(rate, np.zeros(2), psi)[-1])
    beta, around = solved(rate, start, psi)[:-1, 0], psi[:-1]
    expected = beta.mean(), -2.0 * np.mean(beta * np.cos(around)), -2.0 * np.mean(beta * np.sin(around))
    for coordinate, value in zip(PLANE, expected, strict=True):
        assert exhibit(name).numbers[f"steady {coordinate}, full equations"] == pytest.approx(value, abs=CLOSE)


def test_what_the_curves_settle_at(name: str) -> None:
    """After six revolutions e^(-0.4·6·2π) to e^(-0.3·6·2π), 3e-7 to 1e-5, of the step is left in the slow roots."""
    for coordinate in PLANE:
        for model in ("unreduced", "reduced"):
            last = lines(name)[coordinate][model].get_ydata()[-1]
            assert last == pytest.approx(exhibit(name).numbers[f"steady {coordinate}, simple models"], abs=3e-5)


def test_differences_and_time_constants(name: str) -> None:
    numbers, t = exhibit(name).numbers, truths(name)
    expected = {
        f"largest difference of {n}, {model} order": np.abs(x[model] - x["full"]).max()
        for n, x in t.items()
        for model in ("unreduced", "reduced")
    }
    eps = OFFSETS[name]
    D, K, _ = plane_matrices(eps)
    slow = np.linalg.eigvals(-np.linalg.solve(D, K)).real.max()
    c0 = truth.truncated(GAMMA, eps, mu=MU)["c0"]
    expected["longest time constant (s), reduced order"] = -1.0 / (OMEGA * slow)
    expected["longest time constant (s), full equations"] = 2.0 / (OMEGA * c0)  # outside locks σ is -c0/2
    far = np.any([np.abs(t[n]["reduced"] - t[n]["full"]) > 0.05 for n in PLANE], axis=0)
    expected["reduced order within 0.05 from (s)"] = seconds(name)[np.flatnonzero(far)[-1] + 1]
    given = {key: value for key, value in numbers.items() if not key.startswith("steady")}
    assert given == pytest.approx(expected, abs=2 * CLOSE)


def test_caption_says_the_numbers(name: str) -> None:
    found, t = exhibit(name), truths(name)
    for words in (
        f"within {max(np.abs(t[n]['unreduced'] - t[n]['full']).max() for n in PLANE):.3f}",
        f"{np.abs(t['b_1']['reduced'] - t['b_1']['full']).max():.2f} off",
        f"{found.numbers['longest time constant (s), reduced order']:.3f} s, that of the full equations",
    ):
        assert words in found.caption
    t_close = found.numbers["reduced order within 0.05 from (s)"]
    assert (
        f"From {t_close:.2f} s on, {OMEGA * t_close / (2.0 * np.pi):.2f} revolutions".lower() in found.caption.lower()
    )
    for coordinate, letter in (("a_1", "a₁"), ("b_1", "b₁")):
        simple, full = (found.numbers[f"steady {coordinate}, {x}"] for x in ("simple models", "full equations"))
        off = abs(simple - full)
        assert re.search(rf"{off:.4f} .*in {letter} \({100.0 * off / abs(full):.1f} %\)", found.caption)
    assert "scan" not in found.caption and len(found.caption.split()) < 170
    if name == "figure-13":
        over = (np.abs(t["a_0"][x]).max() - abs(found.numbers[f"steady a_0, {y}"])
                for x, y in (("reduced", "simple models"), ("full", "full equations")))  # fmt: skip
        assert "overshoots in a₀ by {:.3f} instead of {:.3f}".format(*over) in found.caption
    assert found.title.startswith(f"Figure {name[-2:]}.") and "{" not in found.caption and "\n" not in found.caption


# ---------------------------------------------------------------------- figure
def test_line_styles_names_and_axes(name: str) -> None:
    figure: Figure = exhibit(name).figure
    assert figure.get_figwidth() == pytest.approx(170.0 / 25.4)
    for models in lines(name).values():
        dashes = [models[model]._unscaled_dash_pattern[1] for model in MODELS]
        assert dashes == [None, DASHED[1], DOTTED[1]]
    (legend,) = figure.legends
    assert [text.get_text().split()[0] for text in legend.get_texts()] == ["full", "unreduced", "reduced"]
    panels = [ax for ax in figure.axes if ax.lines]
    assert all("rad per rad" in ax.get_ylabel() for ax in panels) and len(panels) == 4
    assert [ax.get_xlabel() for ax in panels[2:]] == ["time after the step (s)"] * 2
    figure.draw_without_rendering()
    for ax in panels[:2]:
        (above,) = ax.child_axes
        assert above.get_xlabel() == "revolutions"
        np.testing.assert_allclose(above.get_xlim(), np.array(ax.get_xlim()) * OMEGA / (2.0 * np.pi))


def test_every_text_is_inside_the_figure_and_titles_keep_to_their_panels(name: str) -> None:
    figure: Figure = exhibit(name).figure
    figure.draw_without_rendering()
    for ax in figure.axes:
        for artist in (ax._left_title, ax.xaxis.label, ax.yaxis.label, *figure.legends):
            box = artist.get_window_extent()
            assert box.x0 > -1 and box.x1 < figure.bbox.width + 1 and box.y0 > -1 and box.y1 < figure.bbox.height + 1
        assert ax._left_title.get_window_extent().x1 < ax.bbox.x1 + 1
