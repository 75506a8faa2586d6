"""Sizes of effects and masses that nobody knows are estimated, with intervals that hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.report.calibrated import estimate
from tests.diagnose import slides
from tests.diagnose.test_unknown_numbers import MASS, REACH, URDF, swung

VISCOUS = {"effect": "viscous_friction", "joint": "lift", "side": "motor", "coefficient": "unknown"}
COULOMB = {"effect": "coulomb_friction", "joint": "lift", "side": "motor", "level": "unknown"}


def diagnosed(folder: Path, effects: Any, coefficient: float, level: float) -> fd.Diagnosis:
    """Of a slide with these friction numbers, whose model has these effects."""
    model = slides.model(folder).replace(effects=effects)
    return fd.diagnose(model, [slides.recording(lambda v: coefficient * v + level * float(np.sign(v)))], progress=False)


def unknown(found: fd.Diagnosis) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of each number that was unknown."""
    numbers = {each.parameter: estimate(found.model, each) for each in found.calibration if each.is_open}
    return {name: (number.value, number.std) for name, number in numbers.items()}


@pytest.mark.parametrize(("coefficient", "level"), [(0.05, 0.3), (0.5, 3.0), (6.0, 0.1), (0.0, 12.0), (20.0, 0.0)])
def test_friction_whose_numbers_are_unknown(tmp_path: Path, coefficient: float, level: float) -> None:
    """From a hundredth of the force to most of it, and none at all; nothing else is named."""
    found = diagnosed(tmp_path, [VISCOUS, COULOMB], coefficient, level)
    assert found.verdict == "no_discrepancy"
    for name, true in (("coefficient", coefficient), ("level", level)):
        value, std = unknown(found)[name]
        assert abs(value - true) < 3.0 * std < 0.01 + 0.01 * true
    told = [note for note in found.notes if "was not known: it is estimated as" in note]
    assert len(told) == 2
    assert "coefficient of viscous friction on the motor side of lift" in told[0]


def test_what_the_file_lacks_is_named_beside_an_unknown_size(tmp_path: Path) -> None:
    """Viscous friction without a number in the file; Coulomb friction is missing. The corrected model has both."""
    found = diagnosed(tmp_path, [VISCOUS], 0.5, 3.0)
    assert [name for name, _, _ in slides.named(found)] == ["coulomb_friction"]
    found.save(tmp_path / "answer")
    model = fd.load_model(tmp_path / "answer" / "model.yaml")
    values = {effect.name: effect.values[0] for effect in model.effects}
    assert values == pytest.approx({"viscous_friction": 0.5, "coulomb_friction": 3.0}, rel=0.01)
    assert model.tolerance == {"*": 0.05}


def test_two_sizes_that_no_motion_tells_apart(tmp_path: Path) -> None:
    """The same friction twice: both numbers are said to be undetermined."""
    found = diagnosed(tmp_path, [VISCOUS, {**VISCOUS, "side": "link"}], 0.5, 0.0)
    assert sum("these data do not determine it" in note for note in found.notes) == 2


def test_an_effect_that_does_nothing(tmp_path: Path) -> None:
    """Friction below a picometre in a second, where the joint always moves: no recording has a scale for it."""
    stribeck = {"effect": "stribeck_friction", "joint": "lift", "side": "motor", "excess": "unknown"}
    with pytest.raises(fd.InputError, match=r"effects\[0\].excess: along these motions the effect does nothing; leave"):
        diagnosed(tmp_path, [stribeck | {"velocity": 1e-12}], 0.5, 0.0)


@pytest.mark.parametrize("wrote", [0.15, 1.5, 15.0])
def test_a_mass_that_nobody_knows(tmp_path: Path, wrote: float) -> None:
    """1.5 kg in MuJoCo, and anything in the URDF; the corrected URDF has what was found."""
    text = URDF.format(reach=REACH, mass=wrote, inertia=0.02)
    (tmp_path / "pendulum.urdf").write_text(text, encoding="utf-8")
    robot, joints = fd.load_robot(tmp_path / "pendulum.urdf"), {"hinge": {"rotor_inertia": 0.8}}
    model = fd.FlexibleJointModel(robot, joints, links={"bob": {"mass": "unknown"}}, tolerance=0.01)
    found = fd.diagnose(model, [swung(0.8, 0.02)], progress=False)
    assert [finding.suspect.effect for finding in found.findings] == ["coulomb_friction"]
    value, std = unknown(found)["link_mass"]
    assert abs(value - MASS) < 2.0 * std < 0.05 * MASS
    assert any("The mass of bob was not known: it is estimated as 1.50" in note for note in found.notes)
    found.save(tmp_path / "answer")
    mass, _ = fd.load_model(tmp_path / "answer" / "model.yaml").robot.link_size("bob")
    assert mass == pytest.approx(MASS, rel=0.01)
