"""The study's summary for people and for programs, and how ambiguities and misprints are read."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from flexdyn.io.json_text import jsonable
from flexdyn.io.yaml import parse_yaml
from flexdyn.paper import equations as eq
from flexdyn.paper.cases import PaperCases
from flexdyn.paper.chapter import Chapter, prose
from flexdyn.paper.verification import random_states, tip_acceleration
from flexdyn.simulation.run import Run

TITLE = "The Effect of Friction on the Formulation and Numerical Solution of Elastic Joint Manipulators"
AREA_MOMENT = 9.9e-12  # m^4: I_1 = I_2 of Table I


def summary_data(chapters: Sequence[Chapter], readings: list[dict[str, str]], version: str) -> dict[str, Any]:
    """Everything measured, as it goes to summary.json."""
    checks = [check for chapter in chapters for check in chapter.checks]
    return {
        "schema": "flexdyn.paper/1",
        "flexdyn": version,
        "paper": TITLE,
        "passed": all(check.passed for check in checks),
        "checks": [jsonable(asdict(check)) for check in checks],
        "numbers": {chapter.title: jsonable(chapter.numbers) for chapter in chapters if chapter.numbers},
        "readings": readings,
        "figures": {figure.name: figure.caption for chapter in chapters for figure in chapter.figures},
        "runs": {name: _run_data(run) for chapter in chapters for name, run in chapter.runs.items()},
    }


def summary_text(chapters: Sequence[Chapter], readings: list[dict[str, str]], version: str) -> str:
    """The same as Markdown, with the figures."""
    runs = {name: run for chapter in chapters for name, run in chapter.runs.items()}
    text = prose(
        "summary.md",
        paper=TITLE,
        version=version,
        checks=[check for chapter in chapters for check in chapter.checks],
        chapters=chapters,
        readings=readings,
        runs=runs,
        notes=list(dict.fromkeys(note for run in runs.values() for note in run.notes)),
        solver=lambda run: type(run.solver).__name__,
        cell=_escaped,
    )
    return text.rstrip("\n") + "\n"


def _run_data(run: Run) -> dict[str, Any]:
    return {
        "duration_s": float(run.t[-1]),
        "samples": len(run.t),
        "solver": run.solver.to_dict(),
        "notes": [*run.notes],
    }


def _escaped(text: str) -> str:
    """Text for a cell of a table. A bar would end it, stars and underscores would make italics, < would open a tag."""
    return re.sub(r"[|*_<]", r"\\\g<0>", text)


def readings(cases: PaperCases) -> list[dict[str, str]]:
    """Misprints and ambiguities of equations, symbols, tables and figures: entries of ``readings.yaml``.

    Each has the place (``where``), the text that is ``printed`` there, the reading that is used (``read_as``) and the
    reason (``why``), with numbers measured by this study.
    """
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
    )
    return list(parse_yaml(text)["readings"])
