"""Inertia from parts: closed forms, sums, turns and shifts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from omnimorph.errors import InputError
from omnimorph.identification import Box, Cylinder, PointMass, assemble
from omnimorph.identification.inertia import Part

numbers = st.floats(-2.0, 2.0)
sizes = st.floats(0.0, 1.0)
masses = st.floats(0.01, 5.0)
places = st.tuples(numbers, numbers, numbers)
turns = st.tuples(numbers, numbers, numbers)
boxes = st.builds(
    Box, mass=masses, size=st.tuples(sizes, sizes, sizes), position=places, orientation=turns
)
cylinders = st.builds(
    Cylinder, mass=masses, radius=sizes, length=sizes, position=places, orientation=turns
)
points = st.builds(PointMass, mass=masses, position=places)
bodies = st.lists(boxes | cylinders | points, min_size=1, max_size=5)


def test_tube_is_a_cylinder_less_its_core() -> None:
    outer = Cylinder(mass=4.0, radius=2.0, length=3.0)
    core = Cylinder(mass=1.0, radius=1.0, length=3.0)  # of the same density
    tube = Cylinder(mass=3.0, radius=2.0, inner_radius=1.0, length=3.0)
    difference = outer.own_inertia() - core.own_inertia()
    assert tube.own_inertia() == pytest.approx(difference, abs=1e-12)


def test_box_is_its_grains() -> None:
    """The inertia is the integral over the mass: a sum over grains, to their own size."""
    turn, place, size = (0.3, -0.7, 1.1), np.array([0.2, -0.1, 0.4]), np.array([0.3, 0.2, 0.1])
    grid = (np.arange(20) + 0.5) / 20.0 - 0.5
    grains = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3) * size
    R = Rotation.from_euler("xyz", turn).as_matrix()  # fixed axes: roll, then pitch, then yaw
    whole = assemble([Box(mass=2.0, size=tuple(size), position=tuple(place), orientation=turn)])
    parts = [PointMass(mass=2.0 / 8000, position=tuple(place + R @ g)) for g in grains]
    sum_of_grains = assemble(parts)
    assert whole.centre == pytest.approx(sum_of_grains.centre, abs=1e-12)
    # a grid of n misses the second moment of a side by 1/n² of it
    assert whole.inertia == pytest.approx(sum_of_grains.inertia, abs=2.0 * 0.13 / 12 / 400 * 1.01)


def test_lying_cylinder_has_its_axis_along_x() -> None:
    lying = Cylinder(mass=12.0, radius=1.0, length=2.0, orientation=(0.0, np.pi / 2, 0.0))
    assert lying.own_inertia() == pytest.approx(np.diag([6.0, 7.0, 7.0]), abs=1e-12)


@given(bodies, bodies)
def test_bodies_add_up(first: list[Part], second: list[Part]) -> None:
    """Two bodies taken as points of their own inertia are one body."""
    a, b, both = assemble(first), assemble(second), assemble([*first, *second])
    total = a.mass + b.mass
    centre = (a.mass * a.centre + b.mass * b.centre) / total
    apart = a.centre - b.centre
    reduced = a.mass * b.mass / total
    between = reduced * (apart @ apart * np.eye(3) - np.outer(apart, apart))
    assert both.mass == pytest.approx(total)
    assert both.centre == pytest.approx(centre, abs=1e-12)
    assert both.inertia == pytest.approx(a.inertia + b.inertia + between, abs=1e-10)


@given(bodies, turns)
def test_turning_the_parts_turns_the_inertia(body: list[Part], turn: tuple[float, ...]) -> None:
    R = Rotation.from_euler("xyz", turn)
    turned = []
    for part in body:
        values = {"position": tuple(R.apply(part.position))}
        if type(part) is not PointMass:
            own = Rotation.from_euler("xyz", part.orientation)  # type: ignore[union-attr]
            with np.errstate(all="ignore"):
                values["orientation"] = tuple((R * own).as_euler("xyz"))
        turned.append(type(part)(**(vars(part) | values)))
    before, after = assemble(body), assemble(turned)
    J = R.as_matrix() @ before.inertia @ R.as_matrix().T
    assert after.inertia == pytest.approx(J, abs=1e-10)
    assert after.centre == pytest.approx(R.apply(before.centre), abs=1e-12)


@given(bodies, places)
def test_shifting_all_parts_changes_the_centre_only(
    body: list[Part], shift: tuple[float, ...]
) -> None:
    moved = [
        type(part)(**(vars(part) | {"position": tuple(np.add(part.position, shift))}))
        for part in body
    ]
    before, after = assemble(body), assemble(moved)
    assert after.inertia == pytest.approx(before.inertia, abs=1e-10)
    assert after.centre == pytest.approx(before.centre + shift, abs=1e-12)


@given(bodies)
def test_every_body_can_exist(body: list[Part]) -> None:
    """No principal moment is negative, or above the sum of the other two."""
    low, middle, high = np.linalg.eigvalsh(assemble(body).inertia)
    slack = 1e-12 * (1.0 + high)
    assert low >= -slack
    assert high <= low + middle + slack


def test_steiner_about_another_point() -> None:
    """A ball far from a counterweight: the reduced mass times the square of the distance."""
    body = assemble([PointMass(mass=3.0), PointMass(mass=1.0, position=(0.0, 0.0, 2.0))])
    assert body.inertia == pytest.approx(np.diag([3.0, 3.0, 0.0]), abs=1e-12)
    assert not body.is_solid


def test_no_parts_and_impossible_parts_are_refused() -> None:
    with pytest.raises(InputError, match=r"there are no parts"):
        assemble([])
    with pytest.raises(InputError, match=r"box: size is .* three numbers of metres"):
        Box(mass=1.0, size=(1.0, 1.0))
    with pytest.raises(InputError, match=r"point: mass is 0.0, but it must be a positive"):
        PointMass(mass=0.0)
    with pytest.raises(InputError, match=r"cylinder: inner_radius is 2.0, .* at most the radius"):
        Cylinder(mass=1.0, radius=1.0, length=1.0, inner_radius=2.0)
