"""Fly a scenario once, show its metrics, and write the run and the metrics to a folder."""

from __future__ import annotations

import argparse
import re
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import allow_code, folder, seed_number
from omnimorph.cli.page import add_page_arguments, announce, check_no_page, served
from omnimorph.results.folder import check_folder, replaced_text, staged

if TYPE_CHECKING:
    from omnimorph import Run, Scenario

SUMMARY = "fly a scenario: metrics on the screen, run and metrics in a folder"
NEEDS = ("omnimorph.simulation.fly", "omnimorph.simulation.scenario_schema", "h5py")

NOT_COMPLETED = 3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="a name that `omnimorph scenarios` lists, or a TOML file",
    )
    parser.add_argument(
        "--vehicle",
        metavar="VEHICLE",
        help="fly another vehicle: a name that `omnimorph vehicles` lists, or a TOML file",
    )
    parser.add_argument(
        "--plant",
        metavar="PLANT",
        help="fly in another plant: perfect, realistic, realistic-1, a TOML file, or "
        "my_module:MyPlant",
    )
    add_part_arguments(parser)
    parser.add_argument(
        "--seed", type=seed_number, default=0, metavar="K", help="seed of the noise (default: 0)"
    )
    parser.add_argument(
        "--out",
        type=folder,
        metavar="DIR",
        help="write run.nc and metrics.json there (default: a folder in ./runs)",
    )
    parser.add_argument(
        "--view",
        action="store_true",
        help="watch it while it flies, in the browser, and push it or cut a rotor",
    )
    add_page_arguments(parser.add_argument_group("with --view"))


PARTS = {
    "sensors": "those of a plant",
    "estimator": "that of a plant",
    "controller": "that of a scenario",
    "allocator": "a kind of rule with the scenario's weights, or that of a scenario",
    "reference": "that of a scenario, or a CSV file of poses",
    "disturbance": "the forces of a plant, beside those there are",
}


