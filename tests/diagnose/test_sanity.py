"""Recordings with a wrong unit, sign or joint get one clear line; those of an arm with a missing effect never do."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.sanity import check_recordings
from tests.arms import SLIDER, slider
from tests.diagnose.sanity_cases import (
    LEVELS,
    RATIO,
    Array,
    Change,
    Channels,
    both,
    checked,
    exchanged,
    geared_arm,
    same,
    scaled,
    without,
)
from tests.diagnose.truths import two_link_motion, two_link_recording

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"
MAPS = ROOT / "benchmarks" / "measured"
THETA_ONLY = without("q.shoulder", "q.elbow")
POSITIONS = ("q.shoulder", "q.elbow", "theta.shoulder", "theta.elbow")
WRONG = {
    "mN m": (scaled(1e3, "tau.elbow"), r"log\.csv: tau\.elbow: .*looks like mN m.* divide tau\.elbow by 1000"),
    "kN m": (scaled(1e-3, "tau.elbow", "tau.shoulder"), r"tau\.shoulder: .*kN m.*tau\.elbow too"),
    "motor torque": (scaled(1 / RATIO, "tau.elbow"), r"the motor shaft's.*multiply tau\.elbow by the gear ratio 100"),
    "reflected twice": (scaled(RATIO, "tau.elbow"), r"reflected twice.*divide tau\.elbow by the gear ratio 100"),
    "torque flipped": (scaled(-1.0, "tau.shoulder"), r"tau\.shoulder: .*sign.*flipped"),
    "degrees": (scaled(180 / np.pi, *POSITIONS), r"shoulder, elbow look like degrees.*give them in rad"),
    "position flipped": (scaled(-1.0, "q.elbow", "theta.elbow"), r"positions of elbow have a flipped sign"),
    "motor positions": (both(THETA_ONLY, scaled(RATIO, "theta.shoulder", "theta.elbow")), r"theta.*the motor shaft's"),
    "torques swapped": (exchanged("tau"), r"the torques of shoulder and elbow look swapped"),
    "positions swapped": (exchanged("q", "theta"), r"the positions of shoulder and elbow look swapped"),
    "joints swapped": (exchanged("q", "theta", "tau"), r"the joints shoulder and elbow look swapped"),
    "theta swapped": (exchanged("theta"), r"theta\.shoulder: theta follows the q of elbow"),
    "theta not reflected": (
        scaled(RATIO, "theta.elbow"),
        r"theta\.elbow: .*'theta = 99\.\d+ q'.*divide.*gear ratio 100",
    ),
    "theta flipped": (scaled(-1.0, "theta.elbow"), r"theta\.elbow: theta and q have opposite signs"),
    "theta in degrees": (scaled(180 / np.pi, "theta.elbow"), r"theta\.elbow: theta is in degrees and q is not"),
}


@pytest.fixture(name="model")
def _model() -> fd.FlexibleJointModel:
    return geared_arm()


@pytest.mark.parametrize("name", WRONG)
def test_a_mistake_is_named_with_its_remedy(model: fd.FlexibleJointModel, name: str) -> None:
    """A unit, sign or joint that is wrong gives one line with recording, channel, value and remedy."""
    change, pattern = WRONG[name]
    with pytest.raises(fd.errors.InputError, match=pattern) as caught:
        checked(model, change)
    assert str(caught.value).startswith("log.csv: ")
    assert "\n" not in str(caught.value)


def _speeds() -> Array:
    return two_link_motion()[0][:, 6:8]


def _plus(torque: Callable[[int, Array, Array], Array]) -> Change:
    """Torques asked for as they would be with another torque on each rotor, which they overcome."""

    def change(channels: Channels) -> Channels:
        added = dict(channels)
        for j, joint in enumerate(("shoulder", "elbow")):
            added[f"tau.{joint}"] = added[f"tau.{joint}"] + torque(j, _speeds()[:, j], channels[f"theta.{joint}"])
        return added

    return change


MISSING = {
    "nothing": same,
    "torque constant 30 % low": scaled(1 / 0.7, "tau.shoulder", "tau.elbow"),
    "torque constant 30 % high": scaled(1 / 1.3, "tau.elbow"),
    "dry friction as large as the torque": _plus(lambda j, u, x: 1.5 * np.sign(u)),
    "viscous friction as large as the torque": _plus(lambda j, u, x: 1.5 * u / np.abs(u).max()),
    "a spring": _plus(lambda j, u, x: 0.8 * x),
    "an offset": _plus(lambda j, u, x: np.full_like(x, 5.0)),
    "motor encoders alone": THETA_ONLY,
    "link encoders alone": without("theta.shoulder", "theta.elbow"),
    "an encoder's gain": scaled(1.02, "q.elbow"),
}


@pytest.mark.parametrize("name", MISSING)
def test_a_missing_effect_is_no_mistake(model: fd.FlexibleJointModel, name: str) -> None:
    """However large an effect is that the model lacks, the recording is not refused."""
    checked(model, MISSING[name])


def test_a_good_recording_needs_no_note(model: fd.FlexibleJointModel) -> None:
    """Nothing is said where the torque follows the model."""
    assert checked(model, same) == ()


def test_a_heavy_payload_is_no_mistake(model: fd.FlexibleJointModel) -> None:
    """A model whose tool weighs half a kilogram more than the arm's is compared, and not refused."""
    checked(model.replace(effects=[fd.effects.Payload(mass=0.5)]), same)


