"""What a diagnosis writes: report.json by the contract, a model that simulates, a page that opens anywhere."""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.pictures import effect_of, law_picture
from flexdyn.diagnose.result import Diagnosis, Finding, Gap, Interrupted, Number, Place, Suspect
from flexdyn.diagnose.trace import Trace
from flexdyn.diagnose.words import (
    next_measurements,
    verdict_sentence,
)
from flexdyn.plots.laws import law_figure
from tests.arms import SLIDER
from tests.browser import open_page
from tests.diagnose import answers

MADE = {
    made.__name__: made for made in (answers.explained, answers.no_discrepancy, answers.unexplained, answers.partly)
}
SENTENCES = {
    "explained": "The disagreement has 4 causes, above all Stribeck friction or presliding friction on the motor side"
    " of elbow, or spring hysteresis in the transmission of elbow.",
    "no_discrepancy": "Model and measurement agree: what is left between them is noise, once 1 number of the model has"
    " moved within tolerance.",
    "unexplained": "Model and measurement disagree, most of all on the motor side of elbow, and no effect of the"
    " catalogue accounts for it.",
    "partly": "Part of the disagreement is explained by Coulomb friction on the link side of shoulder; what is left, no"
    " effect of the catalogue accounts for.",
}
NUMBER = (int, float)
GAP = {"before": NUMBER, "calibrated": NUMBER, "after": NUMBER, "floor": NUMBER}
SUSPECT = {"effect": str, "joint": (str, type(None)), "side": (str, type(None)), "parameters": dict}
SCHEMA = {
    "schema": str,
    "verdict": str,
    "findings": list,
    "calibration": list,
    "gap": {"fit": GAP, "check": GAP},
    "where": list,
    "seconds": NUMBER,
}
"""The example of the contract, read key by key."""
ENTRIES: dict[str, dict[str, Any]] = {
    "findings": SUSPECT
    | {"evidence": {"delta_bic": NUMBER, "check_gain": NUMBER}, "indistinguishable_from": list, "experiment": str},
    "calibration": {"of": str, "parameter": str, "factor": NUMBER, "std": NUMBER, "tolerance": NUMBER},
    "where": {"joint": str, "side": str, "share": NUMBER, "regime": str},
}


@pytest.mark.parametrize("name", MADE)
def test_the_json_is_what_the_contract_says(name: str, tmp_path: Path) -> None:
    """Every key of the contract is there, with its type; JSON by the letter, in which unknown numbers are null."""
    MADE[name]().save(tmp_path)
    text = (tmp_path / "report.json").read_text(encoding="utf-8")
    document = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert document["schema"] == "flexdyn.diagnosis/1"
    assert document["verdict"] in ("no_discrepancy", "explained", "unexplained")
    _holds(document, SCHEMA)
    for key, kinds in ENTRIES.items():
        for entry in document[key]:
            _holds(entry, kinds)
    for finding in document["findings"]:
        for suspect in (finding, *finding["indistinguishable_from"]):
            _holds(suspect, SUSPECT)
            for number in suspect["parameters"].values():
                _holds(number, {"value": NUMBER, "std": NUMBER, "unit": str})


def test_the_json_tells_where_a_sensor_and_a_payload_are(tmp_path: Path) -> None:
    """A payload has neither joint nor side; a sensor effect names its channel, a wrong number whose it is."""
    answers.explained().save(tmp_path)
    stribeck, payload, wrong, offset = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["findings"]
    assert stribeck["parameters"]["excess"] == {"value": 1.2, "std": 0.05, "unit": "N m"}
    assert [rival["effect"] for rival in stribeck["indistinguishable_from"]] == [
        "presliding_friction",
        "spring_hysteresis",
    ]
    assert (payload["joint"], payload["side"], payload["frame"]) == (None, None, "tip")
    assert (wrong["of"], wrong["parameter"]) == ("shoulder", "stiffness")
    assert (offset["channel"], offset["side"]) == ("q.elbow", "sensor")


