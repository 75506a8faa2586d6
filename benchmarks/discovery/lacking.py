"""Everything that the model of a published robot lacks, and which of it the recordings can show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from hidden import Hidden, draw
from layout import Array
from scipy.ndimage import uniform_filter1d
from sizes import Scale
from two_link_run import PERIOD, Truth

FRICTION = (0.04, 0.25)  # of the peak torque without friction, log-uniform; viscous: at the greatest speed
ASYMMETRIC, STRIBECK, LOAD, COUPLED = 0.15, 0.3, 0.3, 0.2
"""Chances: dry friction that differs by direction, and what stands beside it."""
MATTERS = 0.01
"""Least share of the joint's torque, root mean square, from which a missing effect counts."""
SLOW = (0.03, 0.3)  # rad/s, Stribeck velocity, log-uniform
BESIDE = {"stribeck_friction", "load_dependent_friction", "joint_coupling"}
"""Effects that stand beside viscous and dry friction."""
RESTING = 1e-2  # rad/s: slower samples say nothing of friction
AVERAGED = 0.02  # s, over which torques are averaged: no recording shows what is quicker


def draw_lacking(
    rng: np.random.Generator, scales: Sequence[Scale], joints: Sequence[str], links: Sequence[str]
) -> tuple[Hidden, ...]:
    """Effects of all joints; a scale for each."""
    found: list[Hidden] = []
    for j, scale in enumerate(scales):

        def share(j: int = j) -> float:
            return float(np.exp(rng.uniform(*np.log(FRICTION))) * scales[j].peak[j])

        found.append(Hidden("viscous_friction", j, "motor", {"coefficient": share() / float(scale.speed[j])}))
        level, lean = share(), float(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 0.7))
        if rng.random() < ASYMMETRIC:
            both = {"level_positive": level * (1.0 + lean), "level_negative": level * (1.0 - lean)}
            found.append(Hidden("asymmetric_friction", j, "motor", both))
        else:
            found.append(Hidden("coulomb_friction", j, "motor", {"level": level}))
        if rng.random() < STRIBECK:
            velocity = float(np.exp(rng.uniform(*np.log(SLOW))))
            excess = {"excess": scale.torque(0.04, 0.15), "velocity": velocity, "exponent": rng.uniform(1.0, 2.0)}
            found.append(Hidden("stribeck_friction", j, "motor", excess))
        if rng.random() < LOAD:
            found.append(Hidden("load_dependent_friction", j, "motor", {"coefficient": scale.draw(0.05, 0.2)}))
        if rng.random() < COUPLED:
            found.append(draw(("joint_coupling", j, "motor"), scale, joints, links))
    return tuple(found)


def torque_of(one: Hidden, run: Truth, joints: Sequence[str]) -> Array:
    """The torque of an effect along what really happened (samples,) [N m]."""
    n, p = len(joints), one.parameters
    omega = run.y[:, _rates(n)]
    u = omega[:, one.joint or 0]
    laws: dict[str, Callable[[], Array]] = {
        "viscous_friction": lambda: p["coefficient"] * u,
        "coulomb_friction": lambda: p["level"] * np.sign(u),
        "asymmetric_friction": lambda: np.where(u > 0, p["level_positive"], p["level_negative"]) * np.sign(u),
        "stribeck_friction": lambda: p["excess"] * np.exp(-((np.abs(u) / p["velocity"]) ** p["exponent"])) * np.sign(u),
        "load_dependent_friction": lambda: p["coefficient"] * np.abs(run.tau_s[:, one.joint or 0]) * np.sign(u),
        "joint_coupling": lambda: p["coefficient"] * omega[:, list(joints).index(one.place["other"])],
    }
    return laws[one.effect]()


