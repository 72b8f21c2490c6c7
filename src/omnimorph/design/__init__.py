"""What a vehicle is: checked records (`vehicle`) and the TOML files they come from (`files`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from omnimorph.design.files import list_vehicles, load_vehicle, parse_vehicle, vehicle_text
    from omnimorph.design.vehicle import Source, Vehicle

__all__ = ["Source", "Vehicle", "list_vehicles", "load_vehicle", "parse_vehicle", "vehicle_text"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from omnimorph.design import files, vehicle

    return getattr(vehicle if name in vehicle.__all__ else files, name)


def __dir__() -> list[str]:
    return sorted(__all__)
