"""What does an hour of data cost in a diagnosis, and its pages in a browser? Beside it ten minutes of the same.

    python benchmarks/long_pages.py [--lengths 600 3600] [-o FILE.json]

The two-link arm swings at 100 samples a second, and its elbow has friction that the model lacks. Each length has a
process of its own, whose computing and memory are told. The player's page, the plot's and the report are opened in a
chromium without a window: computing of the browser until the page has been drawn, and memory of all its processes. Exit
code 1 if the longer one's pages are larger, slower or take more memory by more than a half, or if the friction is not
found. Linux only; needs the extras plot and test.
"""

from __future__ import annotations

import resource
import shutil
import sys
import tempfile
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from measure import Bound, arguments, conclude
from trust_tables import long_pages_table

import flexdyn as fd

RATE = 100.0  # samples a second
PAGES = {"player's page": "play.html", "plot's page": "plot.html", "report": "report/report.html"}
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
DRAWN = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
OPENINGS = 3
MORE = 1.5  # times: what the longer one's pages may cost of the shorter one's


def made(seconds: float, folder: Path) -> dict[str, Any]:
    """Run, diagnose and write the pages; what the diagnosis took.

    Args:
        seconds: of motion.
        folder: for the pages.
    """
    warnings.simplefilter("ignore")  # limits of the robot
    drives = {"*": {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5}}
    model = fd.load_model("scara_two_link").replace(joints=drives, effects=[], tolerance=0.03)
    robot = model.replace(effects=[fd.effects.CoulombFriction("elbow", side="motor", level=0.6)])
    t = np.arange(0.0, seconds + 0.05, 0.05)
    swing = [0.6 * np.cos(1.1 * t) + 0.2 * np.cos(5.0 * t), 0.5 * np.cos(1.4 * t) + 0.2 * np.cos(4.0 * t)]
    command = fd.PD(fd.Samples(t, np.stack(swing, axis=1), "cubic"), kp=400, kd=20)
    run = fd.simulate(robot, command, seconds, rate=RATE, q0=[0.8, 0.7])
    fd.play(run, html=folder / "play.html").close()
    run.plot().save(folder / "plot.html")
    noise, log = np.random.default_rng(0), run.to_recording()
    sigma = {"q": 2e-6, "theta": 2e-6, "tau": 0.02}  # [rad], [N m]
    names = [f"{signal}.{joint}" for signal in sigma for joint in model.joint_names]
    seen = {name: log[name] + noise.normal(0.0, sigma[name.split(".")[0]], run.t.size) for name in names}
    begin = time.process_time()
    answer = fd.diagnose(model, [fd.Recording(run.t, seen)], progress=False)
    row: dict[str, Any] = {"seconds": seconds, "computing": time.process_time() - begin}
    row |= {"memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6}
    row["found"] = [f"{finding.suspect.effect} ({finding.suspect.joint})" for finding in answer.findings]
    answer.save(folder / "report")
    return row


def opened(page: Path) -> tuple[float, float]:
    """Computing until a page has been drawn [s], and memory of the browser then [MB]; a new browser each time."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        tab = browser.new_page(viewport={"width": 1280, "height": 720}, reduced_motion="reduce")
        session = browser.new_browser_cdp_session()
        before = _computing(session)
        tab.goto(page.resolve().as_uri())
        tab.evaluate(DRAWN)
        after = _computing(session)
        memory = sum(_memory(number) for number in after)
        browser.close()
    return sum(after.values()) - sum(before.get(number, 0.0) for number in after), memory


def _computing(session: Any) -> dict[int, float]:
    """By process of the browser: its computing so far [s]."""
    return {each["id"]: each["cpuTime"] for each in session.send("SystemInfo.getProcessInfo")["processInfo"]}


def _memory(process: int) -> float:
    """A process's memory [MB]; what several share is divided among them."""
    lines = Path(f"/proc/{process}/smaps_rollup").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) * 1024 / 1e6


def row_of(seconds: float) -> dict[str, Any]:
    """All of one length, as the result file writes it."""
    with tempfile.TemporaryDirectory() as folder:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as apart:
            row = apart.submit(made, seconds, Path(folder)).result()
        row["pages"] = {}
        for name, file in PAGES.items():
            times, memory = zip(*(opened(Path(folder) / file) for _ in range(OPENINGS)), strict=True)
            size = (Path(folder) / file).stat().st_size / 1e6
            median = {"computing": float(np.median(times)), "memory": float(np.median(memory))}
            row["pages"][name] = {"megabytes": size} | median
    print(row, file=sys.stderr, flush=True)
    return row


def bounds_of(rows: list[dict[str, Any]]) -> list[Bound]:
    """The last length beside the first."""
    first, last = rows[0], rows[-1]
    wrong = sum(row["found"] != ["coulomb_friction (elbow)"] for row in rows)
    bounds = [Bound("diagnoses that do not name the friction alone", wrong, 0)]
    for name, page in last["pages"].items():
        for key in ("megabytes", "computing", "memory"):
            bounds.append(Bound(f"{name}: {key}, last / first", page[key] / first["pages"][name][key], MORE))
    return bounds


def main() -> int:
    """Work, print, write."""
    parser = arguments(__doc__)
    parser.add_argument("--lengths", type=float, nargs="+", default=[600.0, 3600.0], help="of the motion [s]")
    args = parser.parse_args()
    content = {"rows": [row_of(seconds) for seconds in args.lengths]}
    print(long_pages_table(content))
    return conclude(bounds_of(content["rows"]), args.output, "python benchmarks/long_pages.py", content)


if __name__ == "__main__":
    sys.exit(main())
