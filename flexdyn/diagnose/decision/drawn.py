"""Pictures of what the model left unexplained, before and after: those that tell most."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.figures import OnFit, OnTest
from flexdyn.diagnose.decision.forces import are_prescribed, loops
from flexdyn.diagnose.decision.laws_seen import laws_seen
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.decision.trajectories import trajectories
from flexdyn.diagnose.equations.covariance import Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.localise import traces
from flexdyn.diagnose.hypothesis.fitted import Workspace
from flexdyn.diagnose.report.force import ForceLoop
from flexdyn.diagnose.report.trace import ResidualTrace
from flexdyn.diagnose.report.trajectory import Trajectory

Parts = tuple[tuple[DataPart, ...], tuple[DataPart, ...]]


def drawn(plain: Workspace, first: OnFit, found: Corrected, named: Sequence[Name]) -> tuple[ResidualTrace, ...]:
    """Pictures in the order of how much they explain: of the laws found, then two of every equation.

    Args:
        plain: equations of the model as given over the data of the fit.
        first: figures on these.
        found: the corrected model.
        named: what is told.
    """
    laws = laws_seen(plain.equations, first.after, plain.whiten, found, named)
    ordered = sorted(laws, key=lambda each: -each.explains)
    return (*ordered, *of_equations(plain.equations, first.after, plain.whiten, explained=bool(laws)))


def of_equations(
    before: Equations, after: Equations, whiten: Whitener, *, explained: bool
) -> tuple[ResidualTrace, ...]:
    """Two pictures of every equation, those of which the correction takes most first.

    One is over what its residual depends on more, position or velocity, and one over time. Where nothing was found,
    those come first in which most is left: they are what a reader looks for.

    Args:
        before: of the model as given.
        after: of the corrected model, over the same recordings.
        whiten: by the sensors' noise.
        explained: whether something was found.
    """
    many = len(before.kinds)
    first, last = ((whiten(at.residual).reshape(-1, many) ** 2).sum(axis=0) for at in (before, after))
    pictures = traces(before, after, whiten.mask)
    shares = (first - last) / max(first.sum(), 1e-300) if explained else last / max(last.sum(), 1e-300)
    equations: list[ResidualTrace] = []
    for k in np.argsort(-shares, kind="stable").tolist():
        over_time, *clouds = pictures[3 * k : 3 * k + 3]
        told = (max(clouds, key=_dependence), over_time)
        equations += [dataclasses.replace(each, explains=float(shares[k])) for each in told]
    return tuple(equations)


def _dependence(cloud: ResidualTrace) -> float:
    """Spread of the averages over neighbours: what the residual changes with."""
    spread = float(np.nanvar(cloud.means[:, 1])) if len(cloud.means) else 0.0
    return spread if np.isfinite(spread) else 0.0


def motions(plain: Workspace, first: OnFit, last: OnTest, parts: Parts) -> tuple[Trajectory, ...]:
    """Measured and simulated motion over the test data, then over the data of the fit.

    Args:
        plain: equations of the model as given over the data of the fit.
        first: figures on these.
        last: figures on the test data.
        parts: of the fit, and the test data.
    """
    tested, fitted = _models(plain, first, last)
    rows = last.rows
    seen = ~plain.whiten.mask.reshape(-1, len(plain.equations.kinds))
    return (
        *trajectories(tested, rows.seen, last.shots, parts[1]),
        *trajectories(fitted, seen, first.shots, parts[0]),
    )


def force_loops(plain: Workspace, first: OnFit, last: OnTest, parts: Parts) -> tuple[ForceLoop, ...]:
    """Force over position and speed where a rig prescribes the motion, as `motions` takes its arguments."""
    tested, fitted = _models(plain, first, last)
    return tuple(
        loop
        for models, spans in ((tested, parts[1]), (fitted, parts[0]))
        if are_prescribed(spans)
        for loop in loops(models, spans)
    )


def _models(plain: Workspace, first: OnFit, last: OnTest) -> tuple[tuple[Equations, ...], tuple[Equations, ...]]:
    """Equations of the model as given, calibrated and corrected, over the test data and over the data of the fit."""
    calibrated, rows = first.calibrated.seen(), last.rows
    tested = (rows.given, rows.given.of(calibrated), rows.after)
    return tested, (plain.equations, plain.equations.of(calibrated), first.after)
