"""fd.play: a page served and opened, or written; a handle to close it."""

from __future__ import annotations

import sys
import urllib.request
import webbrowser
from pathlib import Path

import pytest

import flexdyn as fd
from tests.viewer.arms import two_link_run


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Addresses that the user's browser was given; there is a screen."""
    addresses: list[str] = []
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    monkeypatch.setenv("DISPLAY", ":0")
    return addresses


def test_the_browser_is_opened_at_the_page(opened: list[str]) -> None:
    """The page is there until closed."""
    playback = fd.play(two_link_run(), block=False)
    assert opened == [playback.url]
    with urllib.request.urlopen(playback.url, timeout=10) as answer:  # noqa: S310
        assert b"scara_two_link" in answer.read(5000)
    playback.close()
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(playback.url, timeout=10)  # noqa: S310


def test_no_browser_is_opened_unasked(opened: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not if told not to, not for a file, and not without a screen, where Python would start one in the terminal."""
    fd.play(two_link_run(), open_browser=False, block=False).close()
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    fd.play(two_link_run(), block=False).close()
    assert opened == []


def test_a_file_is_written_instead(opened: list[str], tmp_path: Path) -> None:
    """And nothing is served; the handle says where it is."""
    with fd.play(two_link_run(), html=tmp_path / "a b.html") as playback:
        assert playback.url == (tmp_path / "a b.html").as_uri()
    assert (tmp_path / "a b.html").is_file()
    assert opened == []


def test_a_file_that_cannot_be_written_leaves_what_was_there(tmp_path: Path) -> None:
    """One line says why."""
    with pytest.raises(fd.InputError, match="no such folder"):
        fd.play(two_link_run(), html=tmp_path / "no" / "page.html")
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(fd.InputError, match="not a regular file"):
        fd.play(two_link_run(), html=tmp_path / "folder.html")
    assert [path.name for path in tmp_path.iterdir()] == ["folder.html"]


@pytest.mark.parametrize("factor", [0.0, -1.0, float("nan"), float("inf")])
def test_a_factor_that_is_none(factor: float) -> None:
    """Is refused in one line."""
    with pytest.raises(fd.InputError, match=r"magnify.*no such factor"):
        fd.play(two_link_run(), magnify=factor)


def test_a_path_is_read(tmp_path: Path) -> None:
    """A saved run, and another to compare it with, by their paths; the page calls them by the files' names."""
    two_link_run().save(tmp_path / "first.npz")
    two_link_run().save(tmp_path / "second.csv")
    fd.play(tmp_path / "first.npz", str(tmp_path / "second.csv"), html=tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "arm: first" in text
    assert "translucent: second" in text