@pytest.mark.parametrize("name", MADE)
def test_the_page_opens_without_a_network(name: str, tmp_path: Path) -> None:
    """The verdict can be read, every residual is drawn, nothing is wider than the window, nothing is asked for."""
    diagnosis = MADE[name]()
    diagnosis.save(tmp_path)
    with open_page(tmp_path / "report.html", width=1280) as page:
        page.wait_for(f"document.querySelectorAll('.js-plotly-plot').length == {len(diagnosis.residuals)}")
        heading = page.tab.locator("#verdict")
        assert heading.is_visible()
        assert heading.inner_text() == SENTENCES[name] == verdict_sentence(diagnosis)
        told = page.tab.locator("main").inner_text()
        for note in (*diagnosis.notes, *next_measurements(diagnosis)):
            assert note in told
        for width in (1280, 600):
            page.tab.set_viewport_size({"width": width, "height": 900})
            page.wait_for(f"document.documentElement.scrollWidth == {width}")
        tall = "[...document.querySelectorAll('.modebar')].filter(bar => bar.offsetHeight > 40).length"
        assert page.tab.evaluate(tall) == 0, "buttons cover the pictures, which nobody can point at then"


def test_the_page_tells_what_was_found_and_why(tmp_path: Path) -> None:
    """Numbers with their intervals and units, evidence, rivals, the experiment, laws as pictures, the calibration."""
    answers.explained().save(tmp_path)
    with open_page(tmp_path / "report.html") as page:
        told = page.tab.locator("main").inner_text()
        drawn = "() => [...document.querySelectorAll('article img')].map(image => image.naturalWidth)"
        widths = page.tab.evaluate(drawn)
    for text in ("1.102 to 1.298 N m", "0.0232 to 0.0388 rad/s", "\N{GREEK CAPITAL LETTER DELTA}BIC = 812"):
        assert text in told
    for text in ("62 % of the gap", answers.SWEEPS, "on channel q.elbow", "at frame tip", "rotor inertia of shoulder"):
        assert text in told
    assert "1. Stribeck friction or presliding friction" in told
    assert "or spring hysteresis" in told.lower()
    for text in ("Wrong mass of link2", "\N{MINUS SIGN}12", "18\N{NARROW NO-BREAK SPACE}810", "not asked", "3.20"):
        assert text in told, "what else was tried for the payload, on both kinds of data"
    assert len(widths) == 2, "Stribeck friction and the offset have laws, a payload and a factor have none"
    assert min(widths) > 100


def test_names_of_any_origin_do_no_harm(tmp_path: Path) -> None:
    """Joints, notes and titles that are markup are shown as they are written, and no script of theirs runs."""
    evil = "</script><img src=x onerror=\"document.title='stolen'\"><b>{{STYLE}}'&lt;"
    suspect = Suspect(evil, evil, "motor", {evil: Number(1.0, 0.1, evil)}, {"channel": evil})
    finding = Finding(suspect, 20.0, 0.5, (dataclasses.replace(suspect, place={}),), evil)
    gap = Gap(3.0, 2.0, 1.0, 1.0)
    residuals = (Trace(evil, evil, evil, np.arange(3.0), np.arange(3.0), np.arange(3.0)),)
    model = fd.load_model("scara_two_link")
    places = (Place(evil, "motor", 0.5, evil),)
    Diagnosis("unexplained", (finding,), (), gap, gap, places, model, (evil,), 1.0, residuals).save(tmp_path)
    with open_page(tmp_path / "report.html") as page:
        page.wait_for("document.querySelectorAll('.js-plotly-plot .gtitle').length == 1")
        assert page.tab.title() == "Diagnosis of scara_two_link"
        assert evil in page.tab.locator("#verdict").inner_text()
        assert evil in page.tab.locator(".js-plotly-plot .gtitle").text_content()
        assert page.tab.evaluate("document.querySelectorAll('img').length") == 0


def test_no_script_but_its_own_runs(tmp_path: Path) -> None:
    """The page's policy stops a script that someone put into the file."""
    answers.no_discrepancy().save(tmp_path)
    path = tmp_path / "report.html"
    text = path.read_text(encoding="utf-8").replace("</main>", "</main><script>window.stolen = 1</script>")
    path.write_text(text, encoding="utf-8")
    with open_page(path) as page:
        assert page.tab.evaluate("window.stolen === undefined")
        assert [error for error in page.errors if "Content Security Policy" in error]
        page.errors.clear()


