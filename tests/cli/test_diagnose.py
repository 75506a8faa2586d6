"""flexdyn diagnose: recordings in, a report out; what is told on the way, whatever the answer."""

from __future__ import annotations

import datetime
import importlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

import flexdyn as fd
from flexdyn.cli.diagnose import repeated_option
from flexdyn.diagnose.report.result import Diagnosis, Interrupted
from tests.cli.conftest import Runner
from tests.diagnose import report_cases as cases

FILES = ["model.yaml", "report.html", "report.json"]
Given = dict[str, Any]
Answer = Callable[[Diagnosis | BaseException], Given]


@pytest.fixture(autouse=True)
def recordings(tmp_path: Path) -> None:
    """Three short recordings of one arm."""
    run = fd.simulate(fd.load_model("scara_two_link"), [0.1, 0.0], duration=0.2, rate=200)
    for name in ("a", "b", "c"):
        run.save(tmp_path / f"{name}.csv")


@pytest.fixture
def answer(monkeypatch: pytest.MonkeyPatch) -> Answer:
    """Put a diagnosis with a given outcome in the place of the real one, which takes its time."""

    def _answer(outcome: Diagnosis | BaseException) -> Given:
        given: Given = {}

        def diagnose(
            model: fd.FlexibleJointModel,
            fit: Sequence[fd.Recording],
            check: Sequence[fd.Recording] = (),
            *,
            hold_out: Sequence[tuple[float, float]] = (),
            expect: Sequence[str] = (),
        ) -> Diagnosis:
            names = {"fit": [each.name for each in fit], "check": [each.name for each in check]}
            given.update(model=model, **names, hold_out=list(hold_out), expect=list(expect))
            if isinstance(outcome, BaseException):
                raise outcome
            return outcome

        monkeypatch.setattr(importlib.import_module("flexdyn.diagnose"), "diagnose", diagnose)
        return given

    return _answer


def test_effects_that_are_expected_are_handed_on(flexdyn: Runner, answer: Answer) -> None:
    """As often as there are some."""
    given = answer(cases.explained())
    expected = ("--expect", "torque_saturation", "--expect", "channel_lag")
    assert flexdyn("diagnose", "scara_two_link", "a.csv", *expected, "-o", "out").code == 0
    assert given["expect"] == ["torque_saturation", "channel_lag"]


def test_a_report_is_written_and_told(flexdyn: Runner, answer: Answer) -> None:
    """The verdict, the findings with their rivals, the gap, the notes, and where the report is."""
    given = answer(cases.explained())
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "b.csv", "--check", "c.csv", "-o", "there/out")
    assert (outcome.code, outcome.err) == (0, "")
    assert (given["fit"], given["check"], given["model"].name) == (["a", "b"], ["c"], "scara_two_link")
    assert sorted(path.name for path in Path("there/out").iterdir()) == FILES
    told = " ".join(outcome.out.split())
    for text in (
        "The disagreement has 4 causes; the largest is Stribeck friction",
        "or spring hysteresis in the transmission of",
        "p: posterior probability",
        "on the motor side of elbow",
        "excess        1.200  N m      1.102 to 1.298",
        "406",
        "60 %",
        "stiffness of shoulder",
        "from 12.4 to 1.07",
        "1.73, 0.0810 N m",
        "torques that repeat every turn are not seen",
        "there/out/report.html",
    ):
        assert " ".join(text.split()) in told


@pytest.mark.parametrize("made", [each for each in cases.CASES if each is not cases.interrupted])
def test_every_verdict_is_exit_code_0(flexdyn: Runner, answer: Answer, made: Callable[[], Diagnosis]) -> None:
    """An answer is an answer, also "no discrepancy", "unexplained" and "not converged"."""
    answer(made())
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert (outcome.code, outcome.err) == (0, "")
    assert Path("out/report.html").exists()


