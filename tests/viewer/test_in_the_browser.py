"""The page in a real browser: the arm is seen, it moves, the controls work, and nothing leaves the machine."""

from __future__ import annotations

import functools
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests import browser
from tests.browser import OpenPage, Picture
from tests.viewer.arms import rigid_run, shapeless, swinging, two_link_run

pytestmark = pytest.mark.usefixtures("one_browser")
open_page = functools.partial(browser.open_page, width=1000, height=562, webgl=True)  # the processor draws every pixel


def ready(page: OpenPage) -> None:
    """Wait for the scene."""
    page.wait_for("document.body.dataset.ready === 'yes'")
    drawn(page)


def drawn(page: OpenPage) -> None:
    """Wait until what was asked for has been drawn."""
    page.tab.evaluate(
        "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done))))"
    )


def at(page: OpenPage, share: float) -> Picture:
    """The middle of the picture after the slider was pulled to a share of its length."""
    page.tab.evaluate(
        "(share) => { const time = document.getElementById('time'); time.value = share * time.max;"
        " time.dispatchEvent(new Event('input')); }",
        share,
    )
    drawn(page)
    return middle(page.screenshot())


def middle(picture: Picture) -> Picture:
    """Without panel and bar."""
    return picture[:640, 345:]


def differing(one: Picture, other: Picture) -> int:
    """How many pixels are visibly different."""
    return int((np.abs(one.astype(int) - other.astype(int)).max(axis=-1) > 40).sum())


def clock(page: OpenPage) -> float:
    """The time that is written on the page [s]."""
    return float(page.tab.inner_text("#clock").split()[0])


def hide(page: OpenPage, text: str) -> Picture:
    """The picture after a box of the legend was cleared."""
    page.tab.locator("#legend label", has_text=text).locator("input").uncheck()
    drawn(page)
    return middle(page.screenshot())


def test_the_arm_is_seen_and_moves_with_the_slider(tmp_path: Path) -> None:
    """Opened as a file: pixels change where the arm goes and come back with the time."""
    path = tmp_path / "run.html"
    fd.play(two_link_run(), html=path)
    with open_page(path) as page:
        ready(page)
        first, later, again = at(page, 0.0), at(page, 0.6), at(page, 0.0)
        assert differing(first, later) > 2000
        assert differing(first, again) == 0
        assert clock(page) == 0.0
        at(page, 1.0)
        assert clock(page) == 2.0
        at(page, 0.0)
        empty = hide(page, "arm: scara_two_link")
        assert differing(first, empty) > 5000


@pytest.mark.parametrize("name", ["panda", "shapeless"])
def test_meshes_and_bodies_of_inertia_are_seen(name: str, tmp_path: Path) -> None:
    """Both fill a good part of the picture, in the middle of it."""
    model = shapeless(tmp_path) if name == "shapeless" else fd.load_model(name)
    path = tmp_path / "model.html"
    fd.play(model, html=path)
    with open_page(path) as page:
        ready(page)
        assert page.tab.locator("#bar").is_hidden()
        seen = middle(page.screenshot())
        changed = np.abs(seen.astype(int) - hide(page, "arm").astype(int)).max(axis=-1) > 40
        assert changed.mean() > 0.03
        rows, columns = np.nonzero(changed)
        assert 0.25 < rows.mean() / changed.shape[0] < 0.75
        assert 0.25 < columns.mean() / changed.shape[1] < 0.75
        assert np.ptp(rows) > 0.4 * changed.shape[0] or np.ptp(columns) > 0.4 * changed.shape[1]
        # Nothing of it lies outside the part that is free of panel and bar.
        assert rows.min() > 0
        assert columns.min() > 0
        assert columns.max() < changed.shape[1] - 1


