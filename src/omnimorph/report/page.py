"""The page: a template filled with texts, tables and figures, as one file that needs no other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from omnimorph.report.tables import number

if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True)
class Picture:
    """A figure on a page.

    Attributes
    ----------
    svg : str
        The SVG element.
    title : str
        What it shows, for those who cannot see it.
    """

    svg: str
    title: str


def render_page(template: str, **content: Any) -> str:
    """Return a page as HTML: one file, no links to be followed, no script.

    Parameters
    ----------
    template : str
        Name of a file in ``report/templates``.
    content
        What the template asks for; text in it is escaped.
    """
    return templates_of().get_template(template).render(**content)


def templates_of(*packages: str) -> Environment:
    """Return the templates of packages, beside those here; text put into HTML is escaped."""
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, select_autoescape

    environment = Environment(
        loader=ChoiceLoader([PackageLoader(name) for name in (__package__, *packages)]),
        autoescape=select_autoescape(["html.j2"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number
    return environment
