"""Families of cases, and one case from its family, its seed and its number.

Seeds below 10000 are for development; from 10000 on they are for evaluation and are never looked at while building.
"""

from __future__ import annotations

import dataclasses

import layout as at
import numpy as np
import wide
from arm_draw import JOINTS, TwoLinkArm, draw_arm, inertia_at, pair
from choice import FAMILIES, chosen
from control import FEEDFORWARD, draw_bandwidth, make_control
from hidden import Hidden, changed, draw, number_of, prepared, true_arm
from lab import cut, longer
from layout import Array
from model_text import ERROR, MASS_ERROR, TOLERANCE, known_effects, mistaken
from motions import Style, draw_style
from outside import OUTSIDE, draw_outside
from plants import Case, true_plant
from recording import TORQUE_NOISE, Sensors, record
from shown import shown
from sizes import Scale
from two_link_run import Control, Truth, controlled
from visible import visible
from wide import Setup, draw_setup, split

FIT, CHECK = 40.0, 12.0  # s
ATTEMPTS = 60
ORDINARY = Setup(TOLERANCE, "mixed", 1, FEEDFORWARD, wide=False)
QUICK = 2e-4  # s, step of the run that only sizes the effects
FRICTION = {"viscous": (0.03, 0.08), "coulomb": (0.03, 0.06)}
"""Friction that the model file knows: shares of the peak torque (at the greatest speed)."""


def sensors_of(family: str) -> Sensors:
    """What a family measures."""
    family, _ = split(family)
    places = {"motor_only": "motor", "link_only": "link"}
    return Sensors(noise=10.0 if family == "hard" else 1.0, positions=places.get(family, "both"))


def make_case(
    family: str, seed: int, number: int, fit: float = FIT, check: float = CHECK, sensors: Sensors | None = None
) -> Case:
    """Everything about one case; a family that ends in _wide draws from wider ranges.

    Raises:
        ArithmeticError: no stable arm in which the effect shows was found in so many draws.
    """
    base, wider = split(family)
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, 3, FAMILIES.index(base), number, attempt, *([1] if wider else [])])
        setup = draw_setup(rng) if wider else ORDINARY
        measured = dataclasses.replace(sensors or sensors_of(family), every=setup.every)
        try:
            return _attempt(base, seed, number, rng, (fit, check), measured, setup)
        except ArithmeticError:
            continue
    raise ArithmeticError(f"{family} {seed} {number}: nothing in {ATTEMPTS} draws")


def _attempt(
    family: str, seed: int, number: int, rng: np.random.Generator, durations: tuple[float, float], sensors: Sensors,
    setup: Setup,
) -> Case:  # fmt: skip
    arm, styles, bandwidth = _moved(rng, setup)
    places = [] if family in ("none", "outside") else chosen(family, seed, number)
    if sensors.positions != "both" and any(name == "sensor_offset" and j == 0 for name, j, _ in places):
        arm = arm.replace(vertical=True)  # lying down the first joint has no zero that anything but its encoder knows
    if setup.wide and sensors.positions != "both" and places and places[0][0] == "joint_elasticity":
        arm = wide.softened(arm, places[0][1])
    if family == "rigid":
        arm = arm.replace(stiffness=(np.inf, np.inf))
    resolution = np.array([sensors.motor_step(N) for N in arm.gear_ratio])
    resolution = np.where(np.isinf(arm.stiffness), sensors.link_step(), resolution)
    controls = [
        make_control(
            rng, arm, styles, _simulated(duration, setup), bandwidth, resolution, setup.motion, setup.feedforward
        )
        for duration in durations
    ]
    base = _kept(controlled(arm.plant(), controls[0], step=QUICK), setup)
    arm = with_friction(rng, arm, base)
    hidden: tuple[Hidden, ...]
    if family == "outside":
        names = list(OUTSIDE)
        scale = _in(setup, scale_of(rng, arm, base, controls[0], int(rng.integers(2)), 1.0))
        hidden = (draw_outside(names[(number + seed) % len(names)], scale),)
    else:
        factor = 0.3 if family == "hard" else 1.0
        for site in places:
            arm = prepared(arm, site, factor)
        if family == "rigid" and places[0][0] == "joint_elasticity":
            arm = _one_spring(rng, arm, places[0][1])
        hidden = tuple(
            draw(site, _in(setup, scale_of(rng, arm, base, controls[0], site[1], factor))) for site in places
        )
    name = f"{family}{wide.SUFFIX if setup.wide else ''}_{seed}_{number:03d}"
    return _finish(name, arm, hidden, (controls[0], controls[1]), sensors, rng, setup)


def _moved(rng: np.random.Generator, setup: Setup) -> tuple[TwoLinkArm, tuple[Style, Style], Array]:
    """An arm, how its joints are moved, and how fast its controllers are."""
    if not setup.wide:
        return draw_arm(rng), (draw_style(rng), draw_style(rng)), draw_bandwidth(rng)
    arm = wide.springs(rng, draw_arm(rng))
    return arm, (wide.draw_style(rng), wide.draw_style(rng)), wide.bandwidth(rng, arm)


def _in(setup: Setup, scale: Scale) -> Scale:
    return dataclasses.replace(scale, tolerance=setup.tolerance, wide=setup.wide)


def _simulated(duration: float, setup: Setup) -> float:
    """How long a run is; where the ordinary families end, the reference stops dead, and so does the torque."""
    return longer(duration) if setup.wide else duration


def _kept(run: Truth, setup: Setup) -> Truth:
    return cut(run) if setup.wide else run


