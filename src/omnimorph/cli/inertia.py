"""Add up the mass, centre of mass and inertia of boxes, cylinders and point masses.

The TOML file lists them as [[part]], each with kind = "box", "cylinder" or "point", mass_kg,
position_m of its centre and, but for a point, its size and orientation_deg.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from omnimorph.cli import console

SUMMARY = "mass, centre of mass and inertia of a list of parts"
NEEDS = ("omnimorph.identification", "omnimorph.design.schema")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("parts", metavar="PARTS.toml", help="a file of [[part]] tables")


def answer(options: argparse.Namespace) -> console.Answer:
    """Add up the parts."""
    import omnimorph as om

    parts = om.identification.load_parts(options.parts)
    body = om.identification.assemble(parts)
    centre, inertia = body.centre.tolist(), body.inertia.tolist()
    rows = [_row(row, float(abs(body.inertia).max())) for row in inertia]
    lines = [
        f"# {console.counted(len(parts), 'part')} of {options.parts}; about the centre of mass, at",
        f"# {_row(centre)} m: positions in a vehicle file are counted from there",
        f"mass_kg = {body.mass:.10g}",
        f"inertia_kg_m2 = [{', '.join(rows)}]",
    ]
    warnings = []
    if not body.is_solid:
        warnings = [
            "The parts lie in one line and have no inertia about it, which a vehicle must have."
        ]
    lines[2:2] = [f"# {sentence}" for sentence in warnings]
    data = {
        "parts": len(parts),
        "mass_kg": body.mass,
        "centre_of_mass_m": centre,
        "inertia_kg_m2": inertia,
        "warnings": warnings,
    }
    return console.Answer(text="\n".join(lines), data=data)


def _row(numbers: Sequence[float], scale: float = 1.0) -> str:
    """Return numbers as TOML writes them; what is rounding beside `scale` is 0."""
    return f"[{', '.join(f'{x:.6g}' if abs(x) > 1e-12 * scale else '0.0' for x in numbers)}]"
