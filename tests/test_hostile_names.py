"""Names that are markup, script, terminal codes, right-to-left or very long, in every page, picture, table and line."""

from __future__ import annotations

import dataclasses
import html
import json
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import flexdyn as fd
from flexdyn.cli import main
from flexdyn.diagnose.report.document import SCHEMA
from flexdyn.diagnose.report.suspects import Finding
from flexdyn.errors import one_line, visible
from tests.browser import open_page
from tests.diagnose.report_cases import COULOMB, explained
from tests.viewer.arms import DRIVE

pytestmark = pytest.mark.usefixtures("one_browser")

HIT = "window.hit=1;document.title='hit'"
NAMES = (
    f"<img src=x onerror={HIT}>",
    f"</script><script>{HIT}</script>",
    f"\"'><svg onload={HIT}>",
    "{{SCENE}}{{STYLE}}%(x)s{x}%{x}\\n$\\frac{x$",
    "\u05de\u05e8\u05e4\u05e7 \u0645\u0631\u0641\u0642",
    "n" * 200,
)
"""That an arm may have; right-to-left letters are letters."""
TERMINAL = "\x1b]0;owned\x07\x1b[31m\x9b2J\u202egnp.exe"
REFUSED = ("\x9b31mred", "\u202eelbow", "zero\u200bwidth", "n" * 10_000)
"""That no joint or link may have: what does not print, and what no channel could carry."""
BODY = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
HARM = "window.hit === 1 || document.title === 'hit' || document.querySelector('img[src=x], svg[onload], b > script')"


def urdf(names: tuple[str, ...], robot: str) -> str:
    """An arm whose joints and links have these names."""
    words = [html.escape(name) for name in names]
    links = "".join(f'<link name="{word}">{BODY}</link>' for word in words)
    joints = "".join(
        f'<joint name="{word}" type="continuous"><parent link="{parent}"/><child link="{word}"/>'
        '<origin xyz="0.3 0 0"/><axis xyz="0 1 0"/></joint>'
        for parent, word in zip(("base", *words), words, strict=False)
    )
    return f'<robot name="{html.escape(robot)}"><link name="base"/>{links}{joints}</robot>'


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> fd.Run:
    """Of an arm with all of the names, in files that are called like the worst of them."""
    folder = tmp_path_factory.mktemp("named") / f"{TERMINAL}<img src=x onerror=alert(1)>"
    folder.mkdir()
    (folder / "arm.urdf").write_text(urdf(NAMES, f"<script>{HIT}</script>"), encoding="utf-8")
    robot = fd.load_robot(folder / "arm.urdf")
    assert robot.joint_names == NAMES
    effects = [fd.effects.CoulombFriction(name, side="motor", level=0.1) for name in NAMES]
    model = fd.FlexibleJointModel(robot, {"*": DRIVE}, effects, name=f"<script>{HIT}</script>")
    return fd.simulate(model, duration=0.02, q0=np.full(model.n, 0.1), rate=500.0, solver="TimeStepping")


def test_pages_show_them_and_run_nothing(run: fd.Run, tmp_path: Path) -> None:
    """Pictures of runs and comparisons, and the moving arm, in the browser."""
    rec = fd.Recording(run.t, run.to_recording().channels, name=TERMINAL + NAMES[0])
    run.plot(tmp_path / "run.html")
    fd.compare(rec, run).plot(tmp_path / "compared.html")
    fd.play(run, rec, html=tmp_path / "played.html")
    for name in ("run", "compared", "played"):
        with open_page(tmp_path / f"{name}.html", webgl=name == "played") as page:
            page.wait_for("document.body.dataset.ready === 'yes' || document.querySelectorAll('.js-line').length > 1")
            page.tab.mouse.move(640, 300)
            page.tab.wait_for_timeout(100)
            assert not page.tab.evaluate(f"Boolean({HARM})"), name


