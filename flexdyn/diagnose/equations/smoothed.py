"""The signals of one recording after the first filter, with computed positions for missing link or motor encoders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.computed_positions import computed_positions
from flexdyn.diagnose.equations.held_torque import HeldTorque, centred
from flexdyn.diagnose.equations.rest import Rests
from flexdyn.diagnose.equations.shared import SharedResults
from flexdyn.diagnose.equations.simulated_links import filled, links_behind_motors, replayed
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.link_side import LinkSide


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Signals after the first filter, at the full rate, one column for each joint.

    Attributes:
        t: times since the start of the run (samples,) [s].
        dt: between samples [s].
        q, v, a: of the links (samples, n).
        theta, omega, alpha: of the rotors (samples, n); those of the links on a rigid joint with one encoder.
        tau: commanded torque (samples, n), the mean over each instant's two halves of held samples.
        tau_s: measured in the transmission (samples, n); zero if it was not.
        data: the channels before the filter, without sensor effects.
        lost: number of samples of `data` before the first one here.
        resting: where motors rest whose links are not measured (samples, n).
        held: tau before the filter; None: it was never recorded.
        kernel: the first filter; None: these are other samples than the recorded ones.
        passes: how often it was applied.
        wound: deflections before the filters of joints whose links are simulated, else NaN (samples of the recording,
            n); None: none is simulated.
    """

    t: Array
    dt: float
    q: Array
    v: Array
    a: Array
    theta: Array
    omega: Array
    alpha: Array
    tau: Array
    tau_s: Array
    data: Measured
    lost: int
    resting: Flags
    held: HeldTorque | None
    kernel: GaussianSmoother | None
    passes: int
    wound: Array | None

    def filtered(self, x: Array) -> Array:
        """A signal at the recorded samples as these signals are (samples,).

        Raises:
            ValueError: these are other samples than the recorded ones.
        """
        if self.kernel is None:
            raise ValueError("thinned signals have no filter")
        for _ in range(self.passes):
            x = self.kernel.apply(x, 0)
        spare = (len(x) - len(self.t)) // 2
        return x[spare : spare + len(self.t)]

    def recorded(self, j: int, side: str, elastic: bool) -> Array | None:
        """Position of a joint's rotor or link before the filters (samples of the recording,); None: not measured.

        Args:
            j: the joint.
            side: ``motor`` or ``link``.
            elastic: whether they differ.
        """
        signals = ["q", "theta"] if side == "link" else ["theta", "q"]
        known = [each for each in signals[: 1 if elastic else 2] if getattr(self.data, f"has_{each}")[j]]
        return np.asarray(getattr(self.data, known[0])[:, j]) if known and self.kernel is not None else None

    @property
    def delta(self) -> Array:
        """Deflection theta - q (samples, n) [rad or m]."""
        return self.theta - self.q

    @property
    def ddelta(self) -> Array:
        """Rate of the deflection (samples, n) [rad/s or m/s]."""
        return self.omega - self.v


def smoothed(
    model: FlexibleJointModel,
    links: LinkSide,
    data: Measured,
    kernel: GaussianSmoother,
    rests: Rests | None = None,
    *,
    simulated: bool = False,
    began: Array | None = None,
    shared: SharedResults | None = None,
) -> Smoothed:
    """Smooth a recording.

    Args:
        model: resolved.
        links: its link side.
        data: channels without sensor effects.
        kernel: the first filter.
        rests: where motors rest whose links are not measured; None: nowhere.
        simulated: whether all unmeasured links are simulated along the motion of their motors.
        began: how these links begin, see `links_behind_motors`.
        shared: what other models may have asked for; None: nothing.

    A joint with one encoder gets the other position from its own equation (`computed_positions`), or by simulation
    where its motion is prescribed (`replayed`). The whole motion is then filtered once more.
    """
    shared = shared or SharedResults(1)
    q = data.moved
    theta = np.where(data.has_theta, data.theta, q)
    tau = centred(data.tau)
    t, tau_s, lost, inner = data.t, data.tau_s, kernel.half, slice(kernel.half, -kernel.half)
    resting = rests.where if rests else np.zeros((len(t[inner]), model.n), dtype=bool)
    twice, wound = bool((model.elastic & ~data.both).any()), None
    held = HeldTorque(data.tau, kernel, 1 + twice)
    if twice:
        behind = links_behind_motors(model, links, q, theta, data, kernel, began) if simulated else None
        wound = None if behind is None else theta - behind
        q, theta = computed_positions(model, links, q, theta, tau, data, kernel, None if simulated else rests, shared)
        q = replayed(model, q, theta, data, t[inner]) if behind is None else filled(q, kernel.apply(behind, 0))
        tau, tau_s = (shared.filtered(kernel, each, 0) for each in (tau, tau_s))
    elif not data.both.all():  # as many samples as for an elastic joint
        q, theta, tau, tau_s = q[inner], theta[inner], tau[inner], tau_s[inner]
    if not data.both.all():
        t, resting, lost = t[inner], resting[inner], lost + kernel.half
    made: dict[str, Any] = {name: shared.filtered(kernel, q, order) for order, name in enumerate(("q", "v", "a"))}
    made |= {name: shared.filtered(kernel, theta, order) for order, name in enumerate(("theta", "omega", "alpha"))}
    made |= {name: shared.filtered(kernel, each, 0) for name, each in (("tau", tau), ("tau_s", tau_s))}
    origin: dict[str, Any] = {"data": data, "lost": lost, "kernel": kernel, "passes": 1 + twice, "wound": wound}
    return Smoothed(t=t[inner], dt=data.dt, resting=resting, held=held, **made, **origin)