def test_a_clock_in_milliseconds(model: fd.FlexibleJointModel) -> None:
    """Samples four seconds apart show no acceleration."""
    with pytest.raises(fd.errors.InputError, match=r"samples 4 s apart.*divide them by 1000 if they are in ms"):
        checked(model, same, t=4.0 * np.arange(1000.0))


def test_degrees_and_a_gear_ratio_nearby(model: fd.FlexibleJointModel) -> None:
    """Behind a gear of 60, theta in degrees is not taken for the motor's angle, nor that for degrees."""
    joints = {name: dataclasses.replace(joint, gear_ratio=60.0) for name, joint in model.joints.items()}
    geared = model.replace(joints=joints)
    with pytest.raises(fd.errors.InputError, match="theta is in degrees"):
        checked(geared, scaled(180 / np.pi, "theta.elbow"))
    with pytest.raises(fd.errors.InputError, match="theta is the motor's angle"):
        checked(geared, scaled(60.0, "theta.elbow"))


def test_the_recording_that_is_wrong_is_named(model: fd.FlexibleJointModel) -> None:
    """Of two recordings, the one in another unit."""
    rec = two_link_recording(LEVELS, seed=4)
    wrong = {name: x * (1e3 if name.startswith("tau") else 1.0) for name, x in rec.channels.items()}
    one, two = fd.Recording(rec.t, rec.channels, name="a.csv"), fd.Recording(rec.t, wrong, name="b.csv")
    data = (measured(model, one), measured(model, two))
    with pytest.raises(fd.errors.InputError, match=r"^b\.csv: tau\.shoulder: .*mN m"):
        check_recordings(model, data)


@pytest.mark.parametrize(("factor", "problem"), [(1.0, ""), (1e3, "mm|kN"), (-1.0, "sign")])
def test_a_sliding_joint(tmp_path: Path, factor: float, problem: str) -> None:
    """2.5 kg on a rail: positions in mm, or counted the other way round, are told by its inertia."""
    model = fd.FlexibleJointModel(slider(tmp_path), {}, [], gravity=[0.0, 0.0, 0.0])
    t = np.arange(4000) / 1000
    x, a = 0.1 * np.sin(7.0 * t), -4.9 * np.sin(7.0 * t)
    units = {"units": {"q.lift": "m", "tau.lift": "N"}}
    rec = fd.Recording(t, {"q.lift": factor * x, "tau.lift": 2.5 * a}, meta=units)
    data = (measured(model, rec),)
    if not problem:
        assert check_recordings(model, data) == ()
        return
    with pytest.raises(fd.errors.InputError, match=problem):
        check_recordings(model, data)


