"""A design in the scene: the vehicle, its forces, its moments, and where it can hover."""

from __future__ import annotations

from typing import Any

import numpy as np

from omnimorph.analysis.polytope import Polytope
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.viewer import colours
from omnimorph.viewer.design import ATTITUDES, Scales, View
from omnimorph.viewer.shapes import polytope_mesh, sphere, tile, turned_to, wxyz_of
from omnimorph.viewer.stage import place_camera
from omnimorph.viewer.tables import shown_number
from omnimorph.viewer.vehicle_solid import VehicleSolid, drawn_arrows

_APART = 1.35  # half the distance of the four pictures; each is about one unit in radius
_VEHICLE, _FORCES = np.array([-_APART, 0.0, _APART]), np.array([_APART, 0.0, _APART])
_MOMENTS, _HOVER = np.array([-_APART, 0.0, -_APART]), np.array([_APART, 0.0, -_APART])
_HOVER_RADIUS = 0.9
_WORDS = np.array([0.0, 0.0, 1.22])


class DesignScene:
    """Four pictures that stand side by side and change together.

    Top left the vehicle hovering level, top right its forces with the weight sphere and the
    inscribed sphere, bottom left its moments, bottom right the hover power by attitude: a point
    of that sphere is the vertical seen from the body.

    Parameters
    ----------
    server : viser.ViserServer
        Whose scene.
    view : View
        What is shown at first.
    scales : Scales
        What is drawn one unit long.
    """

    def __init__(self, server: Any, view: View, scales: Scales) -> None:
        self._server, self._scene, self._scales = server, server.scene, scales
        server.scene.set_up_direction("+z")
        _light_evenly(server.scene)
        position, look_at = np.array([1.2, -6.6, 1.0]), np.array([0.0, 0.0, 0.1])
        self.camera = position, look_at
        place_camera(server, *self.camera)
        self._captions = [
            self._scene.add_label(
                f"/caption{k}",
                "",
                position=place + _WORDS,
                anchor="center-center",
                font_size_mode="scene",
                font_scene_height=0.13,
            )
            for k, place in enumerate((_VEHICLE, _FORCES, _MOMENTS, _HOVER))
        ]
        self._solid = self._built(view.vehicle)
        self._forces = _Solid(self._scene, "/forces", _FORCES, colours.SKY)
        self._moments = _Solid(self._scene, "/moments", _MOMENTS, colours.PURPLE)
        self._weight = self._sphere("/weight", colours.ORANGE, 0.4)
        self._inside = self._sphere("/inscribed", colours.GREEN, 0.45)
        self._witness: Any = None
        self._tiles = self._sphere_of_tiles()
        for name, place in (("/axes-forces", _FORCES), ("/axes-moments", _MOMENTS)):
            self._scene.add_frame(name, position=place, axes_length=0.45, axes_radius=0.008)
        self._scene.add_frame("/axes-hover", position=_HOVER, axes_length=1.25, axes_radius=0.008)
        self.show(view)

    def show(self, view: View) -> None:
        """Show another design, or the same at another tilt."""
        with self._server.atomic():
            self._show_vehicle(view)
            self._forces.show(view.forces, self._scales.force)
            self._moments.show(view.moments, self._scales.moment)
            self._show_spheres(view)
            self._show_power(view)
            self._write_captions(view)

    def remove(self) -> None:
        """Take it off the scene, for another vehicle to take its place."""
        self._scene.reset()

    def _show_vehicle(self, view: View) -> None:
        vehicle, level, before = view.vehicle, view.level, self._solid.vehicle
        limits = (vehicle.thrust_min, vehicle.thrust_max)
        at_limit = np.any([np.isclose(level.thrust, limit) for limit in limits], axis=0)
        active = (at_limit & level.feasible).astype(np.float64)
        if not np.array_equal(before.rotor_position, vehicle.rotor_position):
            self._solid.remove()
            self._solid = self._built(vehicle)
        self._solid.vehicle = vehicle
        self._solid.show(view.tilt, level.thrust, np.zeros(vehicle.n_rotors), active)

    def _built(self, vehicle: Vehicle) -> VehicleSolid:
        solid = VehicleSolid(self._server, "/vehicle", vehicle, 0.72 / self._scales.length)
        solid.root.position = _VEHICLE
        return solid

    def _show_spheres(self, view: View) -> None:
        self._weight.scale = view.weight / self._scales.force
        radius = 0.0 if view.sphere is None else view.sphere.radius / self._scales.force
        self._inside.visible = radius > 0.0
        self._inside.scale = max(radius, 1e-6)
        tip = np.zeros(3) if view.sphere is None else radius * view.sphere.direction
        points = np.array([[_FORCES, _FORCES + tip + (1e-6, 0.0, 0.0)]])
        shade = [colours.VERMILLION]
        self._witness = drawn_arrows(self._scene, self._witness, "/witness", points, shade, 0.35)
        self._witness.visible = radius > 0.0

    def _show_power(self, view: View) -> None:
        least, most = power_range(view.power)
        span = most - least if most > least else 1.0
        shades = colours.of_power((view.power - least) / span)
        self._tiles.batched_colors = colours.of_instances(shades)

    def _write_captions(self, view: View) -> None:
        angles = [f"{angle:.1f}°" for angle in sorted(np.degrees(view.tilt))]
        tilt = " to ".join(dict.fromkeys([*angles[:1], *angles[-1:]]))  # of several, the range
        radius = 0.0 if view.sphere is None else view.sphere.radius
        texts = [
            f"{view.vehicle.name}, tilt {tilt}" if tilt else view.vehicle.name,
            f"forces: inscribed sphere {shown_number(radius)} N",
            f"moments: inscribed sphere {shown_number(view.moments.inscribed_radius)} N m",
            "hover power by attitude",
        ]
        for caption, text in zip(self._captions, texts, strict=True):
            caption.text = text

    def _sphere(self, name: str, colour: Any, opacity: float) -> Any:
        mesh = sphere(1.0, rings=20)
        return self._scene.add_mesh_simple(
            name,
            mesh.vertices,
            mesh.faces,
            color=colour,
            opacity=opacity,
            position=_FORCES,
            side="front",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _sphere_of_tiles(self) -> Any:
        inside = sphere(0.985 * _HOVER_RADIUS, _HOVER, rings=16)
        self._scene.add_mesh_simple(
            "/hover-inside",
            inside.vertices,
            inside.faces,
            color=(200, 204, 210),
            cast_shadow=False,
            receive_shadow=False,
        )
        # as large as tiles that lie side by side on a lattice can be
        mesh = tile(1.9 * _HOVER_RADIUS / np.sqrt(len(ATTITUDES)))
        return self._scene.add_batched_meshes_simple(
            "/hover",
            mesh.vertices,
            mesh.faces,
            batched_wxyzs=wxyz_of(np.array([turned_to(up) for up in ATTITUDES])),
            batched_positions=_HOVER + _HOVER_RADIUS * ATTITUDES,
            batched_colors=colours.of_instances(colours.GREY, len(ATTITUDES)),
            lod="off",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )


class _Solid:
    """A set of forces or moments: translucent faces, and its edges as lines."""

    def __init__(self, scene: Any, name: str, place: FloatArray, colour: Any) -> None:
        self._scene, self._name, self._place, self._colour = scene, name, place, colour
        self._mesh: Any = None
        self._edges: Any = None

    def show(self, polytope: Polytope, unit: float) -> None:
        """Draw the set with `unit` one long; nothing if it is empty."""
        if polytope.is_empty:
            for part in (self._mesh, self._edges):
                if part is not None:
                    part.visible = False
            return
        mesh = polytope_mesh(polytope, 0.015 * unit)
        vertices = (mesh.vertices / unit).astype(np.float32)
        edges = (_edges(polytope) / unit).astype(np.float32)
        if self._mesh is None:
            self._mesh = self._scene.add_mesh_simple(
                self._name,
                vertices,
                mesh.faces,
                color=self._colour,
                opacity=0.32,
                flat_shading=True,
                side="double",
                position=self._place,
                cast_shadow=False,
                receive_shadow=False,
            )
            self._edges = self._scene.add_line_segments(
                f"{self._name}-edges",
                edges,
                colors=tuple(int(0.6 * channel) for channel in self._colour),
                thickness=0.008,
                position=self._place,
            )
        else:
            self._mesh.vertices, self._mesh.faces = vertices, mesh.faces.astype(np.uint32)
            self._edges.points = edges
        self._mesh.visible = self._edges.visible = True


def _light_evenly(scene: Any) -> None:
    """Light so that a colour is seen as the legend has it, from whatever side."""
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient("/light/all-round", intensity=2.2)
    scene.add_light_directional("/light/from-above", intensity=0.9, position=(2.0, -4.0, 6.0))


def power_range(power: FloatArray) -> tuple[float, float]:
    """Return the least and the most of the powers that are finite; zeros if none is."""
    finite = power[np.isfinite(power)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)


def _edges(polytope: Polytope) -> FloatArray:
    """Return the edges of a set, each as two points: (E, 2, 3)."""
    corners = polytope.vertices
    if polytope.dimension < 2:
        return np.array([[corners[0], corners[-1]]])
    sides = {
        (min(a, b), max(a, b))
        for polygon in polytope.facets
        for a, b in zip(polygon.tolist(), np.roll(polygon, -1).tolist(), strict=True)
    }
    edges: FloatArray = corners[np.array(sorted(sides))]
    return edges
