"""The linear least-squares problem of the equations near a hypothesis: white residuals, slopes and priors."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis import number_columns
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import STEP_ROUNDING, Hypothesis, bounded, least_factor
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.parallel import SILENT, in_parallel
from flexdyn.effects import Effect, SensorEffect
from flexdyn.errors import SimulationError

SAME_DERIVATIVE_DISTANCE = 0.05
"""If a number differs more from its given value, its derivative is computed again [1]."""
SAME_SLOPE_STEPS = 5.0
"""Slopes are kept for changes of an unknown up to this multiple of its scale [1]."""
OUT_OF_TOLERANCE_WIDTH = 1e3
"""Relative width of the prior of a number that is out of its tolerance."""


def linearised(hypothesis: Hypothesis, space: Workspace, before: Fit | None = None, at: Equations | None = None) -> Fit:
    """The least-squares problem at a hypothesis; its step is not taken.

    Args:
        hypothesis: of the model.
        space: data, weights and the derivatives that do not change.
        before: the same effects with other numbers; if these are near, its slopes are used.
        at: the equations of the hypothesis; None: they are computed.

    Raises:
        SimulationError: the equations are not finite.
    """
    at = at or space.equations.of(hypothesis.model())
    here = space.at(at)
    along = space.bare.sloping(at)
    scales = scales_of(hypothesis)
    taken = None if before is None else before.taken or before.hypothesis
    near = before if taken is not None and not at.simulated and _near(hypothesis, taken) else None
    with SILENT():
        y, X = _rows(hypothesis, at, along, here) if near is None else _same_slopes(near, at, here, scales)
    made = problem_of(hypothesis, at, y, X, space, scales)
    return dataclasses.replace(made, taken=taken if near else None)


def problem_of(
    hypothesis: Hypothesis, at: Equations, y: Array, X: Array, space: Workspace, scales: tuple[float, ...]
) -> Fit:
    """The least-squares problem with given white residuals and slopes, and the priors of a hypothesis.

    Args:
        hypothesis: whose unknowns the slopes are by.
        at: its equations.
        y: white residuals (rows,).
        X: their slopes by numbers, unknowns and nuisances (rows, columns).
        space: the common parts of all fits.
        scales: of the unknowns.

    Raises:
        SimulationError: residuals or slopes are not finite.
    """
    require_finite(y, X)
    nuisances = space.bare.unknown.shape[1]
    centre, sigma = priors(hypothesis, space)
    centre, sigma = np.append(centre, np.zeros(nuisances)), np.append(sigma, space.nuisance_sigma)
    return within_bounds(Fit(hypothesis, at, Regression(y, X, centre, sigma, space.rows, nuisances), space, scales))


def require_finite(*white: Array) -> None:
    """Raise a SimulationError if residuals (rows,) or slopes (rows, columns) are not finite, or their squares."""
    with SILENT():
        finite = all(np.isfinite(np.einsum("i...,i...->...", each, each)).all() for each in white)
    if not finite:
        raise SimulationError("the equations are not finite along the measured motion", reason="overflow")


def within_bounds(made: Fit) -> Fit:
    """The problem with fixed values for numbers and unknowns at a bound that would leave it."""
    regression, held = made.regression, _at_bounds(made.hypothesis, made.regression, made.scales)
    if not held:
        return made
    X, sigma, centre = regression.X.copy(), regression.sigma.copy(), regression.centre.copy()
    X[:, held], sigma[list(held)], centre[list(held)] = 0.0, 1e-9, 0.0  # the others are fitted without them
    bound = dataclasses.replace(regression, X=X, sigma=sigma, centre=centre)
    return dataclasses.replace(made, regression=bound, held=held, free=regression)


def _near(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether the numbers of the effects and of the file are so near that the slopes can be kept."""
    pairs = zip(one.unknowns(), other.unknowns(), strict=True)
    moved = (abs(getattr(a, name) - getattr(b, name)) / tangent_scale(b, name) for (a, name), (b, _) in pairs)
    factors = zip(one.factors.values(), other.factors.values(), strict=True)
    return all(x <= SAME_SLOPE_STEPS for x in moved) and all(
        abs(a - b) <= SAME_DERIVATIVE_DISTANCE * abs(b) for a, b in factors
    )


def _rows(hypothesis: Hypothesis, at: Equations, along: Equations, space: Workspace) -> tuple[Array, Array]:
    """White residuals (rows,) and their slopes by the numbers, the unknowns and the encoders' offsets (rows, k)."""

    def slope(unknown: tuple[Effect, str]) -> Array:
        """Derivative by an unknown, in its scale."""
        with SILENT():
            return tangent_scale(*unknown) * tangent(along, *unknown)

    slopes = in_parallel(slope, hypothesis.unknowns())
    white, nuisance = space.beside_nuisance(np.stack([at.residual, *slopes], axis=1))
    numbers = slopes_of_numbers(hypothesis, along, space)
    return white[:, 0], np.column_stack([numbers, white[:, 1:], nuisance])


