"""linearize: the equations of motion near a point as x' = A x + B u, y = C x + D u."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.analysis.jacobian import actuator_gains, resting, sliding_rate, state_matrix, without_resting_friction
from flexdyn.analysis.pose import Pose, checked_frequencies, checked_model
from flexdyn.analysis.statics import Statics
from flexdyn.errors import InputError
from flexdyn.model import FlexibleJointModel
from flexdyn.plant import build_plant

Array = NDArray[np.float64]
SIGNALS = ("q", "theta", "v", "omega", "deflection")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LinearModel:
    """An arm near x0, tau0: (x - x0)' = rate0 + A (x - x0) + B (tau - tau0), y - y0 = C (x - x0) + D (tau - tau0).

    ``control.ss(lin.A, lin.B, lin.C, lin.D)`` takes it as it is, and so does scipy.signal by `to_scipy`.

    Attributes:
        A: (nx, nx), order of x: q, theta of elastic joints, v, omega of elastic joints, internal states of effects.
        B: (nx, inputs), of the torques asked for, reflected [N m or N].
        C: (outputs, nx).
        D: (outputs, inputs): zero.
        x0: state (nx,).
        tau0: torques asked for (n,), of every joint whether it is an input or not.
        rate0: x' at x0 under tau0 (nx,): zero at an equilibrium.
        state_names: ``q.JOINT`` and so on.
        input_names: ``tau.JOINT``.
        output_names: ``q.JOINT`` and so on.
        held: channels left out of x because dry friction holds them.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    x0: Array
    tau0: Array
    rate0: Array
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    held: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Lock every array."""
        for name in ("A", "B", "C", "D", "x0", "tau0", "rate0"):
            getattr(self, name).setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, so that arrays are locked again."""
        return (_rebuild, ({field.name: getattr(self, field.name) for field in fields(self)},))

    def __repr__(self) -> str:
        """Sizes and names, in a line."""
        held = f", held: {', '.join(self.held)}" if self.held else ""
        outputs = ", ".join(self.output_names)
        return f"<LinearModel {len(self.A)} states, {', '.join(self.input_names)} -> {outputs}{held}>"

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A (nx,) [rad/s], by size."""
        values = np.linalg.eigvals(self.A).astype(complex)
        return values[np.lexsort((values.imag, np.abs(values)))]

    def to_scipy(self) -> Any:
        """As a scipy.signal.StateSpace."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.D)

    def frequency_response(self, frequencies: ArrayLike) -> NDArray[np.complex128]:
        """G(i 2 pi f) = C (i 2 pi f - A)^-1 B + D.

        Args:
            frequencies: f (f,) [Hz].

        Returns:
            (f, outputs, inputs) [rad/(N m)] and the like.

        Raises:
            InputError: a frequency at which an undamped arm's response is without bound (0 Hz, if nothing holds it).
        """
        hertz = checked_frequencies(frequencies)
        response = np.empty((len(hertz), len(self.C), self.B.shape[1]), dtype=complex)
        for k, f in enumerate(hertz):
            try:
                states = np.linalg.solve(2j * np.pi * f * np.eye(len(self.A)) - self.A, self.B)
            except np.linalg.LinAlgError:
                problem, remedy = "the response is without bound", "take a frequency beside it"
                raise InputError(problem, key="frequencies", value=float(f), remedy=remedy) from None
            response[k] = self.C @ states + self.D
        return response


def linearize(
    model: FlexibleJointModel,
    x: Pose = None,
    tau: ArrayLike | Mapping[str, float] | None = None,
    *,
    outputs: Sequence[str] = ("q", "theta"),
    inputs: Sequence[str] | None = None,
    stuck: Literal["free", "held"] = "free",
    t: float = 0.0,
) -> LinearModel:
    """The equations of motion near a point as a linear state-space model.

    A is exact: Pinocchio's derivatives of the links, gravity included, and the slopes of every effect. Laws with a
    corner (backlash, end stop, torque limit) are on the branch of the point.

    Args:
        model: the arm.
        x: a state (nx,); or a pose (n,) or by joint, at rest with its springs loaded; None: the model's `initial` pose.
        tau: torques asked for (n,) or by joint; None: what holds the arm at rest at the positions of x.
        outputs: signals (q, theta, v, omega, deflection) of every joint, or channels like ``q.elbow``.
        inputs: joints whose motor torques are inputs; None: every joint.
        stuck: dry friction of contacts that rest at x: ``free`` leaves it out, ``held`` takes their coordinates out of
            the state. What slides at x has the slope of its branch either way.
        t: time since the start of the run [s], for effects that depend on it.

    Returns:
        the linear model.

    Raises:
        InputError: arguments that do not fit the model, motors too weak for the pose, or with ``held`` a contact that
            its dry friction does not hold.
    """
    checked_model(model)
    if stuck not in ("free", "held"):
        raise InputError("no such choice", key="stuck", value=stuck, remedy="it is free or held")
    x0, tau0 = _point(model, x, tau, t)
    joints = [model.index(joint) for joint in (model.joint_names if inputs is None else inputs)]
    names, C = _outputs(model, len(x0), outputs)
    statics = Statics(without_resting_friction(model, x0), t)
    gains = actuator_gains(statics, x0, tau0)
    rate = sliding_rate(statics, x0, tau0)
    held = sorted(resting(model, x0)) if stuck == "held" else []
    plant = build_plant(model) if held else statics.plant
    A = state_matrix(plant, t, x0, tau0)
    B = _input_matrix(statics, x0, gains, held)
    rate = _held_rate(statics, x0, rate, held)
    _check_held(model, A, held)
    states = _state_names(model, len(x0))
    half = model.n + int(model.elastic.sum())
    out = {place for place in held} | {half + place for place in held}
    kept = [i for i in range(len(x0)) if i not in out]
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
        held=tuple(states[place] for place in held),
    )


def frequency_response(
    model: FlexibleJointModel,
    frequencies: ArrayLike,
    *,
    x: Pose = None,
    tau: ArrayLike | Mapping[str, float] | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] = ("q", "theta"),
    stuck: Literal["free", "held"] = "free",
) -> NDArray[np.complex128]:
    """Small sinusoidal motion per sinusoidal motor torque, amplitude and phase: `linearize` at each frequency.

    Args:
        model: the arm.
        frequencies: (f,) [Hz].
        x: where, as in `linearize`.
        tau: under which constant torque, as in `linearize`.
        inputs: joints whose motors move; None: every joint.
        outputs: signals or channels, as in `linearize`.
        stuck: ``free`` or ``held``, as in `linearize`.

    Returns:
        complex (f, outputs, inputs) [rad/(N m)] and the like.

    Raises:
        InputError: arguments that do not fit the model.
    """
    linear = linearize(model, x, tau, inputs=inputs, outputs=outputs, stuck=stuck)
    return linear.frequency_response(frequencies)
