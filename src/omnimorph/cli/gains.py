"""Propose gains and weights for a vehicle, with the margins of its loops and what decided them."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import add_vehicle, milliseconds

if TYPE_CHECKING:
    from omnimorph import ProposedController, StabilityMargins, Vehicle

SUMMARY = "propose gains and weights for a vehicle, with stability margins"
NEEDS = ("omnimorph.control.gains",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    add_vehicle(parser)
    parser.add_argument(
        "--period-ms",
        type=milliseconds("--period-ms", 1e-6, 1e4),
        default=0.004,
        metavar="MS",
        help="time between two commands (default: 4)",
    )
    parser.add_argument(
        "--delay-ms",
        type=milliseconds("--delay-ms", 0.0, 1e6),
        default=0.0,
        metavar="MS",
        help="delay anywhere in the loop (default: 0)",
    )


def answer(options: argparse.Namespace) -> console.Answer:
    """Propose, and show the margins."""
    import omnimorph as om

    vehicle = om.load_vehicle(options.vehicle)
    times = (options.period_ms, options.delay_ms)
    proposal = om.propose_controller(vehicle, *times)
    margins = om.stability_margins(proposal.gains, vehicle, *times)
    period, delay = (f"{1e3 * time:g} ms" for time in times)
    sections = [
        f"{vehicle.name}: {vehicle.title}".rstrip(": "),
        f"Proposed for a control period of {period} and a delay of {delay}.",
        _margins(margins),
        "\n".join(proposal.reasons),
        "In a scenario file `proposed = true` in [controller] stands for all of this:",
        _as_toml(proposal),
    ]
    return console.Answer("\n\n".join(sections), _as_data(vehicle, times, proposal, margins))


def _columns(margins: StabilityMargins) -> dict[str, list[float]]:
    """Return the columns of the table, in units that people read."""
    return {
        "crossover_rad_per_s": margins.crossover.tolist(),
        "phase_margin_deg": [math.degrees(one) for one in margins.phase_margin],
        "gain_margin": margins.gain_margin.tolist(),
        "delay_margin_ms": (1e3 * margins.delay_margin).tolist(),
    }


def _margins(margins: StabilityMargins) -> str:
    from omnimorph.control.margins import AXES

    columns = _columns(margins)
    numbers = [[console.number(one, 4) for one in column] for column in columns.values()]
    rows = list(zip(AXES, *numbers, strict=True))
    return console.table(rows, header=["axis", *columns], align="lrrr")


def _as_toml(proposal: ProposedController) -> str:
    """Return the controller's tables as a scenario file would hold them."""
    lines = ["[controller]"]
    for part in (proposal.gains, proposal.allocator):
        if part is proposal.allocator:
            lines += ["", "[controller.allocator]", f'kind = "{part.kind}"']
        content = {key: value for key, value in part.as_file().items() if key != "kind"}
        lines += [f"{key} = {_shown(value)}" for key, value in content.items()]
    return "\n".join(lines)


def _shown(value: float | tuple[float, ...]) -> str:
    """Return a number, or a list of them, as TOML, to six digits."""
    if isinstance(value, tuple):
        return f"[{', '.join(_shown(one) for one in value)}]"
    text = f"{value:.6g}"
    return text if {".", "e"} & set(text) else f"{text}.0"


def _as_data(
    vehicle: Vehicle,
    times: tuple[float, float],
    proposal: ProposedController,
    margins: StabilityMargins,
) -> dict[str, Any]:
    from omnimorph.control.margins import AXES

    gains = proposal.gains.as_file()
    return {
        "vehicle": vehicle.name,
        "title": vehicle.title,
        "control_period_ms": 1e3 * times[0],
        "delay_ms": 1e3 * times[1],
        "controller": {key: value for key, value in gains.items() if key != "kind"}
        | {"allocator": proposal.allocator.as_file()},
        "margins": {"axis": list(AXES)} | _columns(margins),
        "reasons": list(proposal.reasons),
    }
