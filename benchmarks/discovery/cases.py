"""Families of cases, and one case from its family, its seed and its number.

Seeds below 10000 are for development; from 10000 on they are for evaluation and are never looked at while building.
"""

from __future__ import annotations

import dataclasses

import layout as at
import numpy as np
from arm_draw import JOINTS, TwoLinkArm, draw_arm, inertia_at, pair
from control import draw_bandwidth, make_control
from hidden import Hidden, Site, changed, draw, number_of, prepared, sites, true_arm
from layout import Array
from model_text import ERROR, MASS_ERROR, known_effects, mistaken
from motions import Style, draw_style
from outside import OUTSIDE, draw_outside
from plants import Case, true_plant
from recording import TORQUE_NOISE, Sensors, record
from shown import shown
from sizes import FRICTION as LAWS
from sizes import Scale
from two_link_run import Control, Truth, controlled
from visible import visible

FAMILIES = ("single", "hard", "pair", "motor_only", "link_only", "rigid", "none", "outside")
FIT, CHECK = 40.0, 12.0  # s
EVALUATION = 10_000
ATTEMPTS = 60
QUICK = 2e-4  # s, step of the run that only sizes the effects
FRICTION = {"viscous": (0.03, 0.08), "coulomb": (0.03, 0.06)}
"""Friction that the model file knows: shares of the peak torque (at the greatest speed)."""


def sensors_of(family: str) -> Sensors:
    """What a family measures."""
    places = {"motor_only": "motor", "link_only": "link"}
    return Sensors(noise=10.0 if family == "hard" else 1.0, positions=places.get(family, "both"))


def possible(family: str) -> list[Site]:
    """What can be hidden in a family; no arm shows much of its first link's own inertia: its mass takes the place."""
    missing = {"motor_only": "q", "link_only": "theta"}.get(family)
    spring = "joint_elasticity"
    unseen = ("parameter_error", 0, "link_inertia")
    known = [("parameter_error", 0, "link_mass") if site == unseen else site for site in sites()]
    found = [site for site in known if missing is None or site[2] != missing]
    if family == "rigid":
        wound = {"transmission", "load_dependent_friction", "theta", "stiffness"}
        twice = [(name, j, "link") for name in LAWS for j in (0, 1)]  # the motor's side is the same there
        return [s for s in found if s[0] == spring or not ({s[0], s[2]} & wound or s in twice)]
    return found


def chosen(family: str, seed: int, number: int) -> list[Site]:
    """Sites of a case: number by number through a permutation of all, so that a batch holds all about equally often."""
    order = np.random.default_rng([seed, 1, FAMILIES.index(family)])
    known = possible(family)
    rounds, place = divmod(number, len(known))
    for _ in range(rounds + 1):
        permutation = order.permutation(len(known))
    first = known[permutation[place]]
    if family != "pair":
        return [first]
    rng = np.random.default_rng([seed, 2, number])
    others = [site for site in known if _together(first, site)]
    return [first, others[rng.integers(len(others))]]


def _together(one: Site, two: Site) -> bool:
    """Whether two effects can be told from one another and from one effect alone."""
    if one[0] == two[0] and one[1] == two[1]:
        return False
    same_place = one[1:] == two[1:]
    if same_place and one[2] in ("q", "theta"):
        return False
    elasticity = "joint_elasticity" in (one[0], two[0]) and one[1] == two[1]
    removed = any(a[0] == "parameter_error" and _removes(b, a) for a, b in ((one, two), (two, one)))
    contains = {"coulomb_friction", "asymmetric_friction", "presliding_friction"}
    nested = same_place and (
        {one[0], two[0]} <= contains or {one[0], two[0]} <= {"viscous_friction", "warm_up_friction"}
    )
    # An asymmetry is an offset beside symmetric friction; cables imitate a spring over a short range.
    alike = ({"asymmetric_friction", "torque_offset"}, {"parallel_spring", "position_torque"})
    imitates = same_place and {one[0], two[0]} in alike
    return not (elasticity or removed or nested or imitates)


def _removes(site: Site, wrong: Site) -> bool:
    """Whether hiding the first takes the number out of the model file that the second says is wrong."""
    if site[1] != wrong[1] or site[2] != "motor":
        return False
    coulomb = ("coulomb_friction", "asymmetric_friction", "presliding_friction")
    return (wrong[2] == "level" and site[0] in coulomb) or (wrong[2] == "coefficient" and site[0] == "viscous_friction")


