"""How large effects are: shares of what each equation is about, and what they do to the density of the rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import LEAST_DAMPING_RATIO, SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.equations.computed_positions import acting_on
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import MOTOR, TOTAL, TRANSMISSION
from flexdyn.diagnose.equations.springs import spring_torque
from flexdyn.diagnose.equations.users_laws import torque_of
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect, JointEffect, SensorEffect, registered


@dataclass(frozen=True, eq=False)
class Sizes:
    """Sizes of effects and of columns.

    Attributes:
        equations: where the effects act.
        noise: of the channels.
        mask: rows that say nothing (rows,).
    """

    equations: Equations
    noise: SampleNoise
    mask: Flags

    @lazy
    def reference(self) -> Array:
        """Root mean square of what each equation is about: torque, or deflection (equations,).

        Computed positions have the torque's noise, which only the second filter takes off their accelerations.
        """
        motions, filters = self.equations.motions, self.equations.filters
        calm = filters.rows if self.equations.computed.any() else np.asarray
        tau, needed, delta = (
            np.concatenate([calm(getattr(along, name)) for along in motions])
            for name in ("tau", "inverse_dynamics", "delta")
        )
        torque = np.sqrt(np.maximum((tau**2).mean(axis=0), (needed**2).mean(axis=0)))
        torque = np.maximum(torque, 1e-6 * max(float(torque.max()), 1e-300))
        kinds = self.equations.kinds
        return np.array([max(float(delta[:, j].std()), 1e-12) if k == TRANSMISSION else torque[j] for j, k in kinds])

    def largest(self, raw: Array) -> Array:
        """Largest share of what an equation is about that columns have, (columns, rows) -> (columns,)."""
        table = raw.reshape(len(raw), -1, len(self.equations.kinds))
        return np.asarray(
            (np.sqrt(np.einsum("kte,kte->ke", table, table) / table.shape[1]) / self.reference).max(axis=1)
        )

    def of(self, effect: Effect, change: Array, least: float = SMALLEST_TORQUE_SHARE) -> tuple[float, float]:
        """Share of its joint's torque that an effect has, and the one from which it is one [1].

        Args:
            effect: of which.
            change: of the residual by it (rows,).
            least: share of the torque below which an effect is none, whatever the encoders resolve [1].
        """
        share = max(float(self.largest(change[None])[0]), self.carried(effect))
        least = min(least, self.smallest(effect, share))
        angle = abs(float(getattr(effect, effect.position_error or "-", np.inf)))
        place = {key: str(getattr(effect, key)) for key in ("joint", "channel") if hasattr(effect, key)}
        return share, max(least, self.resolution({"effect": effect.name, **place}) / max(angle, 1e-300) * share)

    def smallest(self, effect: Effect, share: float) -> float:
        """Share of torque from which an effect is one [1].

        An encoder's offset makes little torque on an arm without gravity, and is one where it is more than a step. The
        damping of a transmission makes little torque, and yet decides how long a joint vibrates. It is one also
        where its ratio ``zeta = D/(2 sqrt(K m))`` is large enough; m is the mass of rotor and link against each other.

        Args:
            effect: of which.
            share: of its joint's torque that it makes.
        """
        if isinstance(effect, SensorEffect) and effect.position_error and effect.is_constant:
            step = self.resolution({"effect": effect.name, "channel": effect.channel})
            offset = abs(float(getattr(effect, effect.position_error)))
            return min(SMALLEST_TORQUE_SHARE, share * step / max(offset, 1e-300)) if step else SMALLEST_TORQUE_SHARE
        if not isinstance(effect, JointEffect) or not effect.damps_spring:
            return SMALLEST_TORQUE_SHARE
        damping = abs(float(getattr(effect, effect.damps_spring)))
        if damping == 0.0:  # a fit has taken it to nothing, of which no ratio says how much torque is enough
            return SMALLEST_TORQUE_SHARE
        true = self.equations.true
        j, along = true.index(effect.joint), self.equations.motions[0]
        K, J = float(true.stiffness[j]), float(true.rotor_inertia[j])
        link = float(np.mean(along.M[:, j, j]))
        least_damping = 2.0 * LEAST_DAMPING_RATIO * math.sqrt(K * J * link / max(J + link, 1e-300))
        return min(SMALLEST_TORQUE_SHARE, share * least_damping / damping)

    def carried(self, effect: Effect, scale: float = 1.0) -> float:
        """Share of its joint's torque that a law of a transmission makes there, over `scale` [1].

        Where one of the two positions is computed, the rows have only what this does to the computed one. 0 elsewhere.
        """
        true = self.equations.true
        if not isinstance(effect, JointEffect) or effect.side != "transmission":
            return 0.0
        j = true.index(effect.joint)
        if not self.equations.computed[j]:
            return 0.0
        others = [each for each in acting_on(true, j) if each != effect]
        parts = [
            spring_torque(true, [*others, effect], along, j)[:, 0] - spring_torque(true, others, along, j)[:, 0]
            for along in self.equations.motions
        ]
        row = next(k for k, (i, _) in enumerate(self.equations.kinds) if i == j)
        return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)) / (self.reference[row] * scale))

    def resolution(self, place: Mapping[str, str]) -> float:
        """Size of effects on positions [rad or m] below which they may be rounding; 0 for others.

        An offset may be a whole step of the encoder. Rounding errors repeat with the angle, and of n steps that were
        passed they are independent. The amplitude of a wave fitted to them has the standard deviation
        ``step/sqrt(6 n)``; five of these are ``2 step/sqrt(n)``.
        """
        kind = registered()[place["effect"]]
        signal, _, joint = place.get("channel", "").partition(".")
        if not kind.position_error or signal.startswith("tau"):
            return 0.0
        j = self.equations.true.index(place.get("joint") or joint)
        steps = {each: float(np.sqrt(12.0) * of[j]) for each, of in (("q", self.noise.q), ("theta", self.noise.theta))}
        own = {signal: steps[signal]} if signal in steps else steps
        if not kind.cycles:
            return max(own.values())
        passed = {each: max(self._passed(each, j, step), 1.0) for each, step in own.items()}
        return max(step * min(1.0, 2.0 / math.sqrt(passed[each])) for each, step in own.items())

    def _passed(self, signal: str, j: int, step: float) -> float:
        """Steps of an encoder between its joint's least and greatest position."""
        seen = np.concatenate([getattr(along, signal)[:, j] for along in self.equations.motions])
        return float(np.ptp(seen)) / max(step, 1e-300)

    def rows_of(self, joint: str) -> int:
        """Rows that a gain of a joint's torque scales: those for which the recorded torque makes the link's position.

        Elsewhere the column of a gain is made of the torque that the model needs, which has no noise of the record. A
        rotor's position is made of what the links need.
        """
        j = self.equations.true.index(joint)
        if not self.equations.unmeasured[j]:
            return 0
        which = self.equations.places(j, MOTOR, TOTAL)
        return int((~self.mask.reshape(-1, len(self.equations.kinds))[:, which]).sum())

    def log_jacobian(self, effect: Effect) -> float:
        """Logarithm of how the applied torque changes with the recorded one, summed over the rows.

        The rows are measured in recorded torque. Where a law cuts it off, it may be anything beyond: its density is
        then one over its range, not one over its noise.
        """
        if not isinstance(effect, JointEffect) or effect.stage != "actuator" or effect.late_by:
            return 0.0
        if effect.scales_torque:
            return self.rows_of(effect.joint) * float(np.log(max(1.0 + effect.torque_gain, 0.01)))
        j, total = self.equations.true.index(effect.joint), 0.0
        torque = float(self.reference[self.equations.places(j, MOTOR, TOTAL)[0]])
        floor, step = self.noise.tau[j] / torque, 1e-3 * torque
        for along in self.equations.motions:
            at = self.equations.filters.instants(len(along.t))
            x, u, tau, t = along.theta[at, j], along.omega[at, j], along.tau[at, j], along.t[at]
            ahead, behind = (torque_of(effect, x, u, t=t, tau=tau + sign * step) for sign in (1.0, -1.0))
            slope = np.abs(ahead - behind) / (2.0 * step)
            total += float(np.log(np.clip(slope, floor, 1.0)).sum())
        return total
