"""The columns of a run's file by its schema version: names, order, and what older ones lack."""

from __future__ import annotations

from typing import Any

import numpy as np

from omnimorph.design.vehicle import Vehicle
from omnimorph.results.columns import sizes_of
from omnimorph.results.record import COLUMNS, RunRecord

WITH_LOGS = 3
"""The first schema of files with logged columns; one without them needs no reader of it."""
_OWN = max(column.since for column in COLUMNS)
SCHEMA_VERSION = max(_OWN, WITH_LOGS)
"""The newest that is read; grows with each column that is new. Older files stay readable.

1 had the thrust commanded as ``thrust``, the actual tilt as ``tilt``, and no actual thrust.
"""

_IN_SCHEMA_1 = """
    p_WB R_WB v_WB w_WB_B desired_p_WB desired_R_WB desired_v_WB desired_w_WB_B thrust_command speed
    tilt_actual tilt_command wrench_asked wrench_achieved drag_power cost kkt_residual active
"""  # hashed in this order
_SCHEMA_1 = {name: name for name in _IN_SCHEMA_1.split()}
_SCHEMA_1 |= {"thrust_command": "thrust", "tilt_actual": "tilt"}


def schema_of(run: RunRecord) -> int:
    """Return the schema of the file of a run: no newer than what is in it."""
    return SCHEMA_VERSION if run.logged else _OWN


def names_in_file(version: int) -> dict[str, str]:
    """Return the columns that a file of a schema holds, and their names there, as it hashes them.

    Examples
    --------
    >>> names_in_file(1)["tilt_actual"], "thrust_actual" in names_in_file(1)
    ('tilt', False)
    """
    if version == 1:
        return _SCHEMA_1
    return {column.name: column.name for column in COLUMNS if column.since <= version}


def add_missing(columns: dict[str, Any], version: int, vehicle: Vehicle) -> None:
    """Add the columns that files of a schema lack: numbers that nobody recorded are NaN."""
    held, rows, sizes = names_in_file(version), np.size(columns["time"]), sizes_of(vehicle)
    columns |= {
        column.name: column.unrecorded(rows, sizes) for column in COLUMNS if column.name not in held
    }
