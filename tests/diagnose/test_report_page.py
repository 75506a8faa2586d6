"""report.html in a browser: it opens anywhere, asks nobody for anything, shows all, and agrees with report.json."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.control.commands import PD
from flexdyn.control.samples import Samples
from flexdyn.diagnose.report.digits import percent, probability_text, rounded, times
from flexdyn.diagnose.report.measures import Gap, JointError, Left, ResidualPlace, SignalError
from flexdyn.diagnose.report.origin import RecordingSpan
from flexdyn.diagnose.report.pictures import PICTURES
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import next_measurements, verdict_sentence
from flexdyn.diagnose.report.suspects import Considered, Experiment, Finding, Number, Structure, Suspect
from flexdyn.diagnose.report.trace import ResidualTrace
from tests.browser import open_page
from tests.diagnose import report_cases as cases

pytestmark = pytest.mark.usefixtures("one_browser")

MADE = pytest.mark.parametrize("made", [*cases.CASES, cases.robot])
SHOWN = (cases.explained, cases.interrupted_early)
"""Whose pages CI looks at; `pytest -m slow` looks at all others."""
DRAWN = [made if made in SHOWN else pytest.param(made, marks=pytest.mark.slow) for made in (*cases.CASES, cases.robot)]


@pytest.mark.parametrize("made", DRAWN)
def test_the_page_opens_without_a_network(made: Callable[[], Diagnosis], tmp_path: Path) -> None:
    """The verdict can be read, residuals are drawn, nothing is wider than the window, nothing is asked for."""
    diagnosis = made()
    diagnosis.save(tmp_path)
    with open_page(tmp_path / "report.html", width=1400) as page:
        open_pictures = min(len(diagnosis.residuals), PICTURES) + bool(diagnosis.trajectories)
        page.wait_for(f"document.querySelectorAll('.js-plotly-plot').length == {open_pictures}")
        heading = page.tab.locator("#verdict")
        assert heading.is_visible()
        assert heading.inner_text() == verdict_sentence(diagnosis)
        told = page.tab.locator("main").inner_text()
        for note in (*diagnosis.notes, *next_measurements(diagnosis)):
            assert note in told
        for width in (1400, 800, 600):
            page.tab.set_viewport_size({"width": width, "height": 900})
            page.wait_for(f"document.documentElement.scrollWidth == {width}")
        tall = "[...document.querySelectorAll('.modebar')].filter(bar => bar.offsetHeight > 40).length"
        assert page.tab.evaluate(tall) == 0, "buttons cover the pictures, which nobody can point at then"
        # Plotly offers to upload a chart to its own cloud. That no button does is part of the check of every page.
        assert (page.tab.evaluate("document.querySelectorAll('.modebar-btn').length") > 4) == (open_pictures > 0)
        assert page.tab.evaluate("document.querySelectorAll('a, form, iframe, link[href^=http]').length") == 0
        servers = "[...document.querySelectorAll('.js-plotly-plot')].map(each => each._context.plotlyServerURL)"
        assert page.tab.evaluate(servers) == [""] * open_pictures


@MADE
def test_the_page_says_what_the_json_says(made: Callable[[], Diagnosis], tmp_path: Path) -> None:
    """Probabilities, gaps, errors and what is left, read back from both files."""
    made().save(tmp_path)
    document = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    with open_page(tmp_path / "report.html", scripts=False) as page:
        page.tab.evaluate("document.querySelectorAll('details').forEach(fold => { fold.open = true; })")
        told = page.tab.locator("main").inner_text().replace("\N{NO-BREAK SPACE}", " ")
    for finding in document["findings"]:
        assert probability_text(finding["probability"]) in told
    for gap in document["gap"].values():
        for value in (gap or {}).values():
            assert times(float("inf") if value is None else value) in told
    for joint, error in document["errors"].items():
        known = [value for key in ("before", "after") if (value := error["torque"][key]) is not None]
        assert all(text in told for text in (joint, *map(rounded, known)))
    for left in document["left"]:
        assert percent(left["share_of_torque"]) in told
    assert ("model.yaml was not written" in told) == (not (tmp_path / "model.yaml").exists())


@pytest.mark.parametrize("made", [cases.interrupted, cases.interrupted_early])
def test_an_interruption_is_said_first_and_large(made: Callable[[], Diagnosis], tmp_path: Path) -> None:
    """Above everything else, in the largest letters of the page, and nothing is said of what no effect explains."""
    diagnosis = made()
    diagnosis.save(tmp_path)
    with open_page(tmp_path / "report.html", scripts=False) as page:
        assert page.tab.locator("main").inner_text().startswith("INTERRUPTED")
        size = "element => parseFloat(getComputedStyle(element).fontSize)"
        stop, heading = (page.tab.locator(each).evaluate(size) for each in (".stop", "#verdict"))
        assert stop > 1.3 * heading
        told = page.tab.locator("header").inner_text()
        assert "accounts for" not in told
        assert diagnosis.stopped_at.split(" (")[0].split(":")[0] in told
        assert ("Established by then" in told) == bool(diagnosis.findings)
        assert "worse" not in page.tab.locator("main").inner_text()
        assert page.tab.evaluate("document.title").startswith("Interrupted")


def test_the_page_tells_what_was_found_and_why(tmp_path: Path) -> None:
    """Numbers with their intervals and units, evidence, rivals, the experiment, everything else."""
    cases.explained().save(tmp_path)
    with open_page(tmp_path / "report.html", scripts=False) as page:
        page.tab.evaluate("document.querySelectorAll('details').forEach(fold => { fold.open = true; })")
        told = page.tab.locator("main").inner_text()
    for text in (
        "1.102 to 1.298 N m",
        "0.0232 to 0.0388 rad/s",
        "log Bayes factor 406 (very strong evidence)",
        "If it alone is left out, 62 % of the improvement on the test data is lost.",
        "flexdyn diagnose arm.yaml monday.csv -o out",
        "2026-02-28 09:30:00+01:00",
        "mass of link2",
        "8011.50",
        "The data do not separate these effects:",
        cases.SWEEPS,
        "on channel q.elbow",
        "at frame tip",
        "rotor inertia of shoulder",
        "its cause may lie elsewhere",
        "with presliding friction on the motor side of elbow",
        cases.RIVAL_NOTE,
        "monday.csv",
        "41.6 to 52 s",
        "theta.elbow 1.4e\N{MINUS SIGN}07 rad",
    ):
        assert text in told, text
    assert "1. Stribeck friction or presliding friction" in told


def test_much_is_folded_away_and_drawn_when_it_is_opened(tmp_path: Path) -> None:
    """Of a robot that lacks much: some findings and pictures stand open, the others come on a click."""
    diagnosis = cases.robot()
    diagnosis.save(tmp_path)
    with open_page(tmp_path / "report.html") as page:
        page.wait_for(f"document.querySelectorAll('.js-plotly-plot').length == {PICTURES}")
        assert page.tab.locator("article:visible").count() == 4
        page.tab.locator("#residuals summary").click()
        page.wait_for(f"document.querySelectorAll('.js-plotly-plot').length == {len(diagnosis.residuals)}")
        page.wait_for_buttons()
        wide = "[...document.querySelectorAll('#residuals .main-svg')].every(each => each.clientWidth > 200)"
        assert page.tab.evaluate(wide)
    assert len((tmp_path / "report.html").read_bytes()) < 3e6


MARKUP = "</script><img src=x onerror=\"document.title='stolen'\"><b>{{STYLE}}'&lt;"


def test_names_of_any_origin_do_no_harm(tmp_path: Path) -> None:
    """Joints, files, notes and titles that are markup are shown as they are written, and no script of theirs runs."""
    evil = f"\x1b[31m\u202e{MARKUP}{'n' * 10_000}"
    suspect = Suspect(evil, evil, "motor", {evil: Number(1.0, 0.1, evil)}, {"channel": evil})
    rival = dataclasses.replace(suspect, place={})
    diagnosis = dataclasses.replace(
        cases.unexplained(),
        findings=(Finding(suspect, 0.99, 20.0, 0.5, (rival,), evil, _plan(evil)),) * 3,
        gap_test=Gap(3.0, 2.0, 1.0, 1.0),
        errors={evil: JointError(SignalError(1.0, 0.5, evil, size=10.0), SignalError(0.1, 0.1, evil))},
        where=(ResidualPlace(evil, "motor", 0.5, evil),),
        left=(Left(evil, 0.1, 0.1, (evil,)),),
        structures=(Structure((suspect,), 0.9, -1.0), Structure((rival,), 0.1, -2.0)),
        data=(RecordingSpan(evil, "fit", 0.0, 1.0, 100.0, {evil: 0.1}),),
        notes=(evil,),
        residuals=(ResidualTrace(evil, evil, evil, np.arange(3.0), np.arange(3.0), np.arange(3.0)),),
        considered=(Considered(suspect, 0.9, 1.0, evil),),
        stopped=(evil,),
    )
    diagnosis.save(tmp_path)
    with open_page(tmp_path / "report.html") as page:
        page.wait_for("document.querySelectorAll('.js-plotly-plot .xtitle').length >= 1")
        assert page.tab.title() == "Diagnosis of scara_two_link"
        seen = evil[evil.index("<") : 1000]
        assert seen in page.tab.locator("#verdict").inner_text()
        assert seen in page.tab.locator(".js-plotly-plot .xtitle").first.text_content()
        assert seen in page.tab.locator(".figures h4").first.text_content()
        assert page.tab.evaluate("document.querySelectorAll('img, b b').length") == 0


def test_no_script_but_its_own_runs(tmp_path: Path) -> None:
    """The page's policy stops a script that someone put into the file."""
    cases.no_discrepancy().save(tmp_path)
    path = tmp_path / "report.html"
    text = path.read_text(encoding="utf-8").replace("</main>", "</main><script>window.stolen = 1</script>")
    path.write_text(text, encoding="utf-8")
    with open_page(path) as page:
        assert page.tab.evaluate("window.stolen === undefined")
        assert [error for error in page.errors if "Content Security Policy" in error]
        page.errors.clear()


