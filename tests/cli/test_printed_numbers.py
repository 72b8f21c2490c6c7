"""What commands print is what they hand to programs: every number, and every cell of a table."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from contextlib import chdir
from typing import Any

import numpy as np
import pytest
from tests.cli.printed import answer_of, is_shown, rows_of, unfounded
from tests.cli.test_fit_and_inertia import PARTS, write_bench

import omnimorph as om
from omnimorph.analysis import overview
from omnimorph.cli import analyze, reproduce
from omnimorph.cli.console import Answer
from omnimorph.cli.main import main
from omnimorph.results.metrics import MEASURES
from omnimorph.verification import CASES, Result, run_cases
from omnimorph.verification.case import case

COMMANDS: dict[str, tuple[str, ...]] = {
    "fly": ("fly", "hover", "--seed", "3"),
    "compare": ("compare", "quadrotor", "omnimorph"),
    "analyze": ("analyze", "omnimorph", "--tilt", "12.5"),
    "analyze fixed": ("analyze", "odar-8"),
    "gains": ("gains", "omnimorph", "--delay-ms", "3"),
    "fit": ("fit", "bench.csv"),
    "inertia": ("inertia", "parts.toml"),
    "vehicles": ("vehicles",),
    "vehicle": ("vehicles", "omnimorph"),
    "scenarios": ("scenarios",),
    "scenario": ("scenarios", "paper-case-a"),
}


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Answer]]:
    folder = tmp_path_factory.mktemp("printed")
    write_bench(folder / "bench.csv")
    (folder / "parts.toml").write_text(PARTS, encoding="utf-8")
    with chdir(folder):
        yield {name: answer_of(*words) for name, words in COMMANDS.items()}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_number_printed_is_in_the_json(answers: dict[str, Answer], name: str) -> None:
    also: Any = ()
    if name == "scenario":  # which is printed beside what stands in its file
        also = [om.load_scenario("paper-case-a").reference.duration]
    assert unfounded(answers[name].text, [answers[name].data, also]) == []


def test_a_number_that_is_nowhere_is_found() -> None:
    data = {"error_m": 0.00123456, "share": 0.25, "angle_rad": 1.0, "name": "paper of 2024"}
    assert unfounded("1.2346 mm, 57.3°, 25%, of 2024, odar-8, run.nc", data) == []
    assert unfounded("0.12346 mm, 1.2345 m, 3, 24%", data) == ["0.12346", "1.2345", "3", "24%"]


# --- cell by cell ---------------------------------------------------------------------------------


def test_a_flight_is_printed_measure_by_measure(answers: dict[str, Answer]) -> None:
    text, data = answers["fly"].text, answers["fly"].data
    rows = {
        line.rsplit("  ", 2)[0].strip(): line.split()[-2]
        for line in text.split("\n\n")[2].splitlines()
    }
    assert list(rows) == [measure.label for measure in MEASURES.values()]
    for key, measure in MEASURES.items():
        assert is_shown(rows[measure.label], measure.factor * data["metrics"][key]), key
    metrics = om.load_run(data["files"]["run"]).metrics.as_dict()
    assert data["metrics"] == metrics
    last = next(line for line in text.splitlines() if "times real time" in line)
    assert is_shown(last.split()[0], data["metrics"]["duration_s"])


def test_platforms_are_printed_cell_by_cell(answers: dict[str, Answer]) -> None:
    keys = {
        "rotors": "rotors",
        "servos": "servos",
        "kg": "mass_kg",
        "radius": "radius_over_weight",
        "sideways": "lateral_over_weight",
        "W/kg": "hover_power_W_per_kg",
    }
    rows = rows_of(answers["compare"].text)
    for row, reported in zip(rows, answers["compare"].data["vehicles"], strict=True):
        vehicle = om.load_vehicle(reported["vehicle"])
        numbers = [vehicle.n_rotors, vehicle.n_servos, vehicle.mass]
        assert [reported[key] for key in ("rotors", "servos", "mass_kg")] == numbers
        assert row["vehicle"] == reported["vehicle"]
        for head, key in keys.items():
            assert is_shown(row[head], reported[key]), head
        assert is_shown(row["mm"], 1e3 * reported["flight"]["position_error_mean_m"])
        assert row["class"].split("; ")[-1] == reported["thrust"]


@pytest.mark.parametrize("name", ["analyze", "analyze fixed"])
def test_an_analysis_is_printed_cell_by_cell(answers: dict[str, Answer], name: str) -> None:
    rows, data = rows_of(answers[name].text), answers[name].data
    for row, reported in zip(rows, data["at_tilt"], strict=True):
        cells = {
            "rank A": reported["rank_thrust"],
            "rank F": reported["rank_full"],
            "condition": reported["condition_number"],
            "r free N": reported["force_free_moment"]["radius_N"],
            "r zero N": reported["force_zero_moment"]["radius_N"],
            "lift N": reported["largest_lift_N"],
            "power W": reported["level_hover"]["power_W"],
            "paper": reported["level_hover"]["power_paper"],
        }
        for head, value in cells.items():
            assert is_shown(row[head], value), head
        if reported["tilt_deg"]:
            assert is_shown(row["tilt °"], reported["tilt_deg"][0])


def test_servos_that_differ_are_shown_one_by_one() -> None:
    quad = om.load_vehicle("tilting-quad")
    for angles, shown in (([1.0, 2.5, 1.0, 1.0], "1, 2.50, 1, 1"), ([7.0] * 4, "7")):
        row = analyze._row(overview._at(quad, np.radians(angles), "asked for"))
        assert row[0] == shown
        assert row[-1].endswith(" (asked for)")


def degrees_in(text: str) -> list[float]:
    """Return the angles of a text, in their order."""
    return [float(found) for found in re.findall(r"(-?[\d.]+)°", text)]


def test_where_a_vehicle_can_hover_is_printed_cell_by_cell(answers: dict[str, Answer]) -> None:
    text, data = answers["analyze"].text, answers["analyze"].data
    first, within, beyond = "it can hover", "within its limits", "if the servos turned"
    rows = {row[first]: row for row in rows_of(text[text.index(f"\n{first}") :])}
    keys = {
        "every attitude, zero moment": "every_attitude_zero_moment",
        "every attitude, free moments": "every_attitude_free_moment",
        "level": "level",
    }
    assert list(rows) == list(keys)
    for words, key in keys.items():
        for head, ending in ((within, ""), (beyond, "_whole_turn")):
            (cell,) = (cell for name, cell in rows[words].items() if name.startswith(head))
            expected = np.ravel(data["hovering_range_deg"][key + ending])
            np.testing.assert_allclose(degrees_in(cell), expected, atol=0.005, err_msg=words)
    assert f"tilt {data['tilt_limits_deg'][0]:g}° to {data['tilt_limits_deg'][1]:g}°;" in text
    (line,) = (line for line in text.splitlines() if line.startswith("Singular tilts"))
    assert degrees_in(line) == [one["tilt_deg"] for one in data["singular_tilts"]]
    ranks = [int(found) for found in re.findall(r"rank (\d)", line)]
    assert ranks == [one["rank_thrust"] for one in data["singular_tilts"]]
    assert f"Interference: {len(data['interference']['pairs'])} pairs" in text


def test_a_vehicle_without_servos_says_where_it_hovers(answers: dict[str, Answer]) -> None:
    """The octorotor hovers in every attitude, the quadrotor level only."""
    text, data = answers["analyze fixed"].text, answers["analyze fixed"].data
    assert "hover level: yes; in every attitude: yes; share of all attitudes: all." in text
    assert "r free N" in text
    assert data["at_tilt"][0]["level_hover"]["feasible"]


def test_what_an_analysis_says_of_wakes_and_mass(answers: dict[str, Answer]) -> None:
    text, data = answers["analyze"].text, answers["analyze"].data
    wakes, trade = data["interference"], data["morphing_trade"]
    for k in (0, -1):
        with_them, without = wakes["level_power_W"][k], wakes["level_power_still_air_W"][k]
        assert f"{with_them:.4g} W instead of {without:.4g} W at {wakes['tilt_deg'][k]:g}°" in text
    assert f"{trade['own_share']:.2%}" in text
    assert f"in still air beyond {trade['break_even_tilt_deg']:.2f}°" in text
    assert f"{trade['break_even_tilt_in_wakes_deg']:.2f}°" in text


def test_margins_are_printed_cell_by_cell(answers: dict[str, Answer]) -> None:
    text, data = answers["gains"].text, answers["gains"].data
    assert "for a control period of 4 ms and a delay of 3 ms." in text
    vehicle, margins, times = om.load_vehicle("omnimorph"), data["margins"], (0.004, 0.003)
    assert (data["control_period_ms"], data["delay_ms"]) == (4.0, 3.0)
    proposal = om.propose_controller(vehicle, *times)
    found = om.stability_margins(proposal.gains, vehicle, *times)
    assert proposal.reasons == tuple(data["reasons"])
    assert "\n".join(proposal.reasons) in text
    for key, values in (
        ("crossover_rad_per_s", found.crossover),
        ("phase_margin_deg", np.degrees(found.phase_margin)),
        ("gain_margin", found.gain_margin),
        ("delay_margin_ms", 1e3 * found.delay_margin),
    ):
        np.testing.assert_allclose(margins[key], values, err_msg=key)
    for k, row in enumerate(rows_of(answers["gains"].text)):
        assert row.pop("axis") == margins["axis"][k]
        for head, cell in row.items():
            assert is_shown(cell, margins[head][k]), head


def test_lists_are_those_of_the_catalogues(answers: dict[str, Answer]) -> None:
    for reported in answers["vehicles"].data:
        vehicle = om.load_vehicle(reported["name"])
        found = (vehicle.n_rotors, vehicle.n_servos, vehicle.mass, vehicle.title)
        assert tuple(reported[key] for key in ("rotors", "servos", "mass_kg", "title")) == found
    for reported in answers["scenarios"].data[-3:]:
        scenario = om.load_scenario(reported["name"])
        names = (scenario.vehicle.name, scenario.plant.name, scenario.title)
        assert tuple(reported[key] for key in ("vehicle", "plant", "title")) == names
        assert reported["duration_s"] == scenario.reference.duration


def test_lists_are_printed_cell_by_cell(answers: dict[str, Answer]) -> None:
    for name, numbers in (
        ("vehicles", ["rotors", "servos", "mass_kg"]),
        ("scenarios", ["duration_s"]),
    ):
        for row, reported in zip(rows_of(answers[name].text), answers[name].data, strict=True):
            assert list(row) == list(reported)
            for head, cell in row.items():
                if head in numbers:
                    assert is_shown(cell, reported[head]), head
                else:
                    assert cell == reported[head]


def test_a_scenario_is_printed_line_by_line(answers: dict[str, Answer]) -> None:
    """Each line is a path into the data and what stands there."""
    for reported in (answers["scenario"], answer_of("scenarios", "tour")):
        lines = [line.split(maxsplit=1) for line in reported.text.split("\n\n")[1].splitlines()]
        assert len(lines) == len({key for key, _ in lines}) > 10
        for key, cell in lines:
            value = reported.data
            for part in re.findall(r"\w+", key):
                value = value[int(part) if part.isdecimal() else part]
            if isinstance(value, bool | str):
                assert cell == str(value), key
                continue
            shown = re.sub(r"[\[\]]", "", cell).split(", ")
            for one, number in zip(shown, np.ravel(value).tolist(), strict=True):
                assert is_shown(one, number), key


def test_a_vehicle_is_printed_rotor_by_rotor(answers: dict[str, Answer]) -> None:
    text, data = answers["vehicle"].text, answers["vehicle"].data
    for k, (row, reported) in enumerate(zip(rows_of(text), data["rotor"], strict=True)):
        assert row.pop("rotor") == str(k)
        for head, cell in row.items():
            values = reported[head] if isinstance(reported[head], list) else [reported[head]]
            shown = cell.strip("[]").split(", ")
            for one, value in zip(shown, values, strict=True):
                assert one == value if isinstance(value, str) else is_shown(one, value), head
    body = text[text.index("Every number") :]
    rows = {row["key"]: row for row in rows_of(body)}
    assert is_shown(rows["mass_kg"]["value"], data["mass_kg"])
    for key, row in rows.items():
        assumed = data["assumed"].get(key)
        assert row[""] == ("*" if assumed else ""), key
        assert row["source"] == (assumed or data["sources"].get(key) or row["source"])


def test_claims_are_printed_cell_by_cell() -> None:
    claim = {"key": "energy_a", "paper": 2081.0, "unit": "J", "here": 1764.32, "verdict": "far"}
    claim |= {"difference": -0.1522, "found": "in 20 flights"}
    claim |= {"explained": False, "why": "another plant"}
    assert reproduce._row(claim) == [
        *("energy_a", "2081 J", "1764", "-15.2%", "far", "in 20 flights")
    ]
    sentence = {**claim, "paper": None, "here": None, "difference": None}
    assert reproduce._row(sentence) == ["energy_a", "", "", "", "far", "in 20 flights"]
    assert reproduce._row({**claim, "explained": True})[-1] == "another plant"


def test_parts_are_printed_as_they_add_up(answers: dict[str, Answer]) -> None:
    values, data = tomllib.loads(answers["inertia"].text), answers["inertia"].data
    assert values["mass_kg"] == data["mass_kg"]
    np.testing.assert_allclose(values["inertia_kg_m2"], data["inertia_kg_m2"], atol=1e-12)
    text = answers["inertia"].text
    assert f"# {data['parts']} parts of parts.toml" in text
    (centre,) = (line for line in text.splitlines() if line.endswith("are counted from there"))
    shown = [float(number) for number in centre[3 : centre.index("]")].split(",")]
    np.testing.assert_allclose(shown, data["centre_of_mass_m"], rtol=1e-5, atol=1e-12)


def test_a_fit_is_printed_line_by_line(answers: dict[str, Answer]) -> None:
    text, data = answers["fit"].text, answers["fit"].data
    assert f"torque over force {1e3 * data['drag_to_thrust_m']:.4g} mm" in text
    for key in ("thrust_coefficient_N_per_Hz2", "drag_coefficient_Nm_per_Hz2",
                "time_constant_up_ms", "time_constant_down_ms"):  # fmt: skip
        reported = data[key].get("both", data[key])
        words = next(line for line in text.splitlines() if line.startswith(key)).split()
        shown = [words[2], words[-3], words[-1]]
        for cell, value in zip(
            shown, (reported["value"], reported["low"], reported["high"]), strict=True
        ):
            assert is_shown(cell, value), key
    for key in ("speed_min_Hz", "speed_max_Hz"):
        line = next(line for line in text.splitlines() if line.startswith(key))
        assert is_shown(line.split()[2], data[key])


# --- verify ---------------------------------------------------------------------------------------


@case("by hand")
def two_and_two() -> Result:
    """Two and two are five."""
    return Result(value=4.0, expected=5.0, tolerance=0.25, unit="m")


def test_a_case_that_fails_is_reported_and_the_exit_code_is_1(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_cases, "__defaults__", (None, (CASES[0], two_and_two)))
    assert main(["verify"]) == 1
    shown = capsys.readouterr()
    assert "1 of 2 cases passed. These did not: two-and-two." in shown.err
    good, bad = rows_of(shown.out)
    assert (good[""], bad[""]) == ("passed", "FAILED")
    assert (bad["measured"], bad["expected"], bad["within"], bad["unit"]) == ("4", "5", "0.25", "m")
    assert main(["verify", "--json"]) == 1
    reported = json.loads(capsys.readouterr().out)
    assert (reported["passed"], reported["failed"]) == (1, 1)
    assert [one["passed"] for one in reported["cases"]] == [True, False]
    assert unfounded(shown.out, reported) == []


def test_cases_that_pass_exit_with_0(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_cases, "__defaults__", (None, CASES[:1]))
    assert main(["verify"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert "1 of 1 cases passed." in shown.out
