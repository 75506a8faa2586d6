"""Kinova Gen3: cycles are counted from the positions, and the laws of a sweep are fitted by plain least squares."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from along import along
from kinova_data import CYCLE, cycles, in_cycles, plain, read_sweep, read_trajectory, whole
from kinova_study import _bare
from kinova_trial import Sweep

import flexdyn as fd

DATA = Path(__file__).parents[3] / "shared" / "data" / "kinova_gen3"
needs_data = pytest.mark.skipif(
    not (DATA / "trajectory1.csv").is_file(), reason=f"{DATA} is absent: recordings of a Kinova Gen3 are read there"
)
SPEED = 0.4


def _recording() -> tuple[fd.Recording, np.ndarray]:
    """Constant speed and a current that is the time; cycles 50 and 51 repeat 49, cycle 70 is lost."""
    of = np.delete(np.arange(100), 70)
    of[50:52] = 49
    q, v = SPEED * CYCLE * of, np.full(len(of), SPEED)
    columns = {"q.joint_1": q, "v.joint_1": v, "current.joint_1": CYCLE * of}
    return fd.Recording(CYCLE * np.arange(len(of)), columns), of


def test_cycles_are_counted_from_the_positions() -> None:
    """0 where a row repeats, 3 after two of them, 2 where one is lost, else 1."""
    recording, of = _recording()
    steps = cycles(recording, (1,))
    assert steps.tolist() == np.diff(of).tolist()
    assert sorted(set(steps.tolist())) == [0, 1, 2, 3]


def test_rows_stand_at_their_own_cycle() -> None:
    """What was recorded is a line again, on an even clock of 1 kHz; torques are held where up to two rows are lost."""
    made = in_cycles(_recording()[0], (1,))
    assert made.rate == pytest.approx(1.0 / CYCLE)
    np.testing.assert_allclose(made["q.joint_1"], SPEED * made.t, atol=1e-12)
    np.testing.assert_allclose(made["tau.joint_1"], 9.130 * made.t, atol=2.001 * 9.130 * CYCLE)


@needs_data
def test_a_sweep_tells_the_rotor_and_the_sum_of_its_friction() -> None:
    """Coulomb friction or an offset of the other sign, alone, come out alike; the rotor is that of the diagnosis."""
    sweep = Sweep(1, _bare(DATA, 1), read_sweep(DATA, 1))
    rotor, (friction,) = sweep.fitted([fd.effects.CoulombFriction("joint_1", side="motor", level=1.0)])
    other, (offset,) = sweep.fitted([fd.effects.TorqueOffset("joint_1", offset=1.0)])
    assert isinstance(friction, fd.effects.CoulombFriction)
    assert isinstance(offset, fd.effects.TorqueOffset)
    assert friction.level == pytest.approx(4.1, rel=0.05)
    assert offset.offset == pytest.approx(-friction.level, rel=0.02)
    assert 1e4 * rotor == pytest.approx(0.45, rel=0.15)
    assert other == pytest.approx(rotor, rel=0.05)


@needs_data
def test_the_friction_of_the_sweep_predicts_three_times_the_speed() -> None:
    """Joint 5, viscous and Coulomb friction of the sweep alone, against what the URDF lacks over the trajectory."""
    laws = [
        fd.effects.ViscousFriction("joint_5", side="motor", coefficient=1.0),
        fd.effects.CoulombFriction("joint_5", side="motor", level=1.0),
    ]
    _, (viscous, dry) = Sweep(5, _bare(DATA, 5), read_sweep(DATA, 5)).fitted(laws)
    assert isinstance(viscous, fd.effects.ViscousFriction)
    assert isinstance(dry, fd.effects.CoulombFriction)
    arm = along(whole(DATA), read_trajectory(DATA))
    steady = arm.omega[:, 4] > 1.0
    predicted = dry.level + viscous.coefficient * arm.omega[steady, 4].mean()
    assert predicted == pytest.approx(arm.missing[steady, 4].mean(), rel=0.1)


@needs_data
def test_the_plain_model_is_the_urdf_of_one_joint() -> None:
    """Rigid, without effects, its rotor not known."""
    model = plain(DATA, 4)
    assert model.joint_names == ("joint_4",)
    assert not model.elastic.any()
    assert not model.effects
