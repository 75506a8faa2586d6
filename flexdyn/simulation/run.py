"""Run: the result of a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects.channels import by_channel, measure
from flexdyn.errors import visible
from flexdyn.io.locked import Locked
from flexdyn.io.notebook import Public, card, html_table
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording, write_recording
from flexdyn.records.units import signal_unit
from flexdyn.robot import frame_positions
from flexdyn.simulation.electrical import Electrical, asked_voltage, electrical
from flexdyn.simulation.energy import Energy, ledger
from flexdyn.simulation.inputs_and_signals import SIGNALS, Inputs
from flexdyn.simulation.limits import Exceeded, exceeded
from flexdyn.simulation.solvers import Solver

if TYPE_CHECKING:
    from flexdyn.plots.picture import Picture
    from flexdyn.viewer.page import Inline


@dataclass(frozen=True, eq=False, kw_only=True)
class Run(Locked, Public):
    """A simulated motion: locked arrays over a grid of times, one column a joint in the order of q.

    Attributes:
        t: times (samples,) [s].
        q: link positions (samples, n) [rad or m].
        theta: rotor positions, reflected (samples, n); q where the joint is rigid.
        v: link velocities (samples, n) [rad/s or m/s].
        omega: rotor velocities, reflected (samples, n).
        tau: commanded torques (samples, n) [N m or N], right-continuous where the command jumps.
        tau_applied: torques after the actuator effects (samples, n).
        tau_s: torques in the transmission (samples, n); in a rigid joint tau_applied - f_motor - J a.
        model: that was simulated.
        solver: with its settings; for ``auto`` the solver that was chosen.
        notes: choices and assumptions that the user did not make, one sentence each.
        stats: steps, rejected steps, evaluations of the equations of motion, events.
        z: internal states of presliding and hysteresis (samples, number of states).
        inputs: inputs of the run.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> run.q.shape, run.joint_names
        ((501, 2), ('shoulder', 'elbow'))
    """

    t: Array
    q: Array
    theta: Array
    v: Array
    omega: Array
    tau: Array
    tau_applied: Array
    tau_s: Array
    model: FlexibleJointModel
    solver: Solver
    notes: tuple[str, ...] = ()
    stats: Mapping[str, int] = field(default_factory=dict)
    z: Array
    inputs: Inputs

    def __repr__(self) -> str:
        """A summary in one line."""
        steps = f"{type(self.solver).__name__}, {self.stats.get('steps', 0)} steps"
        return visible(f"<Run {self.model.name}: {self.t[-1]:g} s, {len(self.t)} samples, {steps}>")

    def _repr_html_(self) -> str:
        """HTML for notebooks: solver, first and last positions, and the range of each signal."""
        signals = (self.v, self.deflection, self.tau, self.tau_s)
        rows = (
            (name, float(self.q[0, j]), float(self.q[-1, j]), *(float(np.abs(each[:, j]).max()) for each in signals))
            for j, name in enumerate(self.joint_names)
        )
        steps = f"{self.stats.get('steps', 0)} steps, {self.stats.get('events', 0)} events"
        solver = f"{type(self.solver).__name__}, {steps}"
        facts = {"time": f"{self.t[-1]:g} s, {len(self.t)} samples", "solver": solver}
        heads = ("joint", "first q", "last q", "largest v", "deflection", "tau", "tau_s")
        return card(f"Run of {self.model.name}", facts, html_table(heads, rows), notes=self.notes)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints in the order of the columns."""
        return self.model.joint_names

    @property
    def exceeded(self) -> tuple[Exceeded, ...]:
        """Limits of the URDF that it exceeds at its samples: which joint, when, by how much."""
        return exceeded(self.model.robot, self.t, self.q, self.v, self.tau_applied)

    @property
    def deflection(self) -> Array:
        """The deflection theta - q (samples, n) [rad or m]."""
        return self.theta - self.q

    @cached_property
    def electrical(self) -> Electrical:
        """Volts, amperes, power and heat of the motors under voltage, at the samples."""
        return electrical(self.model, self.tau, self.omega, self.z)

    @cached_property
    def energy(self) -> Energy:
        """The energy ledger: kinetic, spring, gravity, supplied, dissipated by effect; it closes.

        It is computed when it is first used: the motion is integrated once more under the same commanded torques. An
        effect written in Python must give the same torque again.

        Warns:
            EnergyWarning: it does not close to the solver's tolerance.
        """
        return ledger(self)

    def frame_positions(self, frame: str | None = None) -> Array:
        """Positions of a frame (samples, 3) [m], in the axes of the base.

        Args:
            frame: its name; default: the last frame of the chain.
        """
        return frame_positions(self.model.robot, self.q, frame)

    def to_recording(self) -> Recording:
        """The run as a recording: every signal of every joint, as the model's sensors report it.

        The run's own arrays do not change. The meta data hold solver and notes, and the model as the text of its file.
        The model is left out if the robot came from a pin.Model and has no URDF that a file could name.
        """
        from flexdyn.io.yaml import dump_yaml
        from flexdyn.model.model_file import model_to_dict

        channels, units = {}, {}
        sensors = by_channel(self.model.resolved().effects)
        for signal in SIGNALS:
            for j, joint in enumerate(self.joint_names):
                channel = f"{signal}.{joint}"
                channels[channel] = measure(sensors.get(channel, ()), getattr(self, signal)[:, j], self.t)
                if self.model.robot.kinds[j] == "prismatic":
                    units[channel] = signal_unit(signal, prismatic=True)
        volts = asked_voltage(self.model, self.tau)
        driven = [j for j, joint in enumerate(self.model.joints.values()) if joint.actuator is not None]
        channels |= {f"voltage.{self.joint_names[j]}": volts[:, j] for j in driven}
        seen = [f"{e.name} acts on the channel {e.channel}" for each in sensors.values() for e in each]
        meta: dict[str, Any] = {"solver": self.solver.to_dict(), "notes": [*self.notes, *seen]}
        if self.model.robot.source is not None:
            meta["model"] = dump_yaml(model_to_dict(self.model))
        if units:
            meta["units"] = units
        return Recording(self.t, channels, meta=meta, name=self.model.name)

    def to_xarray(self, *, energy: bool = False) -> Any:
        """The run as an xarray dataset: q, v, theta, ... over ``(t, joint)`` with units, as `to_recording` gives them.

        Args:
            energy: add the energy ledger: kinetic, spring, gravity, external, supplied and dissipated [J].

        Returns:
            An xarray.Dataset; ``Recording.from_xarray`` takes it back.

        Raises:
            MissingExtra: xarray is not installed.
        """
        dataset = self.to_recording().to_xarray()
        return self.energy.added_to(dataset) if energy else dataset

    def save(self, path: str | Path) -> None:
        """Write it as a recording; the suffix gives the format: .npz, .h5, .parquet, .mat; .csv drops model and solver.

        Raises:
            InputError: an unknown suffix, or a folder that does not exist.
        """
        write_recording(self.to_recording(), path)

    def plot(self, path: str | Path | None = None, **choice: Any) -> Picture:
        """Draw it: positions, deflection and torques of each joint, the energy ledger below.

        Args:
            path: of a file to write, if given: .png, .pdf, .svg, or .html, which is interactive.
            choice: ``views``, ``joints``, ``start``, ``end``, as `fd.plot` takes them.

        Returns:
            The picture: ``show()`` opens it in the browser, ``save(path)`` writes it.
        """
        from flexdyn.plots import plot

        return plot(self, path=path, **choice)

    def show(self, compare: Any = None, **choice: Any) -> Inline:
        """Play it within a notebook, as the last expression of a cell; `fd.play` opens the browser instead.

        Args:
            compare: motion of a translucent second arm, as for `fd.play`, such as ``"rigid"``.
            choice: ``command`` of the rigid arm; ``height`` of the frame [px], 560 if left out.

        Returns:
            An object that a notebook shows.
        """
        from flexdyn.viewer.playback import inline

        return inline(self, compare, **choice)
