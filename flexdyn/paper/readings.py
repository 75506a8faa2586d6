"""Ambiguities and misprints of the paper, and the chosen reading, with a measured reason if there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.io.yaml import parse_yaml
from flexdyn.paper import equations as eq
from flexdyn.paper.cases import AMPLITUDE, PULSE, PaperCases
from flexdyn.paper.chapter import prose
from flexdyn.paper.verification import random_states, tip_acceleration

AREA_MOMENT = 9.9e-12  # m^4: I_1 = I_2 of Table I


@dataclass(frozen=True)
class Reading:
    """One place of the paper.

    Attributes:
        where: equation, table, figure or section.
        printed: the printed text.
        read_as: the reading that is used.
        why: the reason, with numbers measured by this study.
    """

    where: str
    printed: str
    read_as: str
    why: str


def readings(cases: PaperCases) -> tuple[Reading, ...]:
    """All of them, from ``readings.yaml``: misprints in equations, symbols, Table I, what is missing, figures."""
    arm, friction = cases.arm(), cases.friction
    q, v, _ = random_states()
    accelerations = np.random.default_rng(1).uniform(-5.0, 5.0, q.shape)
    measured, _ = tip_acceleration(arm, q, v, accelerations)
    radius = (4 * AREA_MOMENT / np.pi) ** 0.25
    text = prose(
        "readings.yaml",
        without=np.abs(np.einsum("tij,tj->ti", eq.jacobian(arm, q), accelerations) - measured).max(),
        wrong=np.abs(eq.jacobian_as_printed(arm, q) - eq.jacobian(arm, q)).max(0),
        D22=eq.D22(arm),
        D22_as_printed=eq.D22_as_printed(arm),
        inertia=arm.inertia,
        less=100 * arm.inertia / eq.D22(arm),
        density=round(arm.mu / (np.pi * radius**2), -3),
        friction=friction,
        level=100 * friction.dynamic / cases.limit.stall_torque,
        J=arm.J,
        amplitude=AMPLITUDE,
        pulse=PULSE,
    )
    return tuple(Reading(**each) for each in parse_yaml(text)["readings"])
