"""Effects that equations hardly see are asked of simulated windows: what noise is there, and what a step promises."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from flexdyn.diagnose.faint import OF_NOISE, Seen, at_noise
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.measured import measured
from flexdyn.diagnose.numbers import file_numbers
from flexdyn.diagnose.proposal import linear
from flexdyn.diagnose.refine import refine
from flexdyn.diagnose.run import window_noise
from flexdyn.diagnose.screen import Screened
from flexdyn.diagnose.slopes import ROBUST
from flexdyn.diagnose.windows import Windows
from flexdyn.diagnose.workspace import workspace
from tests.arms import two_link
from tests.diagnose.test_estimate import HANGING, swinging

ROWS, MISSING = 16_000, 0.01


def test_what_noise_makes() -> None:
    """Mean and standard deviation of the robust square of a normal surprise, by quadrature."""

    def moment(power: int) -> float:
        return float(quad(lambda x: (ROBUST**2 * math.log1p((x / ROBUST) ** 2)) ** power * norm.pdf(x), -30, 30)[0])

    mean, std = moment(1), math.sqrt(moment(2) - moment(1) ** 2)
    assert pytest.approx((mean, std), rel=1e-3) == OF_NOISE


def test_surprises_above_noise_are_not_noise() -> None:
    """Normal ones are; a tenth more of each, or one in a hundred ten times as large, are not."""
    noise = np.random.default_rng(8).standard_normal(ROWS)
    found = {}
    for name, surprises in (
        ("noise", noise),
        ("more", 1.1 * noise),
        ("a few", np.where(np.arange(ROWS) % 100, 1.0, 10.0) * noise),
    ):
        cost = float((ROBUST**2 * np.log1p((surprises / ROBUST) ** 2)).sum())
        asked: Any = SimpleNamespace(cost=cost, rows=ROWS)
        found[name] = at_noise(asked)
    assert found == {"noise": True, "more": False, "a few": False}


def test_windows_promise_the_damping_that_is_missing() -> None:
    """Of a transmission that has 0.6 N m s/rad where the file says 0.59; hardly anything of what is not missing."""
    model = two_link(dataclasses.replace(HANGING, damping=(HANGING.damping[0], HANGING.damping[1] - MISSING)))
    noise = workspace(model, (measured(model, swinging()),))[2]
    numbers = {n: 1.0 for n in file_numbers(model) if n.parameter in ("stiffness", "rotor_inertia")}
    bare = refine(Hypothesis(model, numbers), Windows.of(model, [swinging()], window_noise(noise)), rounds=1)
    assert bare.slopes is not None
    assert bare.shot is not None
    seen = Seen.of(bare, bare.slopes, bare.shot)
    promised = {}
    for effect, joint, side in (
        ("transmission_damping", "elbow", "transmission"),
        ("transmission_damping", "shoulder", "transmission"),
        ("viscous_friction", "elbow", "motor"),
    ):
        proposal = linear({"effect": effect, "joint": joint, "side": side}, "coefficient")
        promised[effect, joint] = seen.promise(Screened(0.0, proposal, (), np.zeros(1)))
    right = promised["transmission_damping", "elbow"]
    assert right.values[0] == pytest.approx(MISSING, rel=0.2)
    assert right.score > 100.0
    assert all(each.score < 0.2 * right.score for each in promised.values() if each is not right)
