"""Every number that decides a flight has a path, by which it is read and replaced.

::

    vehicle.mass                    of the vehicle: the controller's model, and the truth with it
    vehicle.thrust_coefficient[3]   of one rotor; vehicle.rotor_position[3][2] of one of its axes
    truth.mass                      of the vehicle in the plant alone
    plant.physics_step              of the plant
    plant.rotor-lag.up              of an effect, by its kind; plant.constant-wrench[1].force of the
                                    second of that kind
    controller.position             of the tracking gains
    controller.allocator.W1         of the allocation rule
    start_tilt, lost_beyond         of the scenario itself

Paths follow from the fields that each record declares, without a list of their own; all values are
in SI. What decides the number of rotors and servos has none, nor has the reference.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.arrays import as_numbers
from omnimorph.design.keys import FIELDS
from omnimorph.design.records import Declaration, Record, declared
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError, legible
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import EFFECTS, Effect
from omnimorph.simulation.effects.truth import TrueValues
from omnimorph.simulation.plant import PlantModel
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import ScenarioLike, as_scenario

_PATH = re.compile(r"(.*?)((?:\[(?:0|[1-9][0-9]{0,8})\])*)", re.DOTALL)
_MOST_NAMED = 4
_PROPOSED_FOR = ("vehicle.", "start_tilt", "plant.control_period", "plant.command-delay.")


def paths(scenario: ScenarioLike) -> list[str]:
    """Return the path of every number, or array of numbers, of a scenario.

    They are what `value_at` reads, `replaced` puts in and `fly_many` varies, all in SI; an index
    behind a path, ``vehicle.thrust_coefficient[3]``, is one entry of it, counted from 0.

    Examples
    --------
    >>> import omnimorph as om
    >>> found = om.paths("hover")
    >>> found[:3], "controller.allocator.W1" in found
    (['vehicle.mass', 'vehicle.tilt_mechanism_mass', 'vehicle.inertia'], True)
    """
    return list(_known(_parts(as_scenario(scenario))))


def value_at(scenario: ScenarioLike, path: str) -> float | FloatArray | None:
    """Return the value at a path, in SI.

    Returns
    -------
    float, array or None
        None where an effect has no number of its own and takes the vehicle's.

    Raises
    ------
    ScenarioError
        If there is no such path; it names the nearest ones.

    Examples
    --------
    >>> import omnimorph as om
    >>> om.value_at("hover", "vehicle.mass")
    1.315
    """
    scenario = as_scenario(scenario)
    part, _, field, at = _place(_parts(scenario), path)
    value = _whole(part, field, scenario.vehicle)[at] if at else getattr(part, field)
    return value if value is None else float(value) if np.ndim(value) == 0 else np.array(value)


def shape_at(scenario: Scenario, path: str, beside: Sequence[str] = ()) -> tuple[int, ...]:
    """Return the shape of the numbers at a path; where one may stand for several, of all of them.

    Raises
    ------
    ScenarioError
        If there is no such path; it names the nearest ones, also among what else may be asked for
        `beside` it.

    Examples
    --------
    >>> import omnimorph as om
    >>> hover = om.load_scenario("hover")
    >>> shape_at(hover, "vehicle.mass"), shape_at(hover, "controller.allocator.W1")
    ((), (8,))
    """
    part, _, field, at = _place(_parts(scenario), path, beside)
    shape: tuple[int, ...] = _whole(part, field, scenario.vehicle)[at].shape
    return shape


def _refuse_overlaps(scenario: Scenario, values: Mapping[str, ArrayLike]) -> None:
    """Refuse a path beside one of its own numbers: which of them would count."""
    for path in values:
        whole = next((one for one in values if str(path).startswith(f"{one}[")), None)
        if whole is not None:
            allowed = f"left out, or put into the numbers at {whole}"
            raise ScenarioError.at(f"scenario {scenario.name}", str(path), "given", allowed)


def replaced(scenario: ScenarioLike, values: Mapping[str, ArrayLike]) -> Scenario:
    """Return a scenario with other values at several paths, put in together and then checked.

    So two limits can move past the old ones.

    Parameters
    ----------
    scenario : Scenario, str or path
        Which remains as it is, or its name or file.
    values : mapping
        From paths, such as those of `paths`, to a number or an array in SI. One number for what
        each rotor, servo or filter has is that of all of them.

    Raises
    ------
    InputError
        If there is no such path (the message names the nearest ones), or if what comes out is not
        possible.

    Examples
    --------
    A plant that is heavier than the controller believes, and a stiffer controller:

    >>> import omnimorph as om
    >>> other = om.replaced("hover", {"truth.mass": 1.4, "controller.position": 40.0})
    >>> om.value_at(other, "truth.mass"), om.value_at(other, "vehicle.mass"), other.gains.position
    (1.4, 1.315, 40.0)
    """
    scenario = as_scenario(scenario)
    if not isinstance(values, Mapping):
        allowed = "a mapping from paths to numbers"
        raise ScenarioError.at(f"scenario {scenario.name}", "values", values, allowed)
    # A controller that was proposed is so no longer once that changes for which it was.
    another = any(str(path).startswith(("controller.", *_PROPOSED_FOR)) for path in values)
    proposed = scenario.proposed and not another
    parts = _parts(scenario)
    changes: dict[str, dict[str, Any]] = {name: {} for name in parts}
    known_truth = [one for one in scenario.plant.effects if isinstance(one, TrueValues)]
    true_values = [value for one in known_truth for value in one.values]
    _refuse_overlaps(scenario, values)
    for path, value in values.items():
        place = _place(parts, path)
        number = _number(parts, place, path, value)
        if place.name == "truth":
            here = (place.field, *place.at)
            true_values = [v for v in true_values if (v[0], *v[1])[: len(here)] != here]
            true_values.append((place.field, place.at, number.tolist()))
        else:
            _put(changes[place.name], place, number, scenario.vehicle)
    new = {name: _with(part, changes[name]) for name, part in parts.items() if name}
    effects = [new[name] for name, _ in _effects(scenario.plant)]
    if true_values:
        effects.append(TrueValues(values=tuple(true_values)))
    return dataclasses.replace(
        scenario,
        vehicle=new["vehicle"],
        plant=dataclasses.replace(new["plant"], effects=tuple(effects)),
        gains=new["controller"],
        allocator=new["controller.allocator"],
        proposed=proposed,
        overrides=scenario.overrides if proposed else {},
        **{name: number.tolist() for name, number in changes[""].items()},
    )


class _Place(NamedTuple):
    """Where a path leads."""

    part: Any
    name: str  # of the part: "vehicle", "plant.rotor-lag", and so on; "" for the scenario itself
    field: str
    at: tuple[int, ...]


def _parts(scenario: Scenario) -> dict[str, Any]:
    """Return what has numbers, under the beginning of its paths."""
    return {
        "vehicle": scenario.vehicle,
        "truth": scenario.plant.true_vehicle(scenario.vehicle),
        "plant": scenario.plant,
        **dict(_effects(scenario.plant)),
        "controller": scenario.gains,
        "controller.allocator": scenario.allocator,
        "": scenario,
    }


def _effects(plant: PlantModel) -> Iterator[tuple[str, Effect]]:
    """Yield the effects by the beginning of their paths; those of one kind are numbered."""
    kinds = [effect.kind for effect in plant.effects]
    for number, effect in enumerate(plant.effects):
        if not isinstance(effect, TrueValues):
            several = kinds.count(effect.kind) > 1
            which = f"[{kinds[:number].count(effect.kind)}]" if several else ""
            yield f"plant.{effect.kind}{which}", effect


def _rules(part: Any) -> dict[str, Declaration]:
    """Return the fields of a part that hold numbers, with what is declared of them."""
    kind: Any = type(part)
    return _rules_of(kind)


@functools.cache
def _rules_of(kind: Any) -> dict[str, Declaration]:
    fields = declared(kind).items()
    if issubclass(kind, Vehicle | Record):
        return {name: field for name, field in fields if field.is_number or field.is_count}
    return {name: field for name, field in fields if isinstance(field.default, float)}


def _known(parts: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return every path, with the name of the part and the field."""
    found = [(name, field) for name, part in parts.items() for field in _rules(part)]
    return {f"{name}.{field}".removeprefix("."): (name, field) for name, field in found}


