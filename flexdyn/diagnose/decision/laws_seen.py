"""The residual against what a found law depends on, before and after, with the law drawn through it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.model_rows import ModelRows
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, SENSOR, TRANSMISSION
from flexdyn.diagnose.equations.localise import SIDE_OF_EQUATION
from flexdyn.diagnose.report.trace import ResidualTrace
from flexdyn.diagnose.report.words import capital, effect_name, number_phrase

CURVE_VARIANCE_SHARE = 0.9
"""Share of a law's variance that one quantity must explain for the law to be a curve over it [1]."""
EQUAL_SHARE_DIFFERENCE = 0.02
"""Shares that differ by less are equal: the first quantity of the list is taken."""
LAW_BINS = 60
"""Averages by which quantities are compared."""
LAW_POINTS = 240
"""Points of a drawn law."""


def laws_seen(rows: ModelRows, found: Corrected, named: Sequence[Name]) -> tuple[ResidualTrace, ...]:
    """A picture of every name, in the equation in which its law does most.

    Before is the corrected model without this one effect, after is the corrected model (a partial residual plot:
    Larsen and McCleary, Technometrics 14, 1972). The difference of the two is what the law does along the measured
    motion; it is drawn over the quantity that explains most of its variance.

    Args:
        rows: over the data of the fit.
        found: the corrected model.
        named: the names that are reported.
    """
    made = (_picture(rows, found, each.candidate) for each in named)
    return tuple(each for each in made if each is not None)


def _picture(rows: ModelRows, found: Corrected, c: int) -> ResidualTrace | None:
    """The picture of one candidate's law; None: it does nothing here, or too few rows show it."""
    without, after, shape = rows.of_hypothesis(found.without(c)), rows.after, rows.seen.shape
    law = without.residual - after.residual
    power = (rows.whiten(law).reshape(shape) ** 2).sum(axis=0)
    k = int(power.argmax())
    clear = rows.seen[:, k]
    own, left = law.reshape(shape)[clear, k], after.residual.reshape(shape)[clear, k]
    if not power.any() or len(own) < 2 * LAW_BINS:
        return None
    known = [(label, values[clear]) for label, values in _quantities_of_laws(after, k)]
    shares = [_share(values, own) for _, values in known]
    best = next(place for place, share in enumerate(shares) if share >= max(shares) - EQUAL_SHARE_DIFFERENCE)
    label, x = known[best]
    curve = shares[best] >= CURVE_VARIANCE_SHARE
    note = "" if curve else f"The law depends on more than {label.partition(' ')[0]}: its line is an average."
    j, side = after.kinds[k]
    joint, robot = after.true.joint_names[j], after.true.robot
    unit = robot.angle_unit(joint) if side == TRANSMISSION else robot.torque_unit(joint)
    candidate = found.candidates[c]
    number, name = candidate.number, effect_name(candidate.kind)
    name = name if number is None else number_phrase(found.hypothesis.given, number.of, number.parameter)
    trace = ResidualTrace.thinned(
        f"{capital(name)}: {joint}, {SIDE_OF_EQUATION[side]}", label, f"residual [{unit}]", x, own + left, left
    )
    whole, more, less = (float((rows.white(at) ** 2).sum()) for at in (rows.given, without, after))
    line = _averaged_line(x, own, LAW_POINTS if curve else LAW_BINS)
    return dataclasses.replace(trace, law=line, note=note, explains=(more - less) / max(whole, 1e-300))


def _quantities_of_laws(at: Equations, k: int) -> list[tuple[str, Array]]:
    """What a law may depend on, with its unit (rows of an equation,): of the equation's own joint first."""
    j, side = at.kinds[k]
    names, robot = at.true.joint_names, at.true.robot
    link = side in (LINK, SENSOR, TRANSMISSION)
    angle = robot.angle_unit(names[j])
    own = (("v", "/s"), ("q", ""), ("a", "/s^2")) if link else (("omega", "/s"), ("theta", ""), ("alpha", "/s^2"))
    found = [(f"{signal} [{angle}{per}]", at.at_rows(signal)[:, j]) for signal, per in own]
    if at.true.elastic[j]:
        found.append((f"theta-q [{angle}]", at.at_rows("delta")[:, j]))
    found.append((f"torque [{robot.torque_unit(names[j])}]", at.at_rows("tau")[:, j]))
    for i, other in enumerate(names):
        if i != j:
            unit = robot.angle_unit(other)
            found.append((f"v of {other} [{unit}/s]", at.at_rows("v")[:, i]))
            found.append((f"q of {other} [{unit}]", at.at_rows("q")[:, i]))
    return [*found, ("t [s]", at.at_rows("t"))]


def _share(x: Array, y: Array) -> float:
    """Share of the variance of y that its averages over neighbours in x hold, less what chance gives them [1]."""
    total = float(y.var()) * len(y)
    if total <= 0.0:
        return 0.0
    ordered = y[np.argsort(x, kind="stable")]
    within = sum(float(((part - part.mean()) ** 2).sum()) for part in np.array_split(ordered, LAW_BINS))
    return 1.0 - within / total * (len(y) - 1) / max(1, len(y) - LAW_BINS)


def _averaged_line(x: Array, y: Array, count: int) -> Array:
    """Averages over neighbours in x (points, 2), in its order."""
    order = np.argsort(x, kind="stable")
    parts = [part for part in np.array_split(order, min(count, len(x))) if len(part)]
    return np.array([[x[part].mean(), y[part].mean()] for part in parts])