def judged(
    hidden: Sequence[Hidden], run: Truth, joints: Sequence[str], inertial: Callable[[int], Array]
) -> list[dict[str, Any]]:
    """Entries of the truth file.

    An effect matters where the part of its torque that the model explains without it in no way is, in root mean square,
    more than the cables' torque and more than a hundredth of the joint's: so "matters" means that these data can show
    it. In no way: by no linear combination of the columns of all inertial numbers that act on the joint and of

    - viscous friction: 1 and sgn(u);
    - Coulomb friction: 1 and u;
    - asymmetric friction: the same for its mean level; u and sgn(u) for half the difference, and both must pass;
    - Stribeck and load-dependent friction, coupling: 1, u, sgn(u) and the others of these on the joint.

    Samples at rest are left out, all torques are averaged over 20 ms. `unique` is that root mean square (the smaller
    of the two), `needed` what it must pass, `share` that of the whole torque of the effect over the joint's.

    Args:
        hidden: all effects.
        run: what really happened in the fit.
        joints: names.
        inertial: columns of a joint by its index (samples, m).
    """
    entries = []
    for one in hidden:
        j = one.joint or 0
        u = run.y[:, _rates(len(joints))][:, j]
        moving = np.abs(u) > RESTING
        own = torque_of(one, run, joints)
        beside = [
            torque_of(other, run, joints)
            for other in hidden
            if other is not one and other.joint == j and {one.effect, other.effect} <= BESIDE
        ]
        parts = _parts(one, own, u)
        unique = min(
            _unexplained(_averaged(part)[moving], _averaged(np.column_stack([*columns, *beside, inertial(j)]))[moving])
            for part, columns in parts
        )
        needed = max(_rms(run.cables[moving, j]), MATTERS * _rms(run.tau[moving, j]))
        share = _rms(own[moving]) / _rms(run.tau[moving, j])
        numbers = {"matters": bool(unique > needed), "unique": unique, "needed": needed, "share": share}
        entries.append(one.to_dict(joints) | numbers)
    return entries


def _parts(one: Hidden, own: Array, u: Array) -> list[tuple[Array, list[Array]]]:
    """Parts of an effect's torque that must show, and the columns that each must differ from."""
    constant, way = np.ones_like(u), np.sign(u)
    if one.effect == "viscous_friction":
        return [(own, [constant, way])]
    if one.effect == "coulomb_friction":
        return [(own, [constant, u])]
    if one.effect == "asymmetric_friction":
        middle = 0.5 * (one.parameters["level_positive"] + one.parameters["level_negative"])
        return [(middle * way, [constant, u]), (own - middle * way, [u, way])]
    return [(own, [constant, u, way])]


def _unexplained(torque: Array, columns: Array) -> float:
    size = np.linalg.norm(columns, axis=0)
    columns = columns[:, size > 0.0] / size[size > 0.0]
    values = np.linalg.lstsq(columns, torque, rcond=1e-8)[0]
    return _rms(torque - columns @ values)


def _averaged(values: Array) -> Array:
    """Moving averages along the samples."""
    return np.asarray(uniform_filter1d(values, round(AVERAGED / PERIOD), axis=0))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _rates(n: int) -> slice:
    """Where the velocities of the rotors stand among the states."""
    return slice(6, 8) if n == 2 else slice(3 * n, 4 * n)


def harmless(
    hidden: Sequence[dict[str, Any]], joints: Sequence[str], wrong: Sequence[dict[str, str]]
) -> list[dict[str, Any]]:
    """Names that are true, or do no harm, though they are not asked for.

    Joints are elastic; the filter of the currents is a lag of the recorded torque; numbers of the file beyond three
    tolerances are wrong; where a difference by direction does not show, Coulomb friction is the same.
    """
    found: list[dict[str, Any]] = []
    for joint in joints:
        found.append({"effect": "joint_elasticity", "joint": joint, "side": "transmission"})
        found.append({"effect": "channel_lag", "joint": joint, "side": "sensor", "channel": f"tau.{joint}"})
        found.append({"effect": "command_delay", "joint": joint, "side": "motor"})
    found += [{"effect": "parameter_error", "joint": None, "side": None, **number} for number in wrong]
    found += [
        {"effect": "coulomb_friction", "joint": one["joint"], "side": "motor"}
        for one in hidden
        if one["effect"] == "asymmetric_friction" and not one["matters"]
    ]
    return found


def accelerations(rates: Array) -> Array:
    """Of the links along a run (samples, n) [rad/s^2]."""
    return np.asarray(np.gradient(rates, PERIOD, axis=0))