def _split(path: str) -> tuple[str, tuple[int, ...]]:
    """Return a path without the indices behind it, and the indices."""
    begin, indices = _PATH.fullmatch(path).groups()  # type: ignore[union-attr]  # any text matches
    return begin, tuple(int(index) for index in re.findall(r"\d+", indices))


def _place(parts: Mapping[str, Any], path: str, beside: Sequence[str] = ()) -> _Place:
    """Return where a path leads; refuse one that leads nowhere."""
    known = _known(parts)
    begin, at = _split(path) if isinstance(path, str) else ("", ())
    if begin not in known:
        raise _unknown(parts, path if isinstance(path, str) else repr(path), known, beside)
    name, field = known[begin]
    place = _Place(parts[name], name, field, at)
    shape = np.shape(_whole(place.part, field, parts["vehicle"]))
    if len(at) > len(shape) or any(i >= n for i, n in zip(at, shape, strict=False)):
        allowed = f"one with indices within the shape {shape}" if shape else "one without an index"
        raise ScenarioError.at(_where(parts), "path", path, allowed)
    return place


def _where(parts: Mapping[str, Any]) -> str:
    return f"scenario {parts[''].name}"


def _unknown(
    parts: Mapping[str, Any], path: str, paths: Iterable[str], beside: Sequence[str]
) -> ScenarioError:
    """Return the refusal of a path that is not there, with what is nearest."""
    where, plant = _where(parts), parts["plant"]
    there = [effect.kind for effect in plant.effects]
    for kind in [effect.kind for effect in EFFECTS if effect.kind not in there]:
        if path.startswith(f"plant.{kind}."):
            allowed = f"left out, because plant {plant.name} has no {kind}"
            return ScenarioError.at(where, "path", path, allowed)
    known = [*beside, *paths]
    ends = {key: key.rpartition(".")[2] for key in known}
    end = path.rpartition(".")[2]
    near = [key for key in known if ends[key] == end]
    near += difflib.get_close_matches(path, known, n=_MOST_NAMED, cutoff=0.7)
    alike = difflib.get_close_matches(end, set(ends.values()), cutoff=0.8)
    near += [key for key in known if ends[key] in alike]
    named = list(dict.fromkeys(near))[:_MOST_NAMED]
    begins = ", ".join([*filter(None, parts), *_rules(parts[""])])
    all_of_them = f"they are {', '.join(beside)}, or begin" if beside else "they begin"
    hint = f"did you mean {' or '.join(named)}?" if named else f"{all_of_them} with {begins}."
    what = "key or path" if beside else "path"
    sentence = f"{where}: {legible(path)} is not a known {what}; {hint}"
    return ScenarioError(sentence, file=where, key=path, allowed=f"one of {', '.join(known)}")