def test_a_proposed_experiment_is_drawn(tmp_path: Path) -> None:
    """The motion, and what the rival would leave unexplained."""
    first, *rest = cases.explained().findings
    planned = dataclasses.replace(first, plan=_plan("Stribeck friction"))
    dataclasses.replace(cases.explained(), findings=(planned, *rest), residuals=()).save(tmp_path)
    with open_page(tmp_path / "report.html") as page:
        page.wait_for("document.querySelectorAll('#plan-0 .main-svg').length > 0")
        told = page.tab.locator("#plans").inner_text()
    assert "Stribeck friction or presliding friction?" in told
    assert "10 times the noise" in told


def _plan(name: str) -> Experiment:
    t = np.linspace(0.0, 5.0, 50)
    reference = Samples(t, np.zeros((50, 2)), interpolation="cubic")
    arm = fd.load_model("scara_two_link")
    command = PD(reference, kp=100.0, kd=10.0)
    assert arm.n == 2
    names, labels = (name, "presliding friction"), ("q [rad]", "left [N m]")
    return Experiment("sweep", 20.0, 4, 0.0, 100.0, command, names, t, np.sin(t), 0.1 * np.cos(t), labels)


def test_the_page_in_print(tmp_path: Path) -> None:
    """Pictures are drawn for the width of the paper before it is printed, and for the window again afterwards."""
    cases.explained().save(tmp_path)
    widths = (
        "() => ['#trace-0 .main-svg', '#trace-0']"
        ".map((each) => document.querySelector(each).getBoundingClientRect().width)"
    )
    with open_page(tmp_path / "report.html", width=1400) as page:
        page.wait_for("document.querySelector('#trace-0 .main-svg') !== null")
        before, _ = page.tab.evaluate(widths)
        page.tab.evaluate("dispatchEvent(new Event('beforeprint'))")
        drawn, room = page.tab.evaluate(widths)
        assert drawn == pytest.approx(room, abs=1.0)
        assert drawn <= 345.0 < before
        page.tab.evaluate("dispatchEvent(new Event('afterprint'))")
        back = "document.querySelector('#trace-0 .main-svg').getBoundingClientRect().width"
        page.wait_for(f"(wide) => Math.abs({back} - wide) < 2", before)
        assert page.tab.pdf(format="A4").startswith(b"%PDF")
