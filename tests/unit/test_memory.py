"""What needs more memory than there is, is refused before any of it is taken.

The doors are tried in processes of their own, which may have a gigabyte more than they hold.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.forked import Forked

from omnimorph.machine.memory import available_bytes

GB = 10**9

# --- how much there is ----------------------------------------------------------------------------


def write(root: Path, files: dict[str, str]) -> Path:
    """Write small files into folders that are made for them."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


MACHINE = {
    "proc/meminfo": f"MemTotal: {9 * 10**6} kB\nMemAvailable: {8 * 10**6} kB\nHugePages: 0\n"
}


def group(folder: str, limit: str, used: int, cached: int) -> dict[str, str]:
    """Return the files of a group of version 2."""
    return {
        f"sys/fs/cgroup/{folder}memory.max": f"{limit}\n",
        f"sys/fs/cgroup/{folder}memory.current": f"{used}\n",
        f"sys/fs/cgroup/{folder}memory.stat": f"anon 1\ninactive_file {cached}\n",
    }


def old_group(folder: str, limit: int, used: int, cached: int) -> dict[str, str]:
    """Return the files of a group of version 1."""
    return {
        f"sys/fs/cgroup/memory/{folder}memory.limit_in_bytes": f"{limit}\n",
        f"sys/fs/cgroup/memory/{folder}memory.usage_in_bytes": f"{used}\n",
        f"sys/fs/cgroup/memory/{folder}memory.stat": f"cache 7\ntotal_inactive_file {cached}\n",
    }


V2, V1 = "0::/a/b\n", "5:cpu:/\n4:cpuset,memory:/a/b\n0::/\n"


