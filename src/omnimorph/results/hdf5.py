"""What HDF5 is given and gives: files, attributes and arrays as every netCDF tool reads them."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np

_LONGEST_FIXED_TEXT = 32_000  # bytes; HDF5 keeps no more than 64 KiB beside an object


class OutputFile(io.FileIO):
    """A file whose first failure to write is kept, and hidden from HDF5.

    HDF5 cannot close a file it cannot write to, and then fails again when the process ends. So it
    hears that all went well, and the reason comes out clean: `failure`.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(os.fspath(path), "w+")
        self.failure: BaseException | None = None

    def write(self, data: Any) -> int:
        """Write, and say that all was written."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while self.failure is None and done < len(view):
                done += super().write(view[done:])
        except BaseException as error:  # HDF5 would lose an interrupt, too
            self.failure = error
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Set the length, and say that it was set."""
        try:
            if self.failure is None:
                return super().truncate(size)
        except BaseException as error:
            self.failure = error
        return size or 0


def plain(value: Any) -> Any:
    """Return an attribute as plain text or number; netCDF keeps a number as a list of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value[0] if value.ndim else value[()]
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if isinstance(value, np.generic) else value


def stored(values: Any) -> Any:
    """Return an array as it is stored: row by row, little-endian; itself if it already is."""
    return np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))


def fixed_text(text: str) -> Any:
    """Return text as an attribute keeps it: of fixed length, which every netCDF tool reads.

    Only a text too long for that goes to the heap of HDF5.
    """
    import h5py

    data = text.encode("utf-8")
    if len(data) > _LONGEST_FIXED_TEXT:
        return text
    return np.array(data, dtype=h5py.string_dtype("utf-8", max(len(data), 1)))
