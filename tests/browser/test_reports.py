"""Reports on a desk and on a phone: nothing is cut without need, and never without a sign."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser
from tests.browser.conftest import DESKTOP, PHONE, opened
from tests.browser.layout import faults_of, layout_of, repeated
from tests.cli.test_fit_and_inertia import write_bench

from omnimorph.cli.main import main
from omnimorph.report.page import Picture, render_page
from omnimorph.report.tables import Table

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The pages that commands write; that of `reproduce` is looked at where it is made."""
    folder = tmp_path_factory.mktemp("reports")
    write_bench(folder / "bench.csv")
    commands = {
        "omnimorph": ("analyze", "omnimorph", "analysis.html"),
        "voliro": ("analyze", "voliro", "analysis.html"),
        "quadrotor": ("analyze", "quadrotor", "analysis.html"),
        "comparison": ("compare", "omnimorph", "voliro", "comparison.html"),
        "fit": ("fit", str(folder / "bench.csv"), "fit.html"),
    }
    found = {}
    for name, (*words, page) in commands.items():
        assert main([*words, "--out", str(folder / name)]) == 0
        found[name] = folder / name / page
    return found


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desk", "phone"])
def test_nothing_is_cut_without_need_or_without_a_sign(
    browser: Browser, pages: dict[str, Path], size: tuple[int, int]
) -> None:
    for name, path in pages.items():
        with opened(browser, path.as_uri(), size) as page:
            assert faults_of(page) == [], name
            assert repeated(page) == [], name
            cut = layout_of(page).cut
            assert bool(cut) == (size == PHONE), "figures are wider than a phone"


def test_a_table_takes_the_free_space_beside_it(browser: Browser, tmp_path: Path) -> None:
    """A table that is wider than the text is not cut while the window is wider still."""
    columns = [f"a_rather_long_number_{k}" for k in range(5)]
    wide = Table("Wide.", ["", *columns], [["row", *(5 * ["123456"])]])
    page_path = tmp_path / "page.html"
    page_path.write_text(
        render_page(
            "fit.html.j2",
            title="Wide",
            rows=1,
            warnings=[],
            numbers=wide,
            lines="x = 1",
            outliers=False,
            pictures={name: Picture("", "") for name in ("coefficients", "residuals")},
            version="",
        )
    )
    for width, is_cut in ((1440, False), (1000, True)):
        with opened(browser, page_path.as_uri(), (width, 900)) as page:
            assert faults_of(page) == []
            assert bool(layout_of(page).cut) == is_cut
