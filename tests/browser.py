"""Chromium without a window, in which tests open the pages that flexdyn writes.

    from tests.browser import open_page

    with open_page(tmp_path / "run.html") as page:      # a file, or an address http://127.0.0.1:...
        page.tab.click("text=Play")                     # the Playwright page itself
        picture = page.screenshot()                     # (height, width, 3) uint8
    # leaving the block asserts: no error in the page, no request but for the page itself, no way out of it

Debian's chromium is used, never one that Playwright would download. Where it is absent the test is skipped, and fails
if CI is set: there the script installs it.
"""

from __future__ import annotations

import io
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray

Picture = NDArray[np.uint8]

# Nothing that a browser does of its own accord, and no name of any host resolves.
FLAGS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)
FLAT = ("--disable-gpu",)
"""For pages without WebGL: they take three fifths of the processor's time."""
WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""For scenes in space: computed on the processor."""
INSIDE = ("data", "blob")
"""Kinds of addresses that are part of the page."""
WAYS_OUT = """() => [...document.querySelectorAll("*")].flatMap((element) => {
  const found = ["href", "xlink:href", "src", "action", "formaction", "data", "ping", "poster", "srcset"]
    .map((name) => element.getAttribute(name)).filter((address) => address !== null);
  return found.filter((address) => {
    const target = new URL(address, location.href);
    const inside = ["data:", "blob:"].includes(target.protocol);
    return !inside && (target.protocol !== location.protocol || target.host !== location.host);
  });
}).concat([...document.querySelectorAll("button, a, [data-title]")]
  .map((element) => `${element.dataset.title || ""} ${element.title || ""} ${element.textContent}`.trim())
  .filter((text) => /\\b(share|upload|cloud|chart studio)\\b/i.test(text)))"""
"""Script that lists what would lead to another host: addresses in the page, and buttons that offer to send data."""
BUTTONS = "[...document.querySelectorAll('.modebar-btn')].map((button) => button.dataset.title)"


@dataclass
class OpenPage:
    """A page in the browser.

    Attributes:
        address: that was opened.
        tab: Playwright's page.
        errors: errors of its scripts, errors and warnings in its console, and requests that failed.
        requests: addresses that it asked for, its own first; not those inside it (data:, blob:).
    """

    address: str
    tab: Any
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def screenshot(self, path: Path | None = None) -> Picture:
        """What is to be seen, (height, width, 3); written to `path` as PNG too, if given."""
        from matplotlib.image import imread

        data = self.tab.screenshot() if path is None else self.tab.screenshot(path=str(path))
        picture = imread(io.BytesIO(data), format="png")
        return np.asarray(np.rint(picture[..., :3] * 255), dtype=np.uint8)

    def wait_for(self, condition: str, argument: Any = None) -> None:
        """Wait until a JavaScript expression or function holds; the test fails after half a minute.

        Playwright's own waiting evaluates text inside the page, which a page's policy may forbid.
        """
        end = time.monotonic() + 30.0
        while not self.tab.evaluate(condition, argument):
            assert time.monotonic() < end, f"it never held: {condition}"
            self.tab.wait_for_timeout(20)

    def wait_for_buttons(self) -> None:
        """Wait for the buttons of the pictures, so that `check` sees them: zoom, save as PNG, and none that sends."""
        self.wait_for("document.querySelectorAll('.modebar-btn').length > 0")
        assert {"Download plot as a PNG", "Zoom"} <= set(self.tab.evaluate(BUTTONS))

    def check(self) -> None:
        """Nothing went wrong in the page, it asked for nothing but itself, and nothing in it leads elsewhere."""
        assert self.errors == []
        assert self.requests == [self.address]
        assert self.tab.evaluate(WAYS_OUT) == []


@contextmanager
def open_page(
    target: str | Path,
    *,
    width: int = 1280,
    height: int = 720,
    motion: bool = False,
    scripts: bool = True,
    webgl: bool = False,
) -> Iterator[OpenPage]:
    """Open a file or an address; on the way out, assert that the page is sound and asked for nothing else.

    Args:
        target: path of an HTML file, or an address of this machine.
        width: of the window [px].
        height: of the window [px].
        motion: let the page move by itself; otherwise it is told that the user wants none.
        scripts: let the page's own scripts run; its text is there without them, and to draw pictures takes seconds.
        webgl: the page shows a scene in space.
    """
    address = target if isinstance(target, str) and "://" in target else Path(target).resolve().as_uri()
    with ExitStack() as ends:
        flags = WEBGL if webgl else FLAT
        browser = _kept[-1].browser(flags) if _kept else ends.enter_context(_browser(flags))
        wish = "no-preference" if motion else "reduce"
        # With a context of its own, which ends with it: storage and settings of one page are not those of the next.
        size = {"width": width, "height": height}
        tab = browser.new_page(viewport=size, reduced_motion=wish, java_script_enabled=scripts)
        ends.callback(tab.close)
        page = OpenPage(address, tab)
        tab.on("pageerror", lambda error: page.errors.append(str(error)))
        tab.on("console", lambda entry: _complaint(page, entry))
        tab.on("requestfailed", lambda request: page.errors.append(f"{request.url}: {request.failure}"))
        tab.on("request", lambda request: _note(page, request.url))
        tab.goto(address)
        yield page
        page.check()


class _Kept:
    """A browser that starts when the first page asks for it, and stays until a page asks for other flags."""

    def __init__(self) -> None:
        self._ends = ExitStack()
        self._flags: tuple[str, ...] = ()
        self._started: Any = None

    def browser(self, flags: tuple[str, ...]) -> Any:
        """The one with these flags, started by now."""
        if self._started is None or flags != self._flags:
            self.close()
            self._started, self._flags = self._ends.enter_context(_browser(flags)), flags
        return self._started

    def close(self) -> None:
        """Stop it."""
        self._ends.close()
        self._started = None


_kept: list[_Kept] = []
"""The browser of the test file that is at work, if it keeps one."""


@pytest.fixture(scope="module")
def one_browser() -> Iterator[None]:
    """All pages of a test file are opened in one browser: to start it costs more than most of its pages."""
    _kept.append(_Kept())
    try:
        yield
    finally:
        _kept.pop().close()


def _complaint(page: OpenPage, entry: Any) -> None:
    if entry.type in ("error", "warning"):
        page.errors.append(entry.text)


def _note(page: OpenPage, address: str) -> None:
    if urlsplit(address).scheme not in INSIDE:
        page.requests.append(address)


@contextmanager
def _browser(flags: tuple[str, ...]) -> Iterator[Any]:
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        _absent("no chromium here; Debian, Ubuntu: apt install chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _absent("playwright is not installed: pip install playwright")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=[*FLAGS, *flags])
        try:
            yield browser
        finally:
            browser.close()


def _absent(reason: str) -> NoReturn:
    """A test that cannot run is skipped, where nobody relies on it."""
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)
