"""Diagnoses of a sliding mass whose motion was computed without flexdyn."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.last_fit import converged
from flexdyn.diagnose.decision.model_rows import rows_of_models
from flexdyn.diagnose.decision.notes import unsettled_numbers
from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.decision.verdict import left_by_joint
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.linear import linearised
from flexdyn.diagnose.progress import STAGES
from flexdyn.diagnose.report.result import Diagnosis, Interrupted
from flexdyn.diagnose.report.sentences import verdict_sentence
from tests.diagnose.truths import Levels, slider_model, slider_recording, sliding
from tests.diagnose.workspaces import workspace

RATE, MASS, LEVEL = 250.0, 2.5, 0.8
LEVELS = Levels(2e-6, 0.02)


def _force(seconds: float, shift: float = 0.0) -> np.ndarray:
    t = np.arange(round(seconds * RATE)) / RATE + shift
    return 6.0 * np.sin(2.1 * t + 0.3) + 5.0 * np.sin(5.3 * t) + 3.0 * np.sin(11.0 * t)


@functools.cache
def _recording(level: float = LEVEL, shift: float = 0.0, seconds: float = 20.0) -> fd.Recording:
    force = _force(seconds, shift)
    x, _ = sliding(force, 1.0 / RATE, MASS, level)
    return slider_recording(x, force, RATE, LEVELS, seed=1)


@pytest.fixture(name="answer", scope="module")
def _answer(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """Friction that the model lacks; the last fifth is test data."""
    return diagnose(slider_model(tmp_path_factory.mktemp("slider")), [_recording()])


def _names(answer: Diagnosis) -> list[set[str]]:
    return [{each.effect for each in finding.names} for finding in answer.findings]


def test_missing_friction_is_named_and_explains_the_test_data(answer: Diagnosis) -> None:
    """Its level, and errors of torque and position that fall to noise."""
    assert answer.verdict == "explained"
    (finding,) = answer.findings
    assert finding.suspect.effect == "coulomb_friction"
    assert finding.established
    level = finding.suspect.parameters["level"]
    assert level.value == pytest.approx(LEVEL, abs=4.0 * level.std)
    assert level.value == pytest.approx(LEVEL, rel=0.01)
    assert finding.test_gain > 0.9
    assert answer.gap_test is not None
    assert answer.gap_test.before > 50.0
    assert answer.gap_test.after < 1.3
    error = answer.errors["lift"]
    assert error.torque.before == pytest.approx(LEVEL, rel=0.05)
    assert error.torque.after < 0.02
    assert (error.torque.unit, error.position.unit) == ("N", "m")
    assert error.position.after < 0.01 * error.position.before
    assert not answer.left


def test_the_corrected_model_holds_what_is_named_and_no_more(answer: Diagnosis) -> None:
    """One friction beside the calibrated numbers."""
    found = [each for each in answer.model.effects if not isinstance(each, fd.effects.ParameterError)]
    assert [type(each) for each in found] == [fd.effects.CoulombFriction]
    assert not answer.no_model
    assert {each.of for each in answer.calibration} == {"mass"}


def test_structures_and_candidates_are_told(answer: Diagnosis) -> None:
    """Ranked, with probabilities that add up; a candidate that was far off is there as well."""
    assert answer.structures[0].probability == max(each.probability for each in answer.structures)
    assert sum(each.probability for each in answer.structures) <= 1.0 + 1e-12
    known = {each.suspect.effect for each in answer.considered}
    assert {"coulomb_friction", "presliding_friction", "viscous_friction"} <= known
    probabilities = [each.probability for each in answer.considered]
    assert probabilities == sorted(probabilities, reverse=True)
    assert "Named" in answer.explain("coulomb_friction@lift.motor")


def test_a_report_can_be_written(answer: Diagnosis, tmp_path: Path) -> None:
    """Strict JSON with the figures of the test data."""
    answer.save(tmp_path)
    document = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert document["verdict"] == "explained"
    assert [each["role"] for each in document["data"]] == ["fit", "test"]
    assert document["data"][0]["to"] < document["data"][1]["from"]


def test_a_right_model_has_no_discrepancy(tmp_path: Path) -> None:
    """Nothing is named, and the gap after calibration is noise."""
    answer = diagnose(slider_model(tmp_path), [_recording(0.0)])
    assert answer.verdict == "no_discrepancy"
    assert not answer.findings
    assert answer.gap_test is not None
    assert answer.gap_test.after < 1.3


def test_the_test_data_decide_nothing_but_the_verdict(tmp_path: Path) -> None:
    """Names, numbers and corrected model are bit for bit the same whether the check agrees or not."""
    model = slider_model(tmp_path)
    same, other = (
        diagnose(model, [_recording()], [_recording(level, shift=1.7, seconds=6.0)]) for level in (LEVEL, 0.0)
    )
    assert same.verdict == "explained"
    assert other.verdict == "partly_explained"
    assert [each.joint for each in other.left] == ["lift"]
    assert same.model == other.model
    assert same.calibration == other.calibration
    assert same.gap_fit == other.gap_fit
    alike, too = (
        [dataclasses.replace(each, test_gain=0.0, plan=None) for each in answer.findings] for answer in (same, other)
    )
    assert alike == too


@pytest.mark.parametrize("stage", ["simulating windows", "opening the test data"])
def test_an_interrupted_diagnosis_says_what_was_known(tmp_path: Path, stage: str) -> None:
    """Ctrl-C after the structures were compared: names without figures of the test data."""

    def stop(now: str, share: float) -> None:
        if now.startswith(stage):
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        diagnose(slider_model(tmp_path), [_recording()], progress=stop)
    known = caught.value.diagnosis
    assert known is not None
    assert known.verdict == "interrupted"
    assert "coulomb_friction" in _names(known)[0]
    assert known.gap_test is None
    assert np.isnan(known.findings[0].test_gain)


def test_nothing_is_known_before_structures_were_compared(tmp_path: Path) -> None:
    """Ctrl-C before the first comparison: which data were read, and where it was stopped, and no more."""

    def stop(now: str, share: float) -> None:
        if now.startswith("comparing structures"):
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        diagnose(slider_model(tmp_path), [_recording()], progress=stop)
    known = caught.value.diagnosis
    assert known is not None
    assert (known.verdict, known.findings, known.structures) == ("interrupted", (), ())
    assert known.stopped_at == "comparing structures (2 of 5)"
    assert [each.role for each in known.data] == ["fit"]
    assert known.no_model


def test_structures_that_were_compared_are_told_without_a_name(tmp_path: Path) -> None:
    """Ctrl-C in the second pass: the comparison had not ended, so nothing is established."""

    def stop(now: str, share: float) -> None:
        if "pass 2" in now:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        diagnose(slider_model(tmp_path), [_recording()], progress=stop)
    known = caught.value.diagnosis
    assert known is not None
    assert known.findings == ()
    assert "coulomb_friction" in {each.effect for each in known.structures[0].effects}
    assert "Nothing" in verdict_sentence(known) or "No effect" in verdict_sentence(known)


def test_progress_grows_to_the_end_and_names_what_is_in_work(tmp_path: Path) -> None:
    """Stages in their order, each with its number; passes of the search; the share never falls."""
    told: list[tuple[str, float]] = []
    diagnose(slider_model(tmp_path), [_recording()], progress=lambda stage, share: told.append((stage, share)))
    stages = [stage for stage, _ in told]
    for k, name in enumerate(STAGES, start=1):
        assert f"{name} ({k} of {len(STAGES)})" in stages
    assert any("pass 1 of at most" in stage for stage in stages)
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert 0.5 < shares[-1] <= 1.0


@pytest.mark.parametrize("share", [0.0, 0.04])
def test_what_is_left_is_measured_in_torque(tmp_path: Path, share: float) -> None:
    """A wave of force that no record holds; without it nothing is left."""
    model, force = slider_model(tmp_path), _force(20.0)
    wave = share * np.sqrt(2.0) * force.std() * np.sin(3.3 * np.arange(len(force)) / RATE)
    x, _ = sliding(force + wave, 1.0 / RATE, MASS, 0.0)
    data = (measured(model, slider_recording(x, force, RATE, LEVELS, seed=2)),)
    space, start, _ = workspace(model, data)
    found = left_by_joint(rows_of_models(space.equations, start, start, data), {"lift": ("t",)})
    assert [each.joint for each in found] == ["lift"] * (share > 0.0)
    for each in found:
        assert each.share_of_torque == pytest.approx(share, rel=0.05)
        assert each.depends_on == ("t",)
        assert each.correlation_time == pytest.approx(math.acos(math.exp(-1.0)) / 3.3, abs=0.05)


def test_the_noise_of_a_row_is_the_diagonal_of_the_covariance(tmp_path: Path) -> None:
    """The banded factor against L L^T."""
    model = slider_model(tmp_path)
    data = (measured(model, _recording(0.0, seconds=3.0)),)
    space, start, _ = workspace(model, data)
    rows = rows_of_models(space.equations, start, start, data)
    factor = rows.whiten.factor
    L = np.zeros((len(factor),) * 2)
    for lag, line in enumerate(factor.T):
        L += np.diag(line[lag:], -lag)
    np.testing.assert_allclose(rows.variance.ravel(), np.diag(L @ L.T), rtol=1e-12)


@pytest.mark.parametrize(("level", "stands"), [(LEVEL, True), (0.4, False)])
def test_a_fit_that_stopped_short_says_what_it_would_move(tmp_path: Path, level: float, *, stands: bool) -> None:
    """A level at which it stands, and one from which its next step promises much."""
    model = slider_model(tmp_path)
    data = (measured(model, _recording()),)
    space, start, _ = workspace(model, data, None)
    friction: Sequence[fd.effects.Effect] = [fd.effects.CoulombFriction("lift", side="motor", level=level)]
    made = linearised(Hypothesis(model, start.factors, effects=tuple(friction)), space)
    assert converged(made) == stands
    if not stands:
        assert unsettled_numbers(made)[0] == "level of Coulomb friction of lift"


def test_an_expected_effect_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    """One line with the near miss."""
    with pytest.raises(fd.InputError, match="did you mean 'torque_saturation'"):
        diagnose(slider_model(tmp_path), [_recording()], expect=["torque_saturations"])
