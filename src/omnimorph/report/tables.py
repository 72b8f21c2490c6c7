"""Tables of a report: metrics side by side, and everything that was assumed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimorph.design.keys import FIELDS
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.results.metrics import MEASURES, Metrics
from omnimorph.results.run import Run
from omnimorph.units import from_SI, unit_of


@dataclass(frozen=True)
class Table:
    """A table of texts; columns whose number is in `numeric` are set to the right.

    Attributes
    ----------
    caption : str
        What it shows.
    head : sequence of str
        Names of the columns.
    rows : sequence of sequences of str
        As long as the head, each.
    numeric : set of int
        Columns of numbers, counted from 0.
    """

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: frozenset[int] = frozenset()


_EFFECTS = {
    "command-delay": "commands reach the actuators late",
    "rotor-lag": "rotor speeds follow with a first-order lag",
    "speed-limits": "rotors turn no faster than their limits",
    "dead-band": "rotors cannot turn slowly, and stop before they reverse",
    "effectiveness": "rotors give only a share of their thrust",
    "model-mismatch": "the true vehicle is the controller's times these factors",
    "servo-lag": "the tilt follows with a first-order lag",
    "servo-rate-limit": "the tilt moves no faster than its servo can",
    "measurement-noise": "noise on what the controller measures, 1σ, one draw a control step",
    "constant-wrench": "a constant force (in W) and torque (in B)",
    "sine-wrench": "a swinging force (in W) and torque (in B)",
    "wrench-profile": "a force (in W) and torque (in B) over time",
    "interference": "rotors in line take thrust from one another",
    "rotor-momentum": "the spinning rotors carry angular momentum",
    "truth": "what of the true vehicle the controller does not know",
}
# What an effect without numbers of its own takes from the vehicle.
_OWN_VALUES = {
    "rotor-lag": ("time_constant_up", "time_constant_down"),
    "speed-limits": ("speed_min", "speed_max"),
    "dead-band": ("dead_band",),
    "servo-lag": ("servo_time_constant",),
    "servo-rate-limit": ("servo_rate_max",),
}
# How a unit at the end of a key is written, where that does not follow from the key.
_WRITTEN_UNITS = {
    "kg_m2": "kg m²",
    "N_per_Hz2": "N/Hz²",
    "Nm_per_Hz2": "N m/Hz²",
    "Nm": "N m",
    "deg": "°",
    "deg_per_s": "°/s",
}


def number(value: float | None, digits: int = 4) -> str:
    """Return a number to so many significant digits as print sets it; a dash if there is none.

    Examples
    --------
    >>> number(1764.3219), number(-0.000473, 3), number(2.2e-16, 2), number(None)
    ('1764', '−0.000473', '2.2e−16', '—')
    """
    if value is None or not math.isfinite(value):
        return "—"
    if value != 0 and 10.0**digits <= abs(value) < 1e7:
        text = f"{value:,.0f}" if abs(value) >= 1e4 else f"{value:.0f}"
    else:
        text = f"{value:.{digits}g}"
    return text.replace(",", "\N{NARROW NO-BREAK SPACE}").replace("-", "−")


def degrees(angle: float) -> str:
    """Return an angle, given in rad, in degrees, with two decimals if it is not a whole number.

    Examples
    --------
    >>> degrees(math.pi / 3), degrees(-0.66642708), degrees(-1e-17)
    ('60°', '−38.18°', '0°')
    """
    value = math.degrees(angle)
    whole = abs(value - round(value)) < 1e-6
    return f"{round(value):d}°".replace("-", "−") if whole else f"{value:.2f}°".replace("-", "−")


def tilt_text(tilt: FloatArray) -> str:
    """Return the tilt of the servos, rad: one angle if all have the same; "" if there are none.

    Examples
    --------
    >>> tilt_text(np.radians([30.0, 30.0])), tilt_text(np.radians([0.0, 12.5]))
    ('30°', '(0°, 12.50°)')
    """
    angles = [degrees(float(angle)) for angle in tilt]
    if len(set(angles)) > 1:
        return "(" + ", ".join(angles) + ")"
    return angles[0] if angles else ""


def metrics_table(caption: str, columns: Mapping[str, Metrics]) -> Table:
    """Return the metrics of several flights side by side, a row a metric."""
    rows = [
        [
            measure.label,
            *(number(measure.factor * getattr(metrics, key)) for metrics in columns.values()),
            measure.unit,
        ]
        for key, measure in MEASURES.items()
    ]
    outcomes = [metrics.outcome.replace("_", " ") for metrics in columns.values()]
    rows.append(["outcome", *outcomes, ""])
    head = ["", *columns, "unit"]
    return Table(caption, head, rows, frozenset(range(1, len(columns) + 1)))


def trajectory_table(run: Run) -> Table:
    """Return the segments of the run's reference, a row a segment; no rows if it has none."""
    reference = run.provenance.scenario.get("reference", {})
    rows, begin = [], 0.0
    for segment in reference.get("segment", []):
        end = begin + segment["duration_s"]
        rows.append([f"{begin:g} to {end:g}", _what_it_does(segment)])
        begin = end
    return Table(
        "The trajectory, from rest to rest in each segment; moves and axes in the world frame.",
        ["time (s)", "motion"],
        rows,
    )


