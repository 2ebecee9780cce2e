"""What is drawn equals what is computed, is labelled with units and covers nothing; files are whole or absent."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation

from floquet import Hub, Rotor, flapping, lock_windows, stability, sweep, teetering
from floquet.comparison import Metric, Rule, compare, eigenvalues, simple_model
from floquet.errors import ParameterError, StorageError
from floquet.plot import (
    ATLAS,
    KINDS,
    RotorRows,
    eigenvalues_vs_mu,
    error_vs_mu,
    lock_bands,
    plot_database,
    root_locus,
    validity_summary,
)
from floquet.plot.at_edges import errors_of
from floquet.plot.curves import Failing, all_intervals, exact_curves, tpp_curves
from floquet.plot.parts import COLOURS, COLUMN, per_rev
from floquet.query import Database
from floquet.study import load_study
from floquet.study import run as run_study
from floquet.sweep import INTERVALS, Plan, limit_rows, point_rows
from floquet.validity import split_edges

ROTORS = {
    "hingeless": Rotor(lock_number=5.07, hinge_stiffness=0.25),  # lock at 1 per rev from .558
    "soft": Rotor(lock_number=7.12, hinge_stiffness=0.2),  # the same from .047
    "teetering": Rotor(lock_number=6.0, hub=Hub.TEETERING, blades=2),  # the same from .607, never fails
    "heavy": Rotor(lock_number=12.0, blades=3),  # lock at ½ per rev from .214 to .960
    "overdamped": Rotor(lock_number=20.0),  # locked in hover, ρ = 0, and at ½ per rev from .389
    "stiff": Rotor(lock_number=8.0, hinge_stiffness=1.6, blades=3),  # lock at 1½ per rev: every mode against the mean
}
BY_ROTOR = [kind for kind in KINDS if kind != ATLAS]
STEP = 0.01
DASHES = ("--", ":")


def computed(rotor: Rotor, mu: Any) -> RotorRows:
    plan = Plan(rotors=(rotor,), advance_ratio=np.asarray(mu))
    return RotorRows("x", point_rows(plan, 0, plan.points), limit_rows(plan, 0, 1))


@pytest.fixture(scope="module")
def rows() -> dict[str, RotorRows]:
    mu = np.round(np.arange(0.0, 1.0 + STEP / 2.0, STEP), 10)
    return {name: computed(rotor, mu)._replace(name=name) for name, rotor in ROTORS.items()}


def drawn(ax: Axes, label: str) -> Line2D:
    (line,) = [line for line in ax.lines if line.get_label() == label]
    return line


def spans(ax: Axes, gid: str) -> list[Rectangle]:
    return [p for p in ax.patches if isinstance(p, Rectangle) and str(p.get_gid()).startswith(gid)]


def texts(ax: Axes) -> str:
    legend = ax.get_legend()
    words = [t.get_text() for t in ax.texts] + ([t.get_text() for t in legend.get_texts()] if legend else [])
    return "\n".join([*words, ax.get_title(loc="left"), ax.get_xlabel(), ax.get_ylabel()])


# ---------------------------------------------------------------------- curves
@pytest.mark.parametrize("name", ["hingeless", "soft", "teetering", "heavy", "stiff"])
def test_bands_from_rows_are_the_lock_windows(rows: dict[str, RotorRows], name: str) -> None:
    found, true = lock_bands(rows[name].points), lock_windows(ROTORS[name])
    assert [band[2] for band in found] == [window[2] for window in true]
    for band, window in zip(found, true, strict=True):
        assert band[:2] == pytest.approx(window[:2], abs=1e-7)  # 7e-9 measured with rows 0.01 apart


def test_locks_that_follow_within_a_step_are_two_bands_that_end_at_rows(rows: dict[str, RotorRows]) -> None:
    first, second = lock_bands(rows["overdamped"].points)
    assert first[0] == 0.0 and first[2] == 0.0 and second[1] == math.inf and second[2] == 0.5
    true = lock_windows(ROTORS["overdamped"])
    assert abs(first[1] - true[0][1]) < STEP and abs(second[0] - true[1][0]) < STEP


@pytest.mark.parametrize("name", ["hingeless", "soft", "teetering", "heavy", "stiff"])
def test_curves_between_rows_are_the_exponents(rows: dict[str, RotorRows], name: str) -> None:
    """Also beside lock edges, where curves through the rows alone would be wrong by 0.02."""
    rotor, exact = ROTORS[name], exact_curves(rows[name].points)
    there = np.isfinite(exact.mu)
    assert np.count_nonzero(there) > len(rows[name].points["advance_ratio"]) + 20
    true = stability((teetering if rotor.hub else flapping)(rotor, exact.mu[there]))
    both = np.where(np.isnan(exact.sigma[there, 1:]), exact.sigma[there, :1], exact.sigma[there])
    assert np.abs(both - true.exponents.real).max() < 2e-4  # 9e-5 measured, at the half-per-rev edge
    assert np.abs(exact.rho[there] - true.rotation_number).max() < 1e-5


@pytest.mark.parametrize("name", ["hingeless", "soft", "teetering", "heavy"])
def test_tpp_curves_between_rows_are_eigenvalues(rows: dict[str, RotorRows], name: str) -> None:
    rotor = ROTORS[name]
    for mode, (mu, z) in tpp_curves(rows[name].points).items():
        for member in (0, 1) if mode != "differential" else ():
            there = np.isfinite(mu) & np.isfinite(z[:, member].real)
            true = eigenvalues(simple_model(rotor, mu[there], model="teetering" if rotor.hub else "flapping"))
            assert there.sum() == 0 or np.abs(true - z[there, member][:, None]).min(axis=1).max() < 1e-5
        assert np.nanmin(z.imag) >= 0.0


def test_pairs_that_the_assignment_halved_are_drawn_whole(rows: dict[str, RotorRows]) -> None:
    """In a lock the least distance may give a mode one eigenvalue each of two pairs, whose mean is no eigenvalue."""
    points = {k: np.array(v) for k, v in rows["overdamped"].points.items()}
    i = int(np.searchsorted(points["advance_ratio"], 0.2))
    before = tpp_curves(points)
    points["tpp_regressing_2"][i], points["tpp_coning_2"][i] = points["tpp_coning_2"][i], points["tpp_regressing_2"][i]
    assert abs((points["tpp_regressing_1"][i] + points["tpp_regressing_2"][i]).imag) > 0.01
    for mode, (mu, z) in tpp_curves(points).items():
        assert np.array_equal(np.isfinite(mu), np.isfinite(before[mode][0]))
        assert np.nanmax(np.abs(z - before[mode][1])) < 1e-12


def test_names_that_change_break_the_line(rows: dict[str, RotorRows]) -> None:
    points = {k: np.array(v) for k, v in rows["heavy"].points.items()}
    late = points["advance_ratio"] > 0.3
    for i in (1, 2):
        a, b = f"tpp_coning_{i}", f"tpp_advancing_{i}"
        points[a], points[b] = np.where(late, points[b], points[a]), np.where(late, points[a], points[b])
    mu, _ = tpp_curves(points)["advancing"]
    (gap,) = np.flatnonzero(np.isnan(mu[1:-1])) + 1
    assert mu[gap - 1] == pytest.approx(0.3) and mu[gap + 1] == pytest.approx(0.31)


def test_failed_rows_leave_a_gap(rows: dict[str, RotorRows]) -> None:
    points = {k: np.array(v) for k, v in rows["hingeless"].points.items()}
    points["rotation_number"][30:33] = np.nan
    exact = exact_curves(points)
    inside = (exact.mu > 0.295) & (exact.mu < 0.325)
    assert not inside.any() and np.isnan(exact.mu[1:-1]).any()
    assert exact.bands == lock_bands(rows["hingeless"].points)


def test_rows_in_any_order_give_the_same_curves(rows: dict[str, RotorRows]) -> None:
    points = rows["heavy"].points
    order = np.random.default_rng(3).permutation(len(points["advance_ratio"]))
    mixed = {name: np.asarray(values)[order] for name, values in points.items()}
    assert np.array_equal(exact_curves(mixed).sigma, exact_curves(points).sigma, equal_nan=True)
    assert lock_bands(mixed) == lock_bands(points)


def test_intervals_that_the_limits_have_no_room_for_come_from_the_rows() -> None:
    starts = np.arange(8) / 10.0
    mu = np.round(np.arange(0.0, 1.0, 0.01), 10)
    bad = np.any([(mu >= a) & (mu < a + 0.045) for a in starts], axis=0)
    points = {"advance_ratio": mu, "error_regressing": np.where(bad, 0.06, 0.01)}
    stored = tuple((float(a), float(a) + 0.045) for a in starts[:INTERVALS])
    found = Failing(0.0, stored, 8, Rule.PAIRED, 0.05, 1.0)  # type: ignore[arg-type]
    intervals = all_intervals(points, "regressing", found)
    assert intervals[:INTERVALS] == stored
    assert [x for pair in intervals[INTERVALS:] for x in pair] == pytest.approx([0.6, 0.64, 0.7, 0.74])


# ---------------------------------------------------------------------- eigenvalues against μ
@pytest.mark.parametrize("name", ROTORS)
def test_eigenvalues_bands_limit_lines_and_labels(rows: dict[str, RotorRows], name: str) -> None:
    one = rows[name]
    upper, lower = eigenvalues_vs_mu(one.points, one.limits, name=name)
    bands = lock_bands(one.points)
    for ax in (upper, lower):
        patches = spans(ax, "lock")
        assert [(p.get_x(), p.get_x() + p.get_width()) for p in patches] == [
            pytest.approx((a, min(b, 1.0))) for a, b, _ in bands
        ]
    assert all(f"lock, {per_rev(lock)}" in texts(upper) for *_, lock in bands)
    limit = float(one.limits["limit"][0])
    marks = [line.get_xdata() for ax in (upper, lower) for line in ax.lines if line.get_gid() == "limit"]
    assert marks == ([[limit, limit]] * 2 if limit < math.inf else [])
    assert f"= {limit:.3f}" in texts(upper) or limit == math.inf
    strips = [(p.get_x(), p.get_x() + p.get_width()) for p in spans(upper, "failing")]
    count = int(one.limits["intervals"][0])
    ends = [
        (one.limits[f"interval_{k}_start"][0], min(one.limits[f"interval_{k}_end"][0], 1.0))
        for k in range(1, count + 1)
    ]
    assert strips == [pytest.approx(pair) for pair in ends]
    assert all(p.get_y() > 0.9 for p in spans(upper, "failing"))  # a hint at the top of the panel, in its own units
    assert "per rev" in upper.get_ylabel() and "per rev" in lower.get_ylabel()
    assert "dimensionless" in lower.get_xlabel()
    parameters = (
        f"= {ROTORS[name].blades}",
        f"= {ROTORS[name].lock_number:.4g}",
        f"= {ROTORS[name].flap_frequency:.4g}",
    )
    assert all(word in upper.get_title(loc="left") for word in (name, *parameters))
    assert "No dynamic inflow" in upper.figure.get_supxlabel()
    legend = upper.get_legend()
    assert legend is not None
    assert all(h.get_linewidth() > 0 or isinstance(h, Rectangle) for h in legend.legend_handles)
    assert limit < math.inf or "regressing within 5 % up to" in texts(upper)


@pytest.mark.parametrize("name", ["hingeless", "teetering", "heavy"])
def test_floquet_is_solid_tpp_dashed_one_colour_a_mode(rows: dict[str, RotorRows], name: str) -> None:
    upper, lower = eigenvalues_vs_mu(rows[name].points, rows[name].limits)
    modes = [mode.name for mode in compare(ROTORS[name], 0.0).modes]
    for mode in modes:
        assert drawn(upper, f"Floquet, {mode}").get_linestyle() == "-"
        for ax in (upper, lower):
            assert drawn(ax, f"TPP, {mode}").get_linestyle() in DASHES
            assert drawn(ax, f"TPP, {mode}").get_color() == COLOURS[mode]
        assert drawn(upper, f"Floquet, {mode}").get_color() == COLOURS[mode]
    assert len([line for line in upper.lines if not line.get_label().startswith("_")]) == 2 * len(modes)
    assert len([line for line in lower.lines if not line.get_label().startswith("_")]) == len(modes) + 1
    assert len({COLOURS[mode] for mode in COLOURS}) == 4


@pytest.mark.parametrize("name", ["teetering", "heavy", "overdamped"])
def test_rows_lie_on_the_drawn_curves(rows: dict[str, RotorRows], name: str) -> None:
    points = rows[name].points
    upper, lower = eigenvalues_vs_mu(points, None)
    values = {mode.name: mode for mode in compare(ROTORS[name], points["advance_ratio"]).modes}
    every = np.column_stack(drawn(lower, "Floquet, every mode").get_data())
    for i in range(0, len(points["advance_ratio"]), 7):
        mu = points["advance_ratio"][i]
        for k in (1, 2):
            assert np.nanmin(np.hypot(*(every - [mu, -points[f"exponent_{k}"][i].real]).T)) < 1e-9
        for mode, value in values.items():
            frequencies = np.column_stack(drawn(upper, f"Floquet, {mode}").get_data())
            assert np.nanmin(np.hypot(*(frequencies - [mu, abs(value.exact[i, 0].imag)]).T)) < 1e-9
            dampings = np.column_stack(drawn(lower, f"TPP, {mode}").get_data())
            for s in value.simple[i]:
                assert np.nanmin(np.hypot(*(dampings - [mu, -s.real]).T)) < 1e-6


def test_both_damping_branches_of_a_lock_are_drawn_and_meet_at_its_edge(rows: dict[str, RotorRows]) -> None:
    points = rows["hingeless"].points
    _, lower = eigenvalues_vs_mu(points, None)
    x, y = drawn(lower, "Floquet, every mode").get_data()
    gap = int(np.flatnonzero(np.isnan(x))[len(np.flatnonzero(np.isnan(x))) // 2])
    (enter, _, _), x, y = lock_bands(points)[0], np.asarray(x), np.asarray(y)
    second = np.flatnonzero(np.isfinite(y) & (np.arange(len(y)) > gap))
    edges = y[np.abs(x - enter) < 1e-12]
    assert len(edges) >= 2 and np.ptp(edges[np.isfinite(edges)]) < 1e-9
    assert x[second].min() == pytest.approx(enter) and len(second) > 40


def test_growth_is_in_the_shaded_part() -> None:
    """γ = 8, P = 1: growth from μ = 1.392 without reversed flow."""
    one = computed(Rotor(lock_number=8.0), np.linspace(0.0, 1.6, 81))
    _, lower = eigenvalues_vs_mu(one.points, one.limits)
    (shaded,) = spans(lower, "unstable")
    x, y = (np.asarray(values, float) for values in drawn(lower, "Floquet, every mode").get_data())
    assert shaded.get_y() + shaded.get_height() == 0.0 and shaded.get_y() < np.nanmin(y) < 0.0
    assert x[y < 0.0].min() == pytest.approx(1.392, abs=0.02)


# ---------------------------------------------------------------------- errors
@pytest.mark.parametrize("name", ["hingeless", "teetering", "heavy", "overdamped"])
def test_errors_cross_the_tolerance_at_the_limits(rows: dict[str, RotorRows], name: str) -> None:
    one = rows[name]
    ax = error_vs_mu(one.points, one.limits, name=name)
    modes = [mode.name for mode in compare(ROTORS[name], 0.0).modes]
    assert ax.get_yscale() == "log" and "%" in ax.get_ylabel() and "dimensionless" in ax.get_xlabel()
    assert sorted(line.get_ydata()[0] for line in ax.lines if line.get_gid() == "tolerance") == [0.01, 0.05, 0.1]
    assert all(f"{level} %" in [t.get_text() for t in ax.texts] for level in (1, 5, 10))
    assert [(p.get_x(), p.get_x() + p.get_width()) for p in spans(ax, "lock")] == [
        pytest.approx((a, min(b, 1.0)), abs=1e-12) for a, b, _ in lock_windows(ROTORS[name])
    ]
    for i, mode in enumerate(modes):
        limit = float(one.limits["limit"][i])
        dots = [line.get_xydata()[0] for line in ax.lines if line.get_gid() == f"limit {mode}"]
        assert [list(dot) for dot in dots] == ([[limit, 0.05]] if limit < math.inf else [])
        curves = [line.get_xydata() for line in ax.lines if line.get_label() in (mode, f"{mode}, against the mean")]
        if limit < math.inf:
            assert any((np.abs(curve - [limit, 0.05]).max(axis=1) < 1e-12).any() for curve in curves)
            before = np.concatenate(curves)
            assert np.nanmax(before[before[:, 0] < limit][:, 1], initial=0.0) <= 0.05 * (1.0 + 1e-9)
    regressing = float(one.limits["limit"][0])
    assert (f"= {regressing:.3f}" in texts(ax)) == (regressing < math.inf)


@pytest.mark.parametrize("name", ["hingeless", "heavy", "overdamped", "teetering"])
def test_errors_go_through_lock_edges_and_splits(rows: dict[str, RotorRows], name: str) -> None:
    """At the exact edges, with the errors of the comparison there; between rows nothing is cut off."""
    rotor = ROTORS[name]
    found = errors_of(rows[name].points, {})
    splits = [edge for edge in split_edges(rotor) if edge < 1.0]
    edges = [*splits, *(edge for window in lock_windows(rotor) for edge in window[:2] if 0.0 < edge < 1.0)]
    assert edges and np.isin(edges, found.mu).all()
    fine = np.concatenate([edge + np.linspace(-0.9 * STEP, 0.9 * STEP, 61) for edge in edges])
    there, here = compare(rotor, fine), compare(rotor, found.mu)
    for mode, error in found.error.items():
        np.testing.assert_allclose(error, here[mode].error, rtol=1e-6, atol=1e-9)
        assert np.array_equal(found.rule[mode], here[mode].rule)
        drawn_there = np.interp(fine, found.mu, error)
        assert np.abs(drawn_there - there[mode].error).max() < 0.025 * max(there[mode].error.max(), 0.01)
    ax = error_vs_mu(rows[name].points, None, name=name)
    assert [line.get_xdata()[0] for line in ax.lines if line.get_gid() == "split edge"] == splits
    roots = eigenvalues(simple_model(rotor, found.mu, model="teetering" if rotor.hub else "flapping"))
    real = (np.abs(roots.imag) < 1e-9).any(axis=-1)
    strips = [(p.get_x(), p.get_x() + p.get_width()) for p in spans(ax, "TPP split")]
    inside = np.array([any(a < mu < b for a, b in strips) for mu in found.mu])
    clear = ~np.isin(found.mu, [0.0, 1.0, *splits])
    assert np.array_equal(inside[clear], real[clear]) and bool(strips) == ("a TPP pair is split" in texts(ax))


def test_errors_of_other_physics_are_those_of_the_rows() -> None:
    """Rows of reversed flow: without the option no point is added; with it the edges are those of reversed flow."""
    rotor, mu = ROTORS["heavy"], np.linspace(0.0, 1.0, 41)
    points = sweep(rotor, mu, reversed_flow=True)
    alone = errors_of(points, {})
    assert np.array_equal(alone.mu, mu) and alone.splits == () and alone.bands == lock_bands(points)
    found = errors_of(points, {"reversed_flow": True})
    assert list(found.bands) == lock_windows(rotor, reversed_flow=True)
    edges = [edge for window in found.bands for edge in window[:2] if edge < 1.0]
    assert edges and np.isin(edges, found.mu).all()
    fewer = {name: values for name, values in points.items() if name != "flap_damping"}
    assert np.array_equal(errors_of(fewer, {"reversed_flow": True}).mu, mu)


def test_a_database_draws_errors_with_its_own_physics(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "study.toml"
    file.write_text(
        '[study]\nname = "s"\nschema = 1\n[rotors]\nlist = [{lock_number = 12.0, blades = 3}]\n[axes]\n'
        "advance_ratio = {start = 0.0, stop = 1.0, count = 21}\n[compare]\nreversed_flow = true\nmodel = 'flapping'\n",
        encoding="utf-8",
    )
    run_study(load_study(file), tmp_path / "out.h5")
    seen: list[Any] = []
    drawing = lambda points, limits, name, options: (seen.append(options), error_vs_mu(points, limits))[1]  # noqa: E731
    monkeypatch.setitem(KINDS, "error-vs-mu", drawing)
    plot_database(tmp_path / "out.h5", "error-vs-mu", tmp_path / "a.png")
    [options] = seen
    assert options["reversed_flow"] is True and options["model"] == "flapping" and options["tip_loss"] == 1.0


def test_errors_against_the_mean_are_dotted(rows: dict[str, RotorRows]) -> None:
    points = rows["stiff"].points
    ax = error_vs_mu(points, None)
    for mode in ("regressing", "coning", "advancing"):
        solid, dotted = drawn(ax, mode), drawn(ax, f"{mode}, against the mean")
        assert dotted.get_linestyle() not in ("-", "None") and solid.get_linestyle() == "-"
        mean = points["advance_ratio"][points[f"rule_{mode}"] == Rule.MEAN]
        assert mean.size and not np.isin(mean, solid.get_xdata()[np.isfinite(solid.get_ydata())]).any()
        assert np.isin(mean, dotted.get_xdata()[np.isfinite(dotted.get_ydata())]).all()
    assert "mean" in texts(ax)


# ---------------------------------------------------------------------- root locus
@pytest.mark.parametrize("name", ["hingeless", "teetering", "overdamped"])
def test_locus_axes(rows: dict[str, RotorRows], name: str) -> None:
    ax = root_locus(rows[name].points, rows[name].limits, name=name)
    assert ax.get_aspect() == 1.0
    (unstable,) = spans(ax, "unstable")
    assert unstable.get_x() == 0.0 and unstable.get_width() > 0.1 and ax.get_xlim()[0] < -0.3
    assert "Re" in ax.get_xlabel() and "Im" in ax.get_ylabel() and "upper half plane" in ax.get_ylabel()
    assert "per rev" in ax.get_xlabel() and "per rev" in ax.get_ylabel()
    levels = {line.get_ydata()[0] for line in ax.lines if line.get_gid() == "per rev"}
    assert {0.0, 0.5, 1.0} <= levels and all(f"{word} per rev" in texts(ax) for word in ("0", "½", "1"))
    modes = [mode.name for mode in compare(ROTORS[name], 0.0).modes]
    for mode in modes:
        assert drawn(ax, f"Floquet, {mode}").get_linestyle() == "-"
        assert drawn(ax, f"TPP, {mode}").get_linestyle() in DASHES
        assert np.nanmin(drawn(ax, f"Floquet, {mode}").get_ydata()) >= 0.0
    assert len([line for line in ax.lines if not line.get_label().startswith("_")]) == 2 * len(modes)


@pytest.mark.parametrize("name", ["hingeless", "heavy"])
def test_locus_marks_every_tenth_of_mu(rows: dict[str, RotorRows], name: str) -> None:
    points = rows[name].points
    ax = root_locus(points, rows[name].limits)
    for mode in ("regressing", "coning", "advancing"):
        (line,) = [line for line in ax.lines if line.get_gid() == f"mu Floquet {mode}"]
        marks = line.get_xydata()[np.isfinite(line.get_xdata())]
        exact = compare(ROTORS[name], np.arange(11) / 10.0)
        sigma, frequency = exact.stability.exponents.real, np.abs(exact[mode].exact.imag)
        for i in range(11):
            for k in (0, 1):
                assert np.hypot(*(marks - [sigma[i, k], frequency[i, 0]]).T).min() < 1e-8
        assert 11 <= len(marks) <= 22
    rings = [line.get_xydata() for line in ax.lines if str(line.get_gid()).startswith("limit")]
    at = compare(ROTORS[name], float(rows[name].limits["limit"][0]))["regressing"]
    for ring, values in zip(rings, (at.exact, at.simple), strict=True):
        inside = ring[np.isfinite(ring[:, 0])]
        assert np.abs(inside[:, 0] + 1j * inside[:, 1] - max(values, key=lambda z: z.imag)).min() < 1e-3


@pytest.mark.parametrize("name", ["soft", "hingeless", "heavy"])
def test_locus_numbers_stand_apart(rows: dict[str, RotorRows], name: str) -> None:
    """Two numbers closer than 4 points would read as one: 0.5 and 0 as 0.50."""
    for ax in root_locus(rows[name].points, rows[name].limits, name=name).figure.axes:
        boxes = [t.get_window_extent() for t in ax.texts if t.get_text().replace(".", "").isdigit()]
        wide = [box.padded(4.0 * ax.figure.dpi / 72.0) for box in boxes]
        assert not [1 for i, a in enumerate(boxes) for b in wide[:i] if a.overlaps(b)]


def test_locus_enlarges_all_modes_at_one_scale_that_is_larger(rows: dict[str, RotorRows]) -> None:
    ax = root_locus(rows["hingeless"].points, rows["hingeless"].limits)
    panels = [other for other in ax.figure.axes if other is not ax]
    assert len(panels) == 3 and all(panel.get_aspect() == 1.0 for panel in panels)

    def scales(panel: Axes) -> tuple[float, float]:
        box = panel.get_window_extent()
        return box.width / np.ptp(panel.get_xlim()), box.height / np.ptp(panel.get_ylim())

    sizes = np.array([scales(panel) for panel in panels])
    assert np.ptp(sizes) < 1e-6 * sizes.max() and sizes.min() > 1.5 * scales(ax)[0]
    assert scales(ax)[0] == pytest.approx(scales(ax)[1], rel=1e-6)
    narrow = root_locus(rows["hingeless"].points, rows["hingeless"].limits, width=COLUMN)
    assert narrow.figure.axes == [narrow]


# ---------------------------------------------------------------------- summary
def test_summary_bars_locks_and_band(rows: dict[str, RotorRows]) -> None:
    ax = validity_summary(list(rows.values()))
    for i, one in enumerate(rows.values()):
        inside = [p for p in ax.patches if isinstance(p, Rectangle) and i < p.get_y() < i + 1]
        for k, mode in enumerate(mode.name for mode in compare(ROTORS[one.name], 0.0).modes):
            if mode == "differential":
                continue
            fails = [(p.get_x(), p.get_x() + p.get_width()) for p in inside if p.get_gid() == f"fails {mode}"]
            count = int(one.limits["intervals"][k])
            ends = [
                (one.limits[f"interval_{n}_start"][k], min(one.limits[f"interval_{n}_end"][k], 1.0))
                for n in range(1, count + 1)
            ]
            assert fails == [pytest.approx(pair) for pair in ends]
        locks = [(p.get_x(), p.get_x() + p.get_width()) for p in inside if str(p.get_gid()).startswith("lock")]
        assert locks == [pytest.approx((a, min(b, 1.0))) for a, b, _ in lock_bands(one.points)]
        assert all(p.get_hatch() for p in inside if str(p.get_gid()).startswith("lock"))
    (band,) = spans(ax, "folklore")
    assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx((0.3, 0.4))
    named = [t.get_text() for t in ax.texts if t.get_gid() == "limit"]
    limits = [float(one.limits["limit"][0]) for one in rows.values()]
    assert named == [f"{limit:.3f}" if limit < math.inf else "no limit up to 1" for limit in limits]
    assert [label.get_text().split("\n")[0] for label in ax.get_yticklabels()] == list(rows)
    assert "5 %" in texts(ax) and "dimensionless" in ax.get_xlabel()


def test_summary_ends_where_the_rows_end() -> None:
    """Limits up to 1 and rows up to 0.6: what is beyond has no row, so no bar and no lock says anything of it."""
    one = computed(ROTORS["hingeless"], np.linspace(0.0, 0.6, 61))._replace(name="short")
    ax = validity_summary([one])
    assert ax.get_xlim() == (0.0, 0.6)
    ends = [p.get_x() + p.get_width() for p in ax.patches if str(p.get_gid()).startswith(("holds", "fails", "lock"))]
    assert max(ends) == pytest.approx(0.6) and float(one.limits["mu_max"][0]) == 1.0
    teetering = validity_summary([computed(ROTORS["teetering"], np.linspace(0.0, 0.6, 61))])
    assert [t.get_text() for t in teetering.texts if t.get_gid() == "limit"] == ["no limit up to 0.6"]


def test_summary_says_what_it_judges_by_a_mean_and_what_it_leaves_out(rows: dict[str, RotorRows]) -> None:
    def footer(name: str) -> str:
        return str(validity_summary([rows[name]]).figure.get_supxlabel()).replace("\n", " ")

    assert "coning and advancing are held against the pair's mean. Differential is not shown." in footer("hingeless")
    assert "Inside a lock, advancing is held" in footer("heavy") and "Differential" not in footer("heavy")
    assert "Differential" not in footer("teetering") and footer("teetering").endswith(
        "No dynamic inflow in either model."
    )


def test_summary_needs_limits(rows: dict[str, RotorRows]) -> None:
    bare = {name: values[:0] for name, values in rows["soft"].limits.items()}
    with pytest.raises(ParameterError, match="no limits of 'soft'"):
        validity_summary([rows["soft"]._replace(limits=bare)])


# ---------------------------------------------------------------------- all kinds
def draw(kind: str, one: RotorRows, **options: Any) -> Axes:
    if kind == "validity-summary":
        return KINDS[kind]([one], **options)
    found = KINDS[kind](one.points, one.limits, name=one.name, **options)
    return found[0] if isinstance(found, tuple) else found


@pytest.mark.parametrize("kind", BY_ROTOR)
@pytest.mark.parametrize("name", ["hingeless", "overdamped"])
def test_texts_keep_off_each_other(rows: dict[str, RotorRows], kind: str, name: str) -> None:
    for ax in draw(kind, rows[name]).figure.axes:
        boxes = [t.get_window_extent() for t in ax.texts if isinstance(t, Annotation) and t.get_text()]
        assert not [1 for i, a in enumerate(boxes) for b in boxes[:i] if a.overlaps(b)]


@pytest.mark.parametrize("kind", ["eigenvalues-vs-mu", "error-vs-mu"])
@pytest.mark.parametrize("name", ["hingeless", "teetering", "stiff"])
def test_texts_keep_off_the_lines(rows: dict[str, RotorRows], kind: str, name: str) -> None:
    for ax in draw(kind, rows[name]).figure.axes:
        boxes = [t.get_window_extent() for t in ax.texts if isinstance(t, Annotation) and not t.get_in_layout()]
        assert boxes
        for line in ax.lines:
            x, y = ax.transData.transform(line.get_xydata()).T
            assert not [b for b in boxes if np.any((b.x0 < x) & (x < b.x1) & (b.y0 < y) & (y < b.y1))]


@pytest.mark.parametrize("kind", BY_ROTOR)
def test_given_axes_are_drawn_into_and_returned(rows: dict[str, RotorRows], kind: str) -> None:
    figure = Figure()
    axes = list(figure.subplots(2, 1)) if kind == "eigenvalues-vs-mu" else [figure.subplots()]
    option = {"axes": axes} if kind == "eigenvalues-vs-mu" else {"ax": axes[0]}
    assert draw(kind, rows["hingeless"], **option) is axes[0]
    assert figure.axes == axes and figure.get_supxlabel() == "" and not figure.legends


@pytest.mark.parametrize("kind", BY_ROTOR)
def test_too_few_rows_are_a_sentence(rows: dict[str, RotorRows], kind: str) -> None:
    few = rows["soft"]._replace(points={name: values[:3] for name, values in rows["soft"].points.items()})
    with pytest.raises(ParameterError, match="3 advance ratios"):
        draw(kind, few)


def test_without_limits_the_single_kinds_still_draw(rows: dict[str, RotorRows]) -> None:
    for kind in ("root-locus", "eigenvalues-vs-mu", "error-vs-mu"):
        ax = draw(kind, rows["hingeless"]._replace(limits={}))
        assert not [line for line in ax.lines if str(line.get_gid()).startswith("limit")]


def test_users_settings_do_not_change_our_figures(rows: dict[str, RotorRows]) -> None:
    import matplotlib

    with matplotlib.rc_context({"font.size": 30.0, "axes.grid": True}):
        ax = draw("error-vs-mu", rows["soft"])
    assert ax.xaxis.label.get_fontsize() == 8.0 and not ax.xaxis.get_gridlines()[0].get_visible()


def test_no_pyplot_and_no_display() -> None:
    code = "import sys, floquet.plot; assert 'matplotlib.pyplot' not in sys.modules"
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "MPLBACKEND")}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


# ---------------------------------------------------------------------- files
@dataclass
class Memory:
    """A database's reader over tables in memory."""

    data: Mapping[str, Mapping[str, Any]]
    names: Sequence[str]

    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def tables(self) -> Sequence[str]:
        return tuple(self.data)

    def columns(self, table: str) -> Mapping[str, Any]:
        return {
            name: SimpleNamespace(dtype=values.dtype, units="1", long_name=name, flags=None)
            for name, values in self.data[table].items()
        }

    def left_out(self, table: str) -> tuple[str, ...]:
        return ()

    def rows(self, table: str) -> int:
        return len(self.data[table]["rotor"])

    def chunks(
        self, table: str, columns: Sequence[str], start: int = 0, stop: int | None = None, skip: Any = None
    ) -> Iterator[tuple[int, dict[str, Any]]]:
        if len(self.data[table]["rotor"][start:stop]):
            yield start, {name: self.data[table][name][start:stop] for name in columns}

    def spans(self, table: str, start: int = 0, stop: int | None = None, skip: Any = None) -> Iterator[tuple[int, int]]:
        if len(self.data[table]["rotor"][start:stop]):
            yield start, self.rows(table) if stop is None else stop


