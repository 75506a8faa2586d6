"""The energy ledger of a run: stored energy, supplied energy, and the energy that each effect took."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.io.locked import Locked
from flexdyn.io.notebook import Public


class EnergyWarning(UserWarning):
    """The energy ledger of a run does not close to the tolerance of its solver.

    Example:
        >>> issubclass(fd.EnergyWarning, UserWarning)
        True
    """


@dataclass(frozen=True, repr=False)
class Energy(Locked, Public):
    """Where the energy of a motion is and went, sample by sample [J], each (samples,) unless said.

    ``mechanical + magnetic - initial = supplied + external - sum of dissipated + residual``.

    Attributes:
        kinetic: of the links and rotors.
        spring: held by springs of all kinds: transmissions, bristles, hysteresis, parallel springs, counterbalances.
        gravity: of the links, from the height of the base.
        supplied: by each motor since the start, tau_applied omega integrated (samples, n); of a motor with inductance
            also what its winding took in, L i i'.
        external: by wrenches since the start.
        dissipated: since the start, by ``effect.joint.side``; ``damping.JOINT`` is the joint's own. An end stop's entry
            holds what its spring still stores.
        initial: mechanical and magnetic energy at the start of the run, which the first sample need not be [J].
        tolerance: that the residual should stay below [J].
        magnetic: 1/2 L i^2 in the windings of motors with inductance.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> run.energy.closes
        True
        >>> bool(run.energy.dissipated["viscous_friction.elbow.link"][-1] > 0.0)
        True
    """

    kinetic: Array
    spring: Array
    gravity: Array
    supplied: Array
    external: Array
    dissipated: Mapping[str, Array]
    initial: float
    tolerance: float
    magnetic: Array

    def __repr__(self) -> str:
        """Supplied and dissipated energy of the whole run [J], in one line."""
        spent = sum(float(each[-1]) for each in self.dissipated.values())
        given = float(self.supplied[-1].sum())
        return f"<Energy: supplied {given:.4g} J, dissipated {spent:.4g} J, {len(self.kinetic)} samples>"

    @property
    def mechanical(self) -> Array:
        """The sum of kinetic, spring and gravity energy: constant if nothing drives or brakes."""
        return self.kinetic + self.spring + self.gravity

    @property
    def residual(self) -> Array:
        """The error of the ledger, which is the error of the integration."""
        came = self.supplied.sum(axis=1) + self.external
        went = np.sum(list(self.dissipated.values()), axis=0) if self.dissipated else 0.0
        return np.asarray(self.mechanical + self.magnetic - self.initial - came + went)

    @property
    def closes(self) -> bool:
        """Whether the residual stays within the tolerance."""
        return bool(np.abs(self.residual).max() <= self.tolerance)
