"""The study's bench and what it says of a diagnosis; the diagnosis itself runs once, in tests/discovery."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.figure
import numpy as np
import pytest

from flexdyn.diagnose.report.measures import Gap
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Finding, Number, Suspect
from flexdyn.paper import bench, hidden_friction, run_paper_study, study
from flexdyn.paper.bench import Bench
from flexdyn.paper.cases import PaperCases
from flexdyn.paper.hidden_friction_figure import draw_hidden_friction

NAMES = ("coulomb_friction", "stribeck_friction")


@pytest.fixture(scope="module")
def made(cases: PaperCases) -> Bench:
    """The arm on its bench."""
    return Bench(cases)


def answer(cases: PaperCases, *, leave_out: int = 0, wrong: float = 1.0) -> Diagnosis:
    """What a perfect diagnosis says, or one that misses some effects or errs in a number."""
    findings = []
    for effect in hidden_friction.hidden(cases.model)[leave_out:]:
        numbers = {
            entry.name: Number(wrong * float(getattr(effect, entry.name)), 1e-4, str(entry.metadata["unit"]))
            for entry in effect.parameters()
        }
        findings.append(Finding(Suspect(effect.name, effect.joint, effect.side, numbers), 0.999, 5e3, 0.3))  # type: ignore[attr-defined]
    gap = Gap(300.0, 200.0, 1.02, 1.0)
    return Diagnosis("explained", tuple(findings), cases.model, gap_fit=gap, gap_test=gap)


def test_the_motion_rests_at_every_corner() -> None:
    """Through all corners, with no velocity there, so that dry friction is seen to stick and to break away."""
    wanted = bench.corner_motion(bench.FIT)
    assert wanted.shape == (40_001, 2)
    for j, corners in enumerate(bench.FIT):
        for t, angle in corners:
            k = round(t * bench.BENCH_RATE)
            assert wanted[k, j] == pytest.approx(angle, abs=1e-12)
            assert np.ptp(wanted[max(k - 2, 0) : k + 3, j]) < 1e-5


def test_the_arm_follows_sticks_and_sweeps(made: Bench) -> None:
    """Control holds the arm near what is wanted; both joints rest for a while, creep, and move fast."""
    run = made.runs["fit"]
    assert np.abs(run.theta - bench.corner_motion(bench.FIT)).max() < 0.3
    for j in (0, 1):
        speed = np.abs(run.v[:, j])
        assert (speed == 0.0).mean() > 0.01
        assert ((speed > 0.0) & (speed < 0.05)).mean() > 0.15
        assert speed.max() > 0.3


def test_sensors_are_as_stated(made: Bench) -> None:
    """Whole counts of 20 bit a turn of the joint and 17 bit a turn of the motor; 0.2 % of the peak torque as noise."""
    for name, run in made.runs.items():
        rec = made.recordings[name]
        for j, joint in enumerate(("shoulder", "elbow")):
            for signal, count, true in (("q", 2.0**20, run.q), ("theta", 100.0 * 2.0**17, run.theta)):
                counts = rec[f"{signal}.{joint}"] * count / (2.0 * np.pi)
                np.testing.assert_allclose(counts, np.round(counts), atol=1e-5)
                left = true[:, j] - rec[f"{signal}.{joint}"]
                assert left.min() >= 0.0
                assert left.max() <= 2.0 * np.pi / count * 1.001
            noise = rec[f"tau.{joint}"] - run.tau[:, j]
            assert noise.std() == pytest.approx(0.002 * np.abs(run.tau[:, j]).max(), rel=0.03)


def test_only_dry_friction_is_hidden(cases: PaperCases) -> None:
    """The model without dry friction keeps limit and viscous friction; K and J are off by at most its tolerance."""
    given = hidden_friction.without_dry_friction(cases.model)
    assert [effect.name for effect in given.effects] == ["torque_speed_limit"] * 2 + ["viscous_friction"] * 2
    assert sorted({effect.name for effect in hidden_friction.hidden(cases.model)}) == list(NAMES)
    for joint, true in cases.model.joints.items():
        for key in ("stiffness", "rotor_inertia"):
            off = abs(getattr(given.joints[joint], key) / getattr(true, key) - 1.0)
            assert 0.01 < off < 0.021


def test_checks_hold_for_the_right_answer_only(cases: PaperCases) -> None:
    """A missing effect, a false one, a doubtful one or a wrong number fails a check."""
    truth = hidden_friction.hidden(cases.model)
    right = answer(cases)
    assert all(check.passed for check in hidden_friction.checks(truth, right))
    missed = hidden_friction.checks(truth, answer(cases, leave_out=1))
    assert [check.passed for check in missed] == [False, True, True]
    false = Finding(Suspect("torque_offset", "elbow", "motor"), 0.99, 10.0, 0.1)
    doubt = dataclasses.replace(right.findings[0], rivals=(false.suspect,))
    for findings in ((*right.findings, false), (doubt, *right.findings[1:])):
        named, *_ = hidden_friction.checks(truth, dataclasses.replace(right, findings=findings))
        assert not named.passed
    assert [check.passed for check in hidden_friction.checks(truth, answer(cases, wrong=1.2))] == [True, False, True]
    unmeasured = hidden_friction.checks(truth, dataclasses.replace(right, gap_test=None))
    assert [check.passed for check in unmeasured] == [True, True, False]


def test_the_gap_falls_with_every_effect(cases: PaperCases, made: Bench, tmp_path: Path) -> None:
    """With all that is missing the gap is the diagnosis' own; on the way it is simulated, and it falls; it is drawn."""
    given, right = hidden_friction.without_dry_friction(cases.model), answer(cases, leave_out=2)
    steps = hidden_friction.gap_steps(given, right, [made.recordings["check"].trim(3.0, 9.0)])
    assert [step.name for step in steps[:2]] == ["as given", "calibrated"]
    assert [step.gap for step in (*steps[:2], *steps[3:])] == [300.0, 200.0, 1.02, 1.0]
    assert 3.0 < steps[2].gap < 200.0
    assert {step.name for step in steps[2:4]} == {f"+ Stribeck friction, {joint}" for joint in ("shoulder", "elbow")}
    canvas = matplotlib.figure.Figure(figsize=(7.16, 3.6), layout="constrained")
    draw_hidden_friction(canvas, made.recordings["check_fig4"], given, right.model, steps)
    canvas.savefig(tmp_path / "gap.png")
    bars = canvas.axes[-1]
    assert [label.get_text() for label in bars.get_yticklabels()] == [step.name for step in steps[:-1]]
    lines = {line.get_label(): line.get_ydata() for line in canvas.axes[1].lines}
    truth = np.degrees(made.runs["check_fig4"].q[::4, 1])
    assert np.abs(lines["with what was found"] - truth).max() < 0.2
    assert np.abs(lines["model as given"] - truth).max() > 5.0


