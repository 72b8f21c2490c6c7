"""What cannot hold itself in the air is analysed, and refused where it would be flown."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_vehicle

import omnimorph as om
from omnimorph.analysis.flight_worthiness import why_it_cannot_fly
from omnimorph.analysis.platform import platform
from omnimorph.design.writing import vehicle_text
from omnimorph.errors import ScenarioError


def two_rotors() -> om.Vehicle:
    return build_vehicle([[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]])


def sideways() -> om.Vehicle:
    """Six rotors whose axes lie flat: they push sideways, and never up."""
    angle = np.radians(60.0 * np.arange(6))
    arm = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    across = np.column_stack([-np.sin(angle), np.cos(angle), np.zeros(6)])
    heights = 0.1 * np.resize([1.0, -1.0], 6)[:, None] * [0.0, 0.0, 1.0]
    return build_vehicle(0.2 * arm + heights, across)


CANNOT: list[tuple[Callable[[], om.Vehicle], str]] = [
    (lambda: build_star(4, mass=5.0), "lift at most 14.4 N without a moment, and it weighs 49.05"),
    (two_rotors, "independent directions, and flying takes 4"),
    (sideways, "cannot push it upwards"),
    # four rotors at 500 rad/s or more: 4 · 1e-5 · 500² = 10 N, and 0.5 kg weigh less
    (
        lambda: build_star(4, mass=0.5, speed_min=500.0),
        "lift at least 10 N at their lowest speeds, and it weighs 4.905 N",
    ),
]


@pytest.mark.parametrize("name", om.list_vehicles())
def test_the_catalogue_flies(name: str) -> None:
    assert why_it_cannot_fly(om.load_vehicle(name)) == ""


@pytest.mark.parametrize(("build", "reason"), CANNOT)
def test_the_reason_is_reported(build: Callable[[], om.Vehicle], reason: str) -> None:
    assert reason in why_it_cannot_fly(build())
    platform(build())  # and it is analysed all the same


def test_the_most_of_all_tilts_is_found() -> None:
    """The rotors of OmniMorph lift most untilted, 8 f_max, and less at every other tilt."""
    heavy = om.load_vehicle("omnimorph").replace(mass=5.0)
    assert "lift at most 42.87 N without a moment" in why_it_cannot_fly(heavy)


@pytest.mark.parametrize(("build", "reason"), CANNOT)
def test_a_scenario_that_would_fly_it_is_refused(
    build: Callable[[], om.Vehicle], reason: str, tmp_path: Path
) -> None:
    (tmp_path / "odd.toml").write_text(vehicle_text(build()), encoding="utf-8")
    file = tmp_path / "flight.toml"
    text = 'schema = 1\nname = "flight"\nbase = "hover"\nplant = "perfect"\nvehicle = "odd.toml"\n'
    fixed: dict[str, Any] = om.load_scenario("paper-fixed-45-a").allocator.as_file()
    keys = {key: list(v) if isinstance(v, tuple) else v for key, v in fixed.items()}
    rule = "\n".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
    file.write_text(f"{text}[controller.allocator]\n{rule}\n", encoding="utf-8")
    with pytest.raises(ScenarioError) as refused:
        om.load_scenario(file)
    assert str(refused.value).startswith(f"{file}: vehicle small cannot fly: ")
    assert reason in str(refused.value)