def _same_slopes(near: Fit, at: Equations, space: Workspace, scales: tuple[float, ...]) -> tuple[Array, Array]:
    """The same with the slopes of a fit that is near."""
    X = (near.free or near.regression).X.copy()
    first, end = len(near.hypothesis.factors), X.shape[1] - space.bare.unknown.shape[1]
    X[:, first:end] *= np.array(scales) / np.array(near.scales)
    white, X[:, end:] = space.beside_nuisance(at.residual)
    return white[:, 0], X


def _at_bounds(hypothesis: Hypothesis, regression: Regression, scales: tuple[float, ...]) -> tuple[int, ...]:
    """Columns of the numbers and unknowns at a bound that would leave it."""
    first = len(hypothesis.factors)
    wanted = regression.values[first : first + len(scales)] * np.array(scales)
    pairs = enumerate(hypothesis.factors.items())
    held = [k for k, (n, f) in pairs if f <= least_factor(n) and regression.values[k] < 0.0]
    for k, ((effect, name), dx) in enumerate(zip(hypothesis.unknowns(), wanted.tolist(), strict=True)):
        value = getattr(effect, name)
        if abs(bounded(effect, name, dx) - value) < STEP_ROUNDING * abs(dx):
            held.append(first + k)
    return tuple(held)


def reached(hypothesis: Hypothesis, at: Equations, space: Workspace) -> float:
    """`Fit.reached` without computing slopes; infinite if the equations are not finite."""
    space = space.at(at)
    with SILENT():
        rows, nuisance = space.beside_nuisance(at.residual)
        y = rows[:, 0]
        if not (np.isfinite(y @ y) and np.isfinite(nuisance).all()):
            return math.inf
    centre, sigma = priors(hypothesis, space)
    nuisances = nuisance.shape[1]
    alone = Regression(y, nuisance, np.zeros(nuisances), space.nuisance_sigma, space.rows, nuisances)
    return alone.at_zero + float(((centre / sigma) ** 2).sum())


def slopes_of_numbers(hypothesis: Hypothesis, at: Equations, space: Workspace) -> Array:
    """Whitened derivatives of the file's numbers (rows, numbers); derivatives that have changed are computed again.

    These are those of numbers far from their given values, those of a joint whose encoders or spring were wrong,
    because its deflection is smaller than sensor errors, and those of a joint whose torque has another gain, in which
    its rows are. Mass, centre of mass and inertia of a link multiply one another, and their torque winds the springs:
    if one of them is far off, or the links carry more, all are computed again; so are those of links, and of the joint,
    where an effect changes the torque from which a position is computed. Where links are simulated, all are: a small
    change of the frequency of a vibration is another phase after many periods.
    """
    numbers, effects = hypothesis.factors, hypothesis.effects
    far = {n for n, factor in numbers.items() if abs(factor - 1.0) > SAME_DERIVATIVE_DISTANCE}
    computed = {name for name, is_computed in zip(at.true.joint_names, at.computed, strict=True) if is_computed}
    wound = {getattr(e, "joint", None) for e in effects} & computed
    carry = any(n.joint is None for n in far) or any(e.stage == "inertia" for e in effects)
    wrong = (e for e in effects if isinstance(e, SensorEffect) or e.position_error or e.scales_torque)
    joints = wound | {getattr(e, "joint", None) for e in wrong}
    links = bool(wound) and not carry
    carry = carry or at.simulated
    anew = tuple(n for n in numbers if carry or n in far or n.joint in joints or (links and n.joint is None))
    if not anew:
        return space.numbers
    slopes = space.numbers.copy()
    with SILENT():
        taken = space.whiten(number_columns.of_numbers(at, anew)) / np.array([numbers[n] for n in anew])
    slopes[:, [k for k, number in enumerate(numbers) if number in anew]] = taken
    return slopes


def tangent_scale(effect: Effect, name: str) -> float:
    """Scale of a parameter for steps and columns."""
    value, declared = abs(getattr(effect, name)), effect.declared(name)
    if declared["step"] is not None:
        return float(declared["step"])
    return 0.01 * value if value > 0.0 else float(declared["step_at_zero"])


def scales_of(hypothesis: Hypothesis) -> tuple[float, ...]:
    """Scales of all parameters that are estimated."""
    return tuple(tangent_scale(*unknown) for unknown in hypothesis.unknowns())


def tangent(equations: Equations, effect: Effect, name: str) -> Array:
    """Derivative of the residual (rows,) by a parameter of an effect of the model, over a tenth of its scale."""
    return columns.of_parameter(equations, effect, name, 0.1 * tangent_scale(effect, name))


def priors(hypothesis: Hypothesis, space: Workspace) -> tuple[Array, Array]:
    """Centres of the priors relative to the present numbers, and widths, in the scales of steps (columns,)."""
    centre = [1.0 - factor for factor in hypothesis.factors.values()]
    sigma = [OUT_OF_TOLERANCE_WIDTH if n in hypothesis.freed else max(n.tolerance, 1e-9) for n in hypothesis.factors]
    for effect, name in hypothesis.unknowns():
        off, std = (0.0, math.inf) if space.beliefs is None else space.beliefs(effect, name)
        scale = tangent_scale(effect, name)
        centre.append(off / scale)
        sigma.append(std / scale)
    return np.array(centre), np.array(sigma)
