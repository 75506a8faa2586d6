"""Make the picture of flexdyn play in docs: the Panda beside its rigid twin, photographed in Chromium.

Needs the test extra (Playwright) and a chromium, as the tests in the browser do.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import flexdyn as fd

OUT = Path(__file__).parents[1] / "benchmarks" / "figures" / "play.png"
WIDTH, HEIGHT = 1120, 630  # px
SHOWN_AT = 0.95  # of the slider
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")  # no graphics card is needed
TO_TIME = (
    "(share) => { const time = document.getElementById('time'); time.value = share * time.max;"
    " time.dispatchEvent(new Event('input')); }"
)
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done))))"


def swing() -> fd.Run:
    """A quick swing about the base and out; joints softer than the Panda's and 3 kg at the hand, so that it shows."""
    model = fd.load_model("panda")
    model = model.replace(joints={"*": {"stiffness": 1500.0}}, effects=[*model.effects, fd.effects.Payload(mass=3.0)])
    home = np.array([0.0, -0.8, 0.0, -2.2, 0.0, 1.6, 0.8])
    out = home + np.array([1.2, 0.9, 0.0, 0.9, 0.0, 0.3, 0.0])
    path = fd.Samples([0.0, 0.6, 1.2], np.array([home, out, home]), "cubic")
    command = fd.PD(path, kp=[900, 900, 700, 700, 300, 200, 80], kd=[60, 60, 40, 40, 15, 10, 4])
    return fd.simulate(model, command, q0=home, theta0="equilibrium")


def photograph(page: Path, picture: Path) -> None:
    """Open a page, pull its slider, take the picture."""
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        sys.exit("no chromium here; Debian, Ubuntu: apt install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        tab = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, reduced_motion="reduce")
        tab.goto(page.resolve().as_uri())
        while tab.evaluate("document.body.dataset.ready") != "yes":
            tab.wait_for_timeout(50)
        tab.evaluate(TO_TIME, SHOWN_AT)
        tab.evaluate(DRAWN)
        tab.screenshot(path=str(picture))
        browser.close()


def main() -> None:
    """Simulate, write the page, photograph it."""
    with TemporaryDirectory() as folder:
        page = Path(folder) / "run.html"
        fd.play(swing(), "rigid", html=page)
        photograph(page, OUT)


if __name__ == "__main__":
    main()
