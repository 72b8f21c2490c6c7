"""Any input may be a pipe, a device, a folder or a name that no file has: reported, and no hang."""

from __future__ import annotations

import json
import os
import signal
import socket
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

import pytest

import omnimorph as om
from omnimorph.cli.main import main
from omnimorph.design import vehicle_text
from omnimorph.design.input_files import MEGABYTE
from omnimorph.reference.samples import SampledReference
from omnimorph.studies.flight_log import FlightLog

COMMANDS = [
    ["vehicles", "{}"],
    ["analyze", "{}"],
    ["gains", "{}"],
    ["compare", "{}"],
    ["scenarios", "{}"],
    ["fly", "{}"],
    ["fly", "hover", "--vehicle", "{}"],
    ["fly", "hover", "--plant", "{}"],
    ["fly", "names-vehicle.toml"],
    ["fly", "names-plant.toml"],
    ["fly", "names-base.toml"],
    ["fly", "names-poses.toml"],
    ["fit", "{}"],
    ["fit", "good.csv", "--like", "{}"],
    ["inertia", "{}"],
    ["view", "{}.nc"],
]
BAD = {
    "pipe.toml": "a pipe, a socket or a device",
    "socket.toml": "a pipe, a socket or a device",
    "/dev/zero": "a pipe, a socket or a device",
    "folder.toml": "it is a directory",
    "x" * 300 + ".toml": "file name too long",
    "a/" * 3000 + ".toml": "file name too long",
    "missing.toml": "there is no such file",
    "large.toml": "",
}
NAMES = {
    "names-vehicle.toml": 'schema = 1\nname = "a"\nbase = "hover"\nvehicle = "{}"\n',
    "names-plant.toml": 'schema = 1\nname = "a"\nbase = "hover"\nplant = "{}"\n',
    "names-base.toml": 'schema = 1\nname = "a"\nbase = "{}"\n',
    "names-poses.toml": 'schema = 1\nname = "a"\nbase = "hover"\n[reference]\nkind = "samples"\n'
    'file = "{}"\n',
}