def test_play_and_pause(tmp_path: Path) -> None:
    """Time passes at about the clock's pace, faster and slower by the speed; pause holds it; it ends at the end."""
    path = tmp_path / "run.html"
    fd.play(two_link_run(), html=path)
    with open_page(path) as page:
        ready(page)
        begun = time.monotonic()
        page.tab.click("#play")
        drawn(page)
        assert page.tab.get_attribute("#play", "aria-label") == "Pause"
        page.wait_for("document.getElementById('time').value > 0.5")
        passed = time.monotonic() - begun
        assert passed > 0.3  # it did not jump
        page.tab.keyboard.press("Space")
        page.tab.click("#fit")
        drawn(page)
        held = clock(page)
        page.tab.wait_for_timeout(300)
        assert clock(page) == held
        assert page.tab.get_attribute("#play", "aria-label") == "Play"
        page.tab.select_option("#speed", "4")
        page.tab.click("#play")
        page.wait_for("!flexdyn.viewer.animator.playing")
        drawn(page)
        assert clock(page) == 2.0
        page.tab.select_option("#speed", "0.02")
        page.tab.click("#play")
        page.tab.wait_for_timeout(500)
        assert 0.0 < clock(page) < 0.3


def test_it_plays_by_itself(tmp_path: Path) -> None:
    """From the start, unless the user's system asks for less motion."""
    path = tmp_path / "run.html"
    fd.play(two_link_run(), html=path)
    with open_page(path, motion=True) as page:
        page.wait_for("document.getElementById('time').value > 0.1")
    with open_page(path) as page:
        ready(page)
        assert clock(page) == 0.0


def test_keys(tmp_path: Path) -> None:
    """Arrows step by a hundredth, with shift by a frame; home and end go there; repeat begins anew."""
    path = tmp_path / "run.html"
    fd.play(two_link_run(), html=path)
    with open_page(path) as page:
        ready(page)
        for key, expected in (("ArrowRight", 0.02), ("ArrowLeft", 0.0), ("Shift+ArrowRight", 1 / 240), ("End", 2.0)):
            page.tab.keyboard.press(key)
            drawn(page)
            assert clock(page) == pytest.approx(expected, abs=6e-4)
        page.tab.check("#repeat")
        page.tab.evaluate("document.activeElement.blur()")
        page.tab.evaluate("flexdyn.seek(1.8)")
        page.tab.keyboard.press("Space")
        page.tab.evaluate("{ const end = performance.now() + 400; while (performance.now() < end); }")  # a slow frame
        page.wait_for("document.getElementById('time').value < 1 && flexdyn.viewer.animator.playing")


def test_the_second_arm_is_seen(tmp_path: Path) -> None:
    """In violet, where it is away from the first; the legend says what it is, and takes it away."""
    path = tmp_path / "both.html"
    far = fd.Recording([0.0, 2.0], {"q.shoulder": [0.5, -0.8], "q.elbow": [0.6, 0.9]}, name="measured")
    fd.play(two_link_run(), far, html=path)
    with open_page(path) as page:
        ready(page)
        assert "translucent: measured" in page.tab.inner_text("#legend")
        both = at(page, 0.5)
        alone = hide(page, "translucent: measured")
        assert differing(both, alone) > 2000
        violet = (both[..., 0].astype(int) - both[..., 1] > 25) & (both[..., 2].astype(int) - both[..., 1] > 25)
        gone = (alone[..., 0].astype(int) - alone[..., 1] > 25) & (alone[..., 2].astype(int) - alone[..., 1] > 25)
        assert violet.sum() > 2000 + gone.sum()
        assert "between the tips" in page.tab.inner_text("#gap")


def test_the_needles_and_the_factor_are_seen(tmp_path: Path) -> None:
    """Red needles swing where the joints deflect, and the page says how much they are magnified."""
    path = tmp_path / "run.html"
    fd.play(two_link_run(), rigid_run(), html=path, magnify=30.0)
    with open_page(path) as page:
        ready(page)
        assert "\u03b8 \u2212 q magnified 30\u00d7" in page.tab.inner_text("#legend")
        shown = at(page, 0.3)
        red = (shown[..., 0] > 170) & (shown[..., 1] < 90) & (shown[..., 2] < 90)
        without = hide(page, "rotor")
        left = (without[..., 0] > 170) & (without[..., 1] < 90) & (without[..., 2] < 90)
        assert red.sum() > left.sum() + 50
        values = page.tab.locator("#rows td").all_inner_texts()
        assert float(values[2]) == pytest.approx(
            1e3 * np.interp(0.6, two_link_run().t, two_link_run().deflection[:, 0]), abs=0.02
        )