def test_pictures_and_notebooks(run: fd.Run, tmp_path: Path) -> None:
    """They are drawn at a size that stands, and a notebook shows the names as text."""
    for suffix in (".png", ".svg"):
        run.plot(tmp_path / f"run{suffix}")
    from matplotlib.image import imread

    assert max(imread(tmp_path / "run.png").shape) < 20_000
    rec = fd.Recording(run.t, run.to_recording().channels, name=TERMINAL + NAMES[1])
    shown: tuple[Any, ...] = (run, run.model, run.model.robot, rec, fd.compare(rec, run))
    for each in shown:
        markup = each._repr_html_()
        assert not [tag for tag in ("<img", "<script", "<svg") if tag in markup.lower()], type(each).__name__
        assert visible(repr(each)) == repr(each), type(each).__name__


@pytest.mark.parametrize("arguments", [["info"], ["info", "--json"], ["info", "--modes"], ["new", "-o", "model.yaml"]])
def test_the_terminal_shows_and_does_not_obey(
    run: fd.Run,
    arguments: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Tables, JSON and lines hold no control character, whatever names and paths hold."""
    monkeypatch.chdir(tmp_path)
    source = str(run.model.robot.source)
    assert "\x1b" in source
    assert main([arguments[0], source, *arguments[1:]]) == 0
    printed = capsys.readouterr()
    assert all(line.isprintable() for line in [*printed.out.splitlines(), *printed.err.splitlines()])
    if "--json" in arguments:
        assert [joint["name"] for joint in json.loads(printed.out)["joints"]] == list(NAMES)
    assert main(["info", f"{source}{TERMINAL}", f"--{TERMINAL}"]) == 2
    assert main(["simulate", f"{TERMINAL}.yaml", "-o", f"{TERMINAL}.csv"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert all(line.isprintable() for line in lines)


def printable(capsys: pytest.CaptureFixture[str]) -> str:
    """What was printed, which holds no control character and no letter that changes the direction."""
    printed = capsys.readouterr()
    assert all(line.isprintable() for line in [*printed.out.splitlines(), *printed.err.splitlines()])
    return printed.out


@pytest.fixture(scope="module")
def files(run: fd.Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of such a name with two runs, and with two models, one of them with a report of a diagnosis."""
    folder = tmp_path_factory.mktemp("filed") / f"{TERMINAL}<script>{HIT}<"
    folder.mkdir()
    for name in (NAMES[1].replace("/", ""), TERMINAL):
        run.save(folder / f"{name}.npz")
    fd.save_model(run.model, folder / f"{TERMINAL}.yaml")
    fd.save_model(run.model, folder / "model.yaml")
    names = {"joint": f"{TERMINAL}{NAMES[0]}", "side": TERMINAL, "effect": f"{TERMINAL}friction"}
    found = names | {"parameters": {TERMINAL: {"value": 1.0, "std": 0.1}}, "probability": 0.5}
    wrong = {"of": TERMINAL, "parameter": TERMINAL, "factor": 1.0, "std": 0.1}
    report = {"schema": SCHEMA, "findings": [found], "calibration": [wrong], "considered": [found]}
    (folder / "report.json").write_text(json.dumps(report), encoding="utf-8")
    return folder


@pytest.mark.parametrize("more", [[], ["--json"]], ids=("text", "json"))
def test_comparisons_show_them(files: Path, more: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Of runs and of models, in files of such names; what a report of a diagnosis holds is not obeyed either."""
    assert main(["compare", *map(str, sorted(files.glob("*.npz"))), *more]) == 0
    assert NAMES[0] in printable(capsys)
    models = [str(path) for path in sorted(files.glob("*.yaml"))]
    assert main(["compare-models", *models, *more]) == 0
    assert "level of Coulomb friction" in printable(capsys)
    for command in ("compare", "compare-models"):
        assert main([command, f"{TERMINAL}.npz", f"{TERMINAL}<b>", f"--{TERMINAL}"]) == 2
        assert main([command, f"{TERMINAL}.npz", f"{TERMINAL}<b>"]) == 2
        printable(capsys)


def test_an_effect_of_such_a_name(capsys: pytest.CaptureFixture[str]) -> None:
    """It is not known, and said in one line."""
    for name in (*NAMES, *REFUSED, TERMINAL):
        assert main(["effects", name]) == 2
        assert not printable(capsys)


def test_a_diagnosis_shows_them(
    files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names of its files and folder, of joints, and of what it is asked to explain; the diagnosis is made by hand."""
    model, log = str(files / "model.yaml"), str(next(files.glob("*.npz")))
    for wrong in (["--explain", TERMINAL], ["--expect", TERMINAL], ["--check", TERMINAL], ["--hold-out", TERMINAL]):
        assert main(["diagnose", model, log, *wrong, "-o", str(tmp_path / "report")]) == 2
        printable(capsys)
    suspect = dataclasses.replace(COULOMB, joint=NAMES[0])
    finding = Finding(suspect, 0.99, 30.0, 0.5, (dataclasses.replace(suspect, effect=TERMINAL),), TERMINAL)
    error = explained().errors["elbow"]
    made = dataclasses.replace(explained(), findings=(finding,), errors=dict.fromkeys(NAMES, error), notes=(TERMINAL,))
    monkeypatch.setattr(import_module("flexdyn.diagnose"), "diagnose", lambda *_, **__: made)
    for more in ([], ["--json"]):
        assert main(["diagnose", model, log, "-o", str(tmp_path / f"{TERMINAL}<script>"), *more]) == 0
        assert "coulomb" in printable(capsys).lower()


def test_files_keep_them(run: fd.Run, tmp_path: Path) -> None:
    """A run is saved and read under these names, in a file that has one of them."""
    for suffix in (".csv", ".npz", ".h5", ".mat"):
        path = tmp_path / f"{TERMINAL}{suffix}"
        run.save(path)
        assert {name for name in fd.read_recording(path).joints if name in NAMES} == set(NAMES)


@pytest.mark.parametrize("name", REFUSED, ids=("terminal", "direction", "invisible", "long"))
def test_names_that_no_channel_can_carry_are_refused(name: str, tmp_path: Path) -> None:
    """One line says so; nothing of the name reaches the terminal as it is."""
    (tmp_path / "arm.urdf").write_text(urdf((name,), "arm"), encoding="utf-8")
    with pytest.raises(fd.InputError, match=r"the name (holds characters that do not|is longer than 200)") as told:
        fd.load_robot(tmp_path / "arm.urdf")
    assert str(told.value).isprintable()
    assert len(str(told.value)) < 700
    model = pin.Model()
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), name)
    with pytest.raises(fd.InputError, match="the name"):
        fd.load_robot(model)


