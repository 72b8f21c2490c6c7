"""The design explorer: sliders morph a vehicle and what it can make, with the numbers beside."""

from __future__ import annotations

import html
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from omnimorph.design.files import list_vehicles, load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.design.writing import vehicle_text
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray
from omnimorph.results.atomic import write_text
from omnimorph.viewer import colours
from omnimorph.viewer.design import Design, View, is_cube, scales_of
from omnimorph.viewer.design_scene import DesignScene, power_range
from omnimorph.viewer.tables import Row, number_table, shown_number

_WIDTH_OF_LEGEND = 5  # colours in the legend of the sphere
_MOST_SAVED = 100  # files: a page that is steered by a program shall not fill the disk


class ExplorerPage:
    """A server's page on which a vehicle is explored.

    Parameters
    ----------
    server : viser.ViserServer
        Whose page it becomes.
    vehicle : Vehicle
        What is explored at first; the catalogue is there to choose from.
    tilt : (m,) array, rad, optional
        At first; see `Design.of` for the default.
    out : Path, optional
        The only folder into which designs are saved; without it they are only downloaded.
    """

    def __init__(
        self, server: Any, vehicle: Vehicle, tilt: FloatArray | None = None, out: Path | None = None
    ) -> None:
        self._server, self._out = server, out
        self._lock = threading.RLock()
        self._own = vehicle
        self._n_saved = 0
        self.design = Design.of(vehicle, tilt)
        scales, view, gui = scales_of(vehicle), self.design.view(), server.gui
        names = list_vehicles()
        choice = tuple(names if vehicle.name in names else [vehicle.name, *names])
        gui.set_panel_label("Design explorer")
        self._choice = gui.add_dropdown("vehicle", choice, initial_value=vehicle.name)
        self._choice.on_update(self._when_moved(self._change_vehicle))
        self._sliders = self._add_sliders()
        self._numbers = gui.add_html("")
        self._legend = gui.add_html("")
        self._save = gui.add_button("Save as TOML", hint=_hint(out))
        self._save.on_click(self._save_design)
        self._saved = gui.add_html("")
        gui.main_panel.dock_right()
        self._write(view)
        self.scene = DesignScene(server, view, scales)  # last: what can be read is there before it

    def change(self, **sliders: Any) -> View:
        """Show the design with other sliders (see `Design`); return what is shown."""
        with self._lock:
            self.design = self.design.changed(**sliders)
            view = self.design.view()
            with self._server.atomic():  # all of it in the same picture
                self._write(view)
                self.scene.show(view)
            return view

    def _add_sliders(self) -> Any:
        gui, base = self._server.gui, self.design.base
        folder = gui.add_folder("Design", order=self._choice.order + 0.5)
        with folder:
            tilts = [self._tilt_slider(j) for j in range(base.n_servos)]
            heavy = self._slider("mass, kg", base.mass)
            fastest = float(base.speed_max.max()) / (2.0 * np.pi)
            speed = self._slider("largest rotor speed, Hz", fastest)
            length, word = _size_of(base)
            size = self._slider(word, length)
            moments = gui.add_dropdown("force set", ("at zero moment", "moments free"))
        moved = self._when_moved
        for slider in tilts:
            slider.on_update(moved(lambda: self.change(tilt=self._angles(tilts))))
        heavy.on_update(moved(lambda: self.change(mass=float(heavy.value))))
        speed.on_update(moved(lambda: self.change(speed=float(speed.value) / fastest)))
        size.on_update(moved(lambda: self.change(size=float(size.value) / length)))
        moments.on_update(moved(lambda: self.change(zero_moment=moments.value == "at zero moment")))
        return folder

    def _slider(self, word: str, now: float) -> Any:
        """Add a slider from a third to three times what the file has."""
        low, high, step = (float(f"{share * now:.1g}") for share in (0.3, 3.0, 0.005))
        return self._server.gui.add_slider(word, low, high, step, now)

    def _tilt_slider(self, j: int) -> Any:
        base = self.design.base
        low, high, now = (
            round(float(np.degrees(angles[j])), 1)
            for angles in (base.servo_angle_min, base.servo_angle_max, self.design.tilt)
        )
        word = "tilt, °" if base.n_servos == 1 else f"{base.servo_name[j]}, °"
        now = min(max(now, low), high)
        return self._server.gui.add_slider(word, low, high, 0.1, now)

    def _angles(self, sliders: list[Any]) -> FloatArray:
        base = self.design.base
        tilt = np.radians([float(slider.value) for slider in sliders])
        return tilt.clip(base.servo_angle_min, base.servo_angle_max)

    def _when_moved(self, action: Callable[[], object]) -> Callable[[Any], None]:
        """Return a callback that acts on what someone moved, and says why where it cannot."""

        def moved(event: Any) -> None:
            self._saved.content = ""
            try:
                action()
            except InputError as mistake:
                self._saved.content = _sentence("notice", str(mistake))

        return moved

    def _change_vehicle(self) -> None:
        name = self._choice.value
        vehicle = self._own if name == self._own.name else load_vehicle(name)
        scales = scales_of(vehicle)
        with self._lock:
            self._sliders.remove()
            self.scene.remove()
            self.design = Design.of(vehicle)
            view = self.design.view()
            self.scene = DesignScene(self._server, view, scales)
            self._sliders = self._add_sliders()
            self._write(view)

    def _write(self, view: View) -> None:
        self._numbers.content = number_table(numbers_of(view))
        least, most = power_range(view.power)
        self._legend.content = _legend(least, most, bool(np.isinf(view.power).any()))

    def _save_design(self, event: Any) -> None:
        with self._lock:
            name = f"{self.design.base.name}-design"
            vehicle = self.design.vehicle().replace(name=name)
        text = vehicle_text(vehicle)
        if event.client is not None:
            event.client.send_file_download(f"{name}.toml", text.encode(), save_immediately=True)
        if self._out is None:
            return
        try:
            path = self._keep(self._out, name, text)
        except (InputError, OSError) as problem:
            self._saved.content = _sentence("notice", str(problem))
        else:
            self._saved.content = _sentence("saved", f"Saved as {path}.")

    def _keep(self, folder: Path, name: str, text: str) -> Path:
        """Write a design into a folder, beside those that are there; return its file."""
        with self._lock:  # who saves at the same time takes the next name
            if self._n_saved == _MOST_SAVED:
                raise InputError(
                    f"this page has saved {_MOST_SAVED} designs, which is the most that it may; "
                    "open it again to save more."
                )
            path = _free_name(folder, name)
            folder.mkdir(parents=True, exist_ok=True)
            write_text(path, text)
            self._n_saved += 1
        return path