def plant_table(run: Run) -> Table:
    """Return how the plant of a run was imperfect, a row an effect, with every number."""
    plant = run.provenance.scenario.get("plant", {})
    provenance = run.provenance
    rows = [
        ["physics step", f"{from_SI(provenance.physics_step, 'ms'):g} ms", _integrator(plant)],
        [
            "control period",
            f"{from_SI(provenance.control_period, 'ms'):g} ms",
            "the command is held in between",
        ],
    ]
    for effect in plant.get("effects", []):
        kind = effect["kind"]
        words = _EFFECTS.get(kind, "")
        rows.append([kind.replace("-", " "), _effect_numbers(effect, run.vehicle), words])
    caption = f"The plant “{provenance.plant_name}”: how the vehicle really behaves."
    texts = [[str(cell or "") for cell in row] for row in rows]
    return Table(caption, ["", "numbers", "what it means"], texts)


def source_table(vehicle: Vehicle, caption: str, names: Sequence[str]) -> Table:
    """Return some of the vehicle's fields with their numbers and where these come from."""
    rows = [
        [name.replace("_", " "), _field_numbers(vehicle, name), vehicle.sources[name].text]
        for name in names
    ]
    return Table(caption, ["", "number", "where it comes from"], rows)


def _field_numbers(vehicle: Vehicle, name: str) -> str:
    """Return what a field of the vehicle holds, in the unit people use; "" for directions."""
    unit = FIELDS[name].unit
    if not unit:
        return ""
    shown = _written(unit)
    value = from_SI(np.asarray(getattr(vehicle, name)), unit)
    if name == "inertia":
        return f"diag{_vector(np.diag(value))} {shown}"
    values = np.unique(np.abs(value) if name == "rotor_position" else value)
    if len(values) > 2:
        return ""
    sign = "±" if name == "rotor_position" else ""
    gap = "" if shown.startswith("°") else " "
    return sign + " and ".join(number(float(v)) for v in values) + gap + shown


def _written(unit: str) -> str:
    """Return a unit at the end of a key as it is written: ``mrad_per_s`` as mrad/s."""
    return _WRITTEN_UNITS.get(unit, unit.replace("_per_", "/").replace("_", " "))


def _integrator(plant: Mapping[str, Any]) -> str:
    return (
        str(plant.get("integrator", ""))
        .replace("-euler", " Euler")
        .replace("runge-kutta-4", "Runge–Kutta 4")
    )


def _what_it_does(segment: Mapping[str, Any]) -> str:
    parts = []
    move = np.asarray(segment.get("move_m", np.zeros(3)), dtype=np.float64)
    if move.any():
        parts.append("move by " + _vector(move) + " m")
    angle = segment.get("rotation_angle_deg", 0.0)
    if angle:
        axis = np.asarray(segment.get("rotation_axis_W", (0.0, 0.0, 1.0)), dtype=np.float64)
        parts.append(f"turn by {number(angle)}° about {_vector(axis)}")
    return " and ".join(parts) or "rest"


def _vector(values: Any) -> str:
    return "(" + ", ".join(number(float(value)) for value in values) + ")"


def _effect_numbers(effect: Mapping[str, Any], vehicle: Vehicle) -> str:
    own = [_named(key, value) for key, value in effect.items() if key != "kind"]
    numbers = [text for text in own if text]
    if not numbers:
        for field in _OWN_VALUES.get(effect["kind"], ()):
            unit = FIELDS[field].unit
            values = np.unique(from_SI(getattr(vehicle, field), unit))
            shown = " to ".join(number(float(value)) for value in values[[0, -1][: len(values)]])
            numbers.append(_named(f"{field}_{unit}", shown))
    return ", ".join(numbers)


def _named(key: str, value: Any) -> str:
    """Return a key with its unit, and a value, as words: ``time constant up 20 ms``."""
    if value is False or value is None:
        return ""
    unit = unit_of(key)
    name = key.removesuffix(f"_{unit}").replace("_", " ")
    if value is True:
        return name
    if isinstance(value, list):
        value = _vector(np.ravel(value)) if np.size(value) <= 18 else "many"
    elif not isinstance(value, str):
        value = number(float(value))
    return f"{name} {value} {_written(unit)}".replace(" °", "°").strip()
