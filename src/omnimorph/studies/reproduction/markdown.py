"""The results as a page of Markdown, from which the documents take their numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from omnimorph.report.tables import Table
from omnimorph.studies.reproduction import page_tables as tables
from omnimorph.studies.reproduction.findings import Findings
from omnimorph.studies.reproduction.hypothesis_tables import hypothesis_table, objection_table
from omnimorph.studies.reproduction.verdicts import RULES, Judged, Verdict

__all__ = ["results_text", "titled"]


def results_text(findings: Findings, judged: Sequence[Judged], command: str) -> str:
    """Return claims, rules, energies, errors, hypotheses and lost thrust, as Markdown."""
    counts = Counter(row.verdict for row in judged)
    verdicts = [
        f"- **{one.value}** ({counts[one]} of {len(judged)}): {one.meaning}" for one in Verdict
    ]
    parts = [
        "# The paper's claims beside what comes out here",
        f"Written by `{command}`, as `results.md`; `report.html` beside it shows how. "
        "The plant is `realistic` unless a row says otherwise.",
        "## Every claim",
        _table(tables.claims_table(judged)),
        "\n".join(verdicts),
        "The rule by which a claim of each kind is judged:",
        "\n".join(f"- **{kind}**: {rule}" for kind, rule in RULES.items()),
        "## Flights",
        *(
            titled(one)
            for one in (tables.energy_table(findings.flights), tables.error_table(findings.flights))
        ),
        "## What could explain the paper's errors",
        *(
            titled(one)
            for one in (hypothesis_table(findings.hypotheses), objection_table(findings.hypotheses))
        ),
        "## Less thrust than expected",
        *(
            titled(one)
            for one in (
                tables.losses_table(findings.degraded),
                tables.frontier_table(findings.degraded),
            )
        ),
    ]
    return "\n\n".join(parts) + "\n"


def titled(table: Table) -> str:
    """Return a table in Markdown below its caption."""
    return f"{table.caption}\n\n{_table(table)}"


def _table(table: Table) -> str:
    rule = ["---:" if column in table.numeric else "---" for column in range(len(table.head))]
    rows = [table.head, rule, *table.rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in row) + " |" for row in rows)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
