"""Part of report.html: numbers of the model that moved within their tolerance."""

from __future__ import annotations

import math
from dataclasses import replace
from html import escape

from flexdyn.diagnose.report.digits import counted, interval_text, relative, rounded, unit_text, value_text
from flexdyn.diagnose.report.html import folded, section, soft, table
from flexdyn.diagnose.report.measures import Calibration
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import CONFIDENCE, Number
from flexdyn.diagnose.report.words import number_phrase
from flexdyn.effects import unit_for
from flexdyn.effects.model_error import effect_place
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import OF_MOTOR

CALIBRATED_ROWS_OPEN = 12
"""Rows that stand open; the others are folded away."""
LIMIT = 3.0
"""Tolerances by which a number may move and be calibrated (contract, section 8)."""
FACTOR = "1"
"""Unit of a number that is told by its factor alone."""
UNITS = {
    "rotor_inertia": ("kg m^2", "kg"),
    "stiffness": ("N m/rad", "N/m"),
    "damping": ("N m s/rad", "N s/m"),
    "torque_constant": ("N m/A", "N m/A"),
    "resistance": ("ohm", "ohm"),
}
"""Of a joint's numbers, where it turns and where it slides."""
EDGE = 3.2
"""Half the width of a number's picture, in tolerances."""
HEADS = ("number", "given", "estimate", "standard error", "95 % interval", "change", "the same in its tolerances")


def calibration(diagnosis: Diagnosis) -> str:
    """All of them, those that moved farthest first."""
    if not diagnosis.calibration:
        return ""
    ordered = sorted(diagnosis.calibration, key=_displacement, reverse=True)
    rows = [_row(diagnosis, entry) for entry in ordered]
    shown = table(HEADS, rows[:CALIBRATED_ROWS_OPEN], name="calibration")
    if rows[CALIBRATED_ROWS_OPEN:]:
        rest = table(HEADS, rows[CALIBRATED_ROWS_OPEN:], name="calibration")
        shown += folded(f"{len(rows) - CALIBRATED_ROWS_OPEN} more, which moved less", rest)
    beyond = sum(_displacement(entry) > LIMIT for entry in ordered)
    said = f"They moved by no more than {LIMIT:g} of their stated tolerances, so they are no findings."
    if beyond:
        said = (
            f"{counted(beyond, 'number')} moved by more than {LIMIT:g} of the stated tolerances but is no finding:"
            " what is left unexplained may have changed it."
        )
    return section(
        "Numbers of the model that were calibrated",
        soft(f"{said} Behind each name: its stated tolerance, one standard deviation.") + shown,
        "calibration",
    )


def _displacement(entry: Calibration) -> float:
    size = abs(entry.factor - 1.0) / entry.tolerance if entry.tolerance > 0.0 else abs(entry.factor - 1.0)
    return size if math.isfinite(size) else 0.0


def _row(diagnosis: Diagnosis, entry: Calibration) -> list[str]:
    name = number_phrase(diagnosis.model, entry.of, entry.parameter)
    held = entry.tolerance <= 0.0 or entry.std < LIMIT * entry.tolerance
    value, unit = given_number(diagnosis.model, entry.of, entry.parameter)
    number = estimate(diagnosis.model, entry)
    known = held and math.isfinite(number.std)
    absolute = f"{rounded(entry.tolerance * value, 2)} {unit_text(unit)}"
    width = absolute if entry.is_open else f"{100.0 * entry.tolerance:.3g}\u00a0%"
    tolerance = f'<span class="soft">{escape(width)}</span>'
    given = f"{value_text(value, 0.0)} {unit_text(unit)}".strip() if unit != FACTOR else "factor 1"
    given = "not known" if entry.is_open else given
    return [
        f"{escape(name)} {tolerance}",
        escape(given),
        value_text(number.value, number.std) if known else "not held by these data",
        value_text(number.std, number.std) if known else "",
        interval_text(replace(number, unit="1")) if known else "",
        "" if entry.is_open else relative(entry.factor),
        _picture(entry),
    ]


def estimate(model: FlexibleJointModel, entry: Calibration) -> Number:
    """A calibrated number in its unit.

    Args:
        model: corrected, see `given_number`.
        entry: its factor.
    """
    value, unit = given_number(model, entry.of, entry.parameter)
    return Number(entry.factor * value, entry.std * value, unit)


def given_number(model: FlexibleJointModel, of: str, parameter: str) -> tuple[float, str]:
    """A number of the model file as given, with its unit; of a link's the factor 1, as its URDF has the number.

    Args:
        model: corrected; its joints and effects hold what was given, and parameter errors what became of it.
        of: joint, link or ``effects[i]``.
        parameter: its name.
    """
    value, unit = _number_of(model, of, parameter)
    return (value, unit) if math.isfinite(value) and value != 0.0 else (1.0, FACTOR)


def _number_of(model: FlexibleJointModel, of: str, parameter: str) -> tuple[float, str]:
    place = effect_place(of)
    if place is not None and place < len(model.effects):
        effect = model.effects[place]
        joint = getattr(effect, "joint", None)
        slides = joint is not None and model.robot.angle_unit(joint) == "m"
        for entry in effect.parameters():
            if entry.name == parameter:
                return float(getattr(effect, parameter)), unit_for(str(entry.metadata["unit"]), prismatic=slides)
    if of in model.joint_names and parameter in UNITS:
        joint = model.joints[of]
        holder = joint.actuator.dc_motor if parameter in OF_MOTOR and joint.actuator is not None else joint
        return float(getattr(holder, parameter)), UNITS[parameter][model.robot.angle_unit(of) == "m"]
    if of in model.links and parameter == "link_inertia":
        return model.links[of].value, UNITS["rotor_inertia"][0]
    return math.nan, FACTOR


def _picture(entry: Calibration) -> str:
    """A dot with its interval on an axis from -3 to 3 tolerances."""
    if not (entry.tolerance > 0.0 and math.isfinite(entry.factor)):
        return ""
    centre = (entry.factor - 1.0) / entry.tolerance
    half = CONFIDENCE * entry.std / entry.tolerance if math.isfinite(entry.std) else 0.0
    low, middle, high = (
        100.0 + 100.0 / EDGE * min(max(x, -EDGE), EDGE) for x in (centre - half, centre, centre + half)
    )
    ticks = "".join(
        f'<line x1="{100 + 100 / EDGE * k:.1f}" x2="{100 + 100 / EDGE * k:.1f}" y1="{2 if k == 0 else 6}"'
        f' y2="{18 if k == 0 else 14}" stroke="#9ca3af"/>'
        for k in range(-3, 4)
    )
    return (
        f'<svg class="drift" viewBox="0 0 200 20" role="img" aria-label="{centre:+.1f} tolerances">'
        f'<line x1="2" x2="198" y1="10" y2="10" stroke="#d1d5db"/>{ticks}'
        f'<line x1="{low:.1f}" x2="{high:.1f}" y1="10" y2="10" stroke="#1f4e9c" stroke-width="3"/>'
        f'<circle cx="{middle:.1f}" cy="10" r="4.5" fill="#1f4e9c"/></svg>'
    )
