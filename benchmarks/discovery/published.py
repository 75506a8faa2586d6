"""Two-link robots as published: a URDF without friction, guessed rotors, joints taken for rigid; what they truly are.

Everything that the model lacks is hidden at once (lacking.py), beside cables that no catalogue holds (cables.py); what
is recorded is what a laboratory can record (lab.py).
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from arm_draw import JOINTS, LINKS, TwoLinkArm, draw_arm, inertia_at, pair
from cables import draw_cables
from cases import scale_of
from control import FEEDFORWARD, feedforward
from excitation import wanted_of
from hidden import Hidden, enter
from lab import (
    LINK_ERROR,
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
from model_text import model_yaml, urdf
from motions import Style
from sizes import log_uniform
from two_link_run import Control, Plant, Truth, controlled

PUBLISHED = "published"
ATTEMPTS = 20
QUICK = 2e-4  # s, step of the run that only sizes the effects
FREQUENCY = (15.0, 60.0)  # Hz, of a link and its rotor on the joint's spring, log-uniform
LOST = 0.3  # rad: a motion that strays further from its reference is another one


def make_published(seed: int, number: int, fit: float, check: float) -> dict[str, Any]:
    """Name, files, recordings and truth of one case.

    Raises:
        ArithmeticError: no arm that follows its reference was found in so many draws.
    """
    return first_that_works(
        PUBLISHED, ATTEMPTS, (seed, 21, number), lambda rng: _attempt(rng, seed, number, (fit, check))
    )


def _attempt(rng: np.random.Generator, seed: int, number: int, durations: tuple[float, float]) -> dict[str, Any]:
    lab, arm = draw_lab(rng), _springs(rng, draw_arm(rng))
    controls = _controls(rng, arm, lab, durations)
    base = cut(controlled(arm.plant(), controls[0], step=QUICK))
    scales = [scale_of(rng, arm, base, controls[0], j, 1.0) for j in (0, 1)]
    hidden = draw_lacking(rng, scales, JOINTS, LINKS)
    peak = scales[0].peak
    path = np.concatenate([control.reference for control in controls])
    cables = draw_cables(rng, path, np.array([1, 0]), lab.cable * peak)
    plant = arm.plant()
    for one in hidden:
        enter(plant.P, one)
    runs = [controlled(plant, control, cables=cables) for control in controls]
    if max(np.abs(r.y[:, 0:2] - c.reference).max() for r, c in zip(runs, controls, strict=True)) > LOST:
        raise ArithmeticError(f"{PUBLISHED} {seed} {number}: lost its reference")
    runs = [cut(run) for run in runs]
    recordings = [record(run, JOINTS, arm.gear_ratio, lab, peak, rng) for run in runs]
    given = _given(rng, arm)
    files = {"model.yaml": model_yaml(given, TOLERANCE), "arm.urdf": urdf(given)}
    answers = _answers(hidden, arm, given, plant, runs[0], lab)
    return packed(PUBLISHED, seed, number, durations, files, recordings, answers)


def _springs(rng: np.random.Generator, arm: TwoLinkArm) -> TwoLinkArm:
    M, J = inertia_at(arm), arm.rotor()
    both = 1.0 / (1.0 / M + 1.0 / J)
    K = both * (2.0 * np.pi * log_uniform(rng, FREQUENCY, 2)) ** 2
    return arm.replace(stiffness=pair(K), damping=pair(2.0 * rng.uniform(0.01, 0.05, 2) * np.sqrt(K * both)))


def draw_published_style(rng: np.random.Generator, reach: float) -> Style:
    """From careful to brisk."""
    speed, hard = rng.uniform(0.8, 2.2), rng.uniform(4.0, 12.0)
    return Style(reach * rng.uniform(0.7, 1.0), float(speed), float(hard), float(rng.uniform(0.03, 0.12)))


def _controls(rng: np.random.Generator, arm: TwoLinkArm, lab: Lab, durations: tuple[float, float]) -> list[Control]:
    styles = [draw_published_style(rng, 1.2) for _ in JOINTS]
    bandwidth = 2.0 * np.pi * rng.uniform(3.0, 6.0, 2)
    whole, seen = inertia_at(arm) + arm.rotor(), np.array([encoder_step(lab, N) for N in arm.gear_ratio])
    controls = []
    for duration in durations:
        wanted = wanted_of(lab.motion, rng, styles, arm.middle, longer(duration))
        torque = FEEDFORWARD * feedforward(arm, wanted)
        controls.append(Control(wanted, torque, whole * bandwidth**2, whole * 1.6 * bandwidth, seen))
    return controls


def _given(rng: np.random.Generator, arm: TwoLinkArm) -> TwoLinkArm:
    """The arm as it is published."""

    def figures(values: Array) -> tuple[float, float]:
        return float(f"{values[0]:.7g}"), float(f"{values[1]:.7g}")

    changed = {name: figures(np.array(getattr(arm, name)) * link_factor(rng, 2)) for name in ("mass", "com", "inertia")}
    rotor = figures(np.array(arm.rotor_inertia) * rotor_factor(rng, 2))
    tool = float(f"{arm.tool * float(link_factor(rng, 1)[0]):.7g}")
    rigid: dict[str, tuple[float, float]] = {"stiffness": (np.inf, np.inf), "damping": (0.0, 0.0)}
    return arm.replace(**changed, **rigid, rotor_inertia=rotor, tool=tool)


def wrong_numbers(factors: dict[tuple[str, str], float]) -> list[dict[str, str]]:
    """Numbers of links by (of, parameter) and their given over their true values that are beyond three tolerances."""
    beyond = [key for key, factor in factors.items() if abs(np.log(factor)) > 3.0 * LINK_ERROR]
    return [{"of": of, "parameter": parameter} for of, parameter in beyond]


def _answers(
    hidden: tuple[Hidden, ...], arm: TwoLinkArm, given: TwoLinkArm, plant: Plant, run: Truth, lab: Lab
) -> dict[str, Any]:
    q, v, a = run.y[:, 0:2], run.y[:, 4:6], accelerations(run.y[:, 4:6])
    entries = judged(hidden, run, JOINTS, lambda j: inertial_columns(j, q, v, a, arm.vertical))
    factors = {("tool", "link_mass"): given.tool / arm.tool}
    for name in ("mass", "com", "inertia"):
        pairs = zip(LINKS, getattr(given, name), getattr(arm, name), strict=True)
        factors |= {(link, f"link_{name}"): new / old for link, new, old in pairs}
    return {
        "rigid_model": True,
        "hidden": entries,
        "allowed": harmless(entries, JOINTS, wrong_numbers(factors)),
        "arm": dataclasses.asdict(arm),
        "given": dataclasses.asdict(given),
        "lab": dataclasses.asdict(lab),
        "scale": drive_columns(run) | {"links": plant.links.tolist()},
    }


def drive_columns(run: Truth) -> dict[str, list[float]]:
    """Torques of the fit joint by joint, for the truth file [N m]."""
    return {
        "peak_torque": np.abs(run.tau).max(axis=0).tolist(),
        "rms_torque": np.sqrt((run.tau**2).mean(axis=0)).tolist(),
        "rms_cables": np.sqrt((run.cables**2).mean(axis=0)).tolist(),
    }


def inertial_columns(j: int, q: Array, v: Array, a: Array, vertical: bool) -> Array:
    """What the numbers of links and rotor multiply in the torque of a joint (samples, m)."""
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    first = [a[:, 0], c * (2.0 * a[:, 0] + a[:, 1]) - s * v[:, 1] * (v[:, 1] + 2.0 * v[:, 0]), a[:, 1]]
    second = [a[:, 0], c * a[:, 0] + s * v[:, 0] ** 2, a[:, 1]]
    hanging = [np.cos(q[:, 0]), np.cos(q.sum(axis=1))] if vertical else []
    return np.stack([*(first if j == 0 else second), *hanging], axis=1)