def test_json_is_the_report(flexdyn: Runner, answer: Answer) -> None:
    """On stdout what report.json holds, and nothing else."""
    answer(cases.partly())
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out", "--json")
    assert outcome.json == json.loads(Path("out/report.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "arguments",
    [
        ("scara_two_link", "a.csv", "--check", "b.csv", "c.csv", "-o", "out"),
        ("scara_two_link", "a.csv", "--check", "b.csv", "--check", "c.csv", "-o", "out"),
        ("--check", "b.csv", "--check", "c.csv", "scara_two_link", "a.csv", "-o", "out"),
        ("scara_two_link", "a.csv", "-o", "out", "--check=b.csv", "c.csv"),
        ("--json", "-o", "out", "scara_two_link", "a.csv", "--check", "b.csv", "c.csv"),
    ],
)
def test_checks_in_both_forms(flexdyn: Runner, answer: Answer, arguments: tuple[str, ...]) -> None:
    """Several after one option, or each after its own, wherever the other options stand."""
    given = answer(cases.no_discrepancy())
    assert flexdyn("diagnose", *arguments).code == 0
    assert (given["fit"], given["check"]) == (["a"], ["b", "c"])


def test_options_after_checks_keep_their_values() -> None:
    """A value that follows another option is no check, and neither is what follows two dashes."""
    takes = {"--check": 1, "-o": 1, "--json": 0}
    typed = ["m", "a", "--check", "b", "c", "-o", "out", "--check", "d", "--json", "--", "e"]
    read = ["m", "a", "--check", "b", "--check", "c", "-o", "out", "--check", "d", "--json", "--", "e"]
    assert repeated_option(typed, takes) == read


def test_a_map_reads_every_recording(flexdyn: Runner, answer: Answer) -> None:
    """Of the fit and of the check alike."""
    given = answer(cases.no_discrepancy())
    for name in ("a", "b"):
        text = Path(f"{name}.csv").read_text(encoding="utf-8")
        Path(f"{name}.csv").write_text(text.replace("q.elbow", "angle", 1), encoding="utf-8")
    Path("map.yaml").write_text(
        "flexdyn_map: 1\ntime: {from: t}\nchannels:\n"
        "  q.elbow: {from: angle, unit: deg}\n  tau.elbow: {from: tau.elbow}\n",
        encoding="utf-8",
    )
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "--check", "b.csv", "--map", "map.yaml", "-o", "out")
    assert (outcome.code, given["fit"], given["check"]) == (0, ["a"], ["b"])


def test_explanations_follow_the_answer(flexdyn: Runner, answer: Answer) -> None:
    """Why a name was given or was not, for people and for programs."""
    answer(cases.explained())
    asked = ("--explain", "coulomb_friction@elbow", "--explain", "payload")
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", *asked, "-o", "out")
    assert (outcome.code, outcome.err) == (0, "")
    assert "Coulomb friction on the motor side of elbow\n  Not named: its probability is 0.02" in outcome.out
    assert "Payload at frame tip\n  Named: its probability is above 0.999" in outcome.out
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", *asked, "-o", "out", "--json")
    assert list(outcome.json["explanations"]) == ["coulomb_friction@elbow", "payload"]


def test_a_missing_model_is_said(flexdyn: Runner, answer: Answer) -> None:
    """Where the corrected model is worse, nothing points to a file that is not there."""
    answer(cases.not_converged())
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert "The report is out/report.html. model.yaml was not written: on the data of the fit" in outcome.out
    assert not Path("out/model.yaml").exists()


