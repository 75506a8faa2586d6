"""Published robots: what a laboratory is given, and that the truth behind it is what the truth file says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cables import draw_cables, pull
from hidden import Hidden
from lab import draw_lab, low_pass
from lacking import judged
from layout import STATES, Array
from make import write_case
from published import inertial_columns, make_published
from published_six import make_published_six
from scipy.signal import butter, filtfilt, lfilter
from two_link_run import Truth

import flexdyn as fd

JOINTS = ("shoulder", "elbow")


@pytest.fixture(scope="module")
def case() -> dict[str, Any]:
    """An arm at 1 kHz that makes point-to-point moves, with viscous and Coulomb friction only."""
    return make_published(1, 2, 40.0, 12.0)


def swings(seconds: float = 40.0) -> tuple[Array, Array]:
    """Times, and angles of two joints that swing at different rates."""
    t: Array = np.asarray(np.arange(round(seconds * 1000)) * 1e-3, dtype=np.float64)
    return t, np.stack([0.8 * np.sin(1.3 * t), 1.0 + 0.7 * np.sin(2.1 * t + 0.4)], axis=1)


def test_a_laboratory_is_given_a_rigid_model_without_friction(case: dict[str, Any], tmp_path: Path) -> None:
    """Motor encoders and currents alone; every joint has viscous and dry friction that the model lacks."""
    place = write_case(case, tmp_path / "published")
    model, recording = fd.load_model(place / "model.yaml"), fd.read_recording(place / "fit.npz")
    assert all(np.isinf(joint.stiffness) for joint in model.joints.values())
    assert not model.effects
    assert set(case["recordings"]["fit"]) == {"t", *(f"{s}.{j}" for s in ("theta", "tau") for j in JOINTS)}
    assert len(recording.t) == 40_000 // case["truth"]["lab"]["every"]
    for joint in JOINTS:
        mine = {one["effect"] for one in case["truth"]["hidden"] if one["joint"] == joint}
        assert "viscous_friction" in mine
        assert mine & {"coulomb_friction", "asymmetric_friction"}


def test_plain_least_squares_finds_the_friction(case: dict[str, Any]) -> None:
    """On the rigid inverse dynamics, through the filter of the currents, to a tenth; what is left is the cables'."""
    channels, truth = case["recordings"]["fit"], case["truth"]
    b, a = butter(4, 2.0 * 8.0 * 1e-3)
    lag = -np.expm1(-1e-3 / truth["lab"]["filtered"])

    def smooth(values: Array) -> Array:
        return np.asarray(filtfilt(b, a, values, axis=0))

    q = smooth(np.stack([channels[f"theta.{joint}"] for joint in JOINTS], axis=1))
    v = np.gradient(q, 1e-3, axis=0)
    acceleration = np.gradient(v, 1e-3, axis=0)
    for j, joint in enumerate(JOINTS):
        inertial = inertial_columns(j, q, v, acceleration, truth["arm"]["vertical"])
        columns = np.column_stack([v[:, j], smooth(np.sign(v[:, j])), inertial])
        columns, torque = lfilter([lag], [1.0, lag - 1.0], columns, axis=0), smooth(channels[f"tau.{joint}"])
        kept = np.abs(v[:, j]) > 0.02
        kept[:1000] = kept[-1000:] = False
        found = np.linalg.lstsq(columns[kept], torque[kept], rcond=None)[0]
        true = {one["effect"]: one["parameters"] for one in truth["hidden"] if one["joint"] == joint}
        assert found[0] == pytest.approx(true["viscous_friction"]["coefficient"], rel=0.1)
        assert found[1] == pytest.approx(true["coulomb_friction"]["level"], rel=0.1)
        left = float((columns[kept] @ found - torque[kept]).std())
        assert left < 2.0 * truth["scale"]["rms_cables"][j]