GANTRY = "".join(
    f"""<link name="{name}"><inertial><mass value="{mass}"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="{name}" type="prismatic"><parent link="{base}"/><child link="{name}"/><axis xyz="{axis}"/>
<limit lower="-100" upper="100" effort="1000" velocity="100"/></joint>"""
    for name, base, axis, mass in (("x", "base", "1 0 0", 1), ("y", "x", "0 1 0", 1), ("z", "y", "0 0 1", 2))
)


@pytest.mark.parametrize("rotor", [0.9, 4.5, 6.5])
def test_a_guessed_rotor_does_not_convict_other_joints(tmp_path: Path, rotor: float) -> None:
    """Axes that move alike could be exchanged as well; a rotor of another axis that is a guess is not healed by it.

    The right rotor weighs 2 kg in the place of those of the model.
    """
    path = tmp_path / "gantry.urdf"
    path.write_text(f'<robot name="gantry"><link name="base"/>{GANTRY}</robot>', encoding="utf-8")
    model = fd.FlexibleJointModel(fd.load_robot(path), {"z": {"rotor_inertia": rotor}}, gravity=[0.0, 0.0, 0.0])
    t = np.arange(4000) / 1000
    motion = {"x": (5.0, 4.0), "y": (5.0, 3.0), "z": (8.0, 4.0)}
    channels = {f"q.{name}": 0.1 * np.sin(w * t) for name, (w, _) in motion.items()}
    channels |= {f"tau.{name}": -0.1 * mass * w**2 * np.sin(w * t) for name, (w, mass) in motion.items()}
    units = {name: "m" if name.startswith("q") else "N" for name in channels}
    check_recordings(model, (measured(model, fd.Recording(t, channels, meta={"units": units})),))


PENDULUM = """<robot name="pendulum"><link name="base"/>
<link name="one"><inertial><origin xyz="0 0 -0.2"/><mass value="0.5235"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
<link name="two"><inertial><origin xyz="0 0 -0.256"/><mass value="0.6256"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
<joint name="joint1" type="continuous"><parent link="base"/><child link="one"/><axis xyz="0 1 0"/></joint>
<joint name="joint2" type="continuous"><parent link="one"/><child link="two"/><origin xyz="0 0 -0.2"/>
<axis xyz="0 1 0"/></joint></robot>"""
CARRIAGE = SLIDER.replace("lift", "carriage").replace('mass value="2.5"', 'mass value="95"')
MACHINES = {
    "emps/DATA_EMPS.mat": ("emps/map.yaml", CARRIAGE, 0.0),
    "emps/DATA_EMPS_PULSES.mat": ("emps/map.yaml", CARRIAGE, 0.0),
    "dfki_double_pendulum/20230629-143524.csv": ("double_pendulum/map.yaml", PENDULUM, -9.81),
    "dfki_double_pendulum/20230629-154548.csv": ("double_pendulum/map.yaml", PENDULUM, -9.81),
}


@pytest.mark.skipif(not DATA.is_dir(), reason="the measured recordings are not beside the repository")
@pytest.mark.parametrize("name", MACHINES)
def test_real_machines_under_rough_models(tmp_path: Path, name: str) -> None:
    """Links alone, without any friction, are model enough for a real recording to pass; in mN m it does not."""
    ready, urdf, weight = MACHINES[name]
    path = tmp_path / "machine.urdf"
    path.write_text(urdf, encoding="utf-8")
    model = fd.FlexibleJointModel(fd.load_robot(path), gravity=[0.0, 0.0, weight])
    rec = fd.read_recording(DATA / name, map=MAPS / ready)
    kept = {c: x for c, x in rec.channels.items() if c.partition(".")[0] in ("theta", "tau")}
    units = {c: rec.unit(c) for c in kept}
    data = measured(model, fd.Recording(rec.t, kept, meta={"units": units}, name=rec.name))
    check_recordings(model, (data,))
    with pytest.raises(fd.errors.InputError, match=r"looks like mN"):
        check_recordings(model, (dataclasses.replace(data, tau=1e3 * data.tau),))
