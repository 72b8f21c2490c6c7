"""Runs for the tests of runs, and a server for the tests of pages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from omnimorph.design.files import load_vehicle, vehicle_text
from omnimorph.design.vehicle import Vehicle
from omnimorph.results.columns import sizes_of
from omnimorph.results.run import COLUMNS, Outcome, Performance, Provenance, Run

OMNIMORPH = load_vehicle("omnimorph")


def build_random_run(rows: int = 20, vehicle: Vehicle = OMNIMORPH, seed: int = 3) -> Run:
    """Return a run full of random numbers."""
    rng = np.random.default_rng(seed)
    sizes = sizes_of(vehicle)
    columns: dict[str, Any] = {
        column.name: rng.standard_normal(column.shape(rows, sizes)) for column in COLUMNS
    }
    columns["active"] = rng.integers(-1, 2, (rows, vehicle.n_rotors)).astype(np.int8)
    provenance = Provenance(
        scenario_name="paper-case-a",
        scenario_text='{"title": "α and β"}',
        vehicle_text=vehicle_text(vehicle),
        plant_name="realistic",
        seed=2**64 - 1,
        flight=7,
        control_period=0.004,
        physics_step=0.001,
        version="0.1.0",
    )
    return Run(
        time=0.001 * np.arange(rows, dtype=np.float64),
        **columns,
        outcome=Outcome.LOST,
        vehicle=vehicle,
        provenance=provenance,
        performance=Performance(wall_time=0.25, real_time_factor=180.0),
    )


@pytest.fixture
def random_run() -> Callable[..., Run]:
    """Return the function that builds a run full of random numbers."""
    return build_random_run


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the path of a stored run."""
    path = tmp_path / "run.nc"
    build_random_run().save(path)
    return path


@pytest.fixture(scope="module")
def own_server() -> Iterator[Any]:
    """A server of pages for the tests of one file."""
    from omnimorph.viewer.server import new_server, stop

    started = new_server()
    yield started
    stop(started)


@pytest.fixture
def server(own_server: Any) -> Any:
    """Return the server with an empty page."""
    own_server.gui.reset()
    own_server.scene.reset()
    return own_server
