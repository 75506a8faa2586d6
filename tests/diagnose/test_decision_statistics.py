"""Statistics of the final fit and shares of the gap, against formulas written down here."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.notes import CORRELATION_TOLD, statistics
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from tests.diagnose.answers import dry_elbow
from tests.diagnose.truths import Levels, slider_model, slider_recording, sliding
from tests.diagnose.workspaces import workspace


def test_statistics_are_those_of_the_normal_equations(tmp_path: Path) -> None:
    """Chi-square, the two criteria, and correlations from the inverse of X^T X with the priors."""
    t = np.arange(2500) / 250.0
    force = 6.0 * np.sin(2.1 * t + 0.3) + 5.0 * np.sin(5.3 * t)
    x, _ = sliding(force, 1.0 / 250.0, 2.5, 0.8)
    model = slider_model(tmp_path)
    data = (measured(model, slider_recording(x, force, 250.0, Levels(2e-6, 0.02), seed=1)),)
    space, start, _ = workspace(model, data)
    friction = (
        fd.effects.CoulombFriction("lift", side="motor", level=0.5),
        fd.effects.ViscousFriction("lift", side="motor", coefficient=0.1),
    )
    made = fit(Hypothesis(model, start.factors, effects=friction), space)
    told, problem = statistics(made), made.free or made.regression
    rows = problem.y + problem.X @ problem.values
    points, variables = problem.rows, problem.X.shape[1]
    chi_square = float(rows @ rows)
    assert told.chi_square == pytest.approx(chi_square, rel=1e-9)
    assert told.reduced == pytest.approx(chi_square / (points - variables), rel=1e-9)
    assert told.aic == pytest.approx(points * math.log(chi_square / points) + 2 * variables, rel=1e-9)
    assert told.bic == pytest.approx(points * math.log(chi_square / points) + math.log(points) * variables, rel=1e-9)
    covariance = np.linalg.inv(problem.X.T @ problem.X + np.diag(1.0 / problem.sigma**2))
    level, viscous = (len(start.factors) + k for k in range(2))
    wanted = covariance[level, viscous] / math.sqrt(covariance[level, level] * covariance[viscous, viscous])
    pair = {"level of Coulomb friction of lift", "coefficient of viscous friction of lift"}
    (found,) = (value for one, other, value in told.correlations if {one, other} == pair)
    assert found == pytest.approx(wanted, rel=1e-6)
    assert found < -0.5, "what one takes the other gives"
    sizes = [abs(value) for _, _, value in told.correlations]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] >= CORRELATION_TOLD


def test_shares_add_up_to_the_whole() -> None:
    """The friction that was hidden takes all but noise."""
    answer = dry_elbow()
    assert answer.shares is not None
    whole = answer.shares.calibration + sum(answer.shares.findings) + answer.shares.left
    assert whole == pytest.approx(1.0, abs=1e-12)
    assert answer.shares.findings[0] > 0.99
    assert answer.shares.left == pytest.approx(answer.shares.noise, rel=0.3)


def test_what_was_read_is_told() -> None:
    """Samples and channels of both spans, and which version said it."""
    answer = dry_elbow()
    first, last = answer.data
    assert first.samples + last.samples == 8001, "a run is sampled at 1 kHz"
    assert first.channels == tuple(
        f"{signal}.{joint}" for signal in ("q", "theta", "tau") for joint in ("shoulder", "elbow")
    )
    assert answer.record.version == fd.__version__
    assert (answer.record.command, answer.record.files) == ("", ())