def test_the_study_with_a_diagnosis(cases: PaperCases, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One part more: its report, figure and runs beside the others, a summary that says what was not found."""

    def diagnose(given: Any, fit: Any, check: Any, progress: Callable[[str, float], None]) -> Diagnosis:
        assert [rec.name for rec in (*fit, *check)] == ["fit", "check_fig4", "check"]
        progress("looking", 0.5)
        return answer(cases, leave_out=3)

    monkeypatch.setattr(study, "CHAPTERS", study.CHAPTERS[1:2])
    monkeypatch.setattr(hidden_friction, "diagnose", diagnose)
    lines: list[str] = []
    done = run_paper_study(tmp_path, diagnose=True, progress=lines.append)
    assert lines[1:] == [f"2 of 2: friction hidden, and found{more}" for more in ("", ": looking, 50 %")]
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == set(done.files)
    made = {str(path.relative_to(tmp_path)) for path in done.files}
    assert made >= {f"diagnosis/{name}" for name in ("report.html", "report.json", "model.yaml")}
    assert made >= {"hidden_friction.png", "runs/diagnosis_fit.npz"}
    assert not done.passed
    told = done.summary["numbers"][hidden_friction.CHAPTER_TITLE]
    assert [each["found"] is None for each in told["hidden"]] == [True, True, True, True, True, False, False, False]
    assert [each["true"] for each in told["hidden"]][:2] == [0.02, 0.02]
    text = (tmp_path / "summary.md").read_text(encoding="utf-8")
    assert "| Coulomb friction on the link side of elbow | level | 0.02 | not found |" in text
    assert "flexdyn's own event-driven integrator" in text
