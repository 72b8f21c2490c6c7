"""What a vehicle is: checked records (`vehicle`) and the TOML files they come from (`files`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from omnimorph.design.files import list_vehicles, load_vehicle, parse_vehicle, vehicle_text
    from omnimorph.design.vehicle import Source, Vehicle

__all__ = [
    "Source",
    "Vehicle",
    "list_vehicles",
    "load_vehicle",
    "parse_vehicle",
    "vehicle_text",
]

_HOME = {
    "Source": "vehicle",
    "Vehicle": "vehicle",
    "list_vehicles": "files",
    "load_vehicle": "files",
    "parse_vehicle": "files",
    "vehicle_text": "files",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
