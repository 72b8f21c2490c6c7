"""`Run`: a recorded flight, with what follows from it and the file it is kept in."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from omnimorph.results.followed import sentence_of
from omnimorph.results.metrics import Metrics, metrics_from_run
from omnimorph.results.record import COLUMNS, Outcome, Performance, Provenance, RunRecord
from omnimorph.results.saving import hash_content, save_run

__all__ = ["COLUMNS", "Outcome", "Performance", "Provenance", "Run"]


class Run(RunRecord):
    """A `RunRecord`, which says what is in it, and what follows from that."""

    @cached_property
    def metrics(self) -> Metrics:
        """The numbers of the run, named as the keys of ``metrics.json``."""
        return metrics_from_run(self)

    @property
    def outcome_sentence(self) -> str:
        """How the flight ended, and whether it was far from its reference then."""
        return sentence_of(self, self.metrics)

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 over the columns, the outcome and the provenance, as hexadecimal text.

        It does not depend on the machine but through the numbers themselves: two runs with the same
        hash are the same flight to the last bit.
        """
        return hash_content(self)

    def save(self, path: str | Path, *, compression: int = 0) -> None:
        """Write the run to a netCDF-4 file, as a whole or not at all.

        Parameters
        ----------
        path : str or Path
            The file, usually ``….nc``; an older one is replaced.
        compression : int
            0 (none) to 9, of gzip; it costs far more time than it saves space.

        Raises
        ------
        RunFileError
            If it cannot be written; nothing half-written is left.
        """
        sentence, content_hash = self.outcome_sentence, self.content_hash
        save_run(self, path, sentence, content_hash, compression=compression)


Run.__doc__ = RunRecord.__doc__
