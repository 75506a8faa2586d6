"""Hidden effects: what can be hidden where, how it enters the true plant, what the model file must then not hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import layout as at
import numpy as np
import sizes
import wide
from arm_draw import JOINTS, LINKS, TwoLinkArm
from layout import Array
from sizes import Parameters, Scale

COLUMNS: dict[str, dict[str, tuple[int, ...]]] = {
    "viscous_friction": {"coefficient": (at.VISCOUS,)},
    "coulomb_friction": {"level": (at.POSITIVE, at.NEGATIVE)},
    "asymmetric_friction": {"level_positive": (at.POSITIVE,), "level_negative": (at.NEGATIVE,)},
    "stribeck_friction": {"excess": (at.EXCESS,), "velocity": (at.VELOCITY,), "exponent": (at.EXPONENT,)},
    "quadratic_drag": {"coefficient": (at.QUADRATIC,)},
    "load_dependent_friction": {"coefficient": (at.LOAD,)},
    "position_dependent_friction": {
        "amplitude": (at.SWING,),
        "harmonic": (at.SWING_HARMONIC,),
        "phase": (at.SWING_PHASE,),
    },
    "presliding_friction": {"level": (at.LEVEL,), "stiffness": (at.BRISTLE,), "damping": (at.BRISTLE_DAMPING,)},
    "warm_up_friction": {"coefficient": (at.WARM,), "time_constant": (at.WARM_TIME,)},
    "transmission_damping": {"coefficient": (at.D,)},
    "hardening_spring": {"cubic": (at.CUBIC,)},
    "backlash": {"half_gap": (at.HALF_GAP,)},
    "spring_hysteresis": {"stiffness": (at.HYSTERESIS,), "width": (at.WIDTH,)},
    "kinematic_error": {"amplitude": (at.ERROR,), "harmonic": (at.ERROR_HARMONIC,), "phase": (at.ERROR_PHASE,)},
    "torque_offset": {"offset": (at.OFFSET,)},
    "torque_constant_error": {"gain": (at.GAIN,)},
    "torque_ripple": {"amplitude": (at.RIPPLE,), "harmonic": (at.RIPPLE_HARMONIC,), "phase": (at.RIPPLE_PHASE,)},
    "torque_speed_limit": {"stall_torque": (at.STALL,), "no_load_speed": (at.NO_LOAD,)},
    "command_delay": {"delay": (at.DELAY,)},
    "parallel_spring": {"stiffness": (at.PARALLEL,), "rest": (at.REST,)},
    "position_torque": {"cos_1": (at.COS_1,), "sin_1": (at.SIN_1,), "cos_2": (at.COS_2,), "sin_2": (at.SIN_2,)},
    "end_stop": {"lower": (at.LOWER,), "upper": (at.UPPER,), "stiffness": (at.STOP,), "damping": (at.STOP_DAMPING,)},
    "joint_coupling": {"coefficient": (at.COUPLING,)},
}
"""Where the parameters of an effect stand in the plant's table; friction counts from its side's first column."""

SUMMED = (at.VISCOUS, at.POSITIVE, at.NEGATIVE)
WITHOUT_COULOMB = ("coulomb_friction", "asymmetric_friction", "presliding_friction")
WRONG = ("stiffness", "rotor_inertia", "link_mass", "link_com", "link_inertia", "coefficient", "level")
"""Numbers that a `parameter_error` may sit on; the last two of the known motor friction."""
LAWS = sizes.FRICTION | sizes.TRANSMISSION | sizes.MOTOR | sizes.LINK | sizes.SENSOR | {"payload": sizes.payload}
"""Parameters of every law that can be hidden, drawn at the size that a case wants."""


@dataclass(frozen=True, eq=False)
class Hidden:
    """One hidden effect.

    Attributes:
        effect: name in the catalogue, or of an effect outside it.
        joint: index of the joint, None: none.
        side: "link", "motor", "transmission", "sensor" or None.
        parameters: true values.
        place: channel, of, parameter, other, frame where the effect has them.
        catalogued: False: outside the catalogue.
    """

    effect: str
    joint: int | None
    side: str | None
    parameters: Parameters
    place: dict[str, str] = field(default_factory=dict)
    catalogued: bool = True

    def to_dict(self, joints: Sequence[str] = JOINTS) -> dict[str, Any]:
        """As the truth file holds it."""
        joint = None if self.joint is None else joints[self.joint]
        entry: dict[str, Any] = dataclasses.asdict(self) | {"joint": joint}
        place: dict[str, str] = entry.pop("place")
        return entry | place


Site = tuple[str, int, str]
"""Effect, joint and side (or channel's signal, or the wrong number's name)."""


def sites() -> list[Site]:
    """Everything that can be hidden in an arm with two elastic joints, joint by joint."""
    found: list[Site] = []
    for j in (0, 1):
        found += [(name, j, side) for name in sizes.FRICTION for side in ("link", "motor")]
        found += [(name, j, "transmission") for name in sizes.TRANSMISSION]
        found += [(name, j, "motor") for name in sizes.MOTOR]
        found += [(name, j, "link") for name in sizes.LINK]
        found += [(name, j, signal) for name in sizes.SENSOR for signal in ("q", "theta")]
        found += [("parameter_error", j, number) for number in WRONG]
        found.append(("joint_elasticity", j, "transmission"))
    return [*found, ("payload", 1, "link")]


def prepared(arm: TwoLinkArm, site: Site, size: float) -> TwoLinkArm:
    """The arm in which this can be hidden: without known friction that the effect would merely change.

    A spring that nobody knows of winds by as much less as the effect is to be smaller.
    """
    name, j, side = site
    if name == "joint_elasticity":
        return arm.replace(stiffness=changed(arm.stiffness, j, arm.stiffness[j] / size))
    if name == "viscous_friction" and side == "motor":
        return arm.replace(viscous=changed(arm.viscous, j, 0.0))
    if name in WITHOUT_COULOMB and side == "motor":
        return arm.replace(coulomb=changed(arm.coulomb, j, 0.0))
    if name == "transmission_damping":
        return arm.replace(damping=changed(arm.damping, j, 0.0))
    return arm


def draw(site: Site, scale: Scale, joints: Sequence[str] = JOINTS, links: Sequence[str] = LINKS) -> Hidden:
    """A hidden effect of the size that the case wants."""
    name, j, side = site
    if name == "parameter_error":
        of = links[j] if side.startswith("link_") else joints[j]
        factor = (wide if scale.wide else sizes).wrong_factor(scale)
        place = {"of": f"{side}_of_{of}" if side in ("coefficient", "level") else of, "parameter": side}
        return Hidden(name, None if side.startswith("link_") else j, None, {"factor": factor}, place)
    if name == "joint_elasticity":
        return Hidden(name, j, side, {"stiffness": scale.K})
    law = (LAWS | wide.LAWS if scale.wide else LAWS)[name]
    if name == "payload":
        return Hidden(name, None, None, law(scale), {"frame": "tool"})
    if name in sizes.SENSOR:
        disc = name == "encoder_eccentricity" and side == "theta"
        parameters = (sizes.MOTOR_DISC if disc else law)(scale)
        return Hidden(name, j, "sensor", parameters, {"channel": f"{side}.{joints[j]}"})
    place = {"other": joints[scale.other]} if name == "joint_coupling" else {}
    return Hidden(name, j, side, {key: float(value) for key, value in law(scale).items()}, place)


def number_of(wrong: Hidden) -> tuple[str, int]:
    """Which number of the arm is wrong."""
    number = wrong.place["parameter"]
    names = {"link_mass": "mass", "link_com": "com", "link_inertia": "inertia"}
    names |= {"coefficient": "viscous", "level": "coulomb"}
    j = wrong.joint if wrong.joint is not None else LINKS.index(wrong.place["of"])
    return names.get(number, number), j


def true_arm(arm: TwoLinkArm, hidden: Hidden) -> TwoLinkArm:
    """The arm whose numbers the effect changes: wrong numbers, payload."""
    if hidden.effect == "payload":
        return arm.replace(tool=arm.tool + hidden.parameters["mass"])
    if hidden.effect != "parameter_error":
        return arm
    name, j = number_of(hidden)
    old = getattr(arm, name)
    return arm.replace(**{name: changed(old, j, old[j] * hidden.parameters["factor"])})


def enter(P: Array, hidden: Hidden) -> None:
    """Write an effect with a law into the plant's table, in place."""
    if hidden.joint is None or hidden.effect not in COLUMNS:
        return
    friction = hidden.effect in sizes.FRICTION or hidden.effect == "load_dependent_friction"
    base = at.MOTOR if friction and hidden.side == "motor" else at.LINK
    for name, value in hidden.parameters.items():
        for column in COLUMNS[hidden.effect][name]:
            summed = friction and column in SUMMED
            P[hidden.joint, base + column] = value + (P[hidden.joint, base + column] if summed else 0.0)


def changed(pair: tuple[float, float], j: int, value: float) -> tuple[float, float]:
    """The pair with another value for one joint."""
    values = np.array(pair)
    values[j] = value
    return float(values[0]), float(values[1])
