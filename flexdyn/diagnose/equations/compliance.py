"""A joint that the model takes for rigid: the effect of a small compliance on the equations."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, TOTAL, TRANSMISSION
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.terms import joint_terms


def of_compliance(equations: Equations, j: int) -> Array:
    """Derivative of the residual (rows,) by the compliance 1/K of a rigid joint, where that is 0.

    With both encoders the deflection is measured, and should equal the link's torque over K. With one encoder, the
    other position has an error of torque over K, whose acceleration loads the rotor or the links. The torque is that of
    the side that was measured; while a motor rests, its friction is unknown, and the torque is that of the link.
    """
    return np.concatenate([_of_recording(equations, each, j).ravel() for each in equations.motions])


def _of_recording(equations: Equations, along: SmoothedMotion, j: int) -> Array:
    """The derivative for one recording (times, equations)."""
    model, filters = equations.true, equations.filters
    terms, J = joint_terms(model, model.all_effects, along, j), model.rotor_inertia[j]
    by_link = along.inverse_dynamics[:, j] - J * along.a[:, j] - terms.link
    by_motor = terms.motor - J * along.alpha[:, j]
    rows = np.zeros((filters.count(len(along.t)), len(equations.kinds)))
    has_q, has_theta = along.data.has_q[j], along.data.has_theta[j]
    swung = [filters.rows(np.where(along.resting[:, j], by_link, by_motor), order) for order in range(3)]
    for place, (i, kind) in enumerate(equations.kinds):
        if has_q and has_theta:
            if i == j and kind == TRANSMISSION:
                rows[:, place] = -filters.rows(by_link - model.damping[j] * along.ddelta[:, j])
        elif has_q:
            if i == j and kind == TOTAL:
                rows[:, place] = -J * filters.rows(by_link, 2) / equations.gains[j]
        elif kind in (TOTAL, LINK):
            loads = along.dragged(j, swung, filters.instants(len(along.t)))[:, i]
            loads -= J * swung[2] if i == j else 0.0  # a rigid joint's rotor is in M
            rows[:, place] = loads / (equations.gains[i] if kind == TOTAL else equations.softness[i])
    return rows
