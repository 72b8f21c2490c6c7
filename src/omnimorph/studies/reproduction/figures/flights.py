"""What the figures of the flights show: which flights, how they look, the numbers of the paper."""

from __future__ import annotations

from omnimorph.report.style import Flight, LineStyle
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.figures import summary
from omnimorph.studies.reproduction.figures.line_styles import DOTTED, LINE_STYLES, ORDER
from omnimorph.studies.reproduction.flights import FIXED_A, FIXED_B, W3, A, B, PaperFlights
from omnimorph.studies.reproduction.results import Results
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS


def energy_rows(flights: PaperFlights) -> list[summary.EnergyRow]:
    """Return the energies of each flight, ours and the paper's."""
    reported = {
        claim.about["scenario"]: claim.value
        for claim in paper.claims().values()
        if claim.about.get("metric") == "drag_energy_paper"
    }
    rows = []
    for name in (B, W3, FIXED_B, FIXED_A, A):
        rows.append(
            summary.EnergyRow(
                label=FLIGHT_LABELS[name],
                values=flights.values(name, "drag_energy_paper").tolist(),
                perfect=spread_of([flights.perfect[name]], "drag_energy_paper").mean,
                paper=reported.get(name),
                line_style=LINE_STYLES[name],
            )
        )
    return rows


def paper_means() -> list[tuple[str, float, float, LineStyle]]:
    """Return the paper's mean errors (mm, and ‖e_R‖) of both cases."""
    means = []
    for name, key in ((A, "a"), (B, "b")):
        distance = paper.claims()[f"position_error_{key}"].value
        sine = paper.claims()[f"attitude_error_{key}"].value
        assert distance is not None
        assert sine is not None
        means.append(
            (f"the paper's mean, {FLIGHT_LABELS[name]}", distance, sine, LINE_STYLES[name])
        )
    return means


def variant_flights(flights: PaperFlights) -> list[Flight]:
    """Return Case A in the plants that ought to agree."""
    return [
        Flight(
            f"{1e3 * variant.step:g} ms" + (", noise" if variant.noise else ""),
            variant.run,
            line_style,
        )
        for variant, line_style in zip(flights.variants, ORDER, strict=True)
    ]


def degraded_flights(results: Results) -> list[Flight]:
    """Return the paper's degraded flights, each followed by the healthy one of its case."""
    shown = []
    for key, run in results.degraded_runs.items():
        about = paper.claims()[key].about
        case = about["scenario"]
        name = f"{FLIGHT_LABELS[case]}, {about['loss_percent']:g} % less"
        shown.append(Flight(name, run, LineStyle(LINE_STYLES[case].colour)))
        healthy = LineStyle(LINE_STYLES[case].colour, DOTTED)
        shown.append(Flight(f"{FLIGHT_LABELS[case]}, healthy", results.flights.runs[case], healthy))
    return shown