def _one_spring(rng: np.random.Generator, arm: TwoLinkArm, j: int) -> TwoLinkArm:
    M, J = inertia_at(arm)[j], arm.rotor()[j]
    K, D = list(arm.stiffness), list(arm.damping)
    K[j] = float((2.0 * np.pi * rng.uniform(12.0, 30.0)) ** 2 * M * J / (M + J))
    D[j] = float(0.04 * np.sqrt(K[j] * M * J / (M + J)))
    return arm.replace(stiffness=(K[0], K[1]), damping=(D[0], D[1]))


def with_friction(rng: np.random.Generator, arm: TwoLinkArm, base: Truth) -> TwoLinkArm:
    """The arm with the friction that its model file will know."""
    peak, speed = np.abs(base.tau).max(axis=0), np.abs(base.y[:, 6:8]).max(axis=0)
    viscous = rng.uniform(*FRICTION["viscous"], 2) * peak / speed
    coulomb = rng.uniform(*FRICTION["coulomb"], 2) * peak
    return arm.replace(viscous=pair(viscous), coulomb=pair(coulomb))


def scale_of(
    rng: np.random.Generator, arm: TwoLinkArm, base: Truth, control: Control, joint: int, factor: float
) -> Scale:
    """What sizes are shares of."""
    return Scale(
        rng=rng,
        factor=factor,
        joint=joint,
        arm=arm,
        other=1 - joint,
        peak=np.abs(base.tau).max(axis=0),
        speed=np.abs(base.y[:, 6:8]).max(axis=0),
        wind=np.abs(base.y[:, 2:4] - base.y[:, 0:2]).max(axis=0),
        low=control.reference.min(axis=0),
        high=control.reference.max(axis=0),
        inertia=inertia_at(arm) + arm.rotor(),
    )


def _finish(
    name: str,
    arm: TwoLinkArm,
    hidden: tuple[Hidden, ...],
    controls: tuple[Control, Control],
    sensors: Sensors,
    rng: np.random.Generator,
    setup: Setup,
) -> Case:
    hard, more = sensors.noise > 1.0, setup.tolerance / TOLERANCE
    given = mistaken(arm, rng, ERROR * more, MASS_ERROR * more, at_edge=hard)
    for one in hidden:
        given = given_for(one, arm, given)
    if not all(_shows(one, arm, given, setup.tolerance) for one in hidden):
        raise ArithmeticError(f"{name}: other numbers make up for the one that is wrong")
    plant = true_plant(arm, hidden)
    noise: list[Array | None] = [None, None]
    if sensors.actuator_noise:
        peak = np.abs(controls[0].feedforward).max(axis=0)
        noise = [TORQUE_NOISE * sensors.noise * peak * rng.normal(size=c.reference.shape) for c in controls]
    runs = [_kept(controlled(plant, c, noise=extra), setup) for c, extra in zip(controls, noise, strict=True)]
    if setup.wide and max(_strayed(run, c) for run, c in zip(runs, controls, strict=True)) > wide.STRAYED:
        raise ArithmeticError(f"{name}: lost its reference")
    recordings = [record(run, JOINTS, arm.gear_ratio, hidden, sensors, rng) for run in runs]
    hidden = tuple(_indexed(one, given) for one in hidden)
    names = dict(zip(("fit", "check"), recordings, strict=True))
    case = Case(
        name, hidden, arm, given, plant, runs[0], runs[1], names, sensors, controls, setup.tolerance, setup.wide
    )
    if not all(visible(case, one) for one in hidden):
        raise ArithmeticError(f"{name}: one of the recordings does not show what is hidden")
    return case


def given_for(one: Hidden, arm: TwoLinkArm, given: TwoLinkArm) -> TwoLinkArm:
    """The arm as written down, where that is what is wrong: a joint taken for rigid, a number off by its factor."""
    if one.effect == "joint_elasticity" and one.joint is not None:
        return given.replace(stiffness=changed(given.stiffness, one.joint, np.inf))
    if one.effect == "parameter_error":
        name, j = number_of(one)
        return given.replace(**{name: changed(getattr(given, name), j, getattr(arm, name)[j])})
    return given


def _strayed(run: Truth, control: Control) -> float:
    """Greatest distance of a joint from its reference [rad]."""
    return float(np.abs(run.y[:, 0:2] - control.reference[: len(run.t)]).max())


def _shows(one: Hidden, arm: TwoLinkArm, given: TwoLinkArm, tolerance: float) -> bool:
    """Whether an effect is more than the tolerance of other numbers: a link's wrong one or a payload may be less."""
    if one.effect == "payload":
        return shown(true_arm(arm, one), given, ("tool", 0), tolerance)
    if one.effect != "parameter_error" or one.joint is not None:
        return True
    return shown(true_arm(arm, one), given, number_of(one), tolerance)


def _indexed(one: Hidden, given: TwoLinkArm) -> Hidden:
    """A wrong number of a known effect, by the effect's place in the model file."""
    if one.place.get("parameter") not in ("coefficient", "level"):
        return one
    rows = [(j, parameter) for _, j, parameter, _ in known_effects(given)]
    index = rows.index((one.joint or 0, one.place["parameter"]))
    return dataclasses.replace(one, side="motor", place=one.place | {"of": f"effects[{index}]"})


def truth_columns(case: Case) -> dict[str, list[float]]:
    """Peak torque and others of the fit, for the truth file."""
    return {
        "peak_torque": [float(x) for x in np.abs(case.fit.tau).max(axis=0)],
        "peak_deflection": [float(x) for x in np.abs(case.fit.y[:, 2:4] - case.fit.y[:, 0:2]).max(axis=0)],
        "at_rest": [float(x) for x in (case.fit.y[:, 4 : at.STATES - 2] == 0.0).mean(axis=0)],
    }


__all__ = ["FAMILIES", "Case", "Style", "make_case"]
