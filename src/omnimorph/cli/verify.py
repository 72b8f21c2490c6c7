"""Check this installation against cases with known answers: closed forms, conservation laws."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from omnimorph.cli import console

if TYPE_CHECKING:
    from omnimorph.verification import Result

SUMMARY = "check this installation against cases with known answers"
NEEDS = ("omnimorph.verification",)

FAILED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command: none of its own."""


def answer(options: argparse.Namespace) -> console.Answer:
    """Run every case and say which passed."""
    from omnimorph.verification import run_cases

    with console.Progress("verifying") as progress:
        results = run_cases(progress)
    failed = [result.name for result in results if not result.passed]
    header = ["", "measured", "expected", "within", "unit", "claim"]
    text = console.table([_row(result) for result in results], header=header, align="lrrrl")
    count = f"{len(results) - len(failed)} of {len(results)} cases passed."
    return console.Answer(
        text=f"{text}\n\n{count}",
        data={
            "passed": len(results) - len(failed),
            "failed": len(failed),
            "cases": [_as_data(result) for result in results],
        },
        code=FAILED if failed else 0,
        complaint=f"{count} These did not: {', '.join(failed)}." if failed else "",
    )


def _row(result: Result) -> list[str]:
    return [
        "passed" if result.passed else "FAILED",
        console.number(result.value, 4),
        console.number(result.expected, 4),
        console.number(result.tolerance, 2),
        result.unit,
        f"{result.name}: {result.claim}",
    ]


def _as_data(result: Result) -> dict[str, object]:
    return {
        "name": result.name,
        "passed": result.passed,
        "value": result.value,
        "expected": result.expected,
        "tolerance": result.tolerance,
        "unit": result.unit,
        "claim": result.claim,
        "source": result.source,
    }
