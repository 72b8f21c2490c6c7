"""Figures of flights: every curve, dot and axis is the run's own column, in the axis's unit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.unit.conftest import build_random_run
from tests.unit.drawn import (
    assert_curves,
    assert_in_sight,
    assert_legend,
    curves_of,
    levels_of,
    number_in,
    panels_of,
    xy,
)

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.report import figures, style
from omnimorph.report.style import Flight, LineStyle
from omnimorph.results import curves
from omnimorph.results.curves import attitude_error
from omnimorph.studies.reproduction.figures import summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OMNIMORPH = om.load_vehicle("omnimorph")
TURN = 2.0 * np.pi
# In flights of so few rows nothing is thinned, and random numbers differ from column to column.
FLIGHTS = [
    Flight("first", build_random_run(seed=3), LineStyle(style.BLUE)),
    Flight("second", build_random_run(seed=4), LineStyle(style.VERMILLION, "--")),
]
TIME = FLIGHTS[0].run.time


def over_time(values: list[FloatArray]) -> list[tuple[str, FloatArray, FloatArray]]:
    """Return the curves of both flights as they should be drawn."""
    pairs = zip(FLIGHTS, values, strict=True)
    return [(flight.label, flight.run.time, value) for flight, value in pairs]


def energy_kJ(run: om.Run) -> FloatArray:
    """The power over the steps so far; that of the first row acted over none."""
    so_far: FloatArray = np.cumsum(np.r_[0.0, run.drag_power[1:]]) * run.provenance.physics_step
    return 1e-3 * so_far


def test_positions_and_rotation() -> None:
    *positions, rotation = panels_of(figures.trajectory(FLIGHTS))
    for i, panel in enumerate(positions):
        assert panel.get_ylabel().startswith("xyz"[i])
        desired = ("desired", TIME, FLIGHTS[0].run.desired_p_WB[:, i])
        assert_curves(panel, [desired, *over_time([f.run.p_WB[:, i] for f in FLIGHTS])])
    about_x = curves.rotation_about_x_deg
    desired = ("desired", TIME, about_x(FLIGHTS[0].run.desired_R_WB))
    assert_curves(rotation, [desired, *over_time([about_x(f.run.R_WB) for f in FLIGHTS])])


def test_errors() -> None:
    elsewhere = [("elsewhere", 11.0, 0.06, LineStyle(style.BLACK))]
    position, angle, sine = panels_of(figures.errors(FLIGHTS, elsewhere))
    runs = [flight.run for flight in FLIGHTS]
    distance = [1e3 * np.linalg.norm(run.p_WB - run.desired_p_WB, axis=1) for run in runs]
    assert_curves(position, over_time(distance))
    assert_curves(angle, over_time([attitude_error(run).angle_deg for run in runs]))
    assert_curves(sine, over_time([attitude_error(run).sine for run in runs]))
    assert "(mm)" in position.get_ylabel()
    assert "(°)" in angle.get_ylabel()
    assert "e_R" in sine.get_ylabel()
    assert [levels_of(panel) for panel in (position, angle, sine)] == [
        [11.0],
        [pytest.approx(np.degrees(np.arcsin(0.06)))],
        [0.06],
    ]


def test_a_band_reaches_from_the_smallest_to_the_largest_value() -> None:
    long = Flight("long", build_random_run(rows=2000), LineStyle(style.BLUE))
    position = panels_of(figures.errors([long]))[0]
    value = curves.position_error_mm(long.run)
    (band,) = position.collections
    heights = np.concatenate([np.asarray(path.vertices)[:, 1] for path in band.get_paths()])
    assert (heights.min(), heights.max()) == (value.min(), value.max())
    ((_, mean),) = curves_of(position)
    assert mean[:, 1].mean() == pytest.approx(value.mean(), rel=1e-2)


def assert_tilts(panel: Axes) -> None:
    assert_curves(panel, over_time([np.degrees(f.run.tilt_actual[:, 0]) for f in FLIGHTS]))
    assert levels_of(panel) == [0.0, pytest.approx(60.0)]


def assert_powers(panel: Axes) -> None:
    assert_curves(panel, over_time([f.run.drag_power for f in FLIGHTS]))


def test_tilt() -> None:
    (panel,) = panels_of(figures.tilt(FLIGHTS))
    assert_tilts(panel)


def test_every_rotor_has_its_own_panel() -> None:
    by_column = np.array(panels_of(figures.rotor_speeds(FLIGHTS)), dtype=object).reshape(4, 2)
    panels = by_column.T.ravel()
    first = number_in(panels[0].get_title(loc="left"))
    ends = [OMNIMORPH.speed_min[0] / TURN, OMNIMORPH.speed_max[0] / TURN]
    for i, panel in enumerate(panels):
        title = panel.get_title(loc="left")
        assert number_in(title) == first + i
        signs = "".join("+" if c > 0 else "−" for c in OMNIMORPH.rotor_position[i])
        assert [c for c in title if c in "+−"] == list(signs)
        assert_curves(panel, [*over_time([f.run.speed[:, i] / TURN for f in FLIGHTS])])
        np.testing.assert_allclose(levels_of(panel), ends)


def test_power_and_energy_in_both_counts() -> None:
    figure = figures.power_and_energy(FLIGHTS[:1], FLIGHTS[1:])
    power, energy = panels_of(figure)
    first, second = FLIGHTS
    assert_curves(power, over_time([first.run.drag_power, second.run.drag_power])[:1])
    assert_curves(energy, over_time([energy_kJ(first.run), energy_kJ(second.run)]))
    figure.draw_without_rendering()
    (paper,) = energy.child_axes
    # c_τ |f|³ with f = w / 2π and c_τ in N m/Hz²: (2π)² / (2π)³
    np.testing.assert_allclose(paper.get_ylim(), 1e3 / TURN * np.array(energy.get_ylim()))


def test_overview_and_tilt_by_plant() -> None:
    tilt, power = panels_of(summary.overview(FLIGHTS, [0.0]))[-2:]
    assert_tilts(tilt)
    assert_powers(power)
    (panel,) = panels_of(summary.tilt_by_plant(FLIGHTS))
    assert_curves(panel, over_time([np.degrees(f.run.tilt_actual[:, 0]) for f in FLIGHTS]))


def test_no_curve_leaves_its_axes() -> None:
    run = om.fly(om.load_scenario("tour").for_vehicle(OMNIMORPH))
    flown = [Flight("tour", run, LineStyle(style.BLUE))]
    row = summary.EnergyRow("tour", [1.0, 6.0], 0.5, 8.0, flown[0].line_style)
    for figure in (
        figures.trajectory(flown),
        figures.tilt(flown),
        figures.rotor_speeds(flown),
        figures.power_and_energy(flown),
        summary.overview(flown, [0.0]),
        summary.tilt_by_plant(flown),
    ):
        assert_in_sight(figure)
        assert_legend(figure)
    assert_in_sight(summary.energies([row]))
    assert_in_sight(figures.errors(flown), floor=True)
    levels = [levels_of(panel) for panel in panels_of(figures.rotor_speeds(flown))]
    for panel, (low, high) in zip(panels_of(figures.rotor_speeds(flown)), levels, strict=True):
        assert panel.get_ylim()[0] < low < high < panel.get_ylim()[1]


def test_desired_and_flown_do_not_look_alike() -> None:
    panel = panels_of(figures.trajectory(FLIGHTS))[0]
    desired, *flown = panel.lines
    assert desired.get_color() == style.SILVER
    line_styles = [(line.get_color(), line.get_linestyle()) for line in flown]
    assert line_styles == [(flight.line_style.colour, flight.line_style.line) for flight in FLIGHTS]


# --- energies as dots -----------------------------------------------------------------------------


def marks(panel: Axes, mark: str) -> list[list[float]]:
    return [xy(line)[0].tolist() for line in panel.lines if line.get_marker() == mark]


def test_energies_are_means_ranges_and_the_others_marks() -> None:
    rows = [
        summary.EnergyRow("one", [1.0, 2.0, 6.0], 1.5, 1.8, FLIGHTS[0].line_style),
        summary.EnergyRow("two", [4.0, 5.0], None, None, FLIGHTS[1].line_style),
        summary.EnergyRow("three", [7.0], 6.5, 2.5, FLIGHTS[1].line_style),
    ]
    (panel,) = panels_of(summary.energies(rows))
    assert marks(panel, "o") == [[3.0, 0.0], [4.5, 1.0], [7.0, 2.0]]
    assert marks(panel, "x") == [[1.5, 0.0], [6.5, 2.0]]
    assert marks(panel, "D") == [[1.8, 0.0], [2.5, 2.0]]
    ranges = [xy(line)[:, 0].tolist() for line in panel.lines if line.get_alpha() == 0.4]
    assert ranges == [[1.0, 6.0], [4.0, 5.0], [7.0, 7.0]]
    assert [tick.get_text() for tick in panel.get_yticklabels()] == ["one", "two", "three"]


def test_time_and_phases_are_those_of_the_flight() -> None:
    run = om.fly(om.load_scenario("tour").for_vehicle(OMNIMORPH))
    flight = Flight("tour", run, LineStyle(style.BLUE))
    (panel,) = panels_of(figures.tilt([flight]))
    assert panel.get_xlim() == (0.0, float(run.time[-1]))
    phases = curves.phases(run)
    names = [(text.get_position()[0], text.get_text()) for text in panel.texts]
    assert names == [
        (0.5 * (phase.begin + phase.end), phase.label)
        for phase in phases
        if phase.end - phase.begin > 0.04 * run.time[-1]
    ]
    shaded = [
        patch.get_extents().transformed(panel.transData.inverted()) for patch in panel.patches
    ]
    np.testing.assert_allclose(
        [[one.x0, one.x1] for one in shaded],
        [[phase.begin, phase.end] for phase in phases[1::2]],
    )
