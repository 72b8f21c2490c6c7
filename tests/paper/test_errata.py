"""What the paper contradicts itself in, each entry of docs/errata.md shown by computation."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.studies.reproduction.paper import claims, printed_matrix
from omnimorph.studies.reproduction.printed_matrix import factors_of

VEHICLE = om.load_vehicle("omnimorph")
HALF_EDGE = 0.1062
KAPPA = float(VEHICLE.kappa[0])
PAGE = Path(__file__).parents[2] / "docs" / "errata.md"
OURS = [0, 1, 2, 3, 4, 7, 5, 6]  # which of our rotors each column of the paper's F is

# Brescianini's axes as the paper prints them (its eq. 2) and the vertices of its eq. (1).
_A, _B, _C = 0.5 + 1 / math.sqrt(12), 0.5 - 1 / math.sqrt(12), 1 / math.sqrt(3)
AXES = np.array(
    [
        [-_A, _B, -_B, _A, _A, -_B, _B, -_A],
        [_B, _A, -_A, -_B, -_B, -_A, _A, _B],
        [_C, -_C, -_C, _C, _C, -_C, -_C, _C],
    ]
)
VERTICES = np.array(
    [
        [1, -1, 1, -1, 1, -1, 1, -1],
        [1, 1, -1, -1, 1, 1, -1, -1],
        [1, 1, 1, 1, -1, -1, -1, -1],
    ]
)


def printed(tilt: float) -> FloatArray:
    """The first eight columns of F as the paper prints them, c_f taken out."""
    s, c, L, k = math.sin(tilt), math.cos(tilt), HALF_EDGE, KAPPA
    worth = {"s": s, "c": c, "Ls": L * s, "Lc": L * c, "ks": k * s, "kc": k * c}
    rows = [[factors_of(entry) for entry in row] for row in printed_matrix()]
    return np.array(
        [[sum(worth[name] * n for name, n in one.items()) for one in row] for row in rows]
    )


def hub_of(force: FloatArray, torque: FloatArray, spin: float) -> FloatArray:
    """The vertex of the cube from which a rotor makes a torque with its force and its drag."""
    lever = torque + spin * KAPPA * force
    vertices = HALF_EDGE * VERTICES.T
    misses = [np.linalg.norm(np.cross(vertex, force) - lever) for vertex in vertices]
    best = int(np.argmin(misses))
    assert misses[best] < 1e-12
    return np.asarray(VERTICES.T[best], dtype=np.float64)


def test_four_entries_of_the_printed_matrix_are_wrong() -> None:
    wrong = set()
    for tilt in (0.3, 0.8, 1.2):
        A = om.allocation_matrix(VEHICLE, tilt)[:, OURS]
        row, column = np.nonzero(np.abs(printed(tilt) - A) > 1e-12)
        wrong |= {(int(i) + 1, int(j) + 1) for i, j in zip(row, column, strict=True)}
    assert wrong == {(2, 2), (2, 3), (2, 4), (4, 7)}


def test_its_force_rows_read_with_the_signs_put_right() -> None:
    s = math.sin(0.8)
    force_y = om.allocation_matrix(VEHICLE, 0.8)[1, OURS]
    assert np.allclose(force_y, [0, -s, 0, s, 0, -s, s, 0], rtol=0.0, atol=1e-15)


def test_as_printed_rotors_7_and_8_share_a_vertex() -> None:
    F, A = printed(0.8), om.allocation_matrix(VEHICLE, 0.8)[:, OURS]
    assert hub_of(F[:3, 6], F[3:, 6], 1.0).tolist() == [-1, -1, -1]
    assert hub_of(F[:3, 7], F[3:, 7], -1.0).tolist() == [-1, -1, -1]
    assert hub_of(A[:3, 6], A[3:, 6], 1.0).tolist() == [-1, 1, -1]  # with + L cos α + L sin α


def test_its_columns_are_not_numbered_as_its_vertices() -> None:
    A = om.allocation_matrix(VEHICLE, 0.8)[:, OURS]
    spins = VEHICLE.rotor_spin[OURS]
    hubs = [hub_of(A[:3, j], A[3:, j], spins[j]).tolist() for j in range(8)]
    assert hubs != VERTICES.T.tolist()
    assert sorted(hubs) == sorted(VERTICES.T.tolist())


def test_its_length_means_three_things() -> None:
    """L/√3 is the half-edge of a cube of circumradius L; F fits only if L is the half-edge."""
    for meaning, half_edge in (("edge", 0.5), ("circumradius", 1 / math.sqrt(3)), ("half", 1.0)):
        moved = VEHICLE.replace(rotor_position=half_edge * VEHICLE.rotor_position)
        A = om.allocation_matrix(moved, 0.8)[:, OURS]
        fits = bool(np.allclose(A[5], printed(0.8)[5], rtol=0.0, atol=1e-12))
        assert fits is (meaning == "half")


def test_the_tilt_axes_have_length_root_two_thirds() -> None:
    lengths = np.linalg.norm(np.cross(AXES.T, [0.0, 0.0, 1.0]), axis=1)
    assert np.allclose(lengths, math.sqrt(2.0 / 3.0), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_printed_rotation_tilts_half_of_the_rotors_the_wrong_way(sign: float) -> None:
    """R'_i R_X(+α) leads to the axes of eq. (2) only where they point down (columns 2, 3, 6, 7)."""
    tilt = math.atan(math.sqrt(2.0))
    fits = []
    for axis in AXES.T:
        x = np.cross(axis, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        y = np.cross([0.0, 0.0, 1.0], x)
        turned = -math.sin(sign * tilt) * y + math.cos(tilt) * np.array([0.0, 0.0, 1.0])
        fits.append(bool(np.allclose(np.abs(turned @ axis), 1.0, rtol=0.0, atol=1e-12)))
    down = (AXES[2] < 0.0).tolist()
    assert fits == (down if sign > 0 else [not one for one in down])


def test_its_signs_would_let_drag_drive_the_rotors() -> None:
    """Drag must act against the rotation: with k = −1 for counter-clockwise it acts along it."""
    A = om.allocation_matrix(VEHICLE, 0.0)
    drag = A[5] - np.cross(VEHICLE.rotor_position, A[:3].T)[:, 2]
    turning = VEHICLE.rotor_spin  # +1: counter-clockwise seen from above, for positive thrust
    assert (drag * turning < 0.0).all()  # ours: on the body, against the rotation
    assert (-drag * turning > 0.0).all()  # the paper's sign


def test_the_thrust_coefficient_stands_once_before_the_derivative() -> None:
    """With inputs u in Hz² and F = c_f [F1 | ∂w/∂α], w = F1 u would count c_f twice if w did."""
    in_Hz = VEHICLE.thrust_coefficient * (2.0 * math.pi) ** 2  # N/Hz²
    u = np.linspace(2000.0, 9000.0, 8)  # Hz²
    h = 1e-6
    wrench = [om.allocation_matrix(VEHICLE, 0.7 + step) @ (in_Hz * u) for step in (-h, h)]
    slope = (wrench[1] - wrench[0]) / (2.0 * h)
    last = om.full_allocation_matrix(VEHICLE, in_Hz * u, 0.7)[:, 8]
    assert np.allclose(last, slope, rtol=1e-7, atol=1e-7)
    assert not np.allclose(in_Hz[0] * last, slope, rtol=0.5)


def test_the_full_matrix_does_not_multiply_eight_thrusts() -> None:
    assert om.full_allocation_matrix(VEHICLE, np.ones(8), 0.7).shape == (6, 9)
    assert om.allocation_matrix(VEHICLE, 0.7).shape == (6, 8)


def test_its_centimetres_are_metres() -> None:
    """It calls the error with ten times W3 comparable to that of Case B, which it gives in m."""
    of_w3, of_b = (claims()[f"position_error_{key}"].value for key in ("w3", "b"))
    assert of_w3 is not None
    assert of_b is not None
    assert of_w3 == pytest.approx(of_b, rel=0.1)  # read in m; in cm it would be 100 times less


def test_at_90_degrees_roll_and_pitch_come_from_lever_arms() -> None:
    """Without any drag the rotors still make roll and pitch, and the rank stays 5."""
    still = VEHICLE.replace(drag_coefficient=VEHICLE.drag_coefficient * 1e-9)
    for vehicle in (VEHICLE, still):
        found = om.analysis.actuation(vehicle, math.pi / 2, beyond_limits=True)
        assert found.rank_thrust == 5
        torques = om.allocation_matrix(vehicle, math.pi / 2)[3:5]
        assert np.linalg.matrix_rank(torques, tol=1e-6) == 2


def test_an_error_of_rates_needs_one_frame() -> None:
    """ω_d − ω is not zero for a body that turns as asked but is turned itself; RᵀR_d ω_d − ω is."""
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    desired = np.array([1.0, 0.0, 0.0])  # in the desired body frame, which is the world's here
    actual = turned.T @ desired  # the same rotation, seen from the turned body
    assert np.linalg.norm(desired - actual) > 1.0
    assert np.linalg.norm(turned.T @ desired - actual) == 0.0


def test_its_joules_are_hertz_cubed() -> None:
    """45 s of level hover at 60° cost 14.2 kJ; as the paper counts them 2257, near its Case A."""
    power = om.analysis.hover(VEHICLE, math.radians(60.0))
    assert 45.0 * power.power == pytest.approx(14179.0, abs=1.0)
    assert 45.0 * power.power_paper == pytest.approx(2256.7, abs=0.1)
    assert power.power / power.power_paper == pytest.approx(2.0 * math.pi, rel=1e-14)


def test_at_30_degrees_its_mechanism_does_not_pay() -> None:
    share = om.analysis.mechanism_share(VEHICLE)
    assert share is not None
    break_even = np.asarray(om.analysis.mass_break_even(np.radians([30.0, 37.0])))
    assert break_even[0] < share < break_even[1]
    assert np.round(100.0 * break_even, 2).tolist() == [15.47, 25.21]


def test_its_37_degrees_leave_the_moments_free() -> None:
    low = [
        math.degrees(om.analysis.omnidirectional_range(VEHICLE, zero_moment=zero)[0, 0])
        for zero in (False, True)
    ]
    assert np.round(low, 2).tolist() == [37.0, 38.18]


def test_the_page_names_tests_that_exist() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE.read_text(encoding="utf-8"))
    assert len(named) >= 15
    for file, test in named:
        text = (PAGE.parents[1] / file).read_text(encoding="utf-8")
        assert f"def {test}(" in text, f"{file}::{test}"
