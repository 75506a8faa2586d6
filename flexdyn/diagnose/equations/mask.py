"""Masked rows: where the sign of a velocity is uncertain, dry friction can have any value between its levels."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, MOTOR, SENSOR, TOTAL
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.rest import borders, near, touches_zero, uncertain_sign
from flexdyn.effects import CouplingEffect

LOAD_ERROR = 0.05
"""Share of a motor's torques by which the load that they leave may be wrong [1]: a usual tolerance of their numbers."""


def sign_mask(equations: Equations, noise: SampleNoise, *, alone: bool = False) -> Flags:
    """Rows (rows,) whose filters cover an instant at which the sign of a velocity of their joint is uncertain.

    Args:
        equations: that have the rows.
        noise: of the encoders.
        alone: whether joints with a computed position do not mask rows of other joints.
    """
    found = []
    for along in equations.motions:
        at = equations.filters.instants(len(along.t))
        hidden = np.zeros((len(at), len(equations.kinds)), dtype=bool)
        unseen = np.flatnonzero(equations.unmeasured).tolist()
        for place, (j, kind) in enumerate(equations.kinds):
            if kind == SENSOR:
                continue
            hidden[:, place] |= _covered(equations, along, _uncertain(equations, along, noise, j, kind))[at]
            for i in () if alone else unseen:
                # A computed position lacks the friction of its sticking joint; the error enters every other equation.
                # While the joint rests, its position follows from the load instead.
                rests = along.resting[:, i]
                lacking = _uncertain(equations, along, noise, i, TOTAL) & ~rests
                hidden[:, place] |= _covered(equations, along, lacking | borders(rests))[at]
        found.append(hidden.ravel())
    return np.concatenate(found)


def passage_mask(equations: Equations, noise: SampleNoise) -> Flags:
    """Rows (rows,) whose filters cover an instant at which a joint with a computed position begins or ends to stick.

    Its friction jumps there at an uncertain instant, and so does the position that is computed from its torque. All
    equations contain the accelerations of that position. In a long rest they are hardly wrong.

    Args:
        equations: that have the rows.
        noise: of the encoders.
    """
    found = []
    for along in equations.motions:
        hidden = np.zeros(len(along.t), dtype=bool)
        for j in np.flatnonzero(equations.unmeasured).tolist():
            hidden |= _covered(equations, along, borders(_uncertain(equations, along, noise, j, TOTAL)))
        rows = hidden[equations.filters.instants(len(along.t))]
        found.append(np.repeat(rows, len(equations.kinds)))
    return np.concatenate(found)


def reversal_mask(equations: Equations, noise: SampleNoise) -> Flags:
    """Rows (rows,) whose filters cover an instant at which the load of an unmeasured link may change its sign.

    If its gear has play, nothing tells where the link is meanwhile. Else its position is between the teeth, and a small
    offset, which gravity and inertia hardly feel.
    """
    found = []
    for along in equations.motions:
        uncertain = np.zeros(len(along.t), dtype=bool)
        for j in np.flatnonzero(equations.unmeasured).tolist():
            load = equations.true.stiffness[j] * along.delta[:, j]
            torques = np.abs(along.tau[:, j]) + equations.true.rotor_inertia[j] * np.abs(along.alpha[:, j])
            sigma = float(noise.tau[j] * np.linalg.norm(equations.filters.first.taps[0]))
            uncertain |= np.abs(load) <= CERTAIN_SIGMAS * sigma + LOAD_ERROR * torques
        rows = _covered(equations, along, uncertain)[equations.filters.instants(len(along.t))]
        found.append(np.repeat(rows, len(equations.kinds)))
    return np.concatenate(found)


def _uncertain(equations: Equations, along: SmoothedMotion, noise: SampleNoise, j: int, kind: str) -> Flags:
    """Samples at which the sign of a velocity in an equation of a joint is uncertain."""
    data = along.data
    uncertain = np.zeros(len(along.t), dtype=bool)
    for side, u, level, there in (
        (MOTOR, along.omega[:, j], noise.theta[j], data.has_theta[j]),
        (LINK, along.v[:, j], noise.q[j], data.has_q[j]),
    ):
        if kind in (MOTOR, LINK) and kind != side:
            continue
        sigma = level if there else max(noise.q[j], noise.theta[j]) * 3.0
        uncertain |= uncertain_sign(u, sigma, equations.filters.first)
        if equations.unmeasured[j]:  # of measured links the error of the filter is known, see `filter_error`
            uncertain |= touches_zero(u, equations.filters.first)
    return uncertain | _rubbing(equations, along, noise, j) if kind in (MOTOR, TOTAL) else uncertain


def _rubbing(equations: Equations, along: SmoothedMotion, noise: SampleNoise, j: int) -> Flags:
    """The same of the velocities of a motor relative to others that rub on it."""
    true, uncertain = equations.true, np.zeros(len(along.t), dtype=bool)
    levels = np.maximum(noise.q, noise.theta)
    for effect in true.all_effects:
        if not isinstance(effect, CouplingEffect) or effect.rubbing_ratio is None:
            continue
        one, other, ratio = true.index(effect.joint), true.index(effect.partner), effect.rubbing_ratio
        if j in (one, other):
            u = along.omega[:, one] - ratio * along.omega[:, other]
            sigma = float(np.hypot(levels[one], ratio * levels[other]))
            uncertain |= uncertain_sign(u, sigma, equations.filters.first)
    return uncertain


def _covered(equations: Equations, along: SmoothedMotion, samples: Flags) -> Flags:
    """Samples whose filters cover one of some samples."""
    return near(samples, equations.filters.reach(1 + (along.lost > equations.filters.first.half)))
