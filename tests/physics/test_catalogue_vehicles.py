"""The field's platforms: wrench maps against rotations coded here, classes, PX4's convention."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import omnimorph as om
from omnimorph.analysis.actuation import ActuationKind, ThrustKind
from omnimorph.analysis.platform import platform
from omnimorph.protocols import FloatArray
from omnimorph.studies.seven_rotors import certificate, find_axes, sphere_hubs

Columns = list[tuple[FloatArray, FloatArray, float]]
"""Hub, thrust axis and spin of each rotor."""


def R_x(angle: float) -> FloatArray:
    return np.asarray(Rotation.from_euler("x", angle).as_matrix())


def R_z(angle: float) -> FloatArray:
    return np.asarray(Rotation.from_euler("z", angle).as_matrix())


def on_arms(
    count: int, length: float, first: float, lean: Callable[[int], float], spin: float
) -> Columns:
    """Rotors on arms: R_z to the arm, then R_x about it, as the papers build them."""
    rows: Columns = []
    for k in range(count):
        turn = R_z(math.radians(first + 360.0 / count * k))
        hub, axis = turn @ [length, 0.0, 0.0], turn @ R_x(lean(k)) @ [0.0, 0.0, 1.0]
        rows.append((hub, axis, spin * (-1.0) ** k))
    return rows


def alternating(angle: float) -> Callable[[int], float]:
    return lambda k: angle * (-1.0) ** k


def omnicopter() -> Columns:
    """Fixed axes of eq. (2) at the vertices of eq. (1)."""
    a, b, c = 0.5 + 1 / math.sqrt(12), 0.5 - 1 / math.sqrt(12), 1 / math.sqrt(3)
    x = [-a, b, -b, a, a, -b, b, -a]
    y = [b, a, -a, -b, -b, -a, a, b]
    z = [c, -c, -c, c, c, -c, -c, c]
    rows: Columns = []
    for k in range(8):
        corner = np.array([1 - 2 * (k % 2), 1 - 2 * (k // 2 % 2), 1 - 2 * (k // 4)], dtype=float)
        hub = 0.12 / math.sqrt(3) * corner
        rows.append((hub, np.array([x[k], y[k], z[k]]), -corner[0] * corner[1]))
    return rows


def odar() -> Columns:
    """The front end, and the rear end mirrored in the centre of mass."""
    front = [(-1, 1, 1, -1), (1, 1, -1, 1), (-1, -1, 1, 1), (1, -1, -1, 1)]
    rows: Columns = []
    for end in (1.0, -1.0):
        for y, z, up, spin in front:
            axis = np.array([0.68, 0.28 * z, 0.68 * up])
            hub = end * np.array([0.4, 0.17 * y, 0.17 * z])
            rows.append((hub, axis / np.linalg.norm(axis), end * spin))
    return rows


def omav(tilts: FloatArray) -> Columns:
    single = on_arms(6, 0.3, 30.0, lambda k: float(tilts[k]), 1.0)
    return [(hub, axis, spin) for hub, axis, _ in single for spin in (1.0, -1.0)]


COMMON = [np.array([angle]) for angle in (0.0, 0.2, 0.5)]
TILTS = np.random.default_rng(5).uniform(-1.2, 1.2, (4, 6))

DESCRIBED: dict[str, tuple[Callable[[FloatArray], Columns], list[FloatArray]]] = {
    "quadrotor": (lambda _: on_arms(4, 0.23, 0.0, lambda k: 0.0, 1.0), [np.empty(0)]),
    "hexarotor": (lambda _: on_arms(6, 0.23, 0.0, lambda k: 0.0, 1.0), [np.empty(0)]),
    "tilt-hex": (
        lambda _: on_arms(6, 0.38998, 0.0, alternating(math.radians(20.0)), -1.0),
        [np.empty(0)],
    ),
    "fast-hex": (lambda t: on_arms(6, 0.38998, 0.0, alternating(float(t[0])), -1.0), COMMON),
    "voliro": (lambda t: on_arms(6, 0.375, 30.0, lambda k: float(t[k]), 1.0), list(TILTS)),
    "omav-12": (omav, list(TILTS)),
    "tilting-quad": (
        lambda t: on_arms(4, 0.23, 0.0, lambda k: float(t[k]), 1.0),
        list(TILTS[:, :4]),
    ),
    "omnicopter": (lambda _: omnicopter(), [np.empty(0)]),
    "odar-8": (lambda _: odar(), [np.empty(0)]),
}


@pytest.mark.parametrize("name", DESCRIBED)
def test_the_wrench_map_is_a_product_of_rotations(name: str) -> None:
    vehicle = om.load_vehicle(name)
    build, tilts = DESCRIBED[name]
    kappa = vehicle.drag_coefficient / vehicle.thrust_coefficient
    for tilt in tilts:
        expected = np.array(
            [
                np.concatenate([axis, np.cross(hub, axis) - spin * drag * axis])
                for (hub, axis, spin), drag in zip(build(tilt), kappa, strict=True)
            ]
        ).T
        np.testing.assert_allclose(om.allocation_matrix(vehicle, tilt), expected, atol=1e-12)


def test_every_platform_is_described_here() -> None:
    known = {*DESCRIBED, "omnimorph", "omnimorph-2026", "omni-plus-seven"}
    assert known == set(om.list_vehicles())


def test_omnimorph_becomes_the_omnicopter_turned() -> None:
    """At atan √2 the axes are the same lines, turned by 15° about z."""
    tilt = math.atan(math.sqrt(2.0))
    morphed = om.allocation_matrix(om.load_vehicle("omnimorph"), tilt)[:3]
    fixed = R_z(math.radians(15.0)) @ om.allocation_matrix(om.load_vehicle("omnicopter"), 0.0)[:3]
    corners = np.sign(om.load_vehicle("omnimorph").rotor_position)
    order = np.lexsort((-corners[:, 0], -corners[:, 1], -corners[:, 2]))
    along = np.abs((morphed[:, order] * fixed).sum(axis=0))
    np.testing.assert_allclose(along, 1.0, atol=1e-12)


# --- classes --------------------------------------------------------------------------------------

UNDER, FULLY = ActuationKind.UNDER_ACTUATED, ActuationKind.FULLY_ACTUATED
REDUNDANT = ActuationKind.REDUNDANT
ONE_WAY, SOME_WAYS = ThrustKind.UNI_DIRECTIONAL, ThrustKind.MULTI_DIRECTIONAL
ALL_WAYS = ThrustKind.OMNIDIRECTIONAL


@pytest.mark.parametrize(
    ("name", "kind", "thrust"),
    [
        ("quadrotor", UNDER, ONE_WAY),
        ("hexarotor", UNDER, ONE_WAY),
        ("tilt-hex", FULLY, SOME_WAYS),
        ("fast-hex", FULLY, SOME_WAYS),
        ("tilting-quad", FULLY, SOME_WAYS),
        ("omnicopter", REDUNDANT, ALL_WAYS),
        ("odar-8", REDUNDANT, ALL_WAYS),
        ("omni-plus-seven", REDUNDANT, ALL_WAYS),
        ("omnimorph", REDUNDANT, ALL_WAYS),
        ("voliro", FULLY, ALL_WAYS),
        ("omav-12", REDUNDANT, ALL_WAYS),
    ],
)
def test_classes(name: str, kind: ActuationKind, thrust: ThrustKind) -> None:
    vehicle = om.load_vehicle(name)
    found = platform(vehicle)
    assert (found.kind, found.thrust_kind) == (kind, thrust)
    claims = re.search("omni-?directional", vehicle.title, re.IGNORECASE)
    assert not claims or thrust is ALL_WAYS, "what its title says"
    assert math.isfinite(found.hover_power), "it hovers level"


def test_assumed_numbers_are_marked() -> None:
    for name in om.list_vehicles():
        vehicle = om.load_vehicle(name)
        assert {"mass", "inertia", "rotor_position"} <= set(vehicle.sources)
        assert all(source.text for source in vehicle.sources.values())


# --- seven rotors ---------------------------------------------------------------------------------


def test_the_seven_axes_prove_themselves() -> None:
    """Rank 6 and A b = 0 for equal b > 0: any wrench can be made with positive thrusts."""
    vehicle = om.load_vehicle("omni-plus-seven")
    proof = certificate(
        vehicle.rotor_axis, vehicle.rotor_position, vehicle.rotor_spin, float(vehicle.kappa[0])
    )
    assert proof.holds
    assert proof.condition_number < 1.55
    A = om.allocation_matrix(vehicle, 0.0)
    for wrench in np.vstack([np.eye(6), -np.eye(6)]):
        thrust = np.linalg.pinv(A) @ wrench
        positive = thrust + max(-thrust.min(), 0.0) + 1.0
        np.testing.assert_allclose(A @ positive, wrench, atol=1e-12)
        assert positive.min() > 0.0


@pytest.mark.slow
def test_the_program_finds_axes_as_good() -> None:
    vehicle = om.load_vehicle("omni-plus-seven")
    spins = vehicle.rotor_spin
    found = find_axes(sphere_hubs(0.3), spins, float(vehicle.kappa[0]))
    kept = certificate(vehicle.rotor_axis, vehicle.rotor_position, spins, float(vehicle.kappa[0]))
    assert found.holds
    assert found.condition_number <= kept.condition_number * (1.0 + 1e-6)


# --- PX4's convention -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in DESCRIBED if DESCRIBED[name][1][0].size == 0])
def test_effectiveness_rows_agree_with_px4(name: str) -> None:
    """PX4's control effectiveness of a rotor: moment = CT p × a − CT KM a, force = CT a, in FRD.

    Its body frame is x forward, y right, z down: ours turned by 180° about x. KM is positive for a
    rotor that turns counter-clockwise seen from above: about its own axis, as our spin.
    """
    vehicle = om.load_vehicle(name)
    to_FRD = np.diag([1.0, -1.0, -1.0])
    rows = []
    for p, a, k, kappa in zip(
        vehicle.rotor_position @ to_FRD,
        vehicle.rotor_axis @ to_FRD,
        vehicle.rotor_spin,
        vehicle.kappa,
        strict=True,
    ):
        CT, KM = 1.0, k * kappa
        rows.append(np.concatenate([CT * np.cross(p, a) - CT * KM * a, CT * a]))
    px4 = np.array(rows).T  # moments first
    ours = om.allocation_matrix(vehicle, 0.0)
    np.testing.assert_allclose(to_FRD @ px4[3:], ours[:3], atol=1e-14)
    np.testing.assert_allclose(to_FRD @ px4[:3], ours[3:], atol=1e-14)
