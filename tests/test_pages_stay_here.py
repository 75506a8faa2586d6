"""No page that flexdyn writes leads to another host or offers to send data there.

Every page that a test opens is checked for it; here is the check of the check, and of the player.
"""

from __future__ import annotations

from pathlib import Path

import plotly.graph_objects
import plotly.io
import pytest

import flexdyn as fd
from tests.browser import WAYS_OUT, open_page
from tests.viewer.arms import two_link_run

pytestmark = pytest.mark.usefixtures("one_browser")


def test_the_player_offers_to_send_nothing(tmp_path: Path) -> None:
    """The arm's page has no link and no form."""
    fd.play(two_link_run(), html=tmp_path / "page.html")
    with open_page(tmp_path / "page.html", webgl=True) as page:
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
