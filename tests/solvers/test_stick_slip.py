"""A mass dragged over a dry floor by a spring whose end moves evenly: the textbook case with a closed-form period."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, StribeckFriction
from flexdyn.simulation.solvers import DormandPrince
from tests.solvers.arms import planar

HEAVY = 1e13
"""Inertia of a rotor that nothing slows [kg m^2]."""
STRIBECK = 1e-10
"""Velocity over which static friction fades; the law below is its limit at 0 [rad/s]."""


@dataclass(frozen=True)
class Dragged:
    """A link of inertia I behind a spring K whose other end moves at V, static level Fs, kinetic level Fk.

    While it slips, y = K (theta - q) - Fk obeys y'' = -w^2 y, w = sqrt(K/I), from y = Fs - Fk = F and y' = K V (the
    link breaks away at rest). Its speed V - y'/K = V (1 - cos wt) + (F w/K) sin wt is 0 again at::

        T_slip = 2/w (pi - atan(F w/(K V))),

    where y = -F. It then sticks until the spring has stretched from Fk - F to Fs, for T_stick = 2 F/(K V).
    """

    stiffness: float
    speed: float
    static: float
    kinetic: float
    inertia: float

    @property
    def slip(self) -> float:
        """Time of one slip [s]."""
        w, fall = math.sqrt(self.stiffness / self.inertia), self.static - self.kinetic
        return 2.0 / w * (math.pi - math.atan(fall * w / (self.stiffness * self.speed)))

    @property
    def period(self) -> float:
        """Of slip and stick together [s]."""
        return self.slip + 2.0 * (self.static - self.kinetic) / (self.stiffness * self.speed)

    @property
    def first(self) -> float:
        """When it first breaks away, the spring at rest at the start [s]."""
        return self.static / (self.stiffness * self.speed)


def case(stiffness: float, speed: float, static: float, kinetic: float) -> tuple[Dragged, fd.FlexibleJointModel]:
    """The closed form and flexdyn's model of it."""
    effects = [
        CoulombFriction("shoulder", side="link", level=kinetic),
        StribeckFriction("shoulder", side="link", excess=static - kinetic, velocity=STRIBECK),
    ]
    model = planar(stiffness, effects, rotor=HEAVY)
    inertia = float(fd.LinkSide(model).mass_matrix(np.zeros(1))[0, 0])
    return Dragged(stiffness, speed, static, kinetic, inertia), model


CASES = [(30.0, 0.1, 1.6, 1.0), (5.5, 0.3, 0.5, 0.4), (400.0, 0.02, 3.0, 2.0)]


@pytest.mark.parametrize("numbers", CASES)
def test_the_period_is_the_closed_form(numbers: tuple[float, float, float, float]) -> None:
    """Every break-away and every stop of ten periods lies within 1e-6 of a period of its instant, sticking between."""
    dragged, model = case(*numbers)
    breaks = dragged.first + dragged.period * np.arange(10)
    stops = breaks + dragged.slip
    near = 1e-6 * dragged.period
    times = np.sort(np.concatenate([breaks - near, breaks + near, stops - near, stops + near]))
    solver = DormandPrince(rtol=1e-10, atol=1e-12)
    run = fd.simulate(model, None, times[-1], solver, v0=[0.0], omega0=[dragged.speed], times=times)
    moving = run.v[:, 0].reshape(-1, 4)  # just before and after a break-away, just before and after a stop
    assert (moving[:, [0, 3]] == 0.0).all()
    assert (moving[:, [1, 2]] > 0.0).all()
    assert run.stats["events"] == 20


@pytest.mark.parametrize("numbers", CASES)
def test_it_travels_as_far_as_its_driver(numbers: tuple[float, float, float, float]) -> None:
    """From one rest to the next the mass moves by V T, T the closed-form period, to 1e-7."""
    dragged, model = case(*numbers)
    rests = dragged.first + dragged.slip + dragged.period * (np.arange(8) + 0.01)
    solver = DormandPrince(rtol=1e-10, atol=1e-12)
    run = fd.simulate(model, None, rests[-1], solver, v0=[0.0], omega0=[dragged.speed], times=rests)
    assert (run.v == 0.0).all()
    np.testing.assert_allclose(np.diff(run.q[:, 0]), dragged.speed * dragged.period, rtol=1e-6)
