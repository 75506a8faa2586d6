"""Coulomb friction and a torque offset of one motor are one law: asymmetric friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.one_law import by_plainer_laws, in_one_law
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior import posterior
from tests.diagnose.slides import model, named, recording

UP, DOWN = 7.0, 3.0


def test_the_one_law_is_named(tmp_path: Path) -> None:
    """No motor is expected to have it, and every motor is expected to have Coulomb friction."""
    diagnosis = fd.diagnose(model(tmp_path), fit=[recording(lambda v: UP if v > 0.0 else -DOWN)])
    ((effect, values, probability),) = named(diagnosis)
    assert effect == "asymmetric_friction"
    assert values == pytest.approx({"level_positive": UP, "level_negative": DOWN}, rel=5e-3)
    assert probability > 0.95
    assert any("is the same as Coulomb friction and torque offset together" in note for note in diagnosis.notes)


def test_the_plainer_law_is_named_where_both_directions_are_alike(tmp_path: Path) -> None:
    """One level says it all."""
    ((effect, values, _),) = named(fd.diagnose(model(tmp_path), fit=[recording(lambda v: UP if v > 0.0 else -UP)]))
    assert effect == "coulomb_friction"
    assert values == pytest.approx({"level": UP}, rel=5e-3)


def test_an_offset_of_the_motor_alone_keeps_its_name(tmp_path: Path) -> None:
    """It is no friction."""
    findings = named(fd.diagnose(model(tmp_path), fit=[recording(lambda v: 10.0 * v, lambda f: f + 2.0)]))
    values = {effect: numbers for effect, numbers, _ in findings}
    assert values.keys() == {"viscous_friction", "torque_offset"}
    assert values["torque_offset"] == pytest.approx({"offset": 2.0}, rel=2e-2)


def test_a_constant_torque_stays_in_the_model_whatever_it_is_called(tmp_path: Path) -> None:
    """An unknown force that wanders may make friction look asymmetric: the name is open, the constant force is not."""
    window = np.hanning(600)
    wander = np.convolve(np.random.default_rng(3).standard_normal(9000), window / np.linalg.norm(window), "valid")
    unknown = iter((wander - wander[:8000].mean()).tolist())
    record = recording(lambda v: UP if v > 0.0 else -DOWN, lambda force: force + next(unknown))
    diagnosis = fd.diagnose(model(tmp_path), fit=[record])
    ((effect, values, _),) = named(diagnosis)
    assert effect == "coulomb_friction"
    assert [each.effect for each in diagnosis.findings[0].rivals] == ["asymmetric_friction"]
    assert values["level"] == pytest.approx(0.5 * (UP + DOWN), rel=0.05)
    (offset,) = (each.offset for each in diagnosis.model.effects if isinstance(each, fd.effects.TorqueOffset))
    assert offset == pytest.approx(0.5 * (DOWN - UP), rel=0.2)
    assert any("torque offset" in note for note in diagnosis.notes)


def test_what_may_be_an_imitation_is_told_as_the_plainer_law(tmp_path: Path) -> None:
    """The model stays the same: the offset has no name, and Coulomb friction is "A or B"."""
    given = model(tmp_path)
    found = posterior(*prepared(given, (measured(given, recording(lambda v: UP if v > 0.0 else -DOWN)),)))
    parts = by_plainer_laws(found, dict.fromkeys(range(len(found.space.candidates)), 0.5))
    assert _kinds(parts) == {"coulomb_friction", "torque_offset"}
    assert by_plainer_laws(parts, {}) is parts
    whole = in_one_law(parts, [c for c, _ in parts.best])
    assert _kinds(whole) == {"asymmetric_friction"}
    assert in_one_law(parts, []) is parts
    assert whole.fitted.reached == pytest.approx(parts.fitted.reached, abs=0.5)
    told, plain = Masses.of(whole.known), Masses.of(parts.known)
    (asymmetric,), (coulomb, _) = (sorted(c for c, _ in each.best) for each in (whole, parts))
    assert told.of_any([asymmetric]) > 0.95
    assert plain.of_any([coulomb]) < 0.95


def _kinds(found: Posterior) -> set[str]:
    """Of the best structure's effects."""
    return {found.space.candidates[c].kind for c, _ in found.best}