def numbers_of(view: View) -> list[Row]:
    """Return the numbers beside the picture: key, label, unit, value."""
    forces = 0.0 if view.sphere is None else view.sphere.radius
    return [
        *_class_rows(view),
        Row("rank", "rank of A", "", [str(view.actuation.rank_thrust)]),
        Row("weight", "weight", "N", [shown_number(view.weight)]),
        Row("force-radius", "inscribed sphere of forces, radius", "N", [shown_number(forces)]),
        Row("weakest", "weakest direction", "", [_direction(view)]),
        Row("lift", "largest force upwards", "N", [_lift(view)]),
        Row(
            "moment-radius",
            "inscribed sphere of moments, radius",
            "N m",
            [shown_number(view.moments.inscribed_radius)],
        ),
        Row("hover-power", "power to hover level", "W", [shown_number(view.level.power)]),
        Row("hovers", "attitudes it can hover in", "", [view.attitudes.words]),
    ]


def _class_rows(view: View) -> list[Row]:
    """Return the class; over all tilts first, where it is another question than at this one."""
    found, at_tilt = view.platform, str(view.actuation.vehicle_class)
    if not found.n_servos:
        return [Row("kind", "class", "", [at_tilt])]
    if not found.has_free_tilts:
        over_all = Row("class", "class over its tilts", "", [str(found.vehicle_class)])
        return [over_all, Row("kind", "class at this tilt", "", [at_tilt])]
    radius, lateral = found.radius_over_weight, found.lateral_over_weight
    return [
        Row("class", "class, each servo at its own tilt", "", [str(found.vehicle_class)]),
        Row("free-radius", "radius over weight, likewise", "", [shown_number(radius, 3)]),
        Row("free-lateral", "sideways over weight, likewise", "", [shown_number(lateral, 3)]),
        Row("kind", "class at the tilts set, as all below", "", [at_tilt]),
    ]


def _direction(view: View) -> str:
    if view.sphere is None or view.sphere.radius == 0.0:
        return "—"
    direction = ", ".join(f"{coordinate:.2f}" for coordinate in view.sphere.direction)
    touched = int((view.forces.offsets <= view.sphere.radius * (1.0 + 1e-9)).sum())
    return direction if touched == 1 else f"{direction}; one of {touched}"


def _lift(view: View) -> str:
    up = np.array([0.0, 0.0, 1.0])
    return "—" if view.forces.is_empty else shown_number(max(view.forces.reach(up), 0.0))


def _legend(least: float, most: float, some_cannot: bool) -> str:
    """Return the colours of the sphere of hover power with their numbers."""
    shares = np.linspace(0.0, 1.0, _WIDTH_OF_LEGEND)
    stops = ", ".join(colours.css(colour) for colour in colours.of_power(shares))
    bar = f"height:10px;border-radius:3px;background:linear-gradient(to right, {stops})"
    ends = (
        f'<div style="display:flex;justify-content:space-between"><span>{shown_number(least)} W'
        f"</span><span>hover power by attitude</span><span>{shown_number(most)} W</span></div>"
    )
    grey = "<div>grey: it cannot hover there</div>" if some_cannot else ""
    if most == 0.0:
        ends, grey = "", "<div>it hovers in no attitude</div>"
    return (
        '<div style="padding:6px 12px;font-size:0.75rem;color:#555">'
        f'<div style="{bar}"></div>{ends}{grey}</div>'
    )


def _size_of(vehicle: Vehicle) -> tuple[float, str]:
    """Return how large a vehicle is, mm, and what that length is called."""
    if is_cube(vehicle):
        return 1e3 * float(abs(vehicle.rotor_position[0, 0])), "half-edge, mm"
    return 1e3 * float(np.linalg.norm(vehicle.rotor_position, axis=1).max()), "longest arm, mm"


def _free_name(folder: Path, name: str) -> Path:
    """Return a file of the folder that is not there yet."""
    path, number = folder / f"{name}.toml", 1
    while path.exists():
        number += 1
        path = folder / f"{name}-{number}.toml"
    return path


def _hint(out: Path | None) -> str:
    return f"into {out}, and as a download" if out else "as a download; --out DIR also keeps it"


def _sentence(key: str, text: str) -> str:
    return f'<div id="{key}" style="padding:2px 12px;font-size:0.8rem">{html.escape(text)}</div>'
