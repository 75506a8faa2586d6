"""The six-joint arm as published: no friction, guessed rotors, joints taken for rigid, as in published.py."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pinocchio as pin
import six_run
from cables import draw_cables
from excitation import wanted_of
from hidden import Hidden, enter
from lab import (
    MARGIN,
    TOLERANCE,
    Lab,
    cut,
    draw_lab,
    encoder_step,
    first_that_works,
    link_factor,
    longer,
    packed,
    record,
    rotor_factor,
)
from lacking import accelerations, draw_lacking, harmless, judged
from layout import Array
from published import FREQUENCY, LOST, draw_published_style, drive_columns, wrong_numbers
from six_arm import MIDDLE, SixArm, figures, model_yaml, nominal, urdf, varied
from six_cases import BUILT, plant
from sizes import Scale, log_uniform
from two_link_run import PERIOD, Control, Truth

PUBLISHED_SIX = "published_six"
ATTEMPTS = 5
REACH = (0.8, 0.5, 0.5, 0.8, 0.8, 1.2)  # rad
FEEDFORWARD = 0.9  # share of the model's torque that is fed forward
FIRST = 12.0  # s of the run that only sizes the effects


def make_published_six(seed: int, number: int, fit: float, check: float) -> dict[str, Any]:
    """Name, files, recordings and truth of one case.

    Raises:
        ArithmeticError: no arm that follows its reference was found in so many draws.
    """
    return first_that_works(
        PUBLISHED_SIX, ATTEMPTS, (seed, 22, number), lambda rng: _attempt(rng, seed, number, (fit, check))
    )


def _attempt(rng: np.random.Generator, seed: int, number: int, durations: tuple[float, float]) -> dict[str, Any]:
    lab, arm = draw_lab(rng), _true_arm(rng)
    whole = _inertia(arm) + arm.rotor()
    controls = _controls(rng, arm, lab, whole, durations)
    P, other = plant(arm), -np.ones(6)
    base = cut(six_run.controlled(arm, P, 0.0, other, _first(controls[0])))
    scales = [_scale(rng, arm, base, controls[0], j, whole) for j in range(6)]
    hidden = draw_lacking(rng, scales, arm.joints, arm.names)
    peak = scales[0].peak
    path = np.concatenate([control.reference for control in controls])
    cables = draw_cables(rng, path, np.array([scale.other for scale in scales]), lab.cable * peak)
    for one in hidden:
        enter(P, one)
        if one.effect == "joint_coupling" and one.joint is not None:
            other[one.joint] = arm.joints.index(one.place["other"])
    runs = [six_run.controlled(arm, P, 0.0, other, control, cables) for control in controls]
    if max(np.abs(r.y[:, 0:6] - c.reference).max() for r, c in zip(runs, controls, strict=True)) > LOST:
        raise ArithmeticError(f"{PUBLISHED_SIX} {seed} {number}: lost its reference")
    runs = [cut(run) for run in runs]
    recordings = [record(run, arm.joints, arm.gear_ratio, lab, peak, rng) for run in runs]
    given, factors = _given(rng, arm)
    files = {"model.yaml": model_yaml(given, TOLERANCE), "arm.urdf": urdf(given)}
    answers = _answers(hidden, arm, factors, runs[0], lab)
    return packed(PUBLISHED_SIX, seed, number, durations, files, recordings, answers)


def _true_arm(rng: np.random.Generator) -> SixArm:
    """Built a little otherwise than the nominal one, with springs of its own, and friction still to come."""
    arm = varied(nominal(), rng, BUILT, BUILT)
    both = 1.0 / (1.0 / _inertia(arm) + 1.0 / arm.rotor())
    K = both * (2.0 * np.pi * log_uniform(rng, FREQUENCY, 6)) ** 2
    D = 2.0 * rng.uniform(0.01, 0.05, 6) * np.sqrt(K * both)
    return arm.replace(stiffness=figures(K), damping=figures(D), viscous=(0.0,) * 6, coulomb=(0.0,) * 6)


def _inertia(arm: SixArm) -> Array:
    """What each joint turns alone, at the middle of the motion (6,) [kg m^2]."""
    model = arm.pinocchio()
    return np.array(np.diag(pin.crba(model, model.createData(), np.array(MIDDLE))))


def _controls(
    rng: np.random.Generator, arm: SixArm, lab: Lab, whole: Array, durations: tuple[float, float]
) -> list[Control]:
    styles = [draw_published_style(rng, reach) for reach in REACH]
    w = 2.0 * np.pi * rng.uniform(3.0, 5.0, 6)
    seen = np.array([encoder_step(lab, N) for N in arm.gear_ratio])
    model, controls = arm.pinocchio(), []
    data, rotor = model.createData(), arm.rotor()
    for duration in durations:
        wanted = wanted_of(lab.motion, rng, styles, MIDDLE, longer(duration))
        v = np.gradient(wanted, PERIOD, axis=0)
        a = np.gradient(v, PERIOD, axis=0)
        forward = np.array([pin.rnea(model, data, *row) for row in zip(wanted, v, a, strict=True)]) + rotor * a
        controls.append(Control(wanted, FEEDFORWARD * forward, whole * w**2, whole * 1.6 * w, seen))
    return controls


def _first(control: Control) -> Control:
    count = round(FIRST / PERIOD)
    return dataclasses.replace(control, reference=control.reference[:count], feedforward=control.feedforward[:count])


def _scale(rng: np.random.Generator, arm: SixArm, base: Truth, control: Control, j: int, whole: Array) -> Scale:
    """What sizes are shares of; speeds are those of the whole motion, as not every joint moves in its first part."""
    return Scale(
        rng=rng,
        factor=1.0,
        joint=j,
        arm=arm,
        other=j - 1 if j > 0 else 1,
        peak=np.maximum(np.abs(base.tau).max(axis=0), np.abs(control.feedforward[:-MARGIN]).max(axis=0)),
        speed=np.abs(np.gradient(control.reference, PERIOD, axis=0)).max(axis=0),
        wind=np.abs(base.y[:, 6:12] - base.y[:, 0:6]).max(axis=0),
        low=control.reference.min(axis=0),
        high=control.reference.max(axis=0),
        inertia=whole,
    )


def _given(rng: np.random.Generator, arm: SixArm) -> tuple[SixArm, dict[tuple[str, str], float]]:
    """The arm as it is published, and given over true of every number of its links."""
    mass, com, inertia = (link_factor(rng, 6) for _ in range(3))
    tool = float(link_factor(rng, 1)[0])
    given = arm.replace(
        mass=figures(np.array(arm.mass) * mass),
        com=arm.com * com[:, None],
        inertia=arm.inertia * inertia[:, None, None],
        tool=arm.tool * tool,
        rotor_inertia=figures(np.array(arm.rotor_inertia) * rotor_factor(rng, 6)),
        stiffness=(np.inf,) * 6,
        damping=(0.0,) * 6,
    )
    factors = {("tool", "link_mass"): tool}
    for name, values in (("mass", mass), ("com", com), ("inertia", inertia)):
        factors |= {(link, f"link_{name}"): float(f) for link, f in zip(arm.names, values, strict=True)}
    return given, factors


def _answers(
    hidden: tuple[Hidden, ...], arm: SixArm, factors: dict[tuple[str, str], float], run: Truth, lab: Lab
) -> dict[str, Any]:
    columns = inertial_columns(arm, run)
    entries = judged(hidden, run, arm.joints, lambda j: columns[j])
    keys = ("mass", "tool", "stiffness", "damping", "rotor_inertia", "gear_ratio")
    return {
        "rigid_model": True,
        "hidden": entries,
        "allowed": harmless(entries, arm.joints, wrong_numbers(factors)),
        "arm": {key: getattr(arm, key) for key in keys},
        "lab": dataclasses.asdict(lab),
        "scale": drive_columns(run),
    }


def inertial_columns(arm: SixArm, run: Truth) -> list[Array]:
    """What the numbers of links and rotor multiply in the torque of every joint, (samples, 61) each."""
    model = arm.pinocchio()
    data, accelerated = model.createData(), accelerations(run.y[:, 12:18])
    rows = zip(run.y[:, 0:6], run.y[:, 12:18], accelerated, strict=True)
    all_of = np.array([pin.computeJointTorqueRegressor(model, data, q, v, a).copy() for q, v, a in rows])
    return [np.column_stack([all_of[:, j], accelerated[:, j]]) for j in range(6)]
