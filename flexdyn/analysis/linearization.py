"""linearize: the equations of motion near a state as x' = A x + B u, y = C x + D u; their frequency response."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.analysis.analysed_model import checked_model, command_delays
from flexdyn.analysis.jacobian import actuator_gains, resting, sliding_rate, without_resting_friction
from flexdyn.analysis.linear_model import LinearModel, output_matrix, state_names
from flexdyn.analysis.pose import ByJoint, Pose, pose, torques, vector
from flexdyn.analysis.statics import Statics
from flexdyn.arrays import Array
from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.plant import build_plant, state_matrix


def linearize(
    model: FlexibleJointModel,
    x: Pose = None,
    tau: ByJoint | None = None,
    *,
    outputs: Sequence[str] = ("q", "theta"),
    inputs: Sequence[str] | None = None,
    stuck: Literal["free", "held"] = "free",
    t: float = 0.0,
) -> LinearModel:
    """Linearise the equations of motion near a state: a linear state-space model.

    A is exact: Pinocchio's derivatives of the links, gravity included, and the slopes of every effect; with full
    `rotor_coupling` it is a difference quotient of the whole motion. Laws with a corner (backlash, end stop, torque
    limit) use the branch at the state. A command delay is not part of A and B: `frequency_response` adds it.

    Args:
        model: the arm.
        x: a state (nx,); or a pose (n,) or by joint, at rest with its springs loaded; None: the model's `initial` pose.
        tau: commanded torques (n,) or by joint; None: the torques that hold the arm at rest at the positions of x.
        outputs: signals (q, theta, v, omega, deflection) of every joint, or channels like ``q.elbow``.
        inputs: joints whose motor torques are inputs; None: every joint.
        stuck: dry friction of contacts that rest at x: ``free`` leaves it out, ``held`` removes their coordinates from
            the state. A contact that slides at x has the slope of its branch in both cases.
        t: time since the start of the run [s], for effects that depend on it.

    Returns:
        The linear model.

    Raises:
        InputError: arguments that do not fit the model, motors too weak for the pose, a contact that slips if ``held``.

    Example:
        >>> model = fd.load_model("ur5")
        >>> lower, upper = fd.holding_torques(model)
        >>> rest = fd.equilibrium(model, (lower + upper) / 2)
        >>> fd.linearize(model, rest.x, rest.tau).B.shape
        (24, 6)
    """
    model, delays = checked_model(model), command_delays(model)
    x0, tau0 = _point(model, x, tau, t)
    joints = [model.index(joint) for joint in (model.joint_names if inputs is None else inputs)]
    names, C = output_matrix(model, len(x0), outputs)
    A, B, rate, held, kept = _matrices(model, x0, tau0, stuck, t)
    states = state_names(model, len(x0))
    return LinearModel(
        A=A[np.ix_(kept, kept)],
        B=B[np.ix_(kept, joints)],
        C=C[:, kept],
        D=np.zeros((len(C), len(joints))),
        x0=x0[kept],
        tau0=tau0,
        rate0=rate[kept],
        state_names=tuple(states[i] for i in kept),
        input_names=tuple(f"tau.{model.joint_names[j]}" for j in joints),
        output_names=names,
        delays=delays[joints],
        held=tuple(states[place] for place in held),
    )


def frequency_response(
    model: FlexibleJointModel,
    frequencies: ArrayLike,
    *,
    x: Pose = None,
    tau: ByJoint | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] = ("q", "theta"),
    stuck: Literal["free", "held"] = "free",
) -> NDArray[np.complex128]:
    """The complex ratio of small sinusoidal motions to sinusoidal motor torques, from `linearize`.

    Args:
        model: the arm.
        frequencies: (f,) [Hz].
        x: state or pose, as in `linearize`.
        tau: constant torque, as in `linearize`.
        inputs: joints whose motors are inputs; None: every joint.
        outputs: signals or channels, as in `linearize`.
        stuck: ``free`` or ``held``, as in `linearize`.

    Returns:
        complex (f, outputs, inputs) [rad/(N m)] and the like.

    Raises:
        InputError: arguments that do not fit the model.

    Example:
        >>> model = fd.load_model("ur5")
        >>> found = fd.frequency_response(model, np.geomspace(1.0, 100.0, 50), inputs=["elbow_joint"])
        >>> found.shape[0]
        50
    """
    return linearize(model, x, tau, inputs=inputs, outputs=outputs, stuck=stuck).frequency_response(frequencies)


def _point(model: FlexibleJointModel, x: Pose, tau: ByJoint | None, t: float) -> tuple[Array, Array]:
    """State (nx,) and commanded torques (n,) to linearise at."""
    statics, n = Statics(model, t), model.n
    if x is None or isinstance(x, Mapping) or np.shape(x) == (n,):
        q = pose(model, x, "x")
        state = statics.state(q, statics.loaded_springs(q))
    else:
        size = statics.plant.state_size
        state = vector(x, size, "x", f"a pose has {n} numbers, a state {size}: q, theta, v, omega, internal states")
    if tau is not None:
        return state, torques(model, tau)
    return state, statics.holding(state[:n], state[model.rotor_places])


def _matrices(
    model: FlexibleJointModel, x: Array, tau: Array, stuck: str, t: float
) -> tuple[Array, Array, Array, list[int], list[int]]:
    """A (nx, nx), B (nx, n) and the rate of the state (nx,); coordinates that are held, entries of x that are not."""
    check_known(stuck, ("free", "held"), "no such choice", key="stuck", value=stuck, remedy="it is free or held")
    statics = Statics(without_resting_friction(model, x), t)
    held = sorted(resting(model, x)) if stuck == "held" else []
    A = state_matrix(build_plant(model) if held else statics.plant, t, x, tau)
    _check_held(model, A, held)
    B = _input_matrix(statics, x, actuator_gains(statics, x, tau), held)
    half = model.n + int(model.elastic.sum())
    rate = sliding_rate(statics, x, tau)
    rate[half : 2 * half] = _constrained(statics, x, rate[half : 2 * half], held)
    kept = [i for i in range(len(x)) if i not in {at for place in held for at in (place, half + place)}]
    return A, B, rate, held, kept


def _constrained(statics: Statics, x: Array, rows: Array, held: list[int]) -> Array:
    """Velocity rows (n + e, ...) of some rate when some velocities stay 0: the others are not coupled to these."""
    if held:
        free = [i for i in range(len(rows)) if i not in held]
        H = statics.inertia(x[: statics.model.n])
        rows[free] = np.linalg.solve(H[np.ix_(free, free)], (H @ rows)[free])
        rows[held] = 0.0
    return rows


def _input_matrix(statics: Statics, x: Array, gains: Array, held: list[int]) -> Array:
    """B (nx, n): a motor acts on its rotor; in a rigid joint, or with full rotor coupling, on all coordinates."""
    model, n = statics.model, statics.model.n
    half = n + int(model.elastic.sum())
    B = np.zeros((len(x), n))
    driven = np.zeros((half, n))
    driven[model.rotor_places, range(n)] = gains
    B[half : 2 * half] = np.linalg.solve(statics.inertia(x[:n]), driven)
    B[half : 2 * half] = _constrained(statics, x, B[half : 2 * half], held)
    return B


def _check_held(model: FlexibleJointModel, A: Array, held: list[int]) -> None:
    """Check that dry friction holds these contacts: the plant gives them no acceleration."""
    half = model.n + int(model.elastic.sum())
    for place in held:
        if A[half + place].any():
            name = state_names(model, len(A))[place]
            remedy = "use stuck='free', or a tau within fd.holding_torques(model, q)"
            raise InputError(f"dry friction does not hold {name} at rest", key="stuck", value="held", remedy=remedy)
