"""Runs of the six-joint arm in MuJoCo: rotors are hinges of their own, springs are tendons between rotor and link.

MuJoCo's Runge-Kutta integrates; what it does not know comes as forces at every stage (mjcb_passive). Dry friction is
its frictionloss, made as hard as it gets, its level renewed every step.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import layout as at
import mujoco
import numpy as np
import pinocchio as pin
from cables import NONE, Cables, pull
from layout import Array
from six_arm import TOOL_AT, TOOL_COM, TOOL_INERTIA, SixArm
from six_forces import act, carried, dry, plain
from two_link_run import PERIOD, Control, Truth

STEP = 1e-4  # s: positions wrong by some 1e-5 rad after 0.5 s, a tenth of what the torque noise does
IMPEDANCE = "0.9999 0.9999 0.001 0.5 2"
UNUSED = ("contact", "equality", "limit", "actuation", "sensor", "midphase", "autoreset", "island")


def mjcf(arm: SixArm, P: Array, payload: float) -> str:
    """The arm for MuJoCo; link hinges first, then rotors, so that qpos = [q, theta]."""
    root = ElementTree.Element("mujoco")
    _add(root, "compiler", angle="radian", autolimits="true", balanceinertia="true", boundinertia="1e-9")
    option = _add(root, "option", integrator="RK4", timestep=str(STEP), gravity="0 0 -9.81", solver="PGS")
    _add(option, "flag", **dict.fromkeys(UNUSED, "disable"))
    world, tendons = _add(root, "worldbody"), _add(root, "tendon")
    parent = world
    hard = {"solreffriction": f"{2 * STEP} 1", "solimpfriction": IMPEDANCE, "frictionloss": "1"}
    for j in range(6):
        parent = _add(parent, "body", pos=_row(arm.translation[j]), quat=_quaternion(arm.rotation[j]))
        _inertial(parent, arm.mass[j], arm.com[j], arm.inertia[j])
        _add(parent, "joint", name=f"q{j}", axis=_row(arm.axis[j]), **hard)
    tool = _add(parent, "body", pos=_row(np.array(TOOL_AT)))
    _inertial(tool, arm.tool, np.array(TOOL_COM), TOOL_INERTIA * np.eye(3))
    if payload > 0.0:
        _inertial(_add(tool, "body"), payload, np.zeros(3), 1e-9 * np.eye(3))
    for j, (rotor, own) in enumerate(zip(arm.rotor(), plain(P), strict=True)):
        body = _add(world, "body")
        _inertial(body, 1.0, np.zeros(3), float(rotor) * np.eye(3))
        _add(body, "joint", name=f"theta{j}", axis="0 0 1", **hard)
        stiffness = repr(float(P[j, at.K])) if own else "0"
        tendon = _add(tendons, "fixed", stiffness=stiffness, damping=repr(float(P[j, at.D])), springlength="0")
        _add(tendon, "joint", joint=f"theta{j}", coef="1")
        _add(tendon, "joint", joint=f"q{j}", coef="-1")
    return ElementTree.tostring(root, encoding="unicode")


def _add(parent: ElementTree.Element, tag: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)


def _inertial(body: ElementTree.Element, mass: float, com: Array, inertia: Array) -> None:
    full = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    _add(body, "inertial", pos=_row(com), mass=repr(float(mass)), fullinertia=_row(full))


def _row(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _quaternion(rotation: Array) -> str:
    x, y, z, w = pin.Quaternion(rotation).normalized().coeffs()
    return _row(np.array([w, x, y, z]))


def controlled(arm: SixArm, P: Array, payload: float, other: Array, control: Control, cables: Cables = NONE) -> Truth:
    """A run under control; the states of the result are [q, theta, v, omega].

    Raises:
        ArithmeticError: the arm left every bound.
    """
    P = P.copy()
    model = mujoco.MjModel.from_xml_string(mjcf(arm, P, payload))
    data = mujoco.MjData(model)
    data.qpos[:6] = control.reference[0]
    mujoco.mj_forward(model, data)
    hang = np.array(data.qfrc_bias[:6])
    gap = P[:, at.HALF_GAP] * np.sign(hang)
    data.qpos[6:] = control.reference[0] + hang / P[:, at.K] + gap
    now, shift, out = np.zeros(6), np.zeros(12), np.zeros(12)

    def passive(_: Any, d: Any) -> None:
        act(d.time, d.qpos, d.qvel, now, other, P, out)
        d.qfrc_passive[:] += out - shift

    mujoco.set_mjcb_passive(passive)
    try:
        return _loop(model, data, P, control, now, shift, cables)
    finally:
        mujoco.set_mjcb_passive(None)


def _loop(model: Any, data: Any, P: Array, control: Control, now: Array, shift: Array, cables: Cables) -> Truth:
    samples, steps = len(control.reference), round(PERIOD / STEP)
    y, tau, sensed = np.zeros((samples, 24)), np.zeros((samples, 6)), np.zeros((samples, 6))
    tau_s, level = np.zeros(6), np.zeros(12)
    pulled = np.zeros((samples if len(cables.others) else 0, 6))
    bent, last = np.zeros(6), np.array(data.qpos[:6])
    before = slow = np.zeros(6)
    late = np.rint(P[:, at.DELAY] / STEP).astype(int)
    wanted = np.vstack([np.diff(control.reference, axis=0), np.zeros((1, 6))]) / PERIOD
    for k in range(samples):
        seen = np.floor(data.qpos[6:] / control.resolution) * control.resolution
        before = seen if k == 0 else before
        slow = slow + PERIOD / (PERIOD + control.filtered) * ((seen - before) / PERIOD - slow)
        before = seen
        tau[k] = control.feedforward[k] + control.kp * (control.reference[k] - seen) + control.kd * (wanted[k] - slow)
        y[k, :12], y[k, 12:] = data.qpos, data.qvel
        if len(pulled):
            pull(y[k, :6], last, bent, cables.others, cables.waves, cables.ropes, pulled[k])
            last, P[:, at.PULL] = y[k, :6].copy(), pulled[k]
        for i in range(steps):
            sample = (k * steps + i - late) // steps
            now[:] = np.where(sample >= 0, tau[np.maximum(sample, 0), np.arange(6)], 0.0)
            carried(data.time, data.qpos, data.qvel, P, tau_s)
            sensed[k] = tau_s if i == 0 else sensed[k]
            dry(data.time, data.qpos, data.qvel, P, tau_s, level, shift)
            model.dof_frictionloss[:] = level
            mujoco.mj_step(model, data)
    if not np.isfinite(y).all() or np.abs(y).max() > 100.0:
        raise ArithmeticError("the arm left every bound: an unstable case")
    return Truth(np.asarray(np.arange(samples, dtype=float) * PERIOD), y, tau, sensed, P, np.zeros(0), pulled)
