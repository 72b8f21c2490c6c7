"""What a killed process was writing is removed by the next that writes there; nothing else is."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from omnimorph.results.atomic import replacing, write_text
from omnimorph.results.folder import staged

_A_FILE = """
from pathlib import Path
from omnimorph.results.atomic import replacing
with replacing("result.txt") as temporary:
    temporary.write_text("half")
    print("writing", flush=True)
    input()
    temporary.write_text("whole")
"""
_A_FOLDER = """
from pathlib import Path
from omnimorph.results.folder import staged
with staged(Path(".")) as part:
    (part / "result.txt").write_text("half")
    print("writing", flush=True)
    input()
    (part / "result.txt").write_text("whole")
"""
WRITERS = pytest.mark.parametrize("program", [_A_FILE, _A_FOLDER], ids=["file", "folder"])


@contextmanager
def writing(program: str, folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Run a writer until it is in the middle of its file."""
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "writing\n"
            yield process
        finally:
            process.kill()


def names(folder: Path) -> list[str]:
    """Return what is in a folder."""
    return sorted(path.name for path in folder.iterdir())


def write_next(folder: Path, program: str) -> None:
    """Write as a process of its own does, which looks for what was left."""
    done = program.replace("input()", "pass")
    subprocess.run([sys.executable, "-c", done], cwd=folder, check=True, capture_output=True)


@WRITERS
@pytest.mark.parametrize("next_program", [_A_FILE, _A_FOLDER], ids=["file", "folder"])
def test_the_next_writer_removes_what_a_killed_one_left(
    tmp_path: Path, program: str, next_program: str
) -> None:
    with ExitStack() as killed_at_the_end:
        for _ in range(3):
            killed_at_the_end.enter_context(writing(program, tmp_path))
    assert len(names(tmp_path)) == 3
    write_next(tmp_path, next_program)
    assert names(tmp_path) == ["result.txt"]
    assert (tmp_path / "result.txt").read_text() == "whole"


@WRITERS
def test_who_still_writes_is_left_alone(tmp_path: Path, program: str) -> None:
    with writing(program, tmp_path) as process:
        write_next(tmp_path, _A_FILE)
        (tmp_path / "result.txt").unlink()
        assert len(names(tmp_path)) == 1
        _, _ = process.communicate("\n")
        assert process.returncode == 0
    assert names(tmp_path) == ["result.txt"]
    assert (tmp_path / "result.txt").read_text() == "whole"


def test_foreign_files_stay(tmp_path: Path) -> None:
    """Another name, another kind of file, and links to what is elsewhere."""
    kept = tmp_path / "kept.txt"
    kept.write_text("mine")
    for name in (".omnimorph-mine.part", ".omnimorph-0123456789ab.part.txt", "0123456789ab.part"):
        (tmp_path / name).write_text("mine")
    os.mkfifo(tmp_path / ".omnimorph-00000000000f.part")
    (tmp_path / ".omnimorph-00000000000e.part").symlink_to(kept)
    before = names(tmp_path)
    write_next(tmp_path, _A_FILE)
    assert names(tmp_path) == sorted([*before, "result.txt"])
    assert kept.read_text() == "mine"


def test_nested_writers_do_not_share_a_temporary_name(tmp_path: Path) -> None:
    with replacing(tmp_path / "a") as outer:
        outer.write_text("outer")
        write_text(tmp_path / "b", "inner")
        with staged(tmp_path) as part:
            write_text(part / "c", "staged")
    assert {name: (tmp_path / name).read_text() for name in names(tmp_path)} == {
        "a": "outer",
        "b": "inner",
        "c": "staged",
    }


def test_threads_that_write_into_one_folder(tmp_path: Path) -> None:
    together = threading.Barrier(8)

    def write(name: str) -> None:
        for k in range(20):
            with replacing(tmp_path / name) as temporary:
                together.wait(timeout=60)
                temporary.write_text(f"{name} {k}")
                together.wait(timeout=60)

    threads = [threading.Thread(target=write, args=(name,)) for name in "abcdefgh"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert names(tmp_path) == list("abcdefgh")
    assert [(tmp_path / name).read_text() for name in "abcdefgh"] == [f"{n} 19" for n in "abcdefgh"]


def test_two_processes_write_one_file(tmp_path: Path) -> None:
    """Both write it whole; the one that is done last wins, and neither removes the other's."""
    with ExitStack() as stack:
        both = [stack.enter_context(writing(_A_FILE, tmp_path)) for _ in range(2)]
        assert len(names(tmp_path)) == 2
        for process in both:
            process.communicate("\n")
            assert process.returncode == 0
            assert (tmp_path / "result.txt").read_text() == "whole"
    assert names(tmp_path) == ["result.txt"]
