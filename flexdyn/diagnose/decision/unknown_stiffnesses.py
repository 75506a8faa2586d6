"""First values of unknown stiffnesses: the rows of the same arm with rigid joints are linear in their compliances."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flexdyn.diagnose.constants import SHOWN_DEFLECTION
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.decision.first_regression import FirstRegression
from flexdyn.diagnose.decision.unknown_laws import without_unknown
from flexdyn.diagnose.equations.compliance import of_compliance
from flexdyn.diagnose.equations.layout import TRANSMISSION
from flexdyn.diagnose.hypothesis.unknown_numbers import with_guesses
from flexdyn.diagnose.inference.weights import rows_of
from flexdyn.diagnose.report.digits import value_text
from flexdyn.diagnose.report.suspects import CONFIDENCE
from flexdyn.effects import JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import JOINT_UNITS
from flexdyn.model.stated_tolerances import known_tolerances

STIFFNESS_SPREAD = 100.0
"""Spread of an unknown stiffness, as a share of its first value [1]."""
WEIGHTINGS = 4
"""Number of times that the equations are weighted by what the last regression left."""


def with_stiffnesses(
    model: FlexibleJointModel, data: tuple[Measured, ...]
) -> tuple[FlexibleJointModel, tuple[str, ...]]:
    """The model with a first value and a broad prior for every stiffness that is unknown, or with a rigid joint.

    The joint is taken for rigid, and the linear equations give its compliance 1/K, together with the numbers of the
    file. It stays rigid where only one encoder shows it, or where its deflection is not far above the noise: there the
    noise of the positions is in the slope by K, and a fit would be too sure of a wrong K.

    Args:
        model: its other unknown numbers stay.
        data: of the fit.

    Returns:
        The model, and a note for each joint that is taken for rigid.

    Raises:
        InputError: all rows are masked, or an effect of the file needs the spring of a joint that stays rigid.
    """
    unknown = [name for name, joint in model.joints.items() if joint.given("stiffness").is_unknown]
    seen = [name for name in unknown if data[0].both[model.index(name)]]
    compliances = _compliances(without_unknown(model), unknown, seen, data) if seen else {}
    first: dict[str, object] = {}
    notes = []
    for name in unknown:
        compliance, spread, power = compliances.get(name, (0.0, math.inf, 0.0))
        if power >= SHOWN_DEFLECTION and compliance > 0.0:
            first[name] = {"value": 1.0 / compliance, "tolerance": STIFFNESS_SPREAD / compliance}
            continue
        first[name], told = math.inf, "only one encoder shows it."
        if name in seen:
            least = value_text(1.0 / (max(compliance, 0.0) + CONFIDENCE * spread), 0.0)
            unit = JOINT_UNITS["stiffness"][model.robot.angle_unit(name) == "m"]
            told = f"its encoders hardly show a deflection: it is about {least} {unit} or more."
        notes.append(
            f"The stiffness of {name} was not known, and {told} The joint is taken for rigid, and its elasticity is"
            " sought like any effect that is missing."
        )
    joints = {name: {"stiffness": stiffness} for name, stiffness in first.items()}
    return (model.replace(joints=joints) if joints else model), tuple(notes)


def _compliances(
    model: FlexibleJointModel, unknown: Sequence[str], seen: Sequence[str], data: tuple[Measured, ...]
) -> dict[str, tuple[float, float, float]]:
    """Compliance of joints with both encoders, its standard deviation, and the power of what it does over the noise's.

    Args:
        model: as given, without effects that have unknown numbers.
        unknown: joints of unknown stiffness.
        seen: those of them that have both encoders.
        data: of the fit.
    """
    at = [model.index(name) for name in seen]
    rigid = with_guesses(taken_for_rigid(model, unknown))
    now = FirstRegression.of(rigid, data, lambda equations: [of_compliance(equations, j) for j in at])
    for _ in range(WEIGHTINGS):
        made = now.solved()
        now = now.weighted(made)
    kinds, first = now.space.equations.kinds, now.X.shape[1] - len(seen)
    spread, told = np.sqrt(np.diag(made.covariance)), rows_of(now.space.bare)
    found = {}
    for place, (name, j) in enumerate(zip(seen, at, strict=True), start=first):
        row = kinds.index((j, TRANSMISSION))
        done = float(made.values[place]) * now.X[:, place].reshape(-1, len(kinds))[:, row]
        found[name] = float(made.values[place]), float(spread[place]), float(done @ done) / float(told.count[row])
    return found


def taken_for_rigid(model: FlexibleJointModel, joints: Sequence[str]) -> FlexibleJointModel:
    """The model with these joints rigid, without the effects that need their springs."""
    true = model.resolved()
    kept = [
        each
        for each in true.effects
        if not (isinstance(each, JointEffect) and each.joint in joints)
        or not (each.side == "transmission" or each.takes_load)
    ]
    tolerance = known_tolerances(true.tolerance)
    if isinstance(tolerance, dict):  # effects have other places now
        tolerance = {path: share for path, share in tolerance.items() if not path.startswith("effects[")}
    rigid = {"stiffness": math.inf, "damping": 0.0}
    return true.replace(joints=dict.fromkeys(joints, rigid), effects=kept, tolerance=tolerance)
