"""The text of a new vehicle file: commented, complete, and fit to fly before it is edited."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, get_args

from omnimorph.errors import VehicleError

Kind = Literal["fixed", "synchronised", "independent"]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""How the rotors tilt: not at all, all together by one servo, or each by its own."""

_FEWEST, _MOST = 4, 18
_ARM, _CANT = 0.25, math.radians(20.0)

_HEAD = """\
# {name}: {count} rotors on a circle, {words}.
#
# Replace every number by your vehicle's and say where it comes from: under [sources] if somebody
# measured or published it, under [assumed] if not. The unit is at the end of each key.
# Look at what you have with   omnimorph vehicles {name}.toml
#                              omnimorph analyze {name}.toml --out analysis
# and fly it with              omnimorph fly tour --vehicle {name}.toml

schema = 1
name = "{name}"
title = "A new vehicle"
mass_kg = 1.5                           # everything included, as it flies
inertia_kg_m2 = [0.020, 0.020, 0.035]   # about the centre of mass: Jx, Jy, Jz, or a 3 x 3 matrix

[rotor_defaults]                        # what all rotors share; a [[rotor]] may say otherwise
thrust_coefficient_N_per_Hz2 = 6.5e-4   # thrust = c_f w|w|, from a thrust stand
drag_coefficient_Nm_per_Hz2 = 1.0e-5    # drag torque = c_tau w|w|
speed_min_Hz = 16.0                     # negative if the rotors can be reversed
speed_max_Hz = 110.0
time_constant_up_ms = 20.0              # how fast the speed follows its command
time_constant_down_ms = 20.0
spin_inertia_kg_m2 = 5e-5               # of propeller and rotor about the axis

# Positions are from the centre of mass, x forward, y to the left, z up. `spin` is the sense in
# which a rotor turns, seen against its thrust: "ccw" or "cw".
"""
_WORDS = {
    "fixed": "canted by 20 degrees in turn and fixed",
    "synchronised": "one servo cants them all, in turn to one side and the other",
    "independent": "each tilts about its arm by a servo of its own",
}
_SERVO = """
[[servo]]
name = "{name}"
angle_min_deg = {low}
angle_max_deg = {high}
rate_max_deg_per_s = 200.0              # under load
time_constant_ms = 0.0
"""


def new_vehicle_text(name: str, rotors: int = 6, kind: Kind = "fixed") -> str:
    """Return the text of a vehicle file to start from.

    Parameters
    ----------
    name : str
        Of the vehicle, and of its file without ``.toml``.
    rotors : int
        An even number from 4 to 18, on a circle; from 6 on if they are fixed, so that it is fully
        actuated.
    kind : str
        One of `KINDS`.

    Raises
    ------
    VehicleError
        If the number or the kind is another.

    Examples
    --------
    >>> new_vehicle_text("mine").splitlines()[0]
    '# mine: 6 rotors on a circle, canted by 20 degrees in turn and fixed.'
    """
    if kind not in KINDS:
        raise VehicleError.at("new vehicle", "kind", kind, ", ".join(KINDS))
    fewest = 6 if kind == "fixed" else _FEWEST
    if rotors % 2 or not fewest <= rotors <= _MOST:
        allowed = f"an even number from {fewest} to {_MOST}"
        raise VehicleError.at("new vehicle", "rotors", rotors, allowed)
    head = _HEAD.format(name=name, count=rotors, words=_WORDS[kind])
    parts = [head, *_rotors(rotors, kind), *_servos(rotors, kind), *_assumed(kind)]
    return "".join(parts)


def _rotors(count: int, kind: Kind) -> Iterator[str]:
    for k in range(count):
        angle = 2.0 * math.pi * k / count
        x, y = math.cos(angle), math.sin(angle)
        side = 1.0 if k % 2 == 0 else -1.0
        yield f"\n[[rotor]]\nposition_m = {_vector(_ARM * x, _ARM * y, 0.0)}\n"
        if kind == "fixed":
            lean = side * math.sin(_CANT)
            yield f"axis = {_vector(lean * y, -lean * x, math.cos(_CANT))}   # of its thrust\n"
        else:
            side = side if kind == "synchronised" else 1.0
            yield f"hinge = {_vector(side * x, side * y, 0.0)}   # it tilts about this axis\n"
            yield f'servo = "{"cant" if kind == "synchronised" else f"arm{k}"}"\n'
        yield f'spin = "{"ccw" if k % 2 == 0 else "cw"}"\n'


def _servos(count: int, kind: Kind) -> Iterator[str]:
    if kind == "synchronised":
        yield _SERVO.format(name="cant", low=0.0, high=35.0)
    elif kind == "independent":
        for k in range(count):
            yield _SERVO.format(name=f"arm{k}", low=-90.0, high=90.0)


def _assumed(kind: Kind) -> Iterator[str]:
    from omnimorph.design.keys import FIELDS  # which loads NumPy; `--help` needs the kinds alone

    yield "\n[assumed]\n"
    asked = [
        field for field in FIELDS.values() if field.shape is not None and not field.is_optional
    ]
    of_tilt = [f for f in asked if f.table == "servo" or f.name in ("hinge_axis", "rotor_servo")]
    others = [field for field in asked if field not in of_tilt]
    for field in others if kind == "fixed" else others + of_tilt:
        key = field.file_key
        name = f'"{key}"' if "." in key else key
        yield f'{name} = "From the template: replace it."\n'


def _vector(*numbers: float) -> str:
    return "[" + ", ".join(repr(round(number, 12) + 0.0) for number in numbers) + "]"