def test_lines_are_bounded_and_printable() -> None:
    """What an error is told may hold anything; long words keep their ends."""
    assert one_line("a\nb\tc\x1b[31m\u202e d") == "a b c [31m d"
    assert len(one_line("x " * 10_000)) == 1000
    assert one_line("n" * 10_000 + " is no joint").endswith("nnn is no joint")
    assert len(str(fd.InputError("x " * 900, key="k " * 900, value="v " * 900, remedy="y " * 900))) == 1500
    assert visible("a\x1b\n\u202e") == r"a\x1b\n\u202e"
    assert visible("a\n\x07", lines=True) == "a\n\\x07"
    assert visible("10\u202f837") == "10\u202f837"  # groups of digits, as in a report


def test_the_paper_says_where_its_page_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The folder is the only name that a user gives to the paper's study; what the study does is tested elsewhere."""
    from flexdyn import paper
    from flexdyn.paper.study import PaperStudy

    monkeypatch.setattr(paper, "run_paper_study", lambda output, **_: PaperStudy({}, (), ()))
    assert main(["paper", "-o", str(tmp_path / f"{TERMINAL}<script>")]) == 0
    printed = capsys.readouterr().out
    assert "\\x1b" in printed
    assert all(line.isprintable() for line in printed.splitlines())
