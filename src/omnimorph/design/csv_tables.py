"""CSV files of numbers, their columns named in the first line: read, or refused in one sentence."""

from __future__ import annotations

import csv
import io
import math
from array import array
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from omnimorph.design.input_files import MEGABYTE, read_text
from omnimorph.design.ranges import Range
from omnimorph.errors import InputError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.protocols import FloatArray

MOST_ROWS = 500_000
_LARGEST = 32 * MEGABYTE
_BYTES_OF_A_CHARACTER = 12  # at "1," a number takes 8, and its row a line number and more


class CsvTable(NamedTuple):
    """What a CSV file holds."""

    columns: list[str]  # their names, C of them
    rows: FloatArray  # (K, C) finite numbers
    lines: list[int]  # on which line of the file each row ends, counted from 1


def read_csv_table(
    path: str | Path,
    check_columns: Callable[[list[str]], None],
    limits: Mapping[str, Range],
    error: type[InputError],
) -> CsvTable:
    """Read a CSV file, of at most 32 MB, whose first line names its columns; skip empty lines.

    `check_columns` refuses names that cannot be used; `limits` are those of the numbers in each
    column, in its unit. Raises `error`, with file, line and column, if the file cannot be read, a
    column is there twice, a line holds another number of values than the first, or a value is no
    number within its range.
    """
    numbers = array("d")  # a list of lists would take ten times the memory
    lines: list[int] = []
    text = read_text(path, error, _LARGEST)
    refuse_more_than_memory(
        f"{path}: its numbers", len(text) * _BYTES_OF_A_CHARACTER, "give fewer rows"
    )
    reader = csv.reader(io.StringIO(text, newline=""))
    try:
        columns = [text.strip() for text in next(reader, [])]
        check_columns(columns)
        _check_once(path, columns, error)
        for texts in reader:
            if any(text.strip() for text in texts):
                numbers.extend(_numbers(path, reader.line_num, columns, texts, limits, error))
                lines.append(reader.line_num)
                if len(lines) > MOST_ROWS:
                    raise error(f"{path}: it holds more than {MOST_ROWS} rows.", file=str(path))
    except csv.Error as problem:
        raise error(f"{path}: it is not a CSV text file: {problem}.") from problem
    return CsvTable(columns, np.array(numbers).reshape(len(lines), len(columns)), lines)


def _check_once(path: str | Path, columns: Sequence[str], error: type[InputError]) -> None:
    for position, name in enumerate(columns):
        if name in columns[:position]:
            raise error(f"{path}: line 1, column {name} is there twice, but must be once.")


def _numbers(
    path: str | Path,
    line: int,
    columns: Sequence[str],
    texts: Sequence[str],
    limits: Mapping[str, Range],
    error: type[InputError],
) -> list[float]:
    if len(texts) != len(columns):
        allowed = f"{len(columns)}, as in the header"
        raise error.at(path, f"line {line}, number of values", len(texts), allowed)
    numbers = []
    for name, text in zip(columns, texts, strict=True):
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not limits[name].least <= number <= limits[name].most:
            key = f"line {line}, column {name}"
            raise error.at(path, key, text.strip(), f"a finite number {limits[name]}")
        numbers.append(number)
    return numbers