def add_part_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that replace parts of a scenario."""
    parts = parser.add_argument_group(
        "other parts: a name, a file, or my_module:MyObject, which needs --allow-code"
    )
    for name, meaning in PARTS.items():
        parts.add_argument(f"--{name}", metavar=name.upper(), help=meaning)
    allow_code(parts)


def answer(options: argparse.Namespace) -> console.Answer:
    """Fly, write, and say how it went."""
    import omnimorph as om
    from omnimorph.simulation.parts import names_an_object

    if not options.view:
        check_no_page(options, "there is none without --view")
    scenario = om.load_scenario(options.scenario, allow_code=options.allow_code)
    if options.vehicle is not None:
        vehicle = om.load_vehicle(options.vehicle)
        plant = None if names_an_object(options.plant) else options.plant
        scenario = scenario.for_vehicle(vehicle, plant=plant)
    given: dict[str, Any] = {name: getattr(options, name) for name in ("plant", *PARTS)}
    scenario = om.with_parts(scenario, **given, allow_code=options.allow_code)
    changes = [Path(name).stem for name in (options.vehicle, *given.values()) if name]
    out = options.out or Path("runs", _folder_name(scenario.name, changes, options.seed))
    check_folder(out)
    if options.view:
        return _watched(options, scenario, out)
    with console.Progress(f"flying {scenario.name}") as progress:
        run = om.fly(scenario, seed=options.seed, progress=progress)
    return _kept(scenario, run, out)


def _watched(options: argparse.Namespace, scenario: Scenario, out: Path) -> console.Answer:
    """Fly while someone looks; keep the run, then the page until the browser leaves it."""
    from omnimorph.live.page import LivePage

    with served(options) as server:
        page = LivePage(server, scenario, options.seed)
        announce(server, options, "it flies once you look, and ends when you have looked")
        answer = _kept(scenario, page.fly(), out)
        with suppress(KeyboardInterrupt):
            page.serve()
    return answer


def _kept(scenario: Scenario, run: Run, out: Path) -> console.Answer:
    """Write a run and its metrics, and say how it went."""
    import omnimorph as om

    replaced = replaced_text(out / "run.nc", out / "metrics.json")
    with staged(out) as new:
        run.save(new / "run.nc")
        run.metrics.write_json(new / "metrics.json")
    completed = run.outcome is om.Outcome.COMPLETED
    return console.Answer(
        text=_as_text(scenario, run, out),
        data=_as_data(scenario, run, out),
        code=0 if completed else NOT_COMPLETED,
        complaint=f"{_complaint(scenario, run)}\n{replaced}".strip(),
    )


def _folder_name(scenario: str, changes: list[str], seed: int) -> str:
    """Return a name without anything that means something in a path."""
    parts = [scenario, *changes, f"seed{seed}"]
    return re.sub(r"[^\w.-]+", "-", "-".join(parts)).lstrip(".-")


def _complaint(scenario: Scenario, run: Run) -> str:
    """Return what is wrong with a flight, in a line each; nothing if all is well."""
    flown, whole = float(run.time[-1]), scenario.reference.duration
    warnings = []
    if run.outcome.name != "COMPLETED":
        warnings.append(f"{run.outcome_sentence} It flew {flown:g} s of {whole:g} s.")
    elif run.outcome_sentence != run.outcome.value:
        warnings.append(run.outcome_sentence)
    if (unproven := run.metrics.unproven_steps) > 0:
        warnings.append(
            f"{unproven} control steps are not proven: the KKT residual of their allocation is up "
            f"to {run.metrics.kkt_residual_max:.1e}."
        )
    return "\n".join(f"{scenario.name}: {line}" for line in warnings)


def _as_text(scenario: Scenario, run: Run, out: Path) -> str:
    performance, provenance = run.performance, run.provenance
    title = f"{scenario.name}: {scenario.title}".rstrip(": ")
    return "\n".join(
        [
            title,
            f"vehicle {scenario.vehicle.name}, plant {provenance.plant_name}, "
            f"seed {provenance.seed}",
            *_in_python(scenario),
            "",
            run.outcome_sentence,
            "",
            console.table(_measures(run.metrics.as_dict()), align="lr"),
            "",
            f"{run.time[-1]:g} s flown in {console.brief(performance.wall_time)} s: "
            f"{console.brief(performance.real_time_factor)} times real time.",
            f"Written to {out}: run.nc, metrics.json.",
        ]
    )


def _in_python(scenario: Scenario) -> list[str]:
    """Return the line that says which parts are written in Python, if any are."""
    from omnimorph.simulation.own_parts import name_of

    parts = [f"{part} {name_of(own)}" for part, own in scenario.own.given().items()]
    return [f"in Python: {', '.join(parts)}"] if parts else []


def _measures(metrics: dict[str, Any]) -> list[list[str]]:
    """Return the rows of the table: what, how much, in which unit."""
    from omnimorph.results.metrics import MEASURES

    rows = []
    for key, measure in MEASURES.items():
        value = metrics[key]
        shown = value if value is None else measure.factor * value
        rows.append([measure.label, console.number(shown), measure.unit])
    return rows


def _as_data(scenario: Scenario, run: Run, out: Path) -> dict[str, Any]:
    return {
        "scenario": scenario.name,
        "title": scenario.title,
        "vehicle": scenario.vehicle.name,
        "plant": run.provenance.plant_name,
        "seed": run.provenance.seed,
        "outcome": run.outcome.name.lower(),
        "outcome_sentence": run.outcome_sentence,
        "metrics": run.metrics.as_dict(),
        "wall_time_s": run.performance.wall_time,
        "real_time_factor": run.performance.real_time_factor,
        "content_hash": run.content_hash,
        "files": {"run": str(out / "run.nc"), "metrics": str(out / "metrics.json")},
    }
