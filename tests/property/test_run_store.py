"""Whatever is in a run comes back from its file; whatever is cut off the file is noticed."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from omnimorph.design.files import load_vehicle, vehicle_text
from omnimorph.errors import RunFileError
from omnimorph.results.run import COLUMNS, Outcome, Performance, Provenance, Run
from omnimorph.results.store import load_run

OMNIMORPH = load_vehicle("omnimorph")
VEHICLE_TEXT = vehicle_text(OMNIMORPH)
SIZES = {"axis": 3, "axis_W": 3, "axis_B": 3, "wrench": 6, "rotor": 8, "servo": 1}

texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=40)
integers = st.integers(0, 2**64 - 1)
seconds = st.floats(1e-300, 1e300)


@st.composite
def runs(draw: st.DrawFn) -> Run:
    """Draw a run of any numbers, not finite ones included."""
    rows = draw(st.integers(1, 3))
    columns: dict[str, Any] = {"time": draw(arrays.arrays(np.float64, rows))}
    for column in COLUMNS:
        kind = np.int8 if column.name == "active" else np.float64
        shape = (rows, *(SIZES[dim] for dim in column.dims))
        columns[column.name] = draw(arrays.arrays(kind, shape))
    provenance = Provenance(
        scenario_name=draw(texts),
        scenario_text=draw(texts),
        vehicle_text=VEHICLE_TEXT,
        plant_name=draw(texts),
        seed=draw(integers),
        flight=draw(integers),
        control_period=draw(seconds),
        physics_step=draw(seconds),
        version=draw(texts),
    )
    return Run(
        **columns,
        outcome=draw(st.sampled_from(Outcome)),
        vehicle=OMNIMORPH,
        provenance=provenance,
        performance=Performance(wall_time=draw(seconds), real_time_factor=draw(seconds)),
    )


@given(run=runs(), compression=st.sampled_from([0, 4]))
def test_any_run_comes_back(run: Run, compression: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.nc")
        run.save(path, compression=compression)
        loaded = load_run(path)
    for column in COLUMNS:
        before, after = getattr(run, column.name), getattr(loaded, column.name)
        assert before.tobytes() == after.tobytes()
    assert loaded.content_hash == run.content_hash == loaded.provenance.content_hash
    assert loaded.outcome is run.outcome
    assert loaded.performance == run.performance


@given(run=runs())
def test_any_run_has_metrics(run: Run) -> None:
    """Metrics never fail or warn; what has no number is null."""
    values = run.metrics.as_dict()
    assert values["outcome"] == run.outcome.name.lower()


@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_a_file_cut_off_anywhere_is_noticed(share: float) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.nc")
        path.write_bytes(WHOLE[: int(share * len(WHOLE))])
        with pytest.raises(RunFileError) as caught:
            load_run(path)
    assert str(caught.value).startswith(f"{path}: the run cannot be read: it is ")
    assert "\n" not in str(caught.value)


def stored() -> bytes:
    """Return the bytes of a file that holds a run."""
    columns: dict[str, Any] = {"time": np.arange(4.0)}
    for column in COLUMNS:
        columns[column.name] = np.ones((4, *(SIZES[dim] for dim in column.dims)))
    provenance = Provenance(
        scenario_name="test",
        scenario_text="{}",
        vehicle_text=VEHICLE_TEXT,
        plant_name="perfect",
        seed=0,
        flight=0,
        control_period=1.0,
        physics_step=1.0,
        version="0",
    )
    run = Run(
        **columns,
        outcome=Outcome.COMPLETED,
        vehicle=OMNIMORPH,
        provenance=provenance,
        performance=Performance(wall_time=1.0, real_time_factor=4.0),
    )
    with tempfile.TemporaryDirectory() as folder:
        run.save(Path(folder, "run.nc"))
        return Path(folder, "run.nc").read_bytes()


WHOLE = stored()
