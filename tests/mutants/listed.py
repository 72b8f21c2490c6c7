"""The list of mistakes: small wrong changes of the source, each beside the tests that notice it."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Mutant:
    """One mistake.

    `before` stands in `file` exactly once and is replaced by `after`; `tests` are files, or tests
    in files (``file::name``), that must then fail.
    """

    area: str
    name: str
    wrong: str
    file: str
    before: str
    after: str
    tests: tuple[str, ...]

    @property
    def needs_a_build(self) -> bool:
        """Whether it is a mistake of the compiled core."""
        return self.file.startswith("core/")

    def applied(self, text: str) -> str:
        """Return the text of its file with the mistake in it."""
        found = text.count(self.before)
        if found != 1 or self.before == self.after:
            raise ValueError(f"{self.area} {self.name}: `before` is {found} times in {self.file}")
        return text.replace(self.before, self.after)


def mutants() -> list[Mutant]:
    """Return all that the TOML files beside this one list; each file is an area."""
    return [
        Mutant(area=path.stem, **entry | {"tests": tuple(entry["tests"])})
        for path in sorted(Path(__file__).parent.glob("*.toml"))
        for entry in tomllib.loads(path.read_text(encoding="utf-8"))["mutant"]
    ]
