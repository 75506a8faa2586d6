"""flexdyn play: a page of a run, a model or a comparison; and one line on what is wrong."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from tests.cli.conftest import Runner


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run that has its model, one without, and one of another arm."""
    folder = tmp_path_factory.mktemp("made")
    run = fd.simulate(fd.load_model("scara_two_link"), duration=0.2, q0=[0.3, 0.4], v0=[1.0, -1.0])
    run.save(folder / "run.npz")
    run.save(folder / "run.csv")
    rec = run.to_recording()
    still = fd.Recording(rec.t, {name: rec[name] for name in rec.channels if name.startswith("q.")}, meta=rec.meta)
    fd.write_recording(still, folder / "still.npz")
    fd.simulate(fd.load_model("scara"), duration=0.01).save(folder / "other.npz")
    (folder / "pd.yaml").write_text("pd: {reference: run.npz, kp: 40.0, kd: 2.0}\n", encoding="utf-8")
    return folder


@pytest.fixture(autouse=True)
def _runs(flexdyn: Runner, made: Path) -> None:
    shutil.copytree(made, Path(), dirs_exist_ok=True)


@pytest.mark.parametrize(
    "arguments",
    [
        ("run.npz",),
        ("run.csv", "--model", "scara_two_link"),
        ("run.npz", "run.csv"),
        ("run.npz", "--rigid"),
        ("run.csv", "--model", "scara_two_link", "--rigid"),
        ("run.npz", "--rigid", "--command", "pd.yaml"),
        ("run.npz", "--magnify", "50"),
        ("scara",),
        ("ur5",),
    ],
)
def test_html(flexdyn: Runner, arguments: tuple[str, ...]) -> None:
    """One file, named in one line."""
    outcome = flexdyn("play", *arguments, "--html", "page.html")
    assert outcome.code == 0
    assert re.fullmatch(r"page\.html: \d\.\d MB, opens in any browser, offline too\n", outcome.out)
    assert Path("page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert not list(Path().glob(".*.tmp"))


def test_the_page_is_that_of_the_python_interface(flexdyn: Runner) -> None:
    """Byte for byte but for the names that meshcat draws by lot."""
    assert flexdyn("play", "run.npz", "--html", "page.html").code == 0
    fd.play("run.npz", html="same.html")
    one, other = (Path(name).read_text(encoding="utf-8") for name in ("page.html", "same.html"))
    parts = [re.split(r'id="scene">[^<]*<', text) for text in (one, other)]
    assert parts[0] == parts[1]


def test_a_map_is_that_of_the_measured_recording(flexdyn: Runner) -> None:
    """OTHER's, if there is one: its columns get the names of the arm's joints."""
    rows = ["time,a1,a2", *(f"{t:g},{0.3 + t:g},{0.4 - t:g}" for t in np.linspace(0.0, 0.2, 21))]
    Path("log.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    channels = "{q.shoulder: {from: a1, unit: rad}, q.elbow: {from: a2, unit: rad}}"
    Path("map.yaml").write_text(f"flexdyn_map: 1\ntime: {{from: time}}\nchannels: {channels}\n", encoding="utf-8")
    assert flexdyn("play", "run.npz", "log.csv", "--map", "map.yaml", "--html", "page.html").err == ""
    assert "translucent: log" in Path("page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("run.csv",), "run.csv: model: the recording does not say which arm it is of; name it: .*--model MODEL"),
        (("run.csv", "--model", "scara"), "run.csv: channels: no position of any joint of the arm.*q.joint1 or theta"),
        (("run.csv", "--model", "scarra"), "scarra.*did you mean 'scara'"),
        (("run.npz", "other.npz"), "other.npz: compare: it is of another arm, scara, and not of scara_two_link"),
        (("run.npz", "gone.npz"), "gone.npz: no such file"),
        (("gone.npz",), "gone.npz: no such file"),
        (("gone",), "gone.*neither a file nor a known model or robot"),
        (("run.npz", "run.csv", "--rigid"), "--rigid: there is one translucent arm.*run.csv.*leave one of them out"),
        (("run.npz", "--command", "pd.yaml"), "--command: a command is for the rigid arm alone; give --rigid too"),
        (("run.npz", "--rigid", "--command", "gone.yaml"), "gone.yaml: there is no such file"),
        (("scara", "--rigid"), "--rigid: a model alone has no torques.*give a run or a recording"),
        (("still.npz", "--rigid"), "still.npz: channels.*no tau of any joint.*tau.shoulder"),
        (("run.npz", "--html", "no/page.html"), "no/page.html: --html.*no such folder"),
        (("run.npz", "--html", "page.pdf"), "page.pdf: --html.*unknown suffix"),
        (("run.npz", "--html", "."), "--html.*unknown suffix"),
        (("run.npz", "--magnify", "0"), "--magnify.*no such factor.*above 0"),
        (("run.npz", "--magnify", "much"), "--magnify.*a number is needed"),
        (("run.npz", "--magnify", "nan"), "--magnify.*a finite number is needed"),
    ],
)
def test_mistakes(flexdyn: Runner, arguments: tuple[str, ...], line: str) -> None:
    """Exit code 2 and one line that names file, option and remedy; nothing is written."""
    with_html = () if "--html" in arguments else ("--html", "page.html")
    outcome = flexdyn("play", *arguments, *with_html)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    assert re.search(line, outcome.err), outcome.err
    assert not Path("page.html").exists()


def test_it_serves_until_interrupted() -> None:
    """The address is printed, the page is there, and Ctrl-C ends it cleanly."""
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    command = [
        sys.executable,
        "-c",
        "import sys; from flexdyn.cli import main; sys.exit(main())",
        "play",
        "run.npz",
        "--no-open",
    ]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as served:
        try:
            assert served.stdout is not None
            found = re.search(r"run\.npz at (http://127\.0\.0\.1:\d+/) \(Ctrl-C ends\)", served.stdout.readline())
            assert found
            with urllib.request.urlopen(found[1], timeout=10) as answer:  # noqa: S310
                assert answer.read(15) == b"<!DOCTYPE html>"
            served.send_signal(signal.SIGINT)
            _, errors = served.communicate(timeout=20)
        finally:
            served.kill()
    assert served.returncode == 0
    assert errors.strip() in ("", "flexdyn: stopped")