def _whole(part: Any, field: str, vehicle: Vehicle) -> FloatArray:
    """Return all numbers of a field; where one stands for several, each of them."""
    if isinstance(part, Scenario) and field == "start_tilt":
        return part.tilt
    numbers = as_numbers(getattr(part, field))
    is_one = numbers.ndim == 0 and np.isfinite(numbers)
    if isinstance(part, Record) and is_one and _rules(part)[field].depth > 0:  # of several
        return np.full(_rules(part)[field].length or vehicle.n_rotors, float(numbers))
    return numbers


def _number(parts: Mapping[str, Any], place: _Place, path: str, value: ArrayLike) -> FloatArray:
    """Return a new value as finite numbers, as many as there is room for."""
    number = as_numbers(value)
    if not np.isfinite(number).all():
        raise ScenarioError.at(_where(parts), path, value, "finite numbers in SI")
    if not place.at and not isinstance(place.part, Vehicle):
        return number  # the record itself says how many there may be
    whole = _whole(place.part, place.field, parts["vehicle"])
    shape, one_for_all = whole[place.at].shape, False
    if not place.at and number.ndim == 0:  # of each rotor, servo or filter
        one_for_all = FIELDS[place.field].shape == ()
    if number.shape != shape and not one_for_all:
        allowed = f"of shape {shape}" if shape else "one number"
        raise ScenarioError.at(_where(parts), path, value, allowed)
    return number


def _put(changes: dict[str, Any], place: _Place, number: FloatArray, vehicle: Vehicle) -> None:
    """Put a new value among the changes of a part."""
    if place.at or isinstance(place.part, Vehicle):
        whole = np.array(changes.get(place.field, _whole(place.part, place.field, vehicle)))
        whole[place.at] = number
        number = whole
    changes[place.field] = number


def _with(part: Any, changes: Mapping[str, FloatArray]) -> Any:
    """Return a part with changes, checked by itself; the same if there are none."""
    if isinstance(part, Vehicle):
        return part.replace(**changes) if changes else part
    rules, values = _rules(part), {name: number.tolist() for name, number in changes.items()}
    for name, value in values.items():
        if rules[name].is_count and isinstance(value, float):
            values[name] = int(value) if value.is_integer() else value
    return dataclasses.replace(part, **values) if changes else part