def test_the_report_says_what_was_done(flexdyn: Runner, answer: Answer, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command line as it was typed, and every file with its size and date, before the report is written."""
    answer(cases.partly())
    typed = ["diagnose", "scara_two_link", "a.csv", "--check", "b.csv", "-o", "out put"]
    monkeypatch.setattr("sys.argv", ["/somewhere/flexdyn", *typed])
    assert flexdyn(*typed).code == 0
    record = json.loads(Path("out put/report.json").read_text(encoding="utf-8"))["record"]
    assert record["command"] == "flexdyn diagnose scara_two_link a.csv --check b.csv -o 'out put'"
    assert [(each["path"], each["use"]) for each in record["files"]] == [("a.csv", "fit"), ("b.csv", "test")]
    assert [each["bytes"] for each in record["files"]] == [Path(name).stat().st_size for name in ("a.csv", "b.csv")]
    now = datetime.datetime.now().astimezone()
    for text in (record["date"], *(each["modified"] for each in record["files"])):
        assert (
            datetime.timedelta(seconds=-2) < now - datetime.datetime.fromisoformat(text) < datetime.timedelta(minutes=5)
        )


def test_ctrl_c_leaves_what_is_known(flexdyn: Runner, answer: Answer) -> None:
    """The partial answer is a report that says so, whatever verdict it came with; exit code of an interrupt."""
    answer(Interrupted(cases.unexplained()))
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert outcome.code == 130
    assert "what was known by then is in out/report.html" in outcome.err
    assert outcome.err.endswith("flexdyn: interrupted\n")
    document = json.loads(Path("out/report.json").read_text(encoding="utf-8"))
    assert document["verdict"] == "interrupted"


@pytest.mark.parametrize("stop", [Interrupted(), KeyboardInterrupt()])
def test_ctrl_c_before_anything_is_known(flexdyn: Runner, answer: Answer, stop: BaseException) -> None:
    """No report, and one line."""
    answer(stop)
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert (outcome.code, outcome.err) == (130, "flexdyn: interrupted\n")
    assert not Path("out").exists()


def test_data_that_cannot_answer(flexdyn: Runner, answer: Answer) -> None:
    """The diagnosis' own refusal is one line with the recording's name, and nothing is written."""
    answer(fd.InputError("the torque never changes", key="tau.elbow", remedy="record a motion"))
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert outcome.code == 2
    assert outcome.err == "flexdyn: a.csv: tau.elbow: the torque never changes; record a motion\n"
    assert not Path("out").exists()


@pytest.mark.parametrize("key", ["effects[4].velocity", "joints.elbow.stiffness", "links.forearm.mass"])
def test_a_number_of_the_model_is_told_with_the_file_of_the_model(flexdyn: Runner, answer: Answer, key: str) -> None:
    """What the data do not tell of an unknown number is mended there, and not in the recording."""
    answer(fd.InputError("these data do not tell it", key=key, value="unknown", remedy="give it a value"))
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert outcome.code == 2
    assert outcome.err == (
        f"flexdyn: scara_two_link: {key}: these data do not tell it, got 'unknown'; give it a value\n"
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("scara_two_link", "a.csv"), "--output: say where to write"),
        (("scara_two_link", "a.csv", "-o", "b.csv"), "b.csv: --output: it is a file"),
        (("scara_two_link", "a.csv", "-o", "b.csv/out"), "--output: a folder cannot be made in a file"),
        (("scara_two_link", "-o", "out"), "missing argument 'FIT...'"),
        (("scara_two_link", "nothing.csv", "-o", "out"), "nothing.csv: no such file"),
        (("scara_too_link", "a.csv", "-o", "out"), "did you mean 'scara_two_link'?"),
        (("scara_two_link", "a.csv", "--check", "./a.csv", "-o", "out"), "a.csv: --check: it is one of FIT too"),
        (
            ("scara_two_link", "a.csv", "-o", "out", "--explain", "coulom_friction@elbow"),
            "--explain: no such effect, got 'coulom_friction'; did you mean 'coulomb_friction'?",
        ),
        (
            ("scara_two_link", "a.csv", "-o", "out", "--explain", "coulomb_friction@elbwo"),
            "--explain: no such place, got 'coulomb_friction@elbwo'; did you mean 'elbow'?",
        ),
        (("scara_two_link", "a.csv", "-o", "out", "--thorough"), "no such option"),
        (("panda", "a.csv", "-o", "out", "--chek", "b.csv"), "'--chek': no such option; did you mean '--check'?"),
    ],
)
def test_mistakes_are_one_line(flexdyn: Runner, answer: Answer, arguments: tuple[str, ...], words: str) -> None:
    """Exit code 2 before any work is done."""
    given = answer(cases.no_discrepancy())
    outcome = flexdyn("diagnose", *arguments)
    assert outcome.code == 2
    assert words.lower() in outcome.err.lower()
    assert outcome.err.count("\n") == 1
    assert not given


def test_the_given_model_is_not_overwritten(flexdyn: Runner, answer: Answer) -> None:
    """A folder whose model.yaml is the one to be diagnosed is refused."""
    given = answer(cases.no_discrepancy())
    fd.save_model(fd.load_model("scara_two_link"), "model.yaml")
    outcome = flexdyn("diagnose", "model.yaml", "a.csv", "-o", ".")
    assert (outcome.code, given) == (2, {})
    assert "model.yaml: --output: the command reads this file; write to another folder" in outcome.err


def test_without_the_extra_no_work_is_begun(flexdyn: Runner, answer: Answer, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the report is drawn with is asked for first."""
    given = answer(cases.no_discrepancy())
    monkeypatch.setattr("flexdyn.errors.find_spec", lambda name: None)
    outcome = flexdyn("diagnose", "scara_two_link", "a.csv", "-o", "out")
    assert (outcome.code, given) == (2, {})
    assert "flexdyn[plot]" in outcome.err
