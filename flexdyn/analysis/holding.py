"""holding_torques: the motor torques under which dry friction lets an arm rest at a pose."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.analysis.analysed_model import checked_model, dry_effects
from flexdyn.analysis.pose import Pose, pose, vector
from flexdyn.analysis.statics import Statics
from flexdyn.arrays import Array
from flexdyn.effects import JointEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot.axes import joint_row

CREEP = float(np.finfo(float).tiny)
"""At this velocity every law has its level at rest [rad/s]."""


class HoldingTorques(NamedTuple):
    """The interval of commanded motor torques, reflected, at which the arm can rest [N m or N].

    Attributes:
        lower: (n,); -inf where the motor saturates before the joint breaks away.
        upper: (n,); inf likewise.

    Example:
        >>> model = fd.load_model("ur5")
        >>> held = fd.holding_torques(model, {"elbow_joint": 1.0})
        >>> held.lower.shape
        (6,)
    """

    lower: Array
    upper: Array


def holding_torques(model: FlexibleJointModel, q: Pose = None, theta: ArrayLike | None = None) -> HoldingTorques:
    """The interval of motor torques, joint by joint, under which the arm can rest at a pose.

    Let W be the torque that carries the link (gravity, parallel springs, stops) and L the levels of dry friction. Then
    the spring's torque can have any value in [W - L_link_negative, W + L_link_positive], and so::

        lower = W - L_link_negative - L_motor_negative,    upper = W + L_link_positive + L_motor_positive

    The result is the torque before the actuator effects, which are inverted. Load-dependent levels use the spring's
    torque at that end. An arm at rest stays at rest under any tau of these intervals, if its rotors are where the
    springs balance it. A sudden change of torque makes rotors without friction vibrate and may break links away
    earlier. Presliding friction is not dry and holds nothing.

    Args:
        model: the arm.
        q: pose (n,) or by joint [rad or m]; None: the model's `initial`.
        theta: rotor positions (n,), which fix the torques of the springs. None: any rotor positions at which link
            friction holds the links.

    Returns:
        lower and upper (n,).

    Raises:
        InputError: a motor too weak to hold the pose, or springs at theta whose torques link friction cannot hold.

    Example:
        >>> model = fd.load_model("ur5")
        >>> lower, upper = fd.holding_torques(model, {"elbow_joint": 1.0})
        >>> bool((lower <= upper).all())
        True
    """
    model = checked_model(model)
    return holding_at(Statics(model), pose(model, q), theta)


def holding_at(statics: Statics, q: Array, theta: ArrayLike | None = None) -> HoldingTorques:
    """`holding_torques` for a prepared model and a checked pose.

    Args:
        statics: of the prepared model.
        q: pose of the links (n,) [rad or m].
        theta: positions of the rotors (n,); default: all that link friction allows.

    Raises:
        InputError: theta at which the links do not rest, or a motor that is too weak.
    """
    model = statics.model
    if theta is None:
        ends = link_range(statics, q)
    else:
        given = vector(theta, model.n, "theta", "one rotor position a joint")
        _check_links(statics, q, given)
        ends = (given, given)
    lower, upper = np.full(model.n, np.inf), np.full(model.n, -np.inf)
    for rotors in ends:  # with load and position, either end of the spring's range may give the extreme torque
        negative, positive = levels(statics, q, rotors, "motor")
        slack = 10.0 * statics.tolerance(q, negative, positive)  # a saturated motor gives at most its bound
        lower = np.minimum(lower, statics.motor_torques(q, rotors, -negative - slack))
        upper = np.maximum(upper, statics.motor_torques(q, rotors, positive + slack))
    if np.isposinf(lower).any() or np.isneginf(upper).any():
        joint = model.joint_names[int(np.argmax(np.isposinf(lower) | np.isneginf(upper)))]
        raise InputError(f"the motor of {joint} is too weak to hold the pose", key="q", value=q)
    return HoldingTorques(lower, upper)


def link_range(statics: Statics, q: Array) -> tuple[Array, Array]:
    """Rotor positions (n,) between which link friction holds the links; q on rigid joints."""
    negative, positive = levels(statics, q, q, "link")
    elastic = statics.elastic
    least = statics.loaded_springs(q, np.where(elastic, -negative, 0.0))
    if not (negative[elastic].any() or positive[elastic].any()):
        return least, least
    return least, statics.loaded_springs(q, np.where(elastic, positive, 0.0))


def levels(statics: Statics, q: Array, theta: Array, side: Literal["link", "motor"]) -> tuple[Array, Array]:
    """Dry levels at rest (n,), L_negative and L_positive, of one side; a rigid joint's levels all count as motor's."""
    model = statics.model
    negative, positive = np.zeros(model.n), np.zeros(model.n)
    tau_s: Array | None = None
    for j, effect in dry_effects(model):
        if side != (effect.side if model.elastic[j] else "motor"):
            continue
        if tau_s is None:
            tau_s = spring_torques(statics, q, theta)
        x = theta[j] if effect.side == "motor" else q[j]
        positive[j] += float(effect.torque(x, CREEP, t=statics.t, tau=tau_s[j]))
        negative[j] -= float(effect.torque(x, -CREEP, t=statics.t, tau=tau_s[j]))
    return negative, positive


def spring_torques(statics: Statics, q: Array, theta: Array) -> Array:
    """Transmission torques at rest (n,) [N m or N], from the balance of the links; 0 on rigid joints.

    Args:
        statics: of the prepared model.
        q: positions of the links (n,) [rad or m].
        theta: of the rotors (n,).
    """
    model, still = statics.model, np.zeros(statics.model.n)
    tau_s = statics.net(q, theta, still)[0] + statics.links.bias(q, still)
    for effect in model.all_effects:
        if not isinstance(effect, JointEffect) or effect.side != "link" or effect.stage == "dry" or effect.is_neutral:
            continue
        if (row := joint_row(model.robot, effect.joint)) is not None:
            tau_s -= row * float(effect.torque(float(row @ q), 0.0, t=statics.t))
            continue
        j = model.index(effect.joint)
        tau_s[j] -= (1.0 if effect.stage == "link" else -1.0) * float(effect.torque(q[j], 0.0, t=statics.t))
    return np.where(model.elastic, tau_s, 0.0)


def _check_links(statics: Statics, q: Array, theta: Array) -> None:
    """Refuse rotor positions whose springs pull a link harder than its dry friction can hold."""
    model = statics.model
    negative, positive = levels(statics, q, theta, "link")
    net = statics.net(q, theta, np.zeros(model.n))[0]
    slack = 1e-9 * max(float(np.abs(statics.links.bias(q, np.zeros(model.n))).max()), float(np.abs(net).max()))
    moves = model.elastic & ((net < -negative - slack) | (net > positive + slack))
    if moves.any():
        j = int(np.argmax(moves))
        unit = model.robot.torque_unit(j)
        problem = f"the link of {model.joint_names[j]} does not rest: the springs leave {net[j]:.4g} {unit} on it"
        raise InputError(problem, key="theta", value=theta, remedy="leave theta out, or load the springs")
