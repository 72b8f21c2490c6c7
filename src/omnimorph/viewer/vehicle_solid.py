"""A vehicle in the scene: frame, rotors that tilt and spin, colours and arrows of their thrusts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.geometry import propeller_radius, thrust_axes
from omnimorph.protocols import FloatArray
from omnimorph.viewer import colours
from omnimorph.viewer.shapes import blades, disc, frame_of, ring, turned_to, wxyz_of

_ARROW_OF_WEIGHT = 1.5  # propeller radii: how long an arrow of the weight's share of a rotor is


class VehicleSolid:
    """A vehicle built from its geometry, to be moved, tilted and coloured.

    Discs and arrows are blue for thrust along the rotor's axis, vermillion for reversed thrust; a
    rotor whose thrust is at its limit has a purple rim.

    Parameters
    ----------
    server : viser.ViserServer
        Whose scene it enters.
    name : str
        Its node, such as ``/first``.
    vehicle : Vehicle
        Any.
    scale : float
        Units of the scene in a metre.
    """

    def __init__(self, server: Any, name: str, vehicle: Vehicle, scale: float = 1.0) -> None:
        self.vehicle, self._name, self._scene = vehicle, name, server.scene
        self._radius = scale * propeller_radius(vehicle)
        self._hubs = scale * vehicle.rotor_position
        self._arrows_shown = True
        self.root = self._scene.add_frame(name, show_axes=False)
        frame = frame_of(vehicle)
        self._scene.add_mesh_simple(
            f"{name}/frame", scale * frame.vertices, frame.faces, color=colours.INK
        )
        n = vehicle.n_rotors
        level = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
        rim = ring(self._radius, 1.07 * self._radius, 0.05 * self._radius)
        self._rims = self._batch("rims", rim, level)
        self._rims.batched_colors = colours.of_instances(colours.PURPLE, n)
        self._discs = self._batch("discs", disc(self._radius, 0.02 * self._radius), level, 0.7)
        self._blades = self._batch("blades", blades(self._radius), level)
        self._blades.batched_colors = colours.of_instances(colours.INK, n)
        self._arrows: Any = None

    def place(self, p_WB: FloatArray, wxyz: FloatArray) -> None:
        """Move it to a pose."""
        self.root.position, self.root.wxyz = p_WB, wxyz

    def remove(self) -> None:
        """Take it off the scene."""
        self.root.remove()

    def show(
        self, tilt: FloatArray, thrust: FloatArray, turns: FloatArray, active: FloatArray
    ) -> None:
        """Tilt its rotors, turn its blades, and show the thrusts.

        Parameters
        ----------
        tilt : (m,) array, rad
            Of each servo.
        thrust : (n,) array, N
            Of each rotor, signed.
        turns : (n,) array, rad
            How far the blades have turned about the thrust axes.
        active : (n,) array
            Not 0 where the thrust is at a limit.
        """
        axes = thrust_axes(self.vehicle, tilt)
        R = np.array([turned_to(axis) for axis in axes])
        level = wxyz_of(R)
        self._discs.batched_wxyzs = self._rims.batched_wxyzs = level
        self._blades.batched_wxyzs = wxyz_of(R @ _about_z(turns))
        limit = np.where(thrust >= 0.0, self.vehicle.thrust_max, -self.vehicle.thrust_min)
        share = np.divide(thrust, limit, out=np.zeros_like(thrust), where=limit > 0.0)
        self._discs.batched_colors = colours.of_instances(colours.of_thrust(share))
        self._rims.batched_scales = np.where(active != 0, 1.0, 1e-3)
        self._show_arrows(axes, thrust)

    @property
    def arrows_are_shown(self) -> bool:
        """Whether thrusts have arrows."""
        return self._arrows_shown

    @arrows_are_shown.setter
    def arrows_are_shown(self, shown: bool) -> None:
        self._arrows_shown = shown
        if self._arrows is not None:
            self._arrows.visible = shown

    def _batch(self, what: str, mesh: Any, level: FloatArray, opacity: float | None = None) -> Any:
        return self._scene.add_batched_meshes_simple(
            f"{self._name}/{what}",
            mesh.vertices,
            mesh.faces,
            batched_wxyzs=level,
            batched_positions=self._hubs,
            batched_scales=np.ones(len(level)),
            batched_colors=colours.of_instances(colours.GREY, len(level)),
            opacity=opacity,
            lod="off",
            cast_shadow=opacity is None,
            side="double" if opacity is not None else "front",
        )

    def _show_arrows(self, axes: FloatArray, thrust: FloatArray) -> None:
        usual = self.vehicle.mass * GRAVITY / self.vehicle.n_rotors
        length = _ARROW_OF_WEIGHT * self._radius * thrust / usual
        points = np.stack([self._hubs, self._hubs + length[:, None] * axes], axis=1)
        reversed_ = (thrust < 0.0)[:, None]
        shades = np.where(reversed_, np.array(colours.VERMILLION), np.array(colours.BLUE))
        self._arrows = drawn_arrows(
            self._scene,
            self._arrows,
            f"{self._name}/thrusts",
            points,
            shades,
            self._radius,
            self._arrows_shown,
        )


class Ghost:
    """Where the vehicle should be: its frame and discs, translucent."""

    def __init__(self, server: Any, name: str, vehicle: Vehicle, tilt: FloatArray) -> None:
        self.root = server.scene.add_frame(name, show_axes=False)
        radius = propeller_radius(vehicle)
        shade = {"color": colours.GREEN, "opacity": 0.3, "cast_shadow": False}
        frame = frame_of(vehicle)
        server.scene.add_mesh_simple(f"{name}/frame", frame.vertices, frame.faces, **shade)
        mesh = disc(radius, 0.02 * radius)
        level = wxyz_of(np.array([turned_to(axis) for axis in thrust_axes(vehicle, tilt)]))
        server.scene.add_batched_meshes_simple(
            f"{name}/discs",
            mesh.vertices,
            mesh.faces,
            batched_wxyzs=level,
            batched_positions=vehicle.rotor_position,
            batched_colors=colours.of_instances(colours.GREEN, len(level)),
            opacity=0.2,
            lod="off",
            cast_shadow=False,
        )

    def place(self, p_WB: FloatArray, wxyz: FloatArray) -> None:
        """Move it to a pose."""
        self.root.position, self.root.wxyz = p_WB, wxyz


def drawn_arrows(
    scene: Any,
    before: Any,
    name: str,
    points: FloatArray,
    shades: ArrayLike,
    radius: float,
    visible: bool = True,
) -> Any:
    """Draw arrows, or move those drawn before; return them.

    Parameters
    ----------
    points : (K, 2, 3) array, m
        Begin and tip of each.
    shades : (K, 3) array
        Their colours.
    radius : float
        Of a propeller, m: how thick they are.
    """
    if before is None:
        return scene.add_arrows(
            name,
            points.astype(np.float32),
            colours.of_instances(shades),
            shaft_radius=0.05 * radius,
            head_radius=0.14 * radius,
            head_length=0.28 * radius,
            visible=visible,
        )
    before.points, before.colors = points.astype(np.float32), colours.of_instances(shades)
    return before


def reach_of(vehicle: Vehicle) -> float:
    """Return the radius of a sphere about the centre of mass that holds the vehicle, m."""
    hubs = np.linalg.norm(vehicle.rotor_position, axis=1)
    return float(hubs.max()) + propeller_radius(vehicle)


def _about_z(angle: FloatArray) -> FloatArray:
    """Return rotations about z, (n, 3, 3)."""
    c, s, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, zero + 1.0]]
    return np.moveaxis(np.array(rows), -1, 0)
