"""Which effects a joint can have, and a rigid joint that an effect makes elastic."""

from __future__ import annotations

import dataclasses
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import (
    Backlash,
    DirectionalGearLoss,
    Effect,
    HardeningSpring,
    JointCoupling,
    JointElasticity,
    KinematicError,
    LoadDependentFriction,
    SpringHysteresis,
    StribeckGearLoss,
    TransmissionDamping,
)
from tests.effects.arms import ELASTIC, RIGID, model_of, own, states
from tests.effects.reference import Arm, trajectory

NEEDS_SPRING: list[Effect] = [
    TransmissionDamping("elbow", coefficient=1.0),
    HardeningSpring("elbow", cubic=1.0),
    Backlash("elbow", half_gap=0.01),
    SpringHysteresis("elbow", stiffness=1.0, width=0.01),
    KinematicError("elbow", amplitude=0.01, harmonic=1.0, phase=0.0),
    LoadDependentFriction("elbow", coefficient=0.1),
    DirectionalGearLoss("elbow", driving=0.1, driven=0.3),
    StribeckGearLoss("elbow", driving=0.1, driven=0.3, velocity=0.2),
]
SLIDER = """<robot name="slider"><link name="base"/>
<link name="a"><inertial><mass value="2.5"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
</link><link name="b"><inertial><mass value="1.0"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-9" upper="9" effort="1000" velocity="9"/></joint>
<joint name="across" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" effort="1000" velocity="9"/></joint></robot>"""
SOFT = JointElasticity("elbow", stiffness=200.0)


@pytest.mark.parametrize("effect", NEEDS_SPRING, ids=lambda effect: effect.name)
def test_what_needs_a_spring_is_refused_on_a_rigid_joint(effect: Effect) -> None:
    """Unless joint_elasticity gives it one, wherever that stands in the list; a neutral one gives none."""
    with pytest.raises(
        fd.InputError, match=rf"^effects\[0\]\.joint: {effect.name} needs an elastic joint, got 'elbow'"
    ):
        model_of(RIGID, [effect])
    with pytest.raises(fd.InputError, match=r"needs an elastic joint"):
        model_of(RIGID, [effect, JointElasticity("elbow", stiffness=float("inf"))])
    with pytest.raises(fd.InputError, match=r"needs an elastic joint"):
        model_of(RIGID, [effect, JointElasticity("shoulder", stiffness=200.0)])
    assert model_of(RIGID, [effect, SOFT]).elastic.tolist() == [False, True]


def test_elasticity_is_refused_on_an_elastic_joint_and_without_a_rotor() -> None:
    """A spring in series would need a body between; a rotor without inertia has no motion of its own."""
    with pytest.raises(fd.InputError, match=r"^effects\[0\]\.joint: joint_elasticity needs a rigid joint, got 'elbow'"):
        model_of(ELASTIC, [SOFT])
    light = dataclasses.replace(RIGID, rotor=(0.1, 0.0))
    with pytest.raises(fd.InputError, match=r"^effects\[0\]\.joint: joint_elasticity needs a rotor that has inertia"):
        model_of(light, [SOFT])


def test_elasticity_as_an_effect_is_elasticity_as_a_number() -> None:
    """The same motion bit for bit; several add; the joint's own damping and other effects act across it."""
    numbers = Arm((np.inf, 300.0), (0.0, 0.4), (0.1, 0.1), gravity=2.0)
    effect = dataclasses.replace(numbers, stiffness=(np.inf, np.inf))
    gap = Backlash("elbow", half_gap=0.001)
    halves = [JointElasticity("elbow", stiffness=100.0), gap, JointElasticity("elbow", stiffness=200.0)]
    one, two = model_of(numbers, [gap]), model_of(effect, halves)
    np.testing.assert_array_equal(one.stiffness, two.stiffness)
    assert two.joints["elbow"].stiffness == np.inf
    runs = [fd.simulate(model, [0.4, 0.2], 0.5, q0=[0.2, 0.1], theta0="equilibrium") for model in (one, two)]
    np.testing.assert_array_equal(states(runs[0]), states(runs[1]))
    np.testing.assert_array_equal(runs[0].tau_s, runs[1].tau_s)
    np.testing.assert_array_equal(runs[0].energy.spring, runs[1].energy.spring)
    assert two.rigid().elastic.tolist() == [False, False]
    assert two.rigid().effects == ()
    assert pickle.loads(pickle.dumps(two)) == two  # noqa: S301 - our own bytes


def test_an_elastic_joint_beside_a_rigid_one() -> None:
    """The mixed arm against SciPy."""
    arm = Arm((np.inf, 300.0), (0.0, 0.4), (0.1, 0.1), gravity=2.0)
    model = model_of(dataclasses.replace(arm, stiffness=(np.inf, np.inf)), [JointElasticity("elbow", stiffness=300.0)])
    times = np.linspace(0.0, 1.0, 11)
    solver = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13)
    run = fd.simulate(model, [0.4, 0.2], 1.0, solver, q0=[0.2, 0.1], times=times)
    x0 = [0.2, 0.1, 0.1, 0.0, 0.0, 0.0]
    expected = trajectory(lambda t, x: arm.derivative(t, x, [0.4, 0.2]), x0, times)
    np.testing.assert_allclose(states(run), expected, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"other": "wrist"}, r"effects\[0\]\.other: no such joint, got 'wrist'"),
        ({"other": "elbow"}, r"effects\[0\]\.joint_coupling\.other: a joint does not couple to itself, got 'elbow'"),
        ({"other": 1}, r"effects\[0\]\.joint_coupling\.other: a joint's name is needed, got 1"),
        ({"joint": "wrist"}, r"effects\[0\]\.joint: no such joint, got 'wrist'"),
    ],
)
def test_a_coupling_needs_two_joints(change: dict[str, Any], words: str) -> None:
    """Both in the robot."""
    entry: Any = {"effect": "joint_coupling", "joint": "elbow", "other": "shoulder", "coefficient": 1.0} | change
    with pytest.raises(fd.InputError, match=f"^{words}"):
        model_of(ELASTIC, [entry])


def test_rigid_leaves_out_what_needs_a_spring() -> None:
    """The rigid twin of an arm with every kind of transmission effect is an arm without them."""
    kept = JointCoupling("elbow", coefficient=0.1, other="shoulder")
    assert model_of(ELASTIC, [*NEEDS_SPRING, kept]).rigid().effects == (kept,)


@pytest.mark.parametrize("stiffness", [np.inf, 3000.0], ids=["rigid", "elastic"])
def test_every_effect_that_fits_runs_on_a_prismatic_joint(stiffness: float, tmp_path: Path) -> None:
    """Metres and newtons where other joints have radians and newton metres."""
    path = tmp_path / "slider.urdf"
    path.write_text(SLIDER, encoding="utf-8")
    robot = fd.load_robot(path)
    joints = {"*": {"rotor_inertia": 0.5, "stiffness": stiffness}}
    needs_spring = {effect.name for effect in NEEDS_SPRING}
    for kind in fd.effects.catalogue().values():
        skipped = {"joint_elasticity"} if stiffness < np.inf else needs_spring
        if not own(kind) or kind.name in skipped or kind.name == "parameter_error":
            continue
        model = fd.FlexibleJointModel(robot, joints, [kind.example("lift", "across")])
        run = fd.simulate(model, [5.0, 1.0], 0.1, v0=[0.3, -0.2])
        assert np.isfinite(states(run)).all()
        assert run.to_recording().unit("q.lift") == "m"
