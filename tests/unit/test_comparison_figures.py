"""Platforms side by side: one scale for all, and the numbers that are drawn are the numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.unit.drawn import assert_in_sight

import omnimorph as om
from omnimorph.model.geometry import propeller_radius
from omnimorph.report.comparison_figures import Column, numbers_of_platforms, to_one_scale

NAMES = ("voliro", "omav-12", "quadrotor", "odar-8", "omnicopter")
VEHICLES = [om.load_vehicle(name) for name in NAMES]


def test_all_are_drawn_to_one_scale() -> None:
    figure = to_one_scale(VEHICLES, [0.0] * len(VEHICLES))
    shown = [panel for panel in figure.axes if panel.get_visible()]
    assert [panel.get_title() for panel in shown] == [vehicle.name for vehicle in VEHICLES]
    assert len({panel.get_xlim() for panel in shown}) == 1
    assert len({panel.get_ylim() for panel in shown}) == 1
    reach = shown[0].get_xlim()[1]
    for vehicle in VEHICLES:
        hubs = np.linalg.norm(vehicle.rotor_position, axis=1)
        assert hubs.max() + propeller_radius(vehicle) < reach
    bar = next(line for line in shown[0].lines if line.get_linewidth() == 2.0)
    begin, end = np.asarray(bar.get_xdata(), dtype=float)
    assert end - begin == 0.5


def test_a_coaxial_pair_is_drawn_as_one() -> None:
    assert propeller_radius(VEHICLES[1]) == pytest.approx(0.48 * 0.3), "the arms are 60° apart"


def test_what_is_drawn_are_the_numbers() -> None:
    columns = [
        Column("radius (–)", [1.5, math.inf, 0.0], 1.0),
        Column("power (W)", [3.0, 2.0, 1.0]),
    ]
    figure = numbers_of_platforms(["a", "b", "c"], columns)
    first, second = figure.axes
    assert [text.get_text() for text in first.get_yticklabels()] == ["a", "b", "c"]
    dots = [line for line in first.lines if line.get_marker() == "o"]
    assert np.asarray(dots[0].get_xydata()).tolist() == [[1.5, 0.0], [0.0, 2.0]]
    dashes = [text.get_position() for text in first.texts if text.get_text() == " —"]
    assert dashes == [(0.0, 1)], "b has no number"
    assert not second.texts
    assert_in_sight(figure)
    assert np.asarray(second.lines[0].get_xdata()).tolist() == [3.0, 2.0, 1.0]
    assert [panel.get_xlabel() for panel in figure.axes] == ["radius (–)", "power (W)"]
