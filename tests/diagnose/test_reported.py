"""Which structure is reported, on a slide whose friction is known, from whatever structure the search ends with."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.one_law import by_plainer_laws, with_best
from flexdyn.diagnose.decision.reported import reported
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior import posterior
from tests.diagnose.slides import RATE, model, recording

UP, DOWN = 7.0, 3.0
PARTS = {"coulomb_friction", "torque_offset"}
LAW = {"asymmetric_friction"}


def searched(
    folder: Path, down: float, motor: Callable[[float], float] = float, seconds: float = 3.0
) -> tuple[Posterior, Workspace]:
    """What the search finds on a slide with these friction levels, and the weighted equations of the plain model."""
    given = model(folder)
    record = recording(lambda v: UP if v > 0.0 else -down, motor, seconds)
    bare, start = prepared(given, (measured(given, record),))
    found = posterior(bare, start)
    return found, weighed(dataclasses.replace(bare, noise=found.noise))


def ended_with(found: Posterior, kinds: set[str]) -> Posterior:
    """As if the search had ended with these effects of the motor."""
    places = {each.kind: c for c, each in enumerate(found.space.candidates) if each.spot == ("lift", "motor")}
    return with_best(found, frozenset((places[kind], 0) for kind in kinds))


def kinds_of(found: Posterior) -> set[str]:
    """Effects of the best structure."""
    return {found.space.candidates[c].kind for c, _ in found.best}


def names_of(found: Posterior, answer: Corrected) -> set[str]:
    """Effects that have names."""
    return {found.space.candidates[each.candidate].kind for each in answer.names}


@pytest.mark.parametrize(("down", "truth"), [(DOWN, "asymmetric_friction"), (UP, "coulomb_friction")])
def test_the_true_law_is_told_from_its_parts_and_from_a_law_that_contains_it(
    tmp_path: Path, down: float, truth: str
) -> None:
    """Two laws that are together the true one give way to it, and so does a law with a level too many."""
    found, plain = searched(tmp_path, down)
    for kinds in (PARTS, LAW):
        answer, model_of_it = reported(ended_with(found, kinds), plain)
        assert kinds_of(answer) == names_of(answer, model_of_it) == {truth}


@pytest.mark.slow
def test_a_law_does_not_give_way_to_one_that_has_no_name(tmp_path: Path) -> None:
    """Under an unknown force a damping of two coefficients may be an imitation; one coefficient has no name either."""
    window = np.hanning(600)
    samples = round(4.0 * RATE)
    wander = np.convolve(
        np.random.default_rng(4).standard_normal(samples + 600), window / np.linalg.norm(window), "valid"
    )[:samples]
    unknown = iter((0.5 * (wander - wander.mean())).tolist())
    found, plain = searched(tmp_path, DOWN, lambda force: force + next(unknown), 4.0)
    answer, model_of_it = reported(found, plain)
    assert kinds_of(answer) == {"asymmetric_friction", "asymmetric_viscous_friction"}
    assert "viscous_friction" in kinds_of(by_plainer_laws(answer, model_of_it.genuine))
    assert names_of(answer, model_of_it) == {"asymmetric_friction"}
