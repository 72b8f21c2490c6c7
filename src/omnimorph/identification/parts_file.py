"""Parts of a vehicle from a TOML file, for its inertia.

::

    [[part]]
    kind = "box"                          # or "cylinder", "point"
    mass_kg = 0.45
    size_m = [0.12, 0.08, 0.03]
    position_m = [0.0, 0.0, 0.01]         # of its centre; the origin if left out
    orientation_deg = [0.0, 0.0, 45.0]    # roll, pitch, yaw; none if left out
    name = "battery"                      # for you
"""

from __future__ import annotations

import os
from functools import cache, reduce
from operator import or_
from typing import Annotated, Any, Literal

from omnimorph.design.documents import check_document, parse_toml
from omnimorph.design.input_files import read_text
from omnimorph.errors import InputError
from omnimorph.identification.inertia import PARTS, Part

__all__ = ["load_parts"]


def load_parts(path: str | os.PathLike[str]) -> list[Part]:
    """Load the parts of a TOML file.

    Parameters
    ----------
    path : str or path
        A file of ``[[part]]`` tables, see the head of this module.

    Returns
    -------
    list of Box, Cylinder or PointMass
        In SI, in the order of the file.

    Raises
    ------
    InputError
        If the file cannot be read, or a key or value in it cannot be used: one sentence with the
        file, the key, the value and what is allowed.
    """
    text, file = read_text(path, InputError), os.fsdecode(path)
    document = parse_toml(text, file, InputError)
    content = check_document(_file_model(), document, file, InputError)
    kinds = {kind.kind: kind for kind in PARTS}
    parts = []
    for index, table in enumerate(content.part):
        try:
            parts.append(kinds[table.kind].from_file(table))
        except InputError as refused:
            raise InputError(f"{file}: part[{index}], a {refused}", file=file) from None
    return parts


@cache
def _file_model() -> Any:
    from pydantic import ConfigDict, Field, create_model

    from omnimorph.design.tables import file_model

    text = (str | None, Field(default=None, description="text"))
    tables = []
    for kind in PARTS:
        word: Any = Literal[kind.kind]
        tables.append(file_model(kind, kind=(word, ...), name=text))
    one_of: Any = Annotated[reduce(or_, tables), Field(discriminator="kind")]
    parts = Field(min_length=1, description="tables, written [[part]], one or more")
    settings = ConfigDict(extra="forbid", strict=True)
    return create_model("PartsFile", __config__=settings, part=(list[one_of], parts))
