"""The batch that everybody runs: 2 s of the two-link arm with dry friction, from many states, with many numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from arms import Arm, Array, with_laws

import flexdyn as fd

DURATION = 2.0  # s
RATE = 100.0  # Hz, of what is compared and stored
SWITCHES = np.array([0.0, 0.5, 1.0, DURATION])  # s
PULSES = np.array([[0.4, 0.2], [-0.4, -0.2], [0.0, 0.0], [0.0, 0.0]])  # N m: off, brake, let it ring out and stick
LOG_RATE = 100.0  # Hz
SPREAD = 0.2  # of stiffness, rotor inertia and friction: +-20 %


@dataclass(frozen=True, eq=False)
class Batch:
    """Runs of one arm under one command.

    Attributes:
        title: what is varied.
        runs: how many.
        log: the torque is a log held at 100 Hz instead of three pulses.
        numbers: stiffness, rotor inertia and friction levels differ too.
    """

    title: str
    runs: int
    log: bool = False
    numbers: bool = False

    @property
    def command(self) -> fd.Samples:
        """Motor torques, held."""
        if not self.log:
            return fd.Samples(SWITCHES, PULSES)
        t = np.arange(round(DURATION * LOG_RATE) + 1) / LOG_RATE
        return fd.Samples(t, np.column_stack([0.4 * np.sin(np.pi * t), 0.2 * np.sin(2.0 * np.pi * t)]))

    @cached_property
    def model(self) -> fd.FlexibleJointModel:
        """The shipped arm with the laws that MuJoCo has too: springs, viscous and Coulomb friction."""
        return with_laws("scara_two_link", dry=True)

    @property
    def grid(self) -> Array:
        """Times of the samples [s]."""
        return np.arange(round(DURATION * RATE) + 1) / RATE

    @cached_property
    def starts(self) -> Array:
        """First link positions (runs, 2) [rad]; the springs are not strained, everything rests."""
        return np.random.default_rng(7).uniform(-1.5, 1.5, (self.runs, 2))

    @cached_property
    def factors(self) -> Array:
        """Of stiffness, rotor inertia and friction level of both joints (runs, 3, 2)."""
        spread = SPREAD if self.numbers else 0.0
        return np.random.default_rng(8).uniform(1.0 - spread, 1.0 + spread, (self.runs, 3, 2))

    def varied(self, k: int) -> fd.FlexibleJointModel:
        """The model of run k."""
        if not self.numbers:
            return self.model
        stiffness, inertia, level = self.factors[k]
        joints = {
            name: {"stiffness": stiffness[j] * joint.stiffness, "rotor_inertia": inertia[j] * joint.rotor_inertia}
            for j, (name, joint) in enumerate(self.model.joints.items())
        }
        effects = [
            effect.replace(level=level[self.model.index(effect.joint)] * effect.level)
            if isinstance(effect, fd.effects.CoulombFriction)
            else effect
            for effect in self.model.effects
        ]
        return self.model.replace(joints=joints, effects=effects)

    def arm(self) -> Arm:
        """As the MuJoCo peer takes it."""
        return Arm(self.model, PULSES[0], np.zeros(2), np.zeros(2), 1e-3)