def test_cables_are_as_big_as_asked_and_like_nothing_in_the_catalogue() -> None:
    """The simulator's torque along the motion they were drawn for."""
    _, q = swings()
    cables = draw_cables(np.random.default_rng(3), q, np.array([1, 0]), np.array([2.0, 0.5]))
    bent, last, out = np.zeros(2), q[0].copy(), np.zeros_like(q)
    for k, now in enumerate(q):
        pull(now, last, bent, cables.others, cables.waves, cables.ropes, out[k])
        last = now
    np.testing.assert_allclose(np.sqrt((out**2).mean(axis=0)), [2.0, 0.5], rtol=1e-6)
    for j in (0, 1):
        own, way = q[:, j], np.sign(np.gradient(q[:, j]))
        alone = np.stack([np.ones_like(own), own, np.cos(own), np.sin(own), np.cos(2 * own), way], axis=1)
        left = out[:, j] - alone @ np.linalg.lstsq(alone, out[:, j], rcond=None)[0]
        assert left.std() > 0.999 * out[:, j].std()


def test_the_filter_of_the_currents_is_of_first_order() -> None:
    """A step that is held from its sample on comes through as 1 - exp(-t/T)."""
    step = np.ones((50, 1))
    step[0] = 0.0
    t = np.arange(50) * 1e-3
    np.testing.assert_allclose(low_pass(step, 4e-3)[1:, 0], 1.0 - np.exp(-(t[1:] - 1e-3) / 4e-3), atol=1e-12)


def test_only_what_the_motion_shows_matters() -> None:
    """Coulomb friction does; Stribeck friction at speeds that are hardly met does not, nor what is small."""
    t, q = swings()
    y = np.zeros((len(t), STATES))
    y[:, 0:2] = y[:, 2:4] = q
    y[:, 4:6] = y[:, 6:8] = np.gradient(q, 1e-3, axis=0)
    run = Truth(t, y, 20.0 * np.cos(q), np.zeros_like(q), np.zeros(0), np.zeros(0), 0.3 * np.sin(7.0 * q))
    hidden = [
        Hidden("coulomb_friction", 0, "motor", {"level": 3.0}),
        Hidden("viscous_friction", 0, "motor", {"coefficient": 0.05}),
        Hidden("stribeck_friction", 0, "motor", {"excess": 3.0, "velocity": 0.01, "exponent": 1.0}),
        Hidden("stribeck_friction", 1, "motor", {"excess": 3.0, "velocity": 0.4, "exponent": 1.0}),
    ]
    found = judged(hidden, run, JOINTS, lambda j: np.cos(q[:, [j]]))
    assert [one["matters"] for one in found] == [True, False, False, True]


def test_six_joints_lack_as_much() -> None:
    """At every joint viscous and dry friction; couplings to a neighbour; the model file says how it guesses rotors."""
    made = make_published_six(1, 0, 0.6, 0.4)
    truth, fit = made["truth"], made["recordings"]["fit"]
    joints = list(dict.fromkeys(one["joint"] for one in truth["hidden"]))
    assert len(joints) == 6
    assert sum(one["effect"] == "viscous_friction" for one in truth["hidden"]) == 6
    for one in truth["hidden"]:
        if one["effect"] == "joint_coupling":
            assert abs(joints.index(one["other"]) - joints.index(one["joint"])) == 1
    assert len(fit) == 13
    assert np.diff(fit["t"]) == pytest.approx(truth["lab"]["every"] * 1e-3)
    assert "'joints.*.rotor_inertia': 0.5" in made["files"]["model.yaml"]


def test_laboratories_differ() -> None:
    """Every rate and kind of motion occurs, noise and lag are in their ranges."""
    labs = [draw_lab(np.random.default_rng(k)) for k in range(200)]
    assert {lab.every for lab in labs} == {1, 2, 4, 8}
    assert {lab.motion for lab in labs} == {"mixed", "fourier", "points", "single"}
    assert all(2e-3 <= lab.filtered <= 8e-3 and 0.005 <= lab.noise <= 0.02 for lab in labs)


@pytest.mark.slow
def test_a_likely_imitation_does_not_hide_what_every_motor_has(tmp_path: Path) -> None:
    """Seed 118001, case 7: quadratic drag is more likely than the viscous friction that is there, and imitates it."""
    place = write_case(make_published(118001, 7, 40.0, 12.0), tmp_path / "published")
    fit, check = (fd.read_recording(place / f"{part}.npz") for part in ("fit", "check"))
    found = fd.diagnose(fd.load_model(place / "model.yaml"), [fit], [check])
    named = {(each.suspect.effect, each.suspect.joint) for each in found.findings}
    assert {(kind, joint) for kind in ("viscous_friction", "coulomb_friction") for joint in JOINTS} <= named
