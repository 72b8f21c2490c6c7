"""A flight in the scene: vehicle, ghost of the desired pose, trail, ground, what is not made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.viewer import colours
from omnimorph.viewer.frames import Frame
from omnimorph.viewer.shapes import disc
from omnimorph.viewer.vehicle_solid import Ghost, VehicleSolid, drawn_arrows, reach_of

FIELD_OF_VIEW = float(np.radians(50.0))
"""Of the camera, from top to bottom, rad."""
MISSED = 0.2
"""Shown as missed is a force of more than this share of the weight."""

_UPRIGHT = 0.9  # aspect below which a view is upright
_TRAIL_POINTS = 60
_LINE = 3.0  # pixels


class Actor:
    """One vehicle that flies in the scene.

    Parameters
    ----------
    server : viser.ViserServer
        Whose scene.
    name : str
        Of its node, such as ``/first``.
    vehicle : Vehicle
        What flies.
    beside : (3,) array, m
        Where its world stands in the scene; two runs stand side by side.
    ground : float, m
        Height of the ground, on which a dark disc shows what it is above.
    path : (K, 3) array, m, optional
        The whole path, drawn thinly.
    label : str
        What hangs above it; nothing by default.
    """

    def __init__(
        self,
        server: Any,
        name: str,
        vehicle: Vehicle,
        beside: FloatArray,
        ground: float,
        path: FloatArray | None = None,
        label: str = "",
    ) -> None:
        self.vehicle = vehicle
        self._scene, self._name, self._reach = server.scene, name, reach_of(vehicle)
        self.beside = np.asarray(beside, dtype=np.float64)
        self._scene.add_frame(name, show_axes=False, position=self.beside)
        self.solid = VehicleSolid(server, f"{name}/vehicle", vehicle)
        self.ghost = Ghost(server, f"{name}/ghost", vehicle, vehicle_tilt_at_rest(vehicle))
        self.ghost_shown = True
        self._ground = ground + 2e-3
        spot = disc(0.9 * self._reach, 1e-3)
        self._spot = self._scene.add_mesh_simple(
            f"{name}/spot", spot.vertices, spot.faces, color=colours.INK, opacity=0.16
        )
        self._missed: Any = None
        self._trail: Any = None
        self._past: list[FloatArray] = []
        if path is not None and len(path) > 1:
            self._line(f"{name}/path", path, colours.GREY, 0.5 * _LINE)
        self._label = None
        if label:
            self._label = self._scene.add_label(
                f"{name}/label",
                label,
                anchor="bottom-center",
                font_size_mode="scene",
                font_scene_height=0.2 * self._reach,
            )

    def show(self, frame: Frame, trail: FloatArray | None = None) -> None:
        """Show a moment.

        Parameters
        ----------
        frame : Frame
            Of this vehicle.
        trail : (K, 3) array, m, optional
            The path it flew; by default the poses shown before.
        """
        self.solid.place(frame.p_WB, frame.wxyz)
        self.solid.show(frame.tilt, np.nan_to_num(frame.thrust), frame.turns, frame.active)
        self.ghost.place(frame.desired_p_WB, frame.desired_wxyz)
        self.ghost.root.visible = self.ghost_shown and self._is_apart(frame)
        self._spot.position = np.array([frame.p_WB[0], frame.p_WB[1], self._ground])
        if self._label is not None:
            self._label.position = frame.p_WB + np.array([0.0, 0.0, 1.3 * self._reach])
        self._show_missed(frame)
        self._show_trail(self._recent(frame) if trail is None else trail)

    def _is_apart(self, frame: Frame) -> bool:
        """Return whether the desired pose can be distinguished from the actual one."""
        distance = 1e-3 * frame.position_error_mm
        return distance > 0.01 * self._reach or frame.attitude_error_deg > 1.0

    def middle(self, frame: Frame) -> FloatArray:
        """Return where the vehicle is in the scene, (3,) m."""
        return self.beside + frame.p_WB

    def show_trail(self, shown: bool) -> None:
        """Show the trail, or hide it."""
        if self._trail is not None:
            self._trail.visible = shown

    def _recent(self, frame: Frame) -> FloatArray:
        self._past = [*self._past[-_TRAIL_POINTS:], frame.p_WB]
        return np.array(self._past)

    def _show_missed(self, frame: Frame) -> None:
        weight = self.vehicle.mass * GRAVITY
        share = float(np.linalg.norm(frame.missed_W)) / weight
        shown = share > MISSED  # never, if no wrench was asked for
        tip = frame.p_WB + 2.0 * self._reach * frame.missed_W / weight
        points = np.array([[frame.p_WB, tip if shown else frame.p_WB + 1e-3]])
        shade = [colours.ORANGE]
        name, thick = f"{self._name}/missed", 0.5 * self._reach
        self._missed = drawn_arrows(self._scene, self._missed, name, points, shade, thick, shown)
        self._missed.visible = shown

    def _show_trail(self, path: FloatArray) -> None:
        if len(path) < 2:
            path = np.repeat(path[:1], 2, axis=0)
        segments = np.stack([path[:-1], path[1:]], axis=1).astype(np.float32)
        if self._trail is None:
            self._trail = self._line(f"{self._name}/trail", path, colours.BLUE, _LINE)
        self._trail.points = segments

    def _line(self, name: str, path: FloatArray, colour: Any, thickness: float) -> Any:
        segments = np.stack([path[:-1], path[1:]], axis=1).astype(np.float32)
        return self._scene.add_line_segments(
            name, segments, colors=colour, thickness=thickness, thickness_units="screen"
        )


def vehicle_tilt_at_rest(vehicle: Vehicle) -> FloatArray:
    """Return the tilt nearest to zero that each servo reaches, (m,) rad."""
    at_rest: FloatArray = np.clip(0.0, vehicle.servo_angle_min, vehicle.servo_angle_max)
    return at_rest


def set_stage(
    server: Any, paths: Sequence[FloatArray], reach: float
) -> tuple[float, tuple[FloatArray, FloatArray]]:
    """Add the ground below some flights, and place the camera so that all of them are seen.

    Parameters
    ----------
    server : viser.ViserServer
        Whose scene.
    paths : sequence of (K, 3) arrays, m
        Where the vehicles come, in the scene.
    reach : float, m
        Of the largest vehicle, see `reach_of`.

    Returns
    -------
    ground : float, m
        Its height: zero, or lower if a flight goes deeper.
    camera : two (3,) arrays, m
        Where it stands, and where it looks.
    """
    low = np.min([path.min(axis=0) for path in paths], axis=0)
    high = np.max([path.max(axis=0) for path in paths], axis=0)
    ground = min(0.0, float(low[2]) - 1.5 * reach)
    _add_ground(server, ground)
    across = 0.5 * float(np.linalg.norm(high - low)) + reach
    camera = camera_for(0.5 * (low + high), across if len(paths) == 1 else 1.2 * across)
    place_camera(server, *camera)
    return ground, camera


def place_camera(server: Any, position: FloatArray, look_at: FloatArray) -> None:
    """Let everyone who opens the page look from there at first."""
    camera = server.initial_camera
    camera.position, camera.look_at, camera.fov = position, look_at, FIELD_OF_VIEW

    @server.on_client_connect  # type: ignore[untyped-decorator]
    def step_back(client: Any) -> None:
        """On a phone held upright the width counts, and the controls hide the lower half."""
        aspect = float(client.camera.aspect)
        if aspect < _UPRIGHT:
            away = _UPRIGHT / aspect * (position - look_at)
            height = 2.0 * float(np.linalg.norm(away)) * np.tan(0.5 * FIELD_OF_VIEW)
            below = look_at - np.array([0.0, 0.0, 0.25 * height])
            client.camera.position = below + away
            client.camera.look_at = below


def _add_ground(server: Any, height: float = 0.0) -> None:
    """Add the ground, z = `height` in m: a grid of half metres."""
    server.scene.set_up_direction("+z")
    server.scene.configure_default_lights(cast_shadow=False)  # a third of the time of a picture
    server.scene.add_grid(
        "/ground",
        infinite_grid=True,
        cell_size=0.5,
        section_size=1.0,
        cell_color=(222, 225, 230),
        section_color=(200, 204, 210),
        plane_color=(247, 248, 250),
        plane_opacity=1.0,
        fade_distance=14.0,
        position=(0.0, 0.0, height),
    )


def camera_for(middle: FloatArray, reach: float) -> tuple[FloatArray, FloatArray]:
    """Return from where to look at a sphere that shall fill the view, and where to: (3,) m each."""
    towards = np.array([0.4, -1.0, 0.4])
    away = 1.2 * reach / np.sin(0.5 * FIELD_OF_VIEW)
    return middle + away * towards / np.linalg.norm(towards), middle
