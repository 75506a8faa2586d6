"""Torques of links that are kept for a motion: those of a pendulum, by its closed form, whatever was asked before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.equations.shared import SharedResults
from flexdyn.records.signals.kernels import GaussianSmoother

Array = NDArray[np.float64]
GRAVITY, LENGTH, INERTIA = 9.81, 0.5, 0.02


@pytest.fixture
def bare(tmp_path: Path) -> fd.FlexibleJointModel:
    """A pendulum whose mass of 1 kg hangs down at q = 0."""
    inertia = f'<inertia ixx="{INERTIA}" ixy="0" ixz="0" iyy="{INERTIA}" iyz="0" izz="{INERTIA}"/>'
    path = tmp_path / "pendulum.urdf"
    path.write_text(
        '<robot name="pendulum"><link name="base"/><link name="rod"><inertial>'
        f'<origin xyz="0 0 {-LENGTH}"/><mass value="1"/>{inertia}</inertial></link>'
        '<link name="tip"/><joint name="end" type="fixed"><parent link="rod"/><child link="tip"/>'
        f'<origin xyz="0 0 {-LENGTH}"/></joint>'
        '<joint name="swing" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>'
        "</robot>",
        encoding="utf-8",
    )
    return fd.FlexibleJointModel(fd.load_robot(path), {"*": {"rotor_inertia": 0.0}})


def heavier(bare: fd.FlexibleJointModel, mass: float) -> fd.LinkSide:
    """The link side of the pendulum with a mass more at its tip."""
    return fd.LinkSide(bare.replace(effects=[fd.effects.Payload(frame="tip", mass=mass)] if mass else []))


def wanted(mass: float, q: Array, a: Array) -> Array:
    """``(I + m l^2) a + m g l sin q``."""
    return (INERTIA + mass * LENGTH**2) * a + mass * GRAVITY * LENGTH * np.sin(q)


@pytest.mark.parametrize("room", [1, 2, 8])
def test_torques_are_those_of_the_arm_and_the_motion_asked_for(room: int, bare: fd.FlexibleJointModel) -> None:
    """Two arms and two motions in turn, each made anew, with room for all of them and for one."""
    t = np.linspace(0.0, 2.0, 50)[:, None]
    shared = SharedResults(room)
    for _ in range(3):
        for more in (0.0, 0.4):
            for w in (1.0, 2.0):
                q, v, a = np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)
                found = shared.torques(heavier(bare, more), q, v, a)
                np.testing.assert_allclose(found, wanted(1.0 + more, q, a), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("room", [1, 4])
def test_filtered_signals_are_those_asked_for(room: int) -> None:
    """Signals that agree at the samples by which they are told apart, in turn, and more of them than there is room."""
    kernel, shared = GaussianSmoother.of_width(0.004, 0.001), SharedResults(room)
    signals = [np.zeros((160, 2)) for _ in range(12)]
    for k, x in enumerate(signals):
        x[1 + 10 * k % 150] = k + 1.0
    for order in (0, 1, 0, 2, 2):
        for x in signals:
            found = shared.filtered(kernel, x.copy(), order)
            np.testing.assert_array_equal(found, kernel.apply(x, order))


def test_links_are_the_same_by_their_numbers(bare: fd.FlexibleJointModel) -> None:
    """Made anew they are the same; a mass and gravity make others."""
    assert heavier(bare, 0.4).same_as(heavier(bare, 0.4))
    assert not heavier(bare, 0.4).same_as(heavier(bare, 0.5))
    assert not heavier(bare, 0.0).same_as(fd.LinkSide(bare.replace(gravity=[0.0, 0.0, -1.62])))
