"""No page that flexdyn writes leads to another host or offers to send data there: each kind, opened in a browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import plotly.graph_objects
import plotly.io
import pytest

import flexdyn as fd
from tests.batch.small import pulse_study
from tests.browser import WAYS_OUT, open_page
from tests.diagnose import report_cases
from tests.viewer.arms import two_link_run

pytestmark = pytest.mark.usefixtures("one_browser")

BUTTONS = "[...document.querySelectorAll('.modebar-btn')].map((button) => button.dataset.title)"
Writer = Callable[[Path], None]


def run_page(file: Path) -> None:
    """Of `run.plot`."""
    two_link_run().plot(file)


def comparison_page(file: Path) -> None:
    """Of `fd.compare`."""
    fd.compare(two_link_run(), two_link_run()).plot(file)


def study_page(file: Path) -> None:
    """Of a study's results."""
    fd.run_study(pulse_study(file.parent, runs=4), out=file.parent / "out.zarr").plot(file)


def report_page(file: Path) -> None:
    """Of a diagnosis."""
    report_cases.robot().save(file.parent)
    (file.parent / "report.html").rename(file)


@pytest.mark.parametrize("write", [run_page, comparison_page, study_page, report_page])
def test_pictures_offer_to_send_nothing(write: Writer, tmp_path: Path) -> None:
    """Every picture's buttons are there (zoom, save as PNG), and none of them shares, uploads or links."""
    write(tmp_path / "page.html")
    with open_page(tmp_path / "page.html") as page:
        page.tab.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
        page.wait_for("document.querySelectorAll('.modebar').length > 0")
        names = page.tab.evaluate(BUTTONS)
        assert {"Download plot as a PNG", "Zoom"} <= set(names)
        assert not [name for name in names if "hare" in name or "loud" in name]


def test_the_player_offers_to_send_nothing(tmp_path: Path) -> None:
    """The arm's page has no link and no form."""
    fd.play(two_link_run(), html=tmp_path / "page.html")
    with open_page(tmp_path / "page.html") as page:
        page.wait_for("document.body.dataset.ready === 'yes'")
        assert page.tab.locator("a[href], form, iframe").count() == 0


def test_the_check_sees_links_and_the_button_that_shares(tmp_path: Path) -> None:
    """Plotly's page as it comes and a link to a host are found; otherwise the tests above would prove nothing."""
    figure = plotly.graph_objects.Figure({"data": [{"y": [1, 2]}]})
    inner = plotly.io.to_html(figure, full_html=False, config={"displayModeBar": True})
    text = f"<!DOCTYPE html><html><body>{inner}<p><a href='https://example.org/x'>more</a></p></body></html>"
    (tmp_path / "usual.html").write_text(text, encoding="utf-8")
    with open_page(tmp_path / "usual.html") as page:
        page.wait_for("document.querySelectorAll('.modebar-btn').length > 0")
        found = page.tab.evaluate(WAYS_OUT)
        assert "https://example.org/x" in found
        assert any("Share chart" in text for text in found)
        page.tab.evaluate("document.body.replaceChildren()")