def test_the_server_serves_it() -> None:
    """The same page at 127.0.0.1, and it asks for nothing but itself."""
    with fd.play(two_link_run(), open_browser=False, block=False) as playback:
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", playback.url)
        with open_page(playback.url) as page:
            ready(page)
            assert differing(at(page, 0.0), at(page, 0.6)) > 2000


EVIL = "</script><img src=x onerror=alert(1)><!--'\"&lt;{{SCENE}}"


def test_names_are_only_text(tmp_path: Path) -> None:
    """Markup in the names of joints, robots and recordings is shown, not obeyed."""
    markup = EVIL.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    model = shapeless(tmp_path, joint=markup, name=markup)
    assert model.joint_names[0] == EVIL
    run = swinging(model)
    path = tmp_path / "run.html"
    recording = fd.Recording(run.t, run.to_recording().channels, name=EVIL)
    fd.play(run, recording, html=path)
    with open_page(path) as page:
        page.tab.on("dialog", lambda dialog: page.errors.append(dialog.message))
        ready(page)
        assert page.tab.locator("#rows td").first.inner_text() == EVIL
        assert EVIL in page.tab.inner_text("#legend")
        assert page.tab.inner_text("#title") == EVIL
        assert page.tab.title() == EVIL
        assert page.tab.locator("img").count() == 0


def test_no_script_but_its_own_runs(tmp_path: Path) -> None:
    """The page's policy stops a script that someone put into the file, and any request."""
    path = tmp_path / "run.html"
    fd.play(fd.load_model("scara_two_link"), html=path)
    text = path.read_text(encoding="utf-8")
    added = "<script>window.stolen = 1</script><img src='https://example.com/x.png'></body>"
    path.write_text(text.replace("</body>", added), encoding="utf-8")
    with open_page(path) as page:
        ready(page)
        assert page.tab.evaluate("window.stolen") is None
        assert len([error for error in page.errors if "Content Security Policy" in error]) == 2
        assert "https://example.com/x.png: csp" in page.errors
        page.requests.remove("https://example.com/x.png")
        page.tab.evaluate("document.querySelector('img').remove()")
        page.errors.clear()


@pytest.mark.parametrize(("width", "height"), [(480, 640), (800, 360)])
def test_a_small_window(width: int, height: int, tmp_path: Path) -> None:
    """The controls stay inside it, the arm is seen, and the factor is still told."""
    path = tmp_path / "run.html"
    fd.play(two_link_run(), html=path)
    with open_page(path, width=width, height=height) as page:
        ready(page)
        for part in ("#bar", "#panel", "#play", "#time", "#fit"):
            box: dict[str, Any] = page.tab.locator(part).bounding_box()
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= width
            assert box["y"] + box["height"] <= height
        assert "magnified" in page.tab.inner_text("#panel summary")
        before = page.screenshot()
        page.tab.keyboard.press("End")
        drawn(page)
        assert differing(before, page.screenshot()) > 500


def test_a_notebook_plays_a_run_in_a_frame(tmp_path: Path) -> None:
    """`run.show()`: the arm is drawn within the frame, which cannot reach the notebook round it."""
    shown = two_link_run().show("rigid", height=400)
    (tmp_path / "notebook.html").write_text(
        f"<!DOCTYPE html><link rel=icon href='data:,'><p>cell</p>{shown._repr_html_()}", encoding="utf-8"
    )
    assert repr(shown).startswith("<Inline: a page of ")
    with open_page(tmp_path / "notebook.html") as page:
        frame = page.tab.frames[1]
        end = time.monotonic() + 30.0
        while frame.evaluate("document.body.dataset.ready") != "yes":
            assert time.monotonic() < end
            page.tab.wait_for_timeout(50)
        assert "translucent: scara_two_link, rigid" in frame.locator("#legend").text_content()
        assert page.tab.locator("iframe").bounding_box()["height"] == 400
        assert (
            frame.evaluate("(() => { try { return parent.document.title; } catch { return 'kept out'; } })()")
            == "kept out"
        )
