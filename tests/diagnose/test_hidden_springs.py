"""Hysteresis of a spring whose link nobody measures: its state at a window's start, and how large it is."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.inference.catalogue import everything
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.shooting.internal_states import INTERNAL_STATE_WIDTH
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.diagnose.shooting.starts import window_starts
from flexdyn.diagnose.shooting.windows import Windows

HYSTERESIS = fd.effects.SpringHysteresis("elbow", stiffness=400.0, width=0.004)
NOISE = {"theta": 2e-6, "tau": 0.02}


@pytest.fixture(scope="module")
def recorded() -> tuple[fd.FlexibleJointModel, fd.Run, fd.Recording]:
    """The arm, its run, and what the motors' encoders saw."""
    joints = {"*": {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5}}
    model = fd.load_model("scara_two_link").replace(joints=joints, effects=[HYSTERESIS], tolerance=0.03)
    t = np.arange(4000) / 1000
    way = np.stack([0.5 * np.sin(2.0 * t), 1.5 + 0.4 * np.sin(3.0 * t) + 0.2 * np.sin(7.0 * t)], axis=1)
    run = fd.simulate(model, fd.PD(fd.Samples(t, way, "cubic"), kp=400, kd=20), q0=way[0])
    log, rng = run.to_recording(), np.random.default_rng(0)
    names = [f"{signal}.{joint}" for signal in NOISE for joint in model.joint_names]
    seen = {name: log[name] + rng.normal(0.0, NOISE[name.split(".")[0]], t.size) for name in names}
    return model, run, fd.Recording(run.t, seen)


def _torque(run: fd.Run) -> Array:
    """Of the hysteresis along the true deflection (samples,) [N m]."""
    return HYSTERESIS.along(run.deflection[:, 1])


def test_windows_begin_with_the_state_that_the_computed_deflection_leads_to(
    recorded: tuple[fd.FlexibleJointModel, fd.Run, fd.Recording],
) -> None:
    """The state of the hysteresis, of which no encoder says anything, within the width that the fit allows it."""
    model, run, recording = recorded
    bare, _ = prepared(model, (measured(model, recording),))
    assert bare.equations.computed.all()
    windows = Windows.of(model, [recording], bare.noise)
    found = window_starts(Shooter(model, windows)).x[:, -1]
    true = HYSTERESIS.states_along(run.deflection[:, 1])[windows.places[:, 1]]
    inside = slice(1, None)  # the first window begins where the filters have not begun
    assert np.abs(found - true)[inside].max() < INTERNAL_STATE_WIDTH * HYSTERESIS.reach
    assert np.abs(true)[inside].max() > 0.5 * HYSTERESIS.reach


def test_an_effect_in_a_transmission_is_as_large_as_its_torque(
    recorded: tuple[fd.FlexibleJointModel, fd.Run, fd.Recording],
) -> None:
    """Not as what the rows have of it, which without a link encoder is much less."""
    model, run, recording = recorded
    bare, start = prepared(model.replace(effects=[]), (measured(model, recording),))
    here = dataclasses.replace(start, effects=(HYSTERESIS,))
    at, work = bare.equations.of(here.model()), weighed(bare)
    library = Library(at, work, here, work.numbers, tuple(everything(at)))
    change = at.residual - bare.equations.residual
    share, _ = library.sizes.of(HYSTERESIS, change)
    of_torque = float(np.sqrt(np.mean(_torque(run) ** 2)) / run.tau[:, 1].std())
    assert share == pytest.approx(of_torque, rel=0.25)
    assert np.sqrt(np.mean(change**2)) < 0.3 * np.sqrt(np.mean(_torque(run) ** 2))
