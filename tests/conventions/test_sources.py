"""Every number of the catalogue says where it comes from: document and place, or it is assumed."""

from __future__ import annotations

import importlib
import re

import pytest

import omnimorph as om
from omnimorph.design import Source

REPOSITORY = r"\b[\w.-]+/[\w.-]+ (@ [0-9a-f]{7,40}|\(commit not recorded\)), (?=[^,;]*[./])\S+"
MENTIONS_REPOSITORY = r"@|github|gitlab|\brepositor|\bmodel files\b|\bsimulation models\b"
DOCUMENT = r"doi 10\.\d{4,}/[\w./-]+|arXiv \d{4}\.\d{4,5}"
PLACE = r"Sec\. '[^']+'|\beqs?\. \(\d+\)|\babstract\b"
COMPUTED = r"^Computed by (omnimorph\.[\w.]+\w)"

ENTRIES = [
    pytest.param(source, id=f"{name}-{attribute}")
    for name in om.list_vehicles()
    for attribute, source in om.load_vehicle(name).sources.items()
]


def fault(source: Source) -> str:
    """Return what is wrong with how a source is named; nothing if it can be looked up."""
    text = source.text
    for mention in re.finditer(MENTIONS_REPOSITORY, text, re.IGNORECASE):
        named = [found.span() for found in re.finditer(REPOSITORY, text)]
        if not any(begin <= mention.start() < end for begin, end in named):
            return "a repository without owner/name, commit and path"
    computed = re.search(COMPUTED, text)
    if computed:
        importlib.import_module(computed[1])
    in_document = re.search(DOCUMENT, text) and re.search(PLACE, text)
    if source.assumed or computed or in_document or re.search(REPOSITORY, text):
        return ""
    return "neither assumed, nor a document with its place, nor a file of a repository"


@pytest.mark.parametrize("source", ENTRIES)
def test_a_source_can_be_looked_up_or_is_assumed(source: Source) -> None:
    assert fault(source) == ""


@pytest.mark.parametrize(
    "text",
    [
        "The public model files.",
        "Kamel et al., The Voliro Omniorientational Hexacopter, 2018.",
        "Aboudorra et al., JIRS 2024, doi 10.1007/s10846-024-02054-x.",
        "someone/vehicles @ main, models/one.sdf",
        "someone/vehicles @ 9217ea3",
        "someone/vehicles, models/one.sdf",
        "Parallel rotors, by definition.",
    ],
)
def test_a_vague_source_is_noticed(text: str) -> None:
    assert fault(Source(text, assumed=False)) != ""


def test_sources_in_either_form_pass() -> None:
    for text in (
        "someone/vehicles @ 9217ea3, models/one.sdf: two motors.",
        "someone/vehicles (commit not recorded), models/one.sdf.",
        "Someone et al., doi 10.1007/s10846-024-02054-x, Sec. 'Simulations'.",
        "Someone et al., arXiv 2004.06612, abstract.",
    ):
        assert fault(Source(text, assumed=False)) == ""
    assert fault(Source("A guess.", assumed=True)) == ""
