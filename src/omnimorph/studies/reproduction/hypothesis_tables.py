"""What the hypotheses on the paper's errors come to, as tables."""

from __future__ import annotations

from collections.abc import Sequence

from omnimorph.report.tables import Table, number
from omnimorph.studies.reproduction.hypotheses import CASES, Hypothesis, error_claims
from omnimorph.studies.reproduction.verdicts import NEAR
from omnimorph.studies.reproduction.words import mean_words

__all__ = ["hypothesis_table", "objection_table"]

_SHORT = dict(zip(CASES, ("A", "B", "W3 × 10"), strict=True))


def hypothesis_table(hypotheses: Sequence[Hypothesis]) -> Table:
    """Return the paper's six mean errors under every hypothesis, and how many come out."""
    claims = list(error_claims())
    factor = {claim.key: 1.0 if claim.unit == "mm" else 1e3 for claim in claims}
    rows = [
        ["the paper", *(number(factor[one.key] * (one.value or 0.0), 3) for one in claims), "", ""]
    ]
    for one in hypotheses:
        means = [
            mean_words(
                one.spread(claim.about["scenario"], claim.about["metric"]), factor[claim.key]
            )
            for claim in claims
        ]
        standing = "as stated" if one.verdict is None else one.verdict.value
        rows.append([one.label, *means, f"{one.explained} of {len(claims)}", standing])
    head = [
        "",
        *(f"{_SHORT[name]} (mm)" for name in CASES),
        *(f"‖e_R‖, {_SHORT[name]} (10⁻³)" for name in CASES),
        f"within {100 * NEAR:g} %",
        "verdict",
    ]
    caption = "Mean position errors and mean ‖e_R‖ of three flights, with half of a 95 % interval."
    return Table(caption, head, rows, frozenset(range(1, 8)))


def objection_table(hypotheses: Sequence[Hypothesis]) -> Table:
    """Return what speaks against each hypothesis."""
    rows = [
        [one.label, number(one.ratio_of_position_errors, 2), "; ".join(one.objections)]
        for one in hypotheses
    ]
    head = ["", "position error, B over A", "against it"]
    return Table(
        "What speaks against each hypothesis, beside the ratio of its position errors.",
        head,
        rows,
        frozenset({1}),
    )