def test_a_report_is_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the new one cannot be finished, the old one is untouched and nothing else is left behind."""
    answers.explained().save(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fails(*arguments: Any, **settings: Any) -> str:
        raise MemoryError

    monkeypatch.setattr(sys.modules["flexdyn.diagnose.report"], "page", fails)
    with pytest.raises(MemoryError):
        answers.no_discrepancy().save(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    """A file where the folder should be is one clear line."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(fd.InputError, match="file: it is a file; give a folder"):
        answers.no_discrepancy().save(tmp_path / "file")


def test_without_plotly_nothing_is_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The extra that is missing is named."""
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(fd.MissingExtra, match=r"flexdyn\[plot\]"):
        answers.explained().save(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_sliding_joint_reads_newton_and_metre(tmp_path: Path) -> None:
    """The picture of a law has the units of its joint."""
    (tmp_path / "slider.urdf").write_text(SLIDER, encoding="utf-8")
    model = fd.FlexibleJointModel(fd.load_robot(tmp_path / "slider.urdf"))
    numbers = {"level": Number(2.5, 0.1, "N")}
    suspect = Suspect("coulomb_friction", "lift", "link", numbers)
    effect = effect_of(suspect)
    assert effect == fd.effects.CoulombFriction("lift", side="link", level=2.5)
    axes = law_figure(effect, prismatic=True).axes[0]
    assert (axes.get_xlabel()[-5:], axes.get_ylabel()[-3:]) == ("[m/s]", "[N]")
    picture = law_picture(suspect, model)
    assert picture is not None
    assert picture != law_picture(suspect, fd.load_model("scara_two_link"))


@pytest.mark.parametrize(
    "suspect",
    [
        Suspect("presliding_friction", "elbow", "motor"),
        Suspect("payload", None, None, {"mass": Number(1.0, 0.1, "kg")}),
        Suspect("no_such_effect", "elbow", "motor"),
        Suspect("coulomb_friction", "elbow", "motor", {"level": Number(math.nan, 0.1, "N m")}),
    ],
)
def test_what_cannot_be_drawn_is_left_out(suspect: Suspect) -> None:
    """No numbers, no law, no such effect, a number that is none."""
    assert law_picture(suspect, fd.load_model("scara_two_link")) is None


def test_every_law_of_the_catalogue_can_stand_in_a_report() -> None:
    """With its example's numbers as the ones found: what `draw_law` draws, the report shows."""
    model = fd.load_model("scara_two_link")
    drawn = {name: law_picture(_example(kind), model) for name, kind in fd.effects.catalogue().items()}
    assert {name for name, picture in drawn.items() if picture is None} == {"payload", "parameter_error"}
    assert all(picture is None or picture.startswith("data:image/svg+xml;base64,") for picture in drawn.values())


def test_an_interrupt_is_one_that_carries_what_is_known() -> None:
    """Uncaught it ends a program as Ctrl-C does."""
    diagnosis = answers.no_discrepancy()
    assert isinstance(Interrupted(diagnosis), KeyboardInterrupt)
    assert Interrupted(diagnosis).diagnosis is diagnosis
    assert Interrupted().diagnosis is None


def _holds(entry: Any, kinds: dict[str, Any]) -> None:
    """Every key is there with its type, or null in place of a number."""
    for key, kind in kinds.items():
        assert key in entry, key
        if isinstance(kind, dict):
            if entry[key] is not None:
                _holds(entry[key], kind)
        else:
            assert isinstance(entry[key], kind) or (kind is NUMBER and entry[key] is None), (key, entry[key])
            assert not isinstance(entry[key], bool)


def _example(kind: type[fd.effects.Effect]) -> Suspect:
    entry = kind.example().to_dict()
    numbers = {field.name: Number(entry.pop(field.name), 0.1, "1") for field in kind.parameters()}
    place: Callable[[str], Any] = entry.pop
    del entry["effect"]
    joint, side = (place(key) if key in entry else None for key in ("joint", "side"))
    return Suspect(kind.name, joint, side, numbers, entry)
