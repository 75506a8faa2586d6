"""The residual against what a found law depends on, before and after, with the law drawn through it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.equations.covariance import Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, SENSOR, TRANSMISSION
from flexdyn.diagnose.equations.localise import SIDES
from flexdyn.diagnose.report.trace import ResidualTrace
from flexdyn.diagnose.report.words import capital, effect_name

CURVE_VARIANCE_SHARE = 0.9
"""Share of a law's variance that one quantity must explain for the law to be a curve over it [1]."""
EQUAL_SHARE_DIFFERENCE = 0.02
"""Shares that differ by less are equal: the first quantity of the list is taken."""
LAW_BINS = 60
"""Averages by which quantities are compared."""
LAW_POINTS = 240
"""Points of a drawn law."""


def laws_seen(
    before: Equations, after: Equations, whiten: Whitener, found: Corrected, named: Sequence[Name]
) -> tuple[ResidualTrace, ...]:
    """A picture of every name, in the equation in which its law does most.

    Before is the corrected model without this one effect, after is the corrected model (a partial residual plot:
    Larsen and McCleary, Technometrics 14, 1972). The difference of the two is what the law does along the measured
    motion; it is drawn over the quantity that explains most of its variance.

    Args:
        before: equations of the model as given.
        after: of the corrected model, over the same recordings.
        whiten: by the sensors' noise.
        found: the corrected model.
        named: the names that are reported.
    """
    whole = float((whiten(before.residual) ** 2).sum())
    pictures = []
    for name in named:
        without = before.of(found.without(name.candidate).seen())
        made = _picture(without, after, whiten, found.candidates[name.candidate].kind)
        if made is not None:
            trace, gone = made
            pictures.append(dataclasses.replace(trace, explains=gone / max(whole, 1e-300)))
    return tuple(pictures)


def _picture(without: Equations, after: Equations, whiten: Whitener, kind: str) -> tuple[ResidualTrace, float] | None:
    many = len(after.kinds)
    law = without.residual - after.residual
    power = (whiten(law).reshape(-1, many) ** 2).sum(axis=0)
    if not power.any():
        return None
    k = int(power.argmax())
    clear = ~whiten.mask.reshape(-1, many)[:, k]
    rows, left = law.reshape(-1, many)[clear, k], after.residual.reshape(-1, many)[clear, k]
    if len(rows) < 2 * LAW_BINS:
        return None
    known = [(label, values[clear]) for label, values in _quantities(after, k)]
    shares = [_share(values, rows) for _, values in known]
    best = next(place for place, share in enumerate(shares) if share >= max(shares) - EQUAL_SHARE_DIFFERENCE)
    label, x = known[best]
    curve = shares[best] >= CURVE_VARIANCE_SHARE
    note = "" if curve else f"The law depends on more than {label.partition(' ')[0]}: its line is an average."
    j, side = after.kinds[k]
    joint, robot = after.true.joint_names[j], after.true.robot
    unit = robot.angle_unit(joint) if side == TRANSMISSION else robot.torque_unit(joint)
    trace = ResidualTrace.thinned(
        f"{capital(effect_name(kind))}: {joint}, {SIDES[side]}", label, f"residual [{unit}]", x, rows + left, left
    )
    gone = float((whiten(without.residual) ** 2).sum() - (whiten(after.residual) ** 2).sum())
    return dataclasses.replace(trace, law=_line(x, rows, LAW_POINTS if curve else LAW_BINS), note=note), gone


def _quantities(at: Equations, k: int) -> list[tuple[str, Array]]:
    """What a law may depend on, with its unit (rows of an equation,): of the equation's own joint first."""
    j, side = at.kinds[k]
    names, robot = at.true.joint_names, at.true.robot
    link = side in (LINK, SENSOR, TRANSMISSION)
    places = [at.filters.instants(len(along.t)) for along in at.motions]

    def column(signal: str, i: int) -> Array:
        pairs = zip(at.motions, places, strict=True)
        return np.concatenate([np.asarray(getattr(along, signal))[rows, i] for along, rows in pairs])

    angle = robot.angle_unit(names[j])
    own = (("v", "/s"), ("q", ""), ("a", "/s^2")) if link else (("omega", "/s"), ("theta", ""), ("alpha", "/s^2"))
    found = [(f"{signal} [{angle}{per}]", column(signal, j)) for signal, per in own]
    if at.true.elastic[j]:
        found.append((f"theta-q [{angle}]", column("delta", j)))
    found.append((f"torque [{robot.torque_unit(names[j])}]", column("tau", j)))
    for i, other in enumerate(names):
        if i != j:
            unit = robot.angle_unit(other)
            found.append((f"v of {other} [{unit}/s]", column("v", i)))
            found.append((f"q of {other} [{unit}]", column("q", i)))
    times = [along.t[rows] for along, rows in zip(at.motions, places, strict=True)]
    return [*found, ("t [s]", np.concatenate(times))]


def _share(x: Array, y: Array) -> float:
    """Share of the variance of y that its averages over neighbours in x hold, less what chance gives them [1]."""
    total = float(y.var()) * len(y)
    if total <= 0.0:
        return 0.0
    ordered = y[np.argsort(x, kind="stable")]
    within = sum(float(((part - part.mean()) ** 2).sum()) for part in np.array_split(ordered, LAW_BINS))
    return 1.0 - within / total * (len(y) - 1) / max(1, len(y) - LAW_BINS)


def _line(x: Array, y: Array, count: int) -> Array:
    """Averages over neighbours in x (points, 2), in its order."""
    order = np.argsort(x, kind="stable")
    parts = [part for part in np.array_split(order, min(count, len(x))) if len(part)]
    return np.array([[x[part].mean(), y[part].mean()] for part in parts])