@pytest.fixture
def database(rows: dict[str, RotorRows]) -> Database:
    def table(which: str) -> dict[str, Any]:
        tables = [
            {**getattr(one, which), "rotor": np.full(len(getattr(one, which)["rotor"]), i)}
            for i, one in enumerate(rows.values())
        ]
        return {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}

    return Database("study.h5", Memory({"points": table("points"), "limits": table("limits")}, tuple(rows)), None)


MAGIC = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}


@pytest.mark.parametrize(
    "kind, ending",
    [("root-locus", "png"), ("eigenvalues-vs-mu", "pdf"), ("error-vs-mu", "svg"), ("validity-summary", "png")],
)
def test_files_are_written_whole_and_the_same_each_time(
    database: Database, tmp_path: Path, kind: str, ending: str
) -> None:
    out = tmp_path / f"figure.{ending.upper()}"
    assert plot_database(database, kind, out) == out
    first = out.read_bytes()
    plot_database(database, kind, str(out))
    assert first.startswith(MAGIC[ending]) and out.read_bytes() == first
    assert os.listdir(tmp_path) == [out.name]


@pytest.mark.parametrize(
    "given, title",
    [
        (None, "hingeless"),
        ("heavy", "heavy"),
        ("Heavy", "heavy"),
        (2, "teetering"),
        ("2", "teetering"),
        (["soft"], "soft"),
    ],
)
def test_a_rotor_is_chosen_by_name_or_number(
    database: Database, tmp_path: Path, given: Any, title: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []
    monkeypatch.setitem(
        KINDS,
        "error-vs-mu",
        lambda points, limits, name, options: (seen.append(name), error_vs_mu(points, limits, name=name))[1],
    )
    plot_database(database, "error-vs-mu", tmp_path / "a.png", rotor=given)
    assert seen == [title]


@pytest.mark.parametrize(
    "kind, out, rotor, words",
    [
        ("rootlocus", "a.png", None, "did you mean 'root-locus'"),
        ("pie", "a.png", None, "there are root-locus, eigenvalues-vs-mu, error-vs-mu, validity-summary"),
        ("root-locus", "a.pgn", None, "did you mean 'png'"),
        ("root-locus", "a", None, "has no ending"),
        ("root-locus", "a.png", "hevy", "did you mean 'heavy'"),
        ("root-locus", "a.png", "6", "it has hingeless, soft"),
        ("root-locus", "a.png", "soft,heavy", "shows 1 at most"),
        ("validity-summary", "a.png", "soft, hevy", "did you mean 'heavy'"),
    ],
)
def test_refusals_are_sentences(
    database: Database, tmp_path: Path, kind: str, out: str, rotor: str | None, words: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        plot_database(database, kind, tmp_path / out, rotor=rotor)
    assert words in str(caught.value) and not os.listdir(tmp_path)


@pytest.mark.parametrize("dpi", [0, 19.9, -5, math.nan, math.inf, 1e9])
def test_dots_per_inch_have_bounds(database: Database, tmp_path: Path, dpi: float) -> None:
    with pytest.raises(ParameterError, match="20 to 2400 dots per inch"):
        plot_database(database, "error-vs-mu", tmp_path / "a.png", dpi=dpi)
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize("given", [["soft", "heavy"], "soft, heavy", (1, "Heavy")])
def test_a_summary_of_some_rotors(
    database: Database, tmp_path: Path, given: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []

    def summary(rotors: Sequence[RotorRows]) -> Axes:
        seen.extend(rotor.name for rotor in rotors)
        return validity_summary(rotors)

    monkeypatch.setitem(KINDS, "validity-summary", summary)
    plot_database(database, "validity-summary", tmp_path / "a.png", rotor=given)
    assert seen == ["soft", "heavy"]


@pytest.fixture(scope="module")
def designs() -> dict[str, Any]:
    """Limits of 60 designs: ten offsets and springs at each of six Lock numbers."""
    gamma = np.repeat(np.arange(4.0, 16.0, 2.0), 10)
    rng = np.random.default_rng(6)
    rotors = Rotor(lock_number=gamma, hinge_offset=rng.uniform(0.0, 0.1, 60), hinge_stiffness=rng.uniform(0.0, 0.2, 60))
    tolerances = ((Metric.RELATIVE, 0.05), (Metric.RELATIVE, 0.1), (Metric.DAMPING, 0.05))
    plan = Plan(rotors=(rotors,), advance_ratio=np.array([0.1]), tolerances=tolerances)
    return limit_rows(plan, 0, 60)


def test_an_atlas_shows_the_share_of_designs_that_hold(designs: dict[str, Any], tmp_path: Path) -> None:
    """Shades and lines against limits counted one by one, at 5 % relative and nothing else."""
    seen: list[Figure] = []
    data = Database("many.h5", Memory({"points": {}, "limits": designs}, ()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("floquet.plot.write_figure", lambda figure, path, dpi: seen.append(figure))
        plot_database(data, ATLAS, tmp_path / "a.png")
    panels = [ax for ax in seen[0].axes if ax.get_title()]
    assert [ax.get_title() for ax in panels] == ["regressing", "coning", "advancing", "differential"]
    for k, ax in enumerate(panels):
        (mesh,) = [one for one in ax.collections if isinstance(one, QuadMesh)]
        shown = np.asarray(mesh.get_array()).reshape(6, -1)
        mu = np.linspace(0.0, 1.0, shown.shape[1])
        own = (designs["mode"] == k) & (designs["metric"] == Metric.RELATIVE) & (designs["tolerance"] == 0.05)
        for row, gamma in zip(shown, np.arange(4.0, 16.0, 2.0), strict=True):
            limits = designs["limit"][own & (designs["lock_number"] == gamma)]
            assert len(limits) == 10
            np.testing.assert_allclose(row, [(limits > at).mean() for at in mu], atol=1e-12)
        for share in (0.9, 0.5, 0.1):
            (line,) = [one for one in ax.lines if one.get_gid() == f"share {share:g}"]
            assert line.get_marker() == "o" and line.get_ydata().tolist() == [4.0, 6.0, 8.0, 10.0, 12.0, 14.0]
            for at, gamma in line.get_xydata():
                limits = designs["limit"][own & (designs["lock_number"] == gamma)]
                held = (limits > 1.0) if math.isnan(at) else (limits > at - 1e-9)
                assert held.mean() >= share - 1e-12
                assert math.isnan(at) or (limits > at).mean() < share - 1e-12
    assert "between the 6 Lock numbers" in seen[0].get_supxlabel().replace("\n", " ")
    assert "60 designs" in seen[0].get_supxlabel() and "above 5 %" in seen[0].get_supxlabel()
    assert 0.0 < shown.mean() < 1.0


def test_an_atlas_counts_equal_designs_once(designs: dict[str, Any], tmp_path: Path) -> None:
    """Design 7 again as design 60, with another number and the limits of nobody."""
    again = {name: values[designs["rotor"] == 7].copy() for name, values in designs.items()}
    again["rotor"][:], again["limit"][:] = 60, 0.0
    more = {name: np.concatenate([designs[name], again[name]]) for name in designs}
    seen: list[dict[str, Any]] = []
    data = Database("more.h5", Memory({"points": {}, "limits": more}, ()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(KINDS, ATLAS, lambda limits: (seen.append(limits), Figure())[1])
        plot_database(data, ATLAS, tmp_path / "a.png")
    assert len(np.unique(seen[0]["rotor"])) == 60 and 60 not in seen[0]["rotor"]


def test_rotors_without_names_have_numbers(database: Database, tmp_path: Path) -> None:
    """Of a file whose rotors have names in part: those, and the range of numbers."""
    data = database._reader.data  # type: ignore[attr-defined]
    some = Database("some.h5", Memory(data, ("mine", "", "", "", "", "")))
    with pytest.raises(ParameterError, match=r"it has mine, and numbers from 0 to 5"):
        plot_database(some, "error-vs-mu", tmp_path / "a.png", rotor="99")


def test_an_atlas_needs_many_designs(database: Database, designs: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="an atlas is of 20 or more"):
        plot_database(database, ATLAS, tmp_path / "a.png")
    with pytest.raises(ParameterError, match="leave out --rotor"):
        plot_database(database, ATLAS, tmp_path / "a.png", rotor="soft")
    none = Database("none.h5", Memory({"points": {}, "limits": {k: v[:0] for k, v in designs.items()}}, ()))
    with pytest.raises(ParameterError, match="has no limits"):
        plot_database(none, ATLAS, tmp_path / "a.png")


def test_nothing_to_draw_and_too_much_to_draw(database: Database, tmp_path: Path) -> None:
    empty = {
        table: {name: values[:0] for name, values in columns.items()}
        for table, columns in database._reader.data.items()
    }  # type: ignore[attr-defined]
    with pytest.raises(ParameterError, match="has no rows"):
        plot_database(Database("empty.h5", Memory(empty, ())), "root-locus", tmp_path / "a.png")
    with pytest.raises(ParameterError, match="has no rows of late"):
        plot_database(Database("part.h5", Memory(empty, ("late",))), "root-locus", tmp_path / "a.png")
    with pytest.raises(ParameterError, match="41 rotors are asked for"):
        plot_database(Database("many.h5", Memory(empty, ("x",) * 41)), "validity-summary", tmp_path / "a.png")


@pytest.mark.parametrize(
    "options, words",
    [
        (None, ""),
        ('{"model": "by hub", "reversed_flow": false, "tip_loss": 1.0}', ""),
        ('{"model": "by hub", "reversed_flow": true, "tip_loss": 0.97}', "With reversed flow, tip loss 0.97. "),
    ],
)
def test_the_footer_names_unusual_physics(
    database: Database, tmp_path: Path, options: str | None, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    database._reader.attributes = {"options": options} if options else {}  # type: ignore[misc]
    seen: list[str] = []

    def save(figure: Figure, file: Path, **_: Any) -> None:
        seen.append(figure.get_supxlabel())
        file.touch()

    monkeypatch.setattr(Figure, "savefig", save)
    plot_database(database, "error-vs-mu", tmp_path / "a.png")
    assert seen == [f"{words}No dynamic inflow in either model."]


@pytest.mark.parametrize("folder", ["missing", "file"])
def test_a_folder_that_cannot_be_written_is_a_storage_error(database: Database, tmp_path: Path, folder: str) -> None:
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(StorageError, match="could not be written"):
        plot_database(database, "error-vs-mu", tmp_path / folder / "a.png")


def test_a_failing_disk_leaves_the_old_figure(
    database: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "a.png"
    out.write_bytes(b"old")

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    with pytest.raises(StorageError, match="the disk is full"):
        plot_database(database, "error-vs-mu", out)
    assert out.read_bytes() == b"old" and os.listdir(tmp_path) == ["a.png"]
