"""The pages beside a flight: curves, frames and numbers are the run's own."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.conftest import build_random_run
from tests.unit.drawn import number_in

import omnimorph as om
from omnimorph.live.page import LivePage
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.results import curves
from omnimorph.viewer.charts import Chart, _on_common_times, _Plot, charts_of
from omnimorph.viewer.explorer_page import numbers_of as numbers_of_design
from omnimorph.viewer.flight_page import numbers_of
from omnimorph.viewer.frames import Flight, blade_turns
from omnimorph.viewer.server import new_server, stop
from omnimorph.viewer.tables import Row, number_table

OMNIMORPH = om.load_vehicle("omnimorph")
TURN = 2.0 * np.pi


def random_flight(seed: int, vehicle: om.Vehicle = OMNIMORPH) -> om.Run:
    """Return a run full of random numbers, its attitudes rotations."""
    run = build_random_run(seed=seed, vehicle=vehicle)
    R, R_d = Rotation.random(2 * len(run.time), seed).as_matrix().reshape(2, -1, 3, 3)
    speed, wrench = 400.0 * run.speed, 20.0 * run.wrench_asked  # large enough to be seen
    return replace(run, R_WB=R, desired_R_WB=R_d, speed=speed, wrench_asked=wrench)


# Random numbers differ from column to column; so few rows are not thinned.
FLIGHTS = [Flight(random_flight(seed), name) for seed, name in ((3, "a"), (4, "b"))]


@pytest.fixture(scope="module")
def server() -> Iterator[Any]:
    started = new_server()
    yield started
    stop(started)


def expected_curves(flight: Flight) -> dict[str, list[FloatArray]]:
    """Return what each chart shows of a flight, from the run's columns."""
    run = flight.run
    return {
        "position error, mm": [1e3 * np.linalg.norm(run.p_WB - run.desired_p_WB, axis=1)],
        "attitude error, °": [curves.attitude_error(run).angle_deg],
        "tilt, °": list(np.degrees(run.tilt_actual).T),
        "rotor speeds, Hz": list(run.speed.T / TURN),
        "rotor drag power": [run.drag_power],
    }


def assert_charts(charts: list[Chart], flights: list[Flight]) -> None:
    wanted = [expected_curves(flight) for flight in flights]
    for chart, title in zip(charts, wanted[0], strict=True):
        assert chart.title.startswith(title)
        values = [value for one in wanted for value in one[title]]
        times = [flight.run.time for flight, one in zip(flights, wanted, strict=True)
                 for _ in one[title]]  # fmt: skip
        for curve, time, value in zip(chart.curves, times, values, strict=True):
            np.testing.assert_allclose(curve.values, value, rtol=1e-12)
            np.testing.assert_array_equal(curve.time, time)


def test_charts_are_the_columns_of_the_runs() -> None:
    assert_charts(charts_of(FLIGHTS[:1]), FLIGHTS[:1])
    assert_charts(charts_of(FLIGHTS), FLIGHTS)


def test_curves_are_called_by_their_flight_and_rotor() -> None:
    position, _, tilt, speeds, _ = charts_of(FLIGHTS)
    assert [curve.label for curve in position.curves] == ["a", "b"]
    assert [curve.label for curve in tilt.curves] == [
        f"{name} {OMNIMORPH.servo_name[0]}" for name in "ab"
    ]
    rotors = [number_in(curve.label) for curve in speeds.curves]
    assert rotors == 2 * list(range(rotors[0], rotors[0] + 8))
    assert tilt.limits == (0.0, 60.0)


def test_a_curve_ends_where_its_flight_ends() -> None:
    whole = vars(FLIGHTS[0].run).items()
    columns: dict[str, Any] = {k: v[:8] for k, v in whole if isinstance(v, np.ndarray)}
    short = replace(FLIGHTS[0].run, **columns)
    power = charts_of([Flight(short, "short"), FLIGHTS[1]])[-1]
    time, (first, second) = _on_common_times(power)
    step = FLIGHTS[1].run.time[1]
    ended = time > short.time[-1] + 0.5 * step
    assert ended.any()
    assert np.isnan(first[ended]).all()
    np.testing.assert_allclose(first[~ended], short.drag_power)
    np.testing.assert_allclose(second, FLIGHTS[1].run.drag_power)


def test_a_plot_draws_its_curves_its_limits_and_the_time(server: Any) -> None:
    chart = charts_of(FLIGHTS)[2]
    plot = _Plot(server, chart)
    at = 0.0055  # between rows 5 and 6
    plot.show_time(at)
    time, *rows, now = plot._handle.data
    kept = time != at
    np.testing.assert_allclose(time[kept], FLIGHTS[0].run.time)
    for row, curve in zip(rows, chart.curves, strict=False):
        np.testing.assert_allclose(row[kept], curve.values)
        np.testing.assert_allclose(row[~kept], curve.values[5:7].mean())
    for row, limit in zip(rows[len(chart.curves) :], chart.limits, strict=True):
        np.testing.assert_array_equal(row, limit)
    low, high = now[~kept]
    assert low <= min(0.0, chart.curves[0].values.min())
    assert high >= max(chart.limits)
    assert np.isnan(now[kept]).all()