@pytest.mark.parametrize(
    ("files", "free"),
    [
        ({}, 8192 * 10**6),
        ({"proc/self/cgroup": V2} | group("a/b/", "max", GB, 0), 8192 * 10**6),
        ({"proc/self/cgroup": V2} | group("a/b/", str(3 * GB), GB, 0), 2 * GB),
        ({"proc/self/cgroup": V2} | group("a/b/", str(3 * GB), 3 * GB, GB // 2), GB // 2),
        ({"proc/self/cgroup": V2} | group("a/b/", str(GB), 2 * GB, 0), 0),
        (
            {"proc/self/cgroup": V2}
            | group("a/b/", str(6 * GB), GB, 0)
            | group("a/", str(5 * GB), 2 * GB, 0),
            3 * GB,
        ),
        # a container that does not see where it is: its own group is the root it sees
        ({"proc/self/cgroup": V2} | group("", str(4 * GB), GB, 0), 3 * GB),
        ({"proc/self/cgroup": V1} | old_group("a/b/", 3 * GB, GB, GB // 2), 5 * GB // 2),
        ({"proc/self/cgroup": V1} | old_group("a/", 2 * GB, GB, 0), GB),
        ({"proc/self/cgroup": V1} | old_group("", 2**63 - 4096, GB, 0), 8192 * 10**6),
        ({"proc/self/cgroup": "not a line of it\n"}, 8192 * 10**6),
    ],
)
def test_the_least_of_machine_and_groups_counts(
    tmp_path: Path, files: dict[str, str], free: int
) -> None:
    assert available_bytes(write(tmp_path, MACHINE | files)) == free


def test_without_proc_there_is_what_the_machine_has(tmp_path: Path) -> None:
    assert available_bytes(tmp_path) > 0


# --- the doors ------------------------------------------------------------------------------------

_FLOWN = """
import os, resource
from dataclasses import replace
from pathlib import Path
import h5py, numpy as np
import omnimorph as om
from omnimorph.errors import TooLargeError
from omnimorph.reference.samples import SampledReference
from omnimorph.reference.segments import Segment, SegmentReference

def lasting(seconds):
    reference = SegmentReference(np.zeros(3), np.eye(3), (Segment(seconds),))
    return replace(om.load_scenario("paper-case-a"), reference=reference)

def peak():  # not ru_maxrss, which begins with what the parent held
    lines = dict(line.split(":") for line in open("/proc/self/status"))
    return int(lines["VmHWM"].split()[0]) / 1024

om.fly(om.load_scenario("hover"))
om.fly_many(om.load_scenario("hover"), 1)
"""

_LIMIT = """
pages = int(open("/proc/self/statm").read().split()[0])
most = pages * os.sysconf("SC_PAGE_SIZE") + 10**9
resource.setrlimit(resource.RLIMIT_AS, (most, most))
before = peak()
"""


Limited = Callable[[str], list[str]]


@pytest.fixture(scope="module")
def forked() -> Iterator[Forked]:
    """What has flown, so that what a door takes is not hidden by what a first flight takes."""
    process = Forked(_FLOWN, dict(os.environ))
    yield process
    process.close()


@pytest.fixture
def limited(forked: Forked, tmp_path: Path) -> Limited:
    """Run a program that may have a gigabyte; return the lines it prints."""

    def run(program: str) -> list[str]:
        done = forked.run(_LIMIT + program, tmp_path)
        assert done.returncode == 0, done.stderr[-2000:]
        return done.stdout.splitlines()

    return run


DOORS = {
    "fly": "om.fly(lasting(60_000.0))",
    "fly, sampled": """
poses = SampledReference([0.0, 60_000.0], np.zeros((2, 3)))
om.fly(lasting(1.0), reference=poses)""",
    "fly, asked": """
class Asked:
    duration = 60_000.0
    def __call__(self, time):
        raise AssertionError("it was asked")
asked = Asked()
plain = lasting(1.0)
object.__setattr__(plain, "reference", asked)
om.fly(plain)""",
    "stepped": "om.SteppedFlight(lasting(60_000.0))",
    "many": "om.fly_many(lasting(1.0), 4_000_000_000)",
    "many, varied": "om.fly_many(lasting(1.0), 1_200_000, vary={'force': om.Normal(0.0, 1.0)})",
    "many, all kept": "om.fly_many(lasting(1.0), 1_000_000, keep='all')",
    "many, some kept": "om.fly_many(lasting(1.0), 1_000_000, keep=range(100_000))",
    "many, most of them kept": "om.fly_many(lasting(1.0), 4_000_000_000, keep='all')",
    "stand": """
vehicle = om.load_vehicle("omnimorph")
profile = om.speed_steps(vehicle, 4, dwell=1e4)
om.ThrustStand(vehicle=vehicle, rotor=4, tilt=0.0).measure(profile)""",
    "noise": """
from omnimorph.simulation.fly import measurement_noise
measurement_noise(0, 0, 10**9)""",
    "directions": """
from omnimorph.analysis.hover import sphere_directions
sphere_directions(10**9)""",
    "hover map": """
from omnimorph.analysis.hover import hover_map, sphere_directions
hover_map(om.load_vehicle("omnimorph"), sphere_directions(20_000), np.zeros(20_000))""",
    "poses": """
Path("poses.csv").write_text("0" * 30_000_000)
resource.setrlimit(resource.RLIMIT_AS, (most - 8 * 10**8, most))
SampledReference.from_csv("poses.csv")""",
    "reproduction": """
from omnimorph.studies.reproduction import Plan, reproduce
reproduce(Path("out"), Plan.whole(0, 10**8))""",
    "reproduction of all seeds": """
from omnimorph.studies.reproduction import Plan, reproduce
reproduce(Path("out"), Plan.quickly(0, 2**64 - 1))""",
    "a job of a study": """
from omnimorph.studies.flight_log import FlightLog
from omnimorph.studies.many_flights import Job, fly_jobs
with FlightLog(Path("flights.jsonl")) as log:
    try:
        fly_jobs([Job(lasting(60_000.0), 0)], log)
    finally:
        assert len(log) == 0, "that it is too large here is no answer"
""",
    "video": """
from omnimorph.viewer.pictures import check_length
check_length(Path("long.mp4"), 10**6, 960, 720)
check_length(Path("long.gif"), 10**6, 960, 720)""",
    "shown": """
from dataclasses import fields
from omnimorph.results.run import COLUMNS
from omnimorph.viewer.frames import Flight
short = om.fly(lasting(1.0))
names = ("time", *(column.name for column in COLUMNS))
long = {name: np.broadcast_to(getattr(short, name)[:1], (10**7, *getattr(short, name).shape[1:]))
        for name in names}
Flight(replace(short, **long), "a long one")""",
    "a stored run": """
from omnimorph.results.run import COLUMNS
om.fly(lasting(0.1)).save("run.nc")
rows, chunk = 10**7, 10**5
with h5py.File("run.nc") as old, h5py.File("large.nc", "w") as file:
    file.attrs.update(old.attrs)
    file["servo"] = ["tilt"]
    for name in ("time", *(column.name for column in COLUMNS)):
        shape, kind = old[name].shape[1:], old[name].dtype
        chunks = (chunk, *shape)
        data = file.create_dataset(name, (rows, *shape), kind, chunks=chunks, compression=1)
        data[:chunk] = 0
        packed = data.id.read_direct_chunk((0,) * len(data.shape))[1]
        for start in range(chunk, rows, chunk):
            data.id.write_direct_chunk((start, *(0 for _ in shape)), packed)
before = peak()
om.load_run("large.nc")""",
}


@pytest.mark.parametrize("door", DOORS)
def test_a_door_refuses_before_it_takes(door: str, limited: Limited) -> None:
    program = "\n".join(f"    {line}" for line in DOORS[door].strip().splitlines())
    reported = limited(
        f"try:\n{program}\nexcept TooLargeError as refused:\n"
        "    print(refused)\n    print(peak() - before)\n"
    )
    message, megabytes = reported
    size = r"[\d.e+]+ [MGT]B"
    assert re.search(rf"need about {size} of memory, but {size} are free; .*\.$", message)
    assert float(megabytes) < 100.0


def test_the_estimate_is_what_a_flight_takes(limited: Limited) -> None:
    reported = limited(
        "from omnimorph.simulation.recording import bytes_of_flights\n"
        "scenario = lasting(300.0)\n"
        "before = peak()\n"
        "om.fly(scenario).metrics\n"
        "print(peak() - before, bytes_of_flights(scenario, 1) / 2**20)\n"
    )
    took, estimated = map(float, reported[0].split())
    assert 0.9 * took < estimated < 1.3 * took


def test_what_fits_is_flown_under_the_same_limit(limited: Limited) -> None:
    reported = limited("print(om.fly_many(lasting(10.0), 8, keep='all').completed.all())")
    assert reported == ["True"]


@pytest.mark.parametrize(
    "options",
    ["", "chunks=(4096, *shape), compression=1", "chunks=(4096, *shape), fletcher32=True"],
)
@pytest.mark.parametrize("rows", [7 * 10**8, 10**6])
def test_a_run_file_that_claims_more_than_it_holds(
    options: str, rows: int, limited: Limited
) -> None:
    """HDF5 makes numbers up where none were written; a file of a few kB can claim terabytes."""
    message, megabytes = limited(
        f"""
from omnimorph.errors import RunFileError
from omnimorph.results.run import COLUMNS
om.fly(lasting(0.1)).save("run.nc")
rows = {rows}
with h5py.File("run.nc") as old, h5py.File("claims.nc", "w") as file:
    file.attrs.update(old.attrs)
    file["servo"] = ["tilt"]
    for name in ("time", *(column.name for column in COLUMNS)):
        shape, kind = old[name].shape[1:], old[name].dtype
        file.create_dataset(name, (rows, *shape), kind, {options})
assert os.path.getsize("claims.nc") < 10**6
before = peak()
try:
    om.load_run("claims.nc")
except RunFileError as refused:
    print(refused)
    print(peak() - before)
"""
    )
    reported = (
        "claims.nc: the run cannot be read: it is cut off or damaged (it does not hold all of "
    )
    assert message == f"{reported}time)."
    assert float(megabytes) < 20.0


def test_the_command_line_tells_it_in_one_line(tmp_path: Path) -> None:
    scenario = 'schema = 1\nname = "long"\nbase = "hover"\n[reference]\nkind = "segments"\n'
    scenario += "[[reference.segment]]\nduration_s = 60000.0\n"
    (tmp_path / "long.toml").write_text(scenario)
    command = "ulimit -v 6000000; exec $0 -m omnimorph fly long.toml"
    done = subprocess.run(
        ["bash", "-c", command, sys.executable], cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(
        r"omnimorph: long: the 60000001 rows of the flight need about [\d.]+ GB of memory, but "
        r"[\d.]+ GB are free; fly for less time or with longer physics steps\.\n",
        done.stderr,
    )
    assert [path.name for path in tmp_path.iterdir()] == ["long.toml"]
