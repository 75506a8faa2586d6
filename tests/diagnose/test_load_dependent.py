"""Load-dependent friction of a joint that the model takes for rigid: the posterior sees it from motor data alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.catalogue import columns_of, everything
from flexdyn.diagnose.inference.posterior import posterior
from tests.arms import slider

Array = NDArray[np.float64]
RATE, MASS, ROTOR, LOSS, GRAVITY = 500.0, 2.5, 0.6, 0.12, 9.81
UNITS = {"theta.lift": "m", "tau.lift": "N"}


def model(folder: Path) -> fd.FlexibleJointModel:
    """A mass that a rigid drive lifts."""
    return fd.FlexibleJointModel(slider(folder), {"lift": {"rotor_inertia": ROTOR}}, gravity=[0.0, 0.0, -GRAVITY])


def lifted(force: Array, up: float = LOSS, down: float = LOSS) -> Array:
    """Position under held forces; the drive loses a share of what it carries. It never stops for long (samples,).

    With s the sign of the speed, ``(MASS + ROTOR) a = f - MASS g - share MASS (a + g) s`` as long as a > -g.
    """
    x, v, found = 0.0, 0.0, []
    for f in force.tolist():
        found.append(x)
        left = 1.0 / RATE
        while left > 1e-15:
            way = np.sign(v) or np.sign(f - MASS * GRAVITY)
            loss = way * (up if way > 0.0 else down)
            a = (f - MASS * GRAVITY * (1.0 + loss)) / (MASS + ROTOR + loss * MASS)
            if v == 0.0 and a * way <= 0.0:  # it sticks
                break
            assert a > -GRAVITY
            step = -v / a if v * a < 0.0 and -v / a < left else left
            x, v = x + v * step + 0.5 * a * step * step, 0.0 if step < left else v + a * step
            left -= step
    return np.array(found)


def _recording(seconds: float, sizes: tuple[float, float]) -> fd.Recording:
    """Motor encoder and force, noisy."""
    t = np.arange(round(seconds * RATE)) / RATE
    force = MASS * GRAVITY + 9.0 * np.sin(2.9 * t + 0.3) + 7.0 * np.sin(6.1 * t) + 4.0 * np.sin(13.0 * t)
    draw = np.random.default_rng(3)
    theta, noisy = (
        exact + size * draw.standard_normal(len(t)) for exact, size in zip((lifted(force), force), sizes, strict=True)
    )
    return fd.Recording(t, {"theta.lift": theta, "tau.lift": noisy}, meta={"units": UNITS})


def test_its_column_is_what_the_joint_carries_against_the_motion(tmp_path: Path) -> None:
    """``-MASS (a + g) sign(v)`` of a motion in closed form; the rotor's own inertia is not carried."""
    t = np.arange(2000) / RATE
    w, size = 5.0, 0.08
    force = MASS * GRAVITY - (MASS + ROTOR) * size * w**2 * np.sin(w * t)
    record = fd.Recording(t, {"theta.lift": size * np.sin(w * t), "tau.lift": force}, meta={"units": UNITS})
    data = measured(model(tmp_path), record)
    at = Equations(model(tmp_path), (data,), Filters.of_rate(data.dt))
    (proposal,) = [each for each in everything(at) if each.place["effect"] == "load_dependent_friction"]
    (column,) = columns_of(at, proposal, ())
    rows = at.filters.instants(len(at.motions[0].t))
    moved = at.motions[0].t[rows]
    wanted = -MASS * (GRAVITY - size * w**2 * np.sin(w * moved)) * np.sign(np.cos(w * moved))
    away = np.abs(np.cos(w * moved)) > 0.3
    np.testing.assert_allclose(column[away], wanted[away], rtol=2e-3)


def test_it_is_found_with_an_elasticity(tmp_path: Path) -> None:
    """A rigid joint has no transmission torque in the model, so the hypothesis makes it as stiff as the data allow."""
    bare, start = prepared(model(tmp_path), (measured(model(tmp_path), _recording(16.0, (2e-6, 0.02))),))
    found = posterior(bare, start)
    assert [found.space.candidates[c].kind for c, _ in sorted(found.best)] == ["load_dependent_friction"]
    friction, spring = sorted(found.fitted.hypothesis.effects, key=lambda each: each.name, reverse=True)
    assert isinstance(friction, fd.effects.LoadDependentFriction)
    assert isinstance(spring, fd.effects.JointElasticity)
    assert friction.coefficient == pytest.approx(LOSS, rel=0.02)
    assert spring.stiffness > 100.0 * ROTOR * 13.0**2