@pytest.mark.parametrize(("steps", "row"), [(6.9, 7), (7.1, 7), (6.4, 6), (6.6, 7)])
def test_the_row_shown_is_the_nearest(steps: float, row: int) -> None:
    flight = FLIGHTS[0]
    assert flight.row_at(steps * flight.run.provenance.physics_step) == row


def test_numbers_of_a_flight_are_those_of_its_row() -> None:
    row = 11
    frames = [flight.frame(row) for flight in FLIGHTS]
    reported = {one.key: one for one in numbers_of(FLIGHTS, frames)}
    for k, flight in enumerate(FLIGHTS):
        run = flight.run
        distance = float(np.linalg.norm(run.p_WB[row] - run.desired_p_WB[row]))
        missed = run.wrench_asked[row, :3] - run.wrench_achieved[row, :3]
        missed_W = float(np.linalg.norm(run.R_WB[row] @ missed))
        expected = {
            "time": f"{run.time[row]:.3f}",
            "position-error": f"{1e3 * distance:.3f}",
            "attitude-error": f"{curves.attitude_error(run).angle_deg[row]:.3f}",
            "tilt": f"{math.degrees(run.tilt_actual[row, 0]):.2f}",
            "fastest-rotor": f"{np.abs(run.speed[row]).max() / TURN:.2f}",
            "largest-thrust": f"{np.abs(run.thrust_actual[row]).max():.3f}",
            "power": f"{run.drag_power[row]:.1f}",
            "missed-force": f"{missed_W:.3f}",
        }
        assert {key: one.values[k] for key, one in reported.items()} == expected
    units = [reported[key].unit for key in ("time", "position-error", "attitude-error", "power")]
    assert units == ["s", "mm", "°", "W"]


def test_a_table_has_what_it_is_then_the_values_then_the_unit() -> None:
    rows = [Row("mass", "weight & more", "N", ["12.9", "7"]), Row("radius", "reach", "m", ["1"])]
    table = ElementTree.fromstring(number_table(rows, ["a", "b"]))
    cells = [["".join(cell.itertext()) for cell in row] for row in table.iter("tr")]
    assert cells == [["", "a", "b", ""], ["weight & more", "12.9", "7", "N"], ["reach", "1", "m"]]
    assert [cell.get("id") for cell in table.iter("td") if cell.get("id")] == [
        *("mass", "mass-2", "radius")
    ]


def test_numbers_of_a_design_are_those_of_the_analysis() -> None:
    from omnimorph.viewer.design import Design

    tilt = np.radians([30.0])
    view = Design.of(OMNIMORPH, tilt).changed(mass=1.1 * OMNIMORPH.mass).view()
    reported = {row.key: row.values[0] for row in numbers_of_design(view)}
    forces = om.analysis.force_set(view.vehicle, tilt, zero_moment=True)
    assert reported["force-radius"] == f"{forces.inscribed_radius:.4g}"
    assert reported["hover-power"] == f"{om.analysis.hover(view.vehicle, tilt).power:.4g}"


# --- live -----------------------------------------------------------------------------------------


def test_a_live_page_shows_the_flight_as_it_is(server: Any) -> None:
    """In a plant whose rotors have more drag than the controller believes."""
    hover = om.load_scenario("hover")
    effects = (*hover.plant.effects, om.effects.ModelMismatch(drag_coefficient=1.5))
    scenario = replace(hover, plant=replace(hover.plant, effects=effects))
    page = LivePage(server, scenario, seed=3)
    page.pilot.advance(0.3)
    page.show()
    run = page.as_run()
    frame, row = page._frame(), len(run.time) - 1
    assert run.provenance.seed == 3
    assert run.content_hash != om.fly(scenario, seed=0).content_hash
    assert frame.time == pytest.approx(run.time[row])
    assert frame.power == pytest.approx(run.drag_power[row])
    believed = np.abs(run.speed[row]) ** 3 @ hover.vehicle.drag_coefficient
    assert frame.power == pytest.approx(1.5 * believed)
    np.testing.assert_array_equal(frame.p_WB, run.p_WB[row])
    np.testing.assert_array_equal(frame.tilt, run.tilt_actual[row])
    assert f"{frame.power:.1f}" in page._numbers.content
    before = page._turns.copy()
    page._show_scene(0.1)
    turned = blade_turns(hover.vehicle, run.speed[row], 0.1)
    np.testing.assert_allclose(page._turns - before, turned)
    assert page.pilot.weight == pytest.approx(hover.vehicle.mass * GRAVITY)
    page.pilot.cut(2)
    page.pilot.cut(5)
    page.pilot.push(np.array([3.0, 4.0, 0.0]))
    page.pilot.restore()
    first, second, push, restored = page._done_to_it().split("<br>")
    one, two = (re.findall(r"\d+", words.split("rotor")[1]) for words in (first, second))
    assert int(two[1]) - int(two[0]) == 3
    assert one == two[:1]
    assert "5.0 N" in push
    assert "all rotors" in restored
    assert all("0.30 s" in words for words in (first, second, push, restored))
    assert_charts(charts_of([page._as_flight()]), [Flight(run, "hover")])
