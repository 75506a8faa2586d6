"""equilibrium: where an arm rests under gravity and motor torques."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.analysis.analysed_model import checked_model
from flexdyn.analysis.eigenmodes import Tangent
from flexdyn.analysis.holding import HoldingTorques, holding_at, link_range
from flexdyn.analysis.jacobian import without_resting_friction
from flexdyn.analysis.pose import ByJoint, Pose, pose, torques
from flexdyn.analysis.roots import Search
from flexdyn.analysis.statics import Statics
from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.io.locked import Locked
from flexdyn.model.flexible_joint_model import FlexibleJointModel


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Equilibrium(Locked):
    """An arm at rest.

    Attributes:
        joint_names: in the order of q.
        q: link positions (n,) [rad or m].
        theta: rotor positions, reflected (n,); q where the joint is rigid.
        x: the state (nx,): q, theta of elastic joints, zero velocities and internal states.
        tau: commanded torques of the motors (n,) [N m or N].
        residual: largest unbalanced net torque [N m or N], a rounding error.
        stability: ``stable``; ``neutral``: it can move without a restoring torque; ``unstable``: any disturbance makes
            it fall; ``held``: there is an equilibrium only with dry friction.
        friction_link: net torque that dry friction balances on every link (n,); 0 unless ``held``.
        friction_motor: the same on every rotor (n,); for rigid joints the whole friction torque.
        holding: interval of motor torques under which dry friction lets the arm rest at this q.

    Example:
        >>> model = fd.load_model("ur5")
        >>> lower, upper = fd.holding_torques(model)
        >>> rest = fd.equilibrium(model, (lower + upper) / 2)
        >>> rest.theta.shape
        (6,)
    """

    joint_names: tuple[str, ...]
    q: Array
    theta: Array
    x: Array
    tau: Array
    residual: float
    stability: str
    friction_link: Array
    friction_motor: Array
    holding: HoldingTorques

    def __repr__(self) -> str:
        """The position, in one line."""
        at = ", ".join(f"{joint} {value:.6g}" for joint, value in zip(self.joint_names, self.q, strict=True))
        return f"<Equilibrium {at}; {self.stability}>"

    @property
    def stable(self) -> bool:
        """Whether the arm returns, or stays, after a small disturbance."""
        return self.stability in ("stable", "held")


def equilibrium(model: FlexibleJointModel, tau: ByJoint | None = None, *, q_guess: Pose = None) -> Equilibrium:
    """Find the positions at which an arm rests under gravity and constant motor torques, with every spring and stop.

    First, dry friction is left out: the result is an equilibrium without it. If there is none, the result is the pose
    nearest to the guess at which friction holds the arm (``stability`` is ``held``). Of several equilibria it is the
    one that Newton's method reaches from the guess; if Newton's method reaches none, one with a lower potential energy.
    Internal states (presliding, hysteresis) are 0.

    Args:
        model: the arm.
        tau: commanded torques of the motors (n,) or by joint [N m or N]; None: none.
        q_guess: start of the search (n,) or by joint; None: the model's `initial`.

    Returns:
        The equilibrium.

    Raises:
        InputError: ``no equilibrium: ...``: the search found no pose that balances the torques.

    Example:
        >>> model = fd.load_model("ur5")
        >>> lower, upper = fd.holding_torques(model, {"elbow_joint": 1.0})
        >>> rest = fd.equilibrium(model, (lower + upper) / 2, q_guess={"elbow_joint": 1.0})
        >>> rest.q.shape
        (6,)
    """
    model = checked_model(model)
    guess = pose(model, q_guess, "q_guess")
    asked = np.zeros(model.n) if tau is None else torques(model, tau)
    statics = Statics(model)

    def net(q: Array) -> Array:
        """Net torques on the links (n,), their springs wound by the motors."""
        return statics.net(q, statics.driven_springs(q, asked), asked)[0]

    size = np.abs(statics.links.bias(guess, np.zeros(model.n))) + np.abs(asked) + np.abs(net(guess))
    mass = statics.links.mass_matrix(guess)
    if not np.abs(size).max() < 1e150:  # its square must not overflow
        remedy = "give torques in N m (prismatic: N)"
        raise InputError("torques too large for a double", key="tau", value=asked, remedy=remedy)
    q, found = Search(net, mass, size).find(guess)
    if found:
        return _frictionless(statics, q, asked)
    with_friction = _held(statics, guess, asked, mass, size)
    if with_friction is None:
        left = net(q)
        j = int(np.argmax(np.abs(left) / np.sqrt(np.diag(mass))))
        unit = model.robot.torque_unit(j)
        problem = f"no equilibrium: at the nearest, {left[j]:.4g} {unit} on {model.joint_names[j]} is left unbalanced"
        raise InputError(problem, remedy="take another tau, or another q_guess")
    return with_friction


def _frictionless(statics: Statics, q: Array, tau: Array) -> Equilibrium:
    """A pose that the springs and motors hold without dry friction, and whether it is stable."""
    theta = statics.driven_springs(q, tau)
    link, rotor = statics.net(q, theta, tau)
    tangent = Tangent(_smooth(statics), q, theta, tau)
    least = tangent.squared_frequencies()[0].min()
    return Equilibrium(
        joint_names=statics.model.joint_names,
        q=q,
        theta=theta,
        x=statics.state(q, theta),
        tau=tau,
        residual=float(np.abs(np.concatenate([link, rotor])).max()),
        stability="stable" if least > 0 else "neutral" if least == 0 else "unstable",
        friction_link=np.zeros(len(q)),
        friction_motor=np.zeros(len(q)),
        holding=holding_at(statics, q),
    )


def _smooth(statics: Statics) -> Statics:
    """The model without dry friction, whose contacts would have no acceleration at rest."""
    return Statics(without_resting_friction(statics.model, np.zeros(statics.plant.state_size)), statics.t)


def _held(statics: Statics, guess: Array, tau: Array, mass: Array, size: Array) -> Equilibrium | None:
    """The pose nearest to the guess at which dry friction holds the arm, if there is one."""
    model = statics.model
    if not any(effect.stage == "dry" and not effect.is_neutral for effect in model.all_effects):
        return None
    try:
        q, found = Search(lambda q: _beyond(holding_at(statics, q), tau), mass, size).newton(guess)
        holding = holding_at(statics, q)
    except InputError:  # a motor is too weak to hold an intermediate pose
        return None
    if not found:
        return None
    least, most = link_range(statics, q)
    theta = np.clip(statics.driven_springs(q, tau), least, most)
    link, rotor = statics.net(q, theta, tau)
    return Equilibrium(
        joint_names=model.joint_names,
        q=q,
        theta=theta,
        x=statics.state(q, theta),
        tau=tau,
        residual=float(np.abs(_beyond(holding, tau)).max()),
        stability="held",
        friction_link=np.where(model.elastic, link, 0.0),
        friction_motor=rotor,
        holding=holding,
    )


def _beyond(holding: HoldingTorques, tau: Array) -> Array:
    """The part of the torques that exceeds what friction holds (n,) [N m or N]."""
    return tau - np.clip(tau, holding.lower, holding.upper)
