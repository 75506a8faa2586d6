"""What stands in the corrected model: effects that can stand without others, and none that is less than a count."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.decision.corrected import needed, possible
from flexdyn.diagnose.decision.gaps import Shots
from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.shooting.gap import Shot
from flexdyn.effects import Effect, JointElasticity, LoadDependentFriction, ViscousFriction
from tests.diagnose.truths import sliding

SOFT = {name: JointElasticity(name, stiffness=900.0) for name in ("shoulder", "elbow")}
LOADED = {name: LoadDependentFriction(name, side="motor", coefficient=0.1) for name in ("shoulder", "elbow")}
PLAIN = ViscousFriction("shoulder", side="motor", coefficient=0.2)
RATE, INERTIA, STEP = 250.0, 2.5, 1e-4
"""Sampling [Hz], a wheel [kg m^2] and the step of its encoder [rad]."""


def _two_links(effects: tuple[Effect, ...], elastic: tuple[str, ...] = ()) -> Hypothesis:
    """A hypothesis of an arm whose joints are rigid but for some."""
    joints = {
        name: {"rotor_inertia": 0.1, **({"stiffness": 400.0} if name in elastic else {})}
        for name in ("shoulder", "elbow")
    }
    return Hypothesis(fd.FlexibleJointModel(fd.load_robot("scara_two_link"), joints), {}, effects=effects)


def test_load_dependent_friction_keeps_the_elasticity_of_its_joint() -> None:
    """Also where that is not named; what other joints have is left out, and what stands is not added again."""
    here = _two_links((SOFT["shoulder"], SOFT["elbow"], LOADED["elbow"], PLAIN))
    assert needed(here, [LOADED["elbow"]]) == (LOADED["elbow"], SOFT["elbow"])
    assert needed(here, [SOFT["elbow"], LOADED["elbow"]]) == (SOFT["elbow"], LOADED["elbow"])
    assert needed(here, [PLAIN]) == (PLAIN,)


def test_load_dependent_friction_goes_with_the_elasticity_of_its_joint() -> None:
    """A rigid joint cannot have it; one that the model file says is elastic can."""
    effects = [LOADED["shoulder"], LOADED["elbow"], PLAIN]
    assert possible(_two_links(()), effects) == (PLAIN,)
    assert possible(_two_links(()), [SOFT["elbow"], *effects]) == (SOFT["elbow"], LOADED["elbow"], PLAIN)
    assert possible(_two_links((), ("shoulder",)), effects) == (LOADED["shoulder"], PLAIN)


def _shots(before: np.ndarray, after: np.ndarray) -> Shots:
    """Of residuals alone (windows, rows, channels)."""
    first, last = (cast(Shot, SimpleNamespace(residual=each)) for each in (before, after))
    return Shots(first, first, last)


@pytest.mark.parametrize(("factors", "closer"), [((1.0, 1.0), True), ((0.5, 1.9), True), ((0.5, 2.1), False)])
def test_closer_is_the_geometric_mean_of_the_channels(factors: tuple[float, float], closer: bool) -> None:
    """Half the error at one encoder is worth twice the error at another, whatever their units."""
    before = np.random.default_rng(0).standard_normal((9, 20, 2)) * [1.0, 1e-4]
    assert _shots(before, before * factors).closer is closer


def test_one_window_does_not_tell_whether_a_model_is_closer() -> None:
    """It may be on the wrong side of a stick: the median window counts; half of them and more do."""
    before = np.ones((9, 20, 1))
    few, many = 0.5 * before, 0.5 * before
    few[:4], many[:5] = 1e3, 1e3
    assert _shots(before, few).closer
    assert not _shots(before, many).closer


def _wheel(folder: Path) -> fd.FlexibleJointModel:
    path = folder / "wheel.urdf"
    path.write_text(f"""<robot name="wheel"><link name="base"/>
<link name="disc"><inertial><mass value="1.0"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="{INERTIA}"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="disc"/><axis xyz="0 0 1"/>
<limit effort="1000" velocity="100"/></joint></robot>""")
    return fd.FlexibleJointModel(fd.load_robot(path), {}, gravity=[0.0, 0.0, 0.0])


@pytest.mark.parametrize(("steps", "named"), [(0.5, False), (10.0, True)])
def test_a_wave_below_a_step_of_the_encoder_is_not_named(tmp_path: Path, steps: float, named: bool) -> None:
    """It may be rounding, however much of the torque its second derivative looks like."""
    t = np.arange(round(8.0 * RATE)) / RATE
    torque = 60.0 * np.sin(2.1 * t + 0.3) + 50.0 * np.sin(5.3 * t) + 30.0 * np.sin(11.0 * t)
    x, _ = sliding(torque, 1.0 / RATE, INERTIA, 0.0)
    seen = x + steps * STEP * np.sin(7.0 * x + 0.4)
    draw = np.random.default_rng(1)
    noisy = torque + 0.02 * draw.standard_normal(len(t))
    record = fd.Recording(t, {"q.axle": STEP * np.round(seen / STEP), "tau.axle": noisy})
    found = {each.suspect.effect: each.suspect for each in diagnose(_wheel(tmp_path), [record]).findings}
    assert set(found) == ({"encoder_eccentricity"} if named else set())
    if named:
        assert found["encoder_eccentricity"].parameters["harmonic"].value == pytest.approx(7.0, rel=1e-3)
        assert found["encoder_eccentricity"].parameters["amplitude"].value == pytest.approx(steps * STEP, rel=0.1)
