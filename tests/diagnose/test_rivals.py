"""Rivals of the best structure: they are compared at the numbers that suit them."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.posterior import posterior

HARMONIC = 5.3
NOISE = {"q": 1e-6, "theta": 2e-7, "tau": 0.01}


@pytest.mark.filterwarnings("ignore::flexdyn.LimitWarning")
def test_waves_over_a_joints_turn_are_compared_at_one_harmonic() -> None:
    """An uneven gear: eccentric encoders and ripple of that joint have its harmonic as a grid point.

    None of them has it from the spectrum of what the best structure leaves, where no peak is left.
    """
    joints = {"*": {"stiffness": 2000.0, "damping": 1.0, "rotor_inertia": 4e-5}}
    given = fd.load_model("scara_two_link").replace(joints=joints, effects=[], tolerance=0.03)
    uneven = fd.effects.KinematicError("elbow", amplitude=2e-4, harmonic=HARMONIC, phase=0.4)
    t = np.arange(4000) / 500
    way = np.stack([0.5 * np.sin(2.0 * t), 1.5 + 0.8 * np.sin(3.0 * t) + 0.2 * np.sin(7.0 * t)], axis=1)
    run = fd.simulate(given.replace(effects=[uneven]), fd.PD(fd.Samples(t, way, "cubic"), kp=400, kd=20), q0=way[0])
    log, rng = run.to_recording(), np.random.default_rng(0)
    names = [f"{signal}.{joint}" for signal in NOISE for joint in given.joint_names]
    seen = {name: log[name] + rng.normal(0.0, NOISE[name.split(".")[0]], len(log)) for name in names}
    found = posterior(*prepared(given, (measured(given, fd.Recording(run.t, seen)),)))
    (best,) = found.best
    named = found.fitted.hypothesis.effects[0]
    assert isinstance(named, fd.effects.KinematicError)
    assert named.harmonic == pytest.approx(HARMONIC, rel=1e-3)
    waves = [
        each
        for c, each in enumerate(found.space.candidates)
        if each.law.cycles and each.proposal is not None and each.proposal.joint == "elbow" and c != best[0]
    ]
    assert {each.kind for each in waves} >= {"encoder_eccentricity", "torque_ripple"}
    for each in waves:
        assert min(abs(point[0] - HARMONIC) for point in each.points) < 1e-3 * HARMONIC, each.identity