def make_case(
    family: str, seed: int, number: int, fit: float = FIT, check: float = CHECK, sensors: Sensors | None = None
) -> Case:
    """Everything about one case.

    Raises:
        ArithmeticError: no stable arm in which the effect shows was found in so many draws.
    """
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, 3, FAMILIES.index(family), number, attempt])
        try:
            return _attempt(family, seed, number, rng, (fit, check), sensors or sensors_of(family))
        except ArithmeticError:
            continue
    raise ArithmeticError(f"{family} {seed} {number}: nothing in {ATTEMPTS} draws")


def _attempt(
    family: str, seed: int, number: int, rng: np.random.Generator, durations: tuple[float, float], sensors: Sensors
) -> Case:
    arm, styles, bandwidth = draw_arm(rng), (draw_style(rng), draw_style(rng)), draw_bandwidth(rng)
    places = [] if family in ("none", "outside") else chosen(family, seed, number)
    if sensors.positions != "both" and any(name == "sensor_offset" and j == 0 for name, j, _ in places):
        arm = arm.replace(vertical=True)  # lying down the first joint has no zero that anything but its encoder knows
    if family == "rigid":
        arm = arm.replace(stiffness=(np.inf, np.inf))
    resolution = np.array([sensors.motor_step(N) for N in arm.gear_ratio])
    resolution = np.where(np.isinf(arm.stiffness), sensors.link_step(), resolution)
    controls = [make_control(rng, arm, styles, duration, bandwidth, resolution) for duration in durations]
    base = controlled(arm.plant(), controls[0], step=QUICK)
    arm = with_friction(rng, arm, base)
    hidden: tuple[Hidden, ...]
    if family == "outside":
        names = list(OUTSIDE)
        scale = scale_of(rng, arm, base, controls[0], int(rng.integers(2)), 1.0)
        hidden = (draw_outside(names[(number + seed) % len(names)], scale),)
    else:
        factor = 0.3 if family == "hard" else 1.0
        for site in places:
            arm = prepared(arm, site, factor)
        if family == "rigid" and places[0][0] == "joint_elasticity":
            arm = _one_spring(rng, arm, places[0][1], base)
        hidden = tuple(draw(site, scale_of(rng, arm, base, controls[0], site[1], factor)) for site in places)
    return _finish(f"{family}_{seed}_{number:03d}", arm, hidden, (controls[0], controls[1]), sensors, rng)


def _one_spring(rng: np.random.Generator, arm: TwoLinkArm, j: int, base: Truth) -> TwoLinkArm:
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
) -> Case:
    hard = sensors.noise > 1.0
    given = mistaken(arm, rng, ERROR, MASS_ERROR, at_edge=hard)
    for one in hidden:
        given = given_for(one, arm, given)
    if not all(_shows(one, arm, given) for one in hidden):
        raise ArithmeticError(f"{name}: other numbers make up for the one that is wrong")
    plant = true_plant(arm, hidden)
    noise: list[Array | None] = [None, None]
    if sensors.actuator_noise:
        peak = np.abs(controls[0].feedforward).max(axis=0)
        noise = [TORQUE_NOISE * sensors.noise * peak * rng.normal(size=c.reference.shape) for c in controls]
    runs = [controlled(plant, c, noise=extra) for c, extra in zip(controls, noise, strict=True)]
    recordings = [record(run, JOINTS, arm.gear_ratio, hidden, sensors, rng) for run in runs]
    hidden = tuple(_indexed(one, given) for one in hidden)
    names = dict(zip(("fit", "check"), recordings, strict=True))
    case = Case(name, hidden, arm, given, plant, runs[0], runs[1], names, sensors, controls)
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


def _shows(one: Hidden, arm: TwoLinkArm, given: TwoLinkArm) -> bool:
    """Whether an effect is more than the tolerance of other numbers: a link's wrong one or a payload may be less."""
    if one.effect == "payload":
        return shown(true_arm(arm, one), given, ("tool", 0))
    if one.effect != "parameter_error" or one.joint is not None:
        return True
    return shown(true_arm(arm, one), given, number_of(one))


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


__all__ = ["EVALUATION", "FAMILIES", "Case", "Style", "make_case"]
