"""Every vehicle of the catalogue flies the tour with gains of its own, whatever the noise."""

from __future__ import annotations

import pytest

import omnimorph as om


@pytest.mark.slow
@pytest.mark.parametrize("name", om.list_vehicles())
def test_it_completes_the_tour_over_ten_seeds(name: str) -> None:
    scenario = om.load_scenario("tour").for_vehicle(om.load_vehicle(name))
    for seed in range(10):
        found = om.fly(scenario, seed=seed).metrics
        assert found.outcome == "completed"
        assert found.position_error_mean_m < 0.005
        assert found.position_error_max_m < 0.05
