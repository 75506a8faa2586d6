"""fd.compare_models: which numbers moved beyond their uncertainty, which effects came or went."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

import flexdyn as fd
from flexdyn.diagnose.compared import report_file
from flexdyn.diagnose.compared.models import CHANCE, _same
from flexdyn.diagnose.report.document import SCHEMA
from flexdyn.diagnose.report.suspects import Number
from tests.diagnose.answers import dry_elbow

ARM = fd.load_model("scara_two_link").replace(effects=[], tolerance=0.01)


def stiffer(factor: float, tolerance: float = 0.01) -> fd.FlexibleJointModel:
    """The arm with another stiffness of the elbow."""
    return ARM.replace(joints={"elbow": {"stiffness": factor * ARM.joints["elbow"].stiffness}}, tolerance=tolerance)


def verdicts(found: fd.ModelsCompared) -> dict[str, str]:
    """By number."""
    return {each.name: each.verdict for each in found.numbers}


def test_a_number_moves_beyond_its_uncertainty() -> None:
    """Of two values known to 1 %, 5 % are 3.5 standard deviations and 2 % are not; known to 30 %, they tell nothing."""
    assert verdicts(fd.compare_models([ARM, stiffer(1.05)]))["stiffness of elbow"] == "moved"
    assert verdicts(fd.compare_models([ARM, stiffer(1.02)]))["stiffness of elbow"] == "stayed"
    wide = ARM.replace(tolerance=0.3)
    assert verdicts(fd.compare_models([wide, stiffer(1.02, 0.3)]))["stiffness of elbow"] == "not told"


def test_the_probability_is_that_of_chi_squared() -> None:
    """Cochran's Q of three values, by SciPy's distribution; equal numbers move as often as chance says."""
    values = [Number(1.0, 0.1, "N"), Number(1.2, 0.2, "N"), Number(1.6, 0.15, "N")]
    w = np.array([1.0 / each.std**2 for each in values])
    x = np.array([each.value for each in values])
    Q = (w * (x - (w * x).sum() / w.sum()) ** 2).sum()
    assert _same(values)[0] == pytest.approx(chi2.sf(Q, 2), rel=1e-9)
    draw = np.random.default_rng(0)
    moved = sum(_same([Number(float(v), 1.0, "N") for v in row])[1] == "moved" for row in draw.normal(50, 1, (4000, 3)))
    assert moved / 4000 == pytest.approx(CHANCE, abs=0.003)


def test_numbers_of_any_size_are_compared() -> None:
    """The unit does not matter, even where squares of the numbers would be infinite or 0."""
    for size in (1e-300, 1.0, 1e300):
        assert _same([Number(each * size, 0.01 * size, "N") for each in (1.0, 1.001)])[1] == "stayed"
        assert _same([Number(each * size, 0.01 * size, "N") for each in (1.0, 1.1)])[1] == "moved"
    assert _same([Number(1.0, 0.0, "N"), Number(1.0, 0.0, "N")]) == (1.0, "stayed")
    assert _same([Number(0.0, 1e300, "N"), Number(1.0, 1e-300, "N")])[1] == "not told"


def test_effects_come_and_go() -> None:
    """In the order of the models: appeared, vanished, in some, in all; numbers of an effect are compared as well."""
    e = fd.effects
    play = e.Backlash("elbow", half_gap=1e-3)
    rubs = e.CoulombFriction("elbow", side="motor", level=0.5)
    old = e.ViscousFriction("elbow", side="motor", coefficient=0.5)
    models = [ARM.replace(effects=each) for each in ([rubs, old], [rubs.replace(level=0.7), play], [rubs, play, old])]
    found = fd.compare_models(models, labels=["new", "worn", "repaired"])
    course = {each.name: each.course for each in found.effects}
    assert course == {
        "backlash in the transmission of elbow": "appeared",
        "viscous friction on the motor side of elbow": "in some",
        "Coulomb friction on the motor side of elbow": "in all",
    }
    (level,) = [each for each in found.numbers if each.name.startswith("level of Coulomb friction")]
    assert level.verdict == "moved"
    assert level.ratio == pytest.approx(1.4)
    assert fd.compare_models(models[::-1][1:]).effects[0].course in ("appeared", "vanished")
    text = str(found).splitlines()
    assert text[0].split() == ["number", "new", "worn", "repaired", "by", "chance"]
    assert "moved" in text[1]


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> tuple[fd.Diagnosis, Path]:
    """A diagnosis that found friction, and the folder that it was saved in."""
    answer = dry_elbow()
    folder = tmp_path_factory.mktemp("compared") / "worn"
    answer.save(folder)
    return answer, folder


def test_a_diagnosis_and_its_folder_are_one(diagnosed: tuple[fd.Diagnosis, Path]) -> None:
    """Values, standard deviations and probabilities are those of the diagnosis, whichever way it comes."""
    answer, folder = diagnosed
    level = answer.findings[0].suspect.parameters["level"]
    for given in (answer, folder, folder / "model.yaml"):
        found = fd.compare_models([given, answer], labels=["one", "other"])
        (row,) = [each for each in found.numbers if each.name.startswith("level of Coulomb")]
        assert row.values[0] is not None
        assert row.values[0].value == pytest.approx(level.value)
        assert row.values[0].std == pytest.approx(level.std, rel=1e-6)
        assert row.verdict == "stayed"
        assert all(each.course == "in all" for each in found.effects)
        (rubs,) = found.effects
        assert rubs.probabilities[0] == pytest.approx(answer.findings[0].probability)


def test_stiffness_of_a_diagnosis_is_told_with_its_deviation(diagnosed: tuple[fd.Diagnosis, Path]) -> None:
    """A calibrated number has the value and the standard deviation of the fit, not the tolerance of the file."""
    answer, _ = diagnosed
    (entry,) = [each for each in answer.calibration if (each.of, each.parameter) == ("elbow", "stiffness")]
    found = fd.compare_models([answer, answer], labels=["one", "other"])
    (row,) = [each for each in found.numbers if each.name == "stiffness of elbow"]
    assert row.values[0] is not None
    assert row.values[0].value == pytest.approx(900.0 * entry.factor)
    assert row.values[0].std == pytest.approx(900.0 * entry.std, rel=1e-6)


def test_an_absent_effect_has_the_probability_that_was_computed(diagnosed: tuple[fd.Diagnosis, Path]) -> None:
    """What a diagnosis compared and did not name stands beside what another model has."""
    answer, _ = diagnosed
    other = answer.model.resolved()
    other = other.replace(effects=[*other.effects, fd.effects.ViscousFriction("elbow", side="motor", coefficient=0.2)])
    (row,) = [each for each in fd.compare_models([answer, other]).effects if each.name.startswith("viscous")]
    assert (row.there, row.course) == ((False, True), "appeared")
    considered = {(c.suspect.effect, c.suspect.joint, c.suspect.side): c.probability for c in answer.considered}
    assert row.probabilities[0] == pytest.approx(considered[("viscous_friction", "elbow", "motor")])


def test_mistakes_are_one_line(tmp_path: Path) -> None:
    """One model, another arm, wrong labels, a folder without a model."""
    for wrong, words in (
        (([ARM],), "one model alone"),
        (([ARM, fd.load_model("ur5")],), "different arms"),
        (([ARM, ARM], ["a"]), "a label for each model"),
        (([ARM, tmp_path],), "no corrected model"),
        (([ARM, 3],), "no model and no diagnosis"),
    ):
        with pytest.raises(fd.InputError, match=words):
            fd.compare_models(*wrong)


COOL: dict[str, Any] = {"effect": "x", "joint": None, "side": None, "parameters": {}, "probability": 0.5}
NO_PROBABILITIES: tuple[Any, ...] = ("1", True, -1, 10**400, [], {})
NO_NUMBERS: tuple[Any, ...] = (1, {}, {"value": 1, "std": -1})
WRONG: dict[str, list[Any]] = {
    "schema": [{}, 3, [], {"schema": None}, {"schema": "other"}, {"schema": f"{SCHEMA[:-1]}99"}, {"schema": [SCHEMA]}],
    "findings": [3, None, [1], [{}], [{"effect": "x"}], [{**COOL, "parameters": [1]}], [{**COOL, "effect": []}]],
    "findings[0].probability": [[{**COOL, "probability": each}] for each in NO_PROBABILITIES],
    "findings[0].parameters.a": [[{**COOL, "parameters": {"a": each}}] for each in NO_NUMBERS],
    "findings[0].of": [[{**COOL, "effect": "parameter_error"}]],
    "considered": [3, {}, [[]], [{**COOL, "joint": 3}], [{**COOL, "side": {}}], [{**COOL, "channel": None}]],
    "calibration": [{}, [{}], [{"of": "elbow", "parameter": None}], [{"of": "a", "parameter": "b", "factor": "c"}]],
}
"""Contents of a report that no diagnosis wrote, by the key that the refusal names."""


@pytest.mark.parametrize("key", WRONG)
def test_a_report_of_a_wrong_shape_is_refused(key: str, tmp_path: Path) -> None:
    """One line names the file and the key, whatever stands where a list, an object, a text or a number belongs."""
    fd.save_model(ARM, tmp_path / "model.yaml")
    whole = {"schema": SCHEMA, "findings": [COOL], "calibration": [], "considered": [COOL]}
    report = tmp_path / "report.json"
    report.write_text(json.dumps(whole), encoding="utf-8")
    fd.compare_models([ARM, tmp_path])
    name = key.partition("[")[0]
    for wrong in WRONG[key]:
        report.write_text(json.dumps(wrong if key == "schema" else whole | {name: wrong}), encoding="utf-8")
        with pytest.raises(fd.InputError, match="report of a diagnosis") as told:
            fd.compare_models([ARM, tmp_path])
        assert str(told.value).startswith(f"{report}: {key}"), wrong


def test_a_report_that_is_not_json_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Open brackets without end, NaN, other encodings, a report that ends early, and one that is too large."""
    fd.save_model(ARM, tmp_path / "model.yaml")
    for data in (b"", b"{", b"[" * 200_000, b'{"schema": NaN}', b"\xff", b"9" * 5000):
        (tmp_path / "report.json").write_bytes(data)
        with pytest.raises(fd.InputError, match=r"not valid JSON|not a text file|no report"):
            fd.compare_models([ARM, tmp_path])
    monkeypatch.setattr(report_file, "MAX_REPORT_BYTES", 10)
    with pytest.raises(fd.InputError, match="larger than 10 bytes"):
        fd.compare_models([ARM, tmp_path])
