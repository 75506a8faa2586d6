"""LinearModel: the result of `linearize`, for scipy.signal and python-control; its states and outputs by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.analysis.pose import checked_frequencies
from flexdyn.arrays import Array
from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.io.locked import Locked
from flexdyn.model.flexible_joint_model import FlexibleJointModel

SIGNALS = ("q", "theta", "v", "omega", "deflection")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LinearModel(Locked):
    """An arm near x0, tau0: (x - x0)' = rate0 + A (x - x0) + B (tau - tau0), y - y0 = C (x - x0) + D (tau - tau0).

    Use it as ``control.ss(lin.A, lin.B, lin.C, lin.D)`` in python-control, or by `to_scipy` in scipy.signal.

    Attributes:
        A: (nx, nx), order of x: q, theta of elastic joints, v, omega of elastic joints, internal states of effects.
        B: (nx, inputs), of the commanded torques, reflected [N m or N].
        C: (outputs, nx).
        D: (outputs, inputs): zero.
        x0: state (nx,).
        tau0: commanded torques (n,) of all joints, inputs or not.
        rate0: x' at x0 under tau0 (nx,): zero at an equilibrium.
        state_names: ``q.JOINT`` and so on.
        input_names: ``tau.JOINT``.
        output_names: ``q.JOINT`` and so on.
        delays: dead time of every input (inputs,) [s], from command_delay; it is not part of A and B.
        held: channels that are left out of x because dry friction holds them.

    Example:
        >>> model = fd.load_model("ur5")
        >>> lin = fd.linearize(model)
        >>> lin.A.shape, lin.to_scipy().A.shape
        ((24, 24), (24, 24))
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
    delays: Array
    held: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Sizes and held channels, in one line."""
        held = f", held: {', '.join(self.held)}" if self.held else ""
        sizes = f"{len(self.A)} states, {len(self.input_names)} inputs, {len(self.output_names)} outputs"
        return f"<LinearModel {sizes}{held}>"

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A (nx,) [rad/s], by absolute value."""
        values = np.linalg.eigvals(self.A).astype(complex)
        return values[np.lexsort((values.imag, np.abs(values)))]

    def to_scipy(self) -> Any:
        """As a scipy.signal.StateSpace."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.D)

    def frequency_response(self, frequencies: ArrayLike) -> NDArray[np.complex128]:
        """G(s) = (C (s - A)^-1 B + D) exp(-s delays), s = 2 pi i f.

        Args:
            frequencies: f (f,) [Hz].

        Returns:
            (f, outputs, inputs) [rad/(N m)] and the like.

        Raises:
            InputError: a frequency at which the response of an undamped arm is infinite (0 Hz, if nothing holds it).
        """
        hertz = checked_frequencies(frequencies)
        response = np.empty((len(hertz), len(self.C), self.B.shape[1]), dtype=complex)
        for k, f in enumerate(hertz):
            try:
                states = np.linalg.solve(2j * np.pi * f * np.eye(len(self.A)) - self.A, self.B)
            except np.linalg.LinAlgError:
                problem, remedy = "the response is infinite", "take a slightly different frequency"
                raise InputError(problem, key="frequencies", value=float(f), remedy=remedy) from None
            response[k] = (self.C @ states + self.D) * np.exp(-2j * np.pi * f * self.delays)
        return response


def state_names(model: FlexibleJointModel, size: int) -> tuple[str, ...]:
    """Channel of every entry of a state of `size` entries; internal states of effects are ``z[i]``."""
    links = model.joint_names
    rotors = [joint for joint, elastic in zip(links, model.elastic, strict=True) if elastic]
    names = [
        f"{signal}.{joint}" for signal, joints in zip(SIGNALS, (links, rotors) * 2, strict=False) for joint in joints
    ]
    return (*names, *(f"z[{i}]" for i in range(size - len(names))))


def output_matrix(model: FlexibleJointModel, size: int, outputs: Sequence[str]) -> tuple[tuple[str, ...], Array]:
    """Names of the outputs and C (outputs, nx).

    Args:
        model: whose joints they are.
        size: nx.
        outputs: signals of every joint, or single channels ``signal.joint``. A rigid joint reads theta as q.

    Raises:
        InputError: an unknown signal or joint.
    """
    if isinstance(outputs, str):
        outputs = (outputs,)
    names = []
    for output in outputs:
        signal, _, joint = str(output).partition(".")
        check_known(signal, SIGNALS, "no such signal", key="outputs", value=output)
        names += [
            f"{signal}.{each}" for each in ((model.joint_names[model.index(joint)],) if joint else model.joint_names)
        ]
    return tuple(names), np.array([_row(model, size, *name.split(".", 1)) for name in names]).reshape(len(names), size)


def _row(model: FlexibleJointModel, size: int, signal: str, joint: str) -> Array:
    j, half = model.index(joint), model.n + int(model.elastic.sum())
    rotor, unit = int(model.rotor_places[j]), np.eye(size)
    if signal == "deflection":
        return np.asarray(unit[rotor] - unit[j])
    return np.asarray(unit[{"q": j, "theta": rotor, "v": half + j, "omega": half + rotor}[signal]])
