"""The pages in a real browser: played, scrubbed, moved, and their numbers compared with the API."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from tests.browser.conftest import PHONE, opened, viewed
from tests.serving import served

import omnimorph as om

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    om.fly(om.load_scenario("paper-case-a")).save(folder / "a.nc")
    om.fly(om.load_scenario("paper-case-b")).save(folder / "b.nc")
    return folder


def number(page: Page, key: str) -> str:
    return page.locator(f"#{key}").inner_text()


def wait_for(page: Page, key: str, text: str) -> None:
    """Wait until an element of the page says something."""
    page.locator(f"#{key}", has_text=text).wait_for()


def set_slider(page: Page, label: str, value: str) -> None:
    """Type into the field beside a slider, as its user may."""
    row = page.locator("label", has_text=label).locator("xpath=../../..")
    field = row.locator("input:visible").last
    field.fill(value)
    field.press("Enter")


def is_drawn(page: Page) -> bool:
    """Tell whether the canvas shows more than its background."""
    from io import BytesIO

    from PIL import Image

    picture = Image.open(BytesIO(page.locator("canvas").first.screenshot())).convert("RGB")
    return len(picture.getcolors(maxcolors=1 << 24) or []) > 200


# --- flights ------------------------------------------------------------------------------------


def test_a_flight_is_scrubbed_and_its_numbers_are_the_run(
    browser: Browser, runs: Path, tmp_path: Path
) -> None:
    run = om.load_run(runs / "a.nc")
    with viewed(browser, "view", "a.nc", folder=runs) as (page, command):
        page.wait_for_selector("#time")
        for moment in ("31.415", "9.27"):
            set_slider(page, "time, s", moment)
            page.wait_for_function(
                f"document.querySelector('#time').innerText == '{float(moment):.3f}'"
            )
            row = round(float(moment) / 1e-3)
            error = np.linalg.norm(run.p_WB[row] - run.desired_p_WB[row])
            assert number(page, "position-error") == f"{1e3 * error:.3f}"
            assert number(page, "tilt") == f"{np.degrees(run.tilt_actual[row, 0]):.2f}"
            fastest = np.abs(run.speed[row]).max() / (2 * np.pi)
            assert number(page, "fastest-rotor") == f"{fastest:.2f}"
            assert number(page, "power") == f"{run.drag_power[row]:.1f}"
        assert page.locator(".uplot").count() == 5
        assert is_drawn(page)
        code, out, err = command.stopped()
    assert (code, out) == (0, "The page is closed.\n")
    assert err == "", "more than where the page is"


def test_a_flight_plays_pauses_and_ends(browser: Browser, runs: Path) -> None:
    with viewed(browser, "view", "a.nc", folder=runs) as (page, command):
        page.wait_for_selector("#time")
        assert command.seconds < 20.0
        page.get_by_role("button", name="Play").click()
        page.wait_for_function("parseFloat(document.querySelector('#time').innerText) > 0.5")
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
        stands = number(page, "time")
        page.wait_for_timeout(600)
        assert number(page, "time") == stands
        page.reload()
        wait_for(page, "time", stands)
        set_slider(page, "time, s", "44.9")
        page.get_by_role("button", name="Play").click()
        page.wait_for_function("document.querySelector('#time').innerText == '45.000'")
        assert "The flight was completed." in page.locator("#notices").inner_text()


def test_two_flights_are_synchronised(browser: Browser, runs: Path) -> None:
    a, b = om.load_run(runs / "a.nc"), om.load_run(runs / "b.nc")
    with viewed(browser, "view", "a.nc", "b.nc", folder=runs) as (page, _):
        page.wait_for_selector("#tilt-2")
        set_slider(page, "time, s", "30")
        page.wait_for_function("document.querySelector('#time').innerText == '30.000'")
        assert number(page, "tilt") == f"{np.degrees(a.tilt_actual[30_000, 0]):.2f}"
        assert number(page, "tilt-2") == f"{np.degrees(b.tilt_actual[30_000, 0]):.2f}"
        assert is_drawn(page)


def test_a_name_in_a_file_is_never_run(browser: Browser, tmp_path: Path) -> None:
    name = "<img src=x onerror='window.harmed = 1'>"
    run = om.fly(om.load_scenario("hover"))
    named = replace(run, provenance=replace(run.provenance, scenario_name=name))
    named.save(tmp_path / "a.nc")
    named.save(tmp_path / "b.nc")
    with viewed(browser, "view", "a.nc", "b.nc", folder=tmp_path) as (page, _):
        page.wait_for_selector("#time-2")
        set_slider(page, "time, s", "0.5")
        wait_for(page, "time", "0.500")
        assert name in page.locator("body").inner_text()
        assert page.evaluate("window.harmed") is None


def test_a_flight_fits_a_phone(browser: Browser, runs: Path) -> None:
    with viewed(browser, "view", "a.nc", folder=runs, size=PHONE) as (page, _):
        page.wait_for_selector("canvas")
        page.wait_for_timeout(2000)
        assert is_drawn(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]


# --- designs ------------------------------------------------------------------------------------


def test_sliders_change_the_numbers_as_the_analysis_says(browser: Browser, tmp_path: Path) -> None:
    vehicle = om.load_vehicle("omnimorph")
    with viewed(browser, "view", "omnimorph", folder=tmp_path) as (page, _):
        page.wait_for_selector("#force-radius")
        best = om.analysis.tilt_of_largest_radius(vehicle)
        most = om.analysis.inscribed_radius(vehicle, best, zero_moment=True)
        assert number(page, "force-radius") == f"{most:.4g}"
        for degrees in (20.0, 54.7):
            set_slider(page, "tilt, °", f"{degrees}")
            tilt = np.radians(degrees)
            forces = om.analysis.force_set(vehicle, tilt, zero_moment=True)
            radius = f"{forces.inscribed_radius:.4g}"
            page.wait_for_function(
                f"document.querySelector('#force-radius').innerText == '{radius}'"
            )
            power = om.analysis.hover(vehicle, tilt).power
            assert number(page, "hover-power") == f"{power:.4g}"
        set_slider(page, "mass, kg", "2.63")
        page.wait_for_function("document.querySelector('#weight').innerText == '25.8'")
        assert is_drawn(page)


def test_another_vehicle_is_chosen_and_a_design_saved(browser: Browser, tmp_path: Path) -> None:
    words = ("view", "omnimorph", "--out", "designs")
    with viewed(browser, *words, folder=tmp_path) as (page, _):
        page.wait_for_selector("#rank")
        page.get_by_role("combobox").first.click()
        page.get_by_role("option", name="tilt-hex", exact=True).click()
        weight = om.load_vehicle("tilt-hex").mass * 9.81
        wait_for(page, "weight", f"{weight:.4g}")
        set_slider(page, "mass, kg", "2.5")
        page.wait_for_function("document.querySelector('#weight').innerText == '24.53'")
        with page.expect_download() as download:
            page.get_by_role("button", name="Save as TOML").click()
        page.wait_for_selector("#saved")
        kept = tmp_path / "designs" / "tilt-hex-design.toml"
        assert om.load_vehicle(kept).mass == 2.5
        assert download.value.path().read_text() == kept.read_text()
    assert [path.name for path in tmp_path.rglob("*.toml")] == [kept.name]


def test_without_a_folder_nothing_is_written_here(browser: Browser, tmp_path: Path) -> None:
    with viewed(browser, "view", "quadrotor", folder=tmp_path, size=PHONE) as (page, _):
        page.wait_for_selector("canvas")
        page.wait_for_timeout(2000)
        assert is_drawn(page)
    assert list(tmp_path.iterdir()) == []


# --- live ---------------------------------------------------------------------------------------


def test_a_live_flight_is_disturbed_and_kept(browser: Browser, tmp_path: Path) -> None:
    words = ("fly", "paper-case-a", "--view", "--out", "flown")
    with served(*words, folder=tmp_path) as command:
        with opened(browser, command.url) as page:
            pace = page.get_by_role("combobox").first
            pace.click()  # slowly, so that it is not out of sight before all is done to it
            page.get_by_role("option", name="a tenth").click()
            page.get_by_role("button", name="+x", exact=True).click()
            wait_for(page, "done", "pushed with 12.9 N")
            page.get_by_role("button", name="Cut its thrust").click()
            wait_for(page, "done", "without thrust: rotor 0")
            page.get_by_role("button", name="Restore all rotors").click()
            page.get_by_role("combobox").last.click()
            page.get_by_role("option", name="paper-case-b", exact=True).click()
            pace.click()
            page.get_by_role("option", name="as fast as possible").click()
            wait_for(page, "notices", "The flight was completed.")
            assert is_drawn(page)
            plots = "Object.values(window.__viserTestpoints.uplots)"
            page.wait_for_function(f"{plots}.every(one => one.chart.data[0].at(-1) === 45)")
            shown = f"{plots}.map(one => [one.createCount, one.chart.scales.x.max])"
            assert page.evaluate(shown) == [[1, 45]] * 5, "every plot goes on to the end"
        out, err = command.process.communicate(timeout=30)
        assert command.process.returncode == 0
    assert "had no effect" not in err
    assert "The flight was completed." in out
    run = om.load_run(tmp_path / "flown" / "run.nc")
    events = json.loads(run.provenance.scenario_text)["events"]
    kinds = [event["kind"] for event in events]
    assert kinds == ["push", "effectiveness", "effectiveness", "controller"]
    assert events[1]["share"] == [0.0, *[1.0] * 7]
    assert run.time[-1] == pytest.approx(45.0)


# --- pictures -----------------------------------------------------------------------------------


def test_pictures_and_videos_are_drawn_without_a_window(
    runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from PIL import Image

    from omnimorph.cli.main import main

    short = tmp_path / "short.nc"
    om.fly(om.load_scenario("hover")).save(short)
    assert (
        main(["view", str(runs / "a.nc"), "--snapshot", str(tmp_path / "t.png"), "--at", "12"]) == 0
    )
    assert main(["view", "omav-12", "--snapshot", str(tmp_path / "d.webp")]) == 0
    assert main(["view", str(short), "--video", str(tmp_path / "v.gif"), "--speed", "8"]) == 0
    assert capsys.readouterr().err == ""
    still = ("--snapshot", str(tmp_path / "t.png"), "--at", "30")
    assert main(["view", str(short), str(runs / "a.nc"), *still]) == 0
    said = capsys.readouterr().err
    assert "it shows the last moment of hover at 5 s." in said
    assert f"replaced what was there: {tmp_path / 't.png'}." in said
    for name in ("t.png", "d.webp"):
        with Image.open(tmp_path / name) as picture:
            assert picture.size == (1600, 1200)
            assert len(picture.convert("RGB").getcolors(maxcolors=1 << 24) or []) > 500
    with Image.open(tmp_path / "v.gif") as video:
        assert getattr(video, "n_frames", 1) > 5
