"""`omnimorph view`: what it refuses, in one sentence that says what to do."""

from __future__ import annotations

import argparse
import socket
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import pytest

import omnimorph as om
from omnimorph.cli.main import main
from omnimorph.cli.page import announce
from omnimorph.cli.view import _ended_before, _moment


@pytest.fixture(scope="module")
def run_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / "hover.nc"
    om.fly(om.load_scenario("hover")).save(path)
    return path


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the one line with which a mistake is refused."""
    assert main(["view", *words]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err


def test_a_port_in_use(run_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        for what in (str(run_file), "omnimorph"):
            said = refused(capsys, what, "--port", port)
            assert f"port {port} is in use; name another with --port" in said
        assert main(["fly", "hover", "--view", "--port", port, "--out", str(run_file.parent)]) == 2
        assert f"port {port} is in use" in capsys.readouterr().err


def test_a_truncated_run(
    run_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.nc"
    cut.write_bytes(run_file.read_bytes()[:20_000])
    said = refused(capsys, str(cut))
    assert "cut.nc: the run cannot be read: it is cut off or damaged" in said


def test_a_run_from_a_newer_version(
    run_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    newer = tmp_path / "newer.nc"
    newer.write_bytes(run_file.read_bytes())
    with h5py.File(newer, "r+") as file:
        file.attrs["schema_version"] = 99
    assert "install a newer omnimorph" in refused(capsys, str(newer))


def test_no_browser_to_draw_with(
    run_file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    said = refused(capsys, str(run_file), "--snapshot", "t.png")
    assert "install Chromium or Chrome" in said
    assert not Path("t.png").exists()


def test_without_viser(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    assert "pip install 'omnimorph[view]'" in refused(capsys, "omnimorph")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["no-such"], "neither a vehicle of the catalogue nor a file"),
        (["no-such.nc"], "no-such.nc: the run cannot be read"),
        (["omnimorph", "quadrotor"], "one run, two runs, or one vehicle"),
        (["omnimorph", "--port", "70000"], "a number from 0 to 65535"),
        (["omnimorph", "--host", "192.0.2.1"], "an address of this machine"),
        (["omnimorph", "--tilt", "80"], "tilt"),
        (["omnimorph", "--at", "3"], "--at goes with a run"),
        (["omnimorph", "--video", "v.gif"], "--video goes with a run"),
        (["omnimorph", "--snapshot", "t.bmp"], "a file that ends in .png, .jpg, .webp"),
        (["omnimorph", "--snapshot", "no/such/t.png"], "a file in a folder that is there"),
        (["omnimorph", "--speed", "0"], "a number from 0.01 on"),
        (["omnimorph", "--speed", "1e-300"], "a number from 0.01 on"),
    ],
)
def test_other_mistakes(
    words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert expected in refused(capsys, *words)


def test_a_vehicle_that_makes_no_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(om.__file__).parent / "design/catalogue/quadrotor.toml").read_text()
    rotors = text.split("[[rotor]]")
    lever = tmp_path / "lever.toml"
    lever.write_text("[[rotor]]".join(rotors[:2]).replace('"quadrotor"', '"lever"'))
    assert "make no force without a moment at any tilt" in refused(capsys, str(lever))


def test_a_tilt_goes_with_a_vehicle(run_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--tilt goes with a vehicle" in refused(capsys, str(run_file), "--tilt", "3")
    assert "--out goes with a vehicle" in refused(capsys, str(run_file), "--out", "designs")


def test_a_moment_after_the_end(run_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    still = ("--snapshot", str(run_file.parent / "t.png"), "--at", "1e6")
    assert "from 0 to" in refused(capsys, str(run_file), *still)


@pytest.mark.parametrize(("option", "needed"), [("--at", "--snapshot"), ("--speed", "--video")])
def test_an_option_that_would_do_nothing(
    option: str, needed: str, run_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refused(capsys, str(run_file), option, "1")
    assert f"{option} goes with {needed}, which is not given" in said


@pytest.mark.parametrize("option", [("--port", "0"), ("--host", "127.0.0.1"), ("--out", "designs")])
def test_a_page_that_is_not_there_has_no_address(
    option: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refused(capsys, "omnimorph", "--snapshot", str(tmp_path / "t.png"), *option)
    assert said.startswith(f"omnimorph: the command line: {option[0]} is ")
    assert said.endswith("a picture is drawn instead.\n")
    if option[0] != "--out":
        assert main(["fly", "hover", *option, "--out", str(tmp_path / "flight")]) == 2
        assert "there is none without --view" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_picture_says_which_flight_had_ended() -> None:
    flights = [SimpleNamespace(name="short", duration=2.0), SimpleNamespace(name="b", duration=5.0)]
    assert _ended_before(flights[1:], 5.0) == ""  # type: ignore[arg-type]
    assert _ended_before(flights, 2.0) == ""  # type: ignore[arg-type]
    assert _ended_before(flights, 3.0) == (  # type: ignore[arg-type]
        "the picture is of 3 s; it shows the last moment of short at 2 s."
    )


def test_a_picture_is_of_the_moment_asked_for_or_of_the_middle() -> None:
    flights = [SimpleNamespace(duration=2.0), SimpleNamespace(duration=5.0)]
    assert _moment(flights, None) == 2.5  # type: ignore[arg-type]
    assert _moment(flights, 0.0) == 0.0  # type: ignore[arg-type]


def test_others_are_warned_of(capsys: pytest.CaptureFixture[str]) -> None:
    server = SimpleNamespace(get_port=lambda: 4321, guard=SimpleNamespace(token="secret"))
    hosts = {"127.0.0.1": False, "192.0.2.1": True, "127.evil.example": True, "0.0.0.0": True}
    for host, warned in hosts.items():
        options = argparse.Namespace(host=host, no_browser=True)
        announce(server, options, "Ctrl-C ends it")
        said = capsys.readouterr().err
        assert ("can see and steer the page" in said) == warned
        shown = "127.0.0.1" if host == "0.0.0.0" else host  # every address is this machine's, too
        assert f"http://{shown}:4321/secret/ " in said
