"""Interactive pages in a real browser: sound, offline, nothing in a name is executed, curves are to be seen."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.plots.palette import HUES
from tests.browser import Picture, open_page

pytestmark = pytest.mark.usefixtures("one_browser")

CURVES = "#picture .scatterlayer .trace path.js-line"
EVIL = "<img src=x onerror=document.title='hit'>"
SCRIPT = "</script><script>document.title='hit'</script>"


def dots_of(picture: Picture, colour: str) -> int:
    """Dots of the screen in a colour, nearly."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    return int((np.abs(picture.astype(int) - wanted).max(axis=2) < 12).sum())


def test_a_page_shows_the_run_and_asks_nobody_for_anything(tmp_path: Path) -> None:
    """Both joints' curves are on the screen in their colours; the legend hides one kind of signal of all joints."""
    run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[0.4, -0.3], rate=200)
    run.plot(tmp_path / "run.html", views=["positions", "deflection"])
    with open_page(tmp_path / "run.html") as page:
        lines = page.tab.locator(CURVES)
        lines.nth(5).wait_for(state="attached")
        page.wait_for_buttons()
        full = page.screenshot()
        assert min(dots_of(full, HUES[0]), dots_of(full, HUES[1])) > 1000
        assert page.tab.title() == "scara_two_link"
        page.tab.locator(".legendtoggle").first.click()
        for _ in range(100):
            page.tab.wait_for_timeout(50)
            if lines.count() < 6:
                break
        assert lines.count() == 4
        assert dots_of(page.screenshot(), HUES[0]) < 0.9 * dots_of(full, HUES[0])


def test_names_in_a_page_are_text(tmp_path: Path) -> None:
    """Joints and files called like markup are shown as they are called; nothing of it runs."""
    t = [0.0, 1.0, 2.0]
    rec, other = (
        fd.Recording(t, {f"q.{EVIL}": [0.0, 1.0, peak], f"q.{SCRIPT}": [peak, 0.0, 1.0]}, name=name)
        for name, peak in ((EVIL, 1.0), (SCRIPT, 2.0))
    )
    fd.plot(rec, other, path=tmp_path / "name.html")
    fd.compare(rec, other).plot(tmp_path / "comparison.html")
    for file in ("name.html", "comparison.html"):
        with open_page(tmp_path / file) as page:
            page.tab.locator(CURVES).nth(2).wait_for(state="attached")
            page.wait_for_buttons()
            page.tab.mouse.move(640, 300)  # over a panel, where a label follows the mouse
            page.tab.wait_for_timeout(200)
            assert {EVIL[:20], SCRIPT[:20]} <= {
                part[:20] for part in page.tab.title().replace(" against ", " and ").split(" and ")
            }
            assert page.tab.locator("img").count() == 0
            shown = " ".join(page.tab.locator("#picture text").all_text_contents())
            assert EVIL[:40] in shown
            assert SCRIPT[:40] in shown


def test_show_opens_a_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is written for good into a folder for temporary files, and the browser is sent there."""
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    path = fd.plot(fd.Recording([0.0, 1.0], {"q.a": [0.0, 1.0]})).show()
    assert opened == [path.as_uri()]
    assert path.is_relative_to(tmp_path)
    text = path.read_text(encoding="utf-8")
    assert "default-src 'none'" in html.unescape(text)
    assert "cdn" not in text.split("<script")[0]


def test_a_notebook_shows_plotlys_page_without_its_upload(monkeypatch: pytest.MonkeyPatch) -> None:
    """The figure is Plotly's own, in each way that notebooks are shown it; none names a host that data would go to."""
    import plotly.io

    picture = fd.plot(fd.Recording([0.0, 1.0], {"q.a": [0.0, 1.0]}))
    monkeypatch.setattr(plotly.io.renderers, "default", "plotly_mimetype+notebook_connected")
    bundle = picture._repr_mimebundle_()
    own = picture.plotly()._repr_mimebundle_()
    shown, usual = (made["application/vnd.plotly.v1+json"] for made in (bundle, own))
    assert shown["layout"] == usual["layout"]
    assert shown["config"]["showSendToCloud"] is False
    assert '"showSendToCloud": false' in bundle["text/html"]
    assert "https://plot.ly" not in str(shown["config"])
