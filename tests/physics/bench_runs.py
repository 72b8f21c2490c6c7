"""Made-up runs of a thrust bench of which the truth is known."""

from __future__ import annotations

from typing import Any

import numpy as np

from omnimorph.identification import BenchData
from omnimorph.protocols import FloatArray

THRUST, DRAG = 1.1e-5, 1.6e-7  # N s²/rad², N m s²/rad²
TURN = 2.0 * np.pi


def staircase(rows: int = 120, *, low_Hz: float = 30.0, high_Hz: float = 150.0) -> FloatArray:
    """Speeds, rad/s, held at 12 levels in turn."""
    levels = np.linspace(low_Hz, high_Hz, 12)
    return TURN * np.repeat(levels, -(-rows // 12))[:rows]


def bench_run(
    speed: FloatArray,
    *,
    seed: int = 0,
    force_noise: float | FloatArray = 0.05,
    torque_noise: float | FloatArray = 1e-3,
    **changes: Any,
) -> BenchData:
    """A run at some speeds with white noise, or with columns changed."""
    random = np.random.default_rng(seed)
    square = speed * np.abs(speed)
    columns: dict[str, Any] = {
        "time": 0.01 * np.arange(len(speed)),
        "speed": speed,
        "force": THRUST * square + force_noise * random.standard_normal(len(speed)),
        "torque": DRAG * square + torque_noise * random.standard_normal(len(speed)),
    }
    return BenchData(**(columns | changes))


def lagged(
    time: FloatArray, command: FloatArray, up: float, down: float, delay: float = 0.0
) -> FloatArray:
    """The speed, rad/s, of a first-order lag behind a command held between the rows."""
    late = command[np.maximum(np.searchsorted(time, time - delay + 1e-9) - 1, 0)]
    speed = np.empty_like(command)
    speed[0] = command[0]
    for k in range(1, len(time)):
        tau = up if abs(late[k - 1]) >= abs(speed[k - 1]) else down
        keep = np.exp(-(time[k] - time[k - 1]) / tau)
        speed[k] = late[k - 1] + keep * (speed[k - 1] - late[k - 1])
    return speed