@pytest.fixture(autouse=True)
def no_hang() -> Iterator[None]:
    """Fail what waits for ever."""

    def ring(number: int, frame: FrameType | None) -> None:
        raise TimeoutError("it waits")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Go to a folder with one of each."""
    monkeypatch.chdir(tmp_path)
    for end in ("", ".nc"):
        os.mkfifo(f"pipe.toml{end}")
        Path(f"folder.toml{end}", "run.nc").mkdir(parents=True)  # a folder in place of a run
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind(f"socket.toml{end}")
        with open(f"large.toml{end}", "wb") as file:
            file.truncate(100 * MEGABYTE)
    rows = [
        f"{k},{20 + 2 * k},{(20 + 2 * k) ** 2 * 1e-4},{(20 + 2 * k) ** 2 * 1e-6}" for k in range(30)
    ]
    Path("good.csv").write_text("\n".join(["time_s,speed_Hz,force_N,torque_Nm", *rows]))
    return tmp_path


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_what_is_no_file_is_reported(
    folder: Path, words: list[str], name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for file, text in NAMES.items():
        Path(file).write_text(text.format(name), encoding="utf-8")
    code = main([word.format(name) for word in words])
    said = capsys.readouterr()
    assert (code, said.out) == (2, "")
    (line,) = said.err.splitlines()
    assert len(line) < 1600
    if name != "/dev/zero" or words[0] != "view":  # /dev/zero.nc is not there
        assert BAD[name] in line
    assert not Path("runs").exists()


@pytest.mark.parametrize(
    "words",
    [
        ["analyze", "{}.toml", "--out", "{}"],
        ["compare", "{}.toml", "--out", "{}"],
        ["fit", "{}.csv", "--out", "{}"],
        ["fly", "{}-scenario.toml", "--vehicle", "{}.toml", "--out", "{}"],
    ],
    ids=" ".join,
)
def test_names_that_are_no_text_are_as_good_as_others(
    folder: Path, words: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    name = os.fsdecode(b"\xff\xfe")
    Path("good.csv").rename(f"{name}.csv")
    Path(f"{name}.toml").write_text(vehicle_text(om.load_vehicle("quadrotor")))
    Path(f"{name}-scenario.toml").write_text('schema = 1\nname = "a"\nbase = "tour"\n')
    assert main([*(word.format(name) for word in words), "--json"]) == 0
    json.loads(capfd.readouterr().out)
    for file in Path(name).rglob("*.json"):
        json.loads(file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ["pipe.toml", "folder.toml", "/dev/zero", "a\0b.toml", 3, None])
def test_python_tells_the_same(folder: Path, name: str) -> None:
    for read in (
        om.load_vehicle,
        om.load_scenario,
        om.load_plant,
        om.load_run,
        om.identification.load_parts,
        om.identification.read_bench,
        SampledReference.from_csv,
    ):
        with pytest.raises(om.InputError) as caught:
            read(name)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize("name", ["a\0b.nc", 3, None, "x" * 300, "folder.toml", "pipe.toml"])
def test_a_run_is_written_to_no_such_thing(folder: Path, name: str) -> None:
    before = sorted(folder.rglob("*"))
    flight = om.SteppedFlight("hover")
    flight.step()
    with pytest.raises(om.InputError, match="it cannot be written"):
        flight.as_run().save(name)
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("name", ["flights.jsonl", "results.json"])
def test_a_pipe_in_the_folder_of_a_study(
    folder: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("out").mkdir()
    os.mkfifo(Path("out", name))
    assert main(["reproduce", "--out", "out"]) == 2
    assert "not one of ours" in capsys.readouterr().err
    with pytest.raises(om.InputError, match="a pipe, a socket or a device"):
        FlightLog(Path("out", name))


def test_an_older_result_nested_without_end(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("out").mkdir()
    Path("out", "results.json").write_text("[" * 100_000)
    assert main(["reproduce", "--out", "out"]) == 2
    assert "not one of ours" in capsys.readouterr().err


def test_a_table_has_a_most_of_rows(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    header, *rows = Path("good.csv").read_text().splitlines()
    Path("long.csv").write_text("\n".join([header, *(rows * 20_000)]))
    assert main(["fit", "long.csv"]) == 2
    assert "long.csv: it holds more than 500000 rows." in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "size", "most"), [("big.toml", MEGABYTE, "1 MB"), ("big.csv", 32 * MEGABYTE, "32 MB")]
)
def test_text_has_a_largest_size(
    folder: Path, name: str, size: int, most: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(name).write_text("#" * (size + 1))
    assert main(["fit" if name.endswith("csv") else "analyze", name]) == 2
    assert f"{name}: this file cannot be read, because it is larger than {most}." in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 3000 + "]" * 3000,
        "a = " + "{b = " * 3000 + "1" + "}" * 3000,
        ".".join("a" * 3000) + " = 1",
        f"[sources{'.a' * 3000}]\nb = 1",
        f"[{'.'.join(['controller'] * 3000)}]\nproposed = true",
        "[[part]]\n" + ".".join("a" * 3000) + " = 1",
        "mass_kg = " + "[" * 25 + "]" * 25,
        ".".join("a" * 400_000) + " = 1",  # would take the parser hours
    ],
)
def test_keys_nested_too_deeply(
    folder: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("deep.toml").write_text(f"{text}\n")
    for words in (["vehicles"], ["fly"], ["inertia"], ["fly", "hover", "--plant"]):
        assert main([*words, "deep.toml"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line == "omnimorph: deep.toml: this file is not valid TOML: Nested too deeply."


@pytest.mark.parametrize(
    "text",
    [
        f'name = "{"x" * 900_000}"',
        f"mass_kg = [{'1.0, ' * 100_000}]",
        f"{'k' * 900_000} = 1",
        'name = "\\u001b[31mred\\u001b[0m\\r\\n\\u0007"\nschema = 1\ntitle = 3',
        '"\\u001b[31m" = 1',
        f"schema = {'9' * 4000}",
    ],
)
def test_messages_are_short_and_harmless(
    folder: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("\x1b[1mbad.toml").write_text(f"{text}\n", encoding="utf-8")
    for words in (["vehicles"], ["fly"], ["inertia"], ["fly", "hover", "--plant"]):
        assert main([*words, "./\x1b[1mbad.toml"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.isprintable()
        assert len(line) < 1600
