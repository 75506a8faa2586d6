"""Parts of report.html: how far model and measurement are apart, where, and what is left."""

from __future__ import annotations

import math
from html import escape

from flexdyn.diagnose.report.digits import percent, rounded, times
from flexdyn.diagnose.report.html import along, bar, folded, section, soft, table
from flexdyn.diagnose.report.measures import Gap, JointError, Left
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.words import place_phrase

COLOURS = ("before", "between", "after")
PICTURES = 6
"""Pictures of residuals that stand open; the others are folded away."""

OPEN_PICTURE_SHARE = 0.01
"""Share of the squared residuals that a picture explains at least to stand open [1]."""


def gap(diagnosis: Diagnosis) -> str:
    """The gap as bars, on both kinds of data on one scale."""
    given = (
        ("On the test data, which no decision read", diagnosis.gap_test),
        ("On the data of the fit", diagnosis.gap_fit),
    )
    groups = [(title, entry) for title, entry in given if entry is not None]
    if not groups:
        return ""
    numbers = [value for _, entry in groups for value in vars(entry).values() if math.isfinite(value)]
    scale = max(numbers, default=1.0) or 1.0
    shown = "".join(_gap_bars(title, entry, scale) for title, entry in groups)
    forced = any(entry.force for entry in diagnosis.errors.values())
    said = (
        "A test rig prescribes the motion, so the gap is that of the forces: root mean square of what the equations"
        " leave, divided by what noise alone makes there. A perfect model reaches the dashed line."
        if forced
        else "Root mean square of simulated minus measured positions over windows of 0.5 s, divided by what noise alone"
        " makes there: sensor noise, torque noise carried through the simulation, and the uncertain first state. A"
        " perfect model reaches the dashed line."
    )
    return section("How far model and measurement are apart", f'<div class="pair">{shown}</div>{soft(said)}', "gap")


def _gap_bars(title: str, entry: Gap, scale: float) -> str:
    floor = f'<i class="floor" style="left:{along(entry.floor, scale)}"></i>' if math.isfinite(entry.floor) else ""
    stages = (("as given", entry.before), ("calibrated", entry.calibrated), ("corrected", entry.after))
    rows = "".join(
        f"<span>{name}</span>{bar(value, scale, colour, times(value), floor)}"
        for (name, value), colour in zip(stages, COLOURS, strict=True)
    )
    floor_text = f"dashed: noise alone, {times(entry.floor)}" if floor else ""
    return f'<div><h4>{title}</h4><div class="bars">{rows}</div><p class="soft mark">{floor_text}</p></div>'


def errors(diagnosis: Diagnosis) -> str:
    """Errors of every joint on the test data in physical units, before and after."""
    if not diagnosis.errors:
        return ""
    shares = [x for e in diagnosis.errors.values() for x in (e.torque_share_before, e.torque_share_after)]
    scale = max((share for share in shares if math.isfinite(share)), default=1.0) or 1.0
    rows = [_error(joint, entry, scale) for joint, entry in diagnosis.errors.items()]
    heads = (
        "joint",
        "torque error,<br>before &rarr; after",
        "share of the joint's torque",
        "position error,<br>before &rarr; after",
        "the same in units<br>of noise",
    )
    said = (
        "Root mean squares on the test data. Torque: what the model's inverse dynamics does not explain, and its share"
        " of the joint's torque. Position: simulated without feedback over windows of 0.5 s, in its unit and"
        " in units of what noise alone makes there. Before: the model as given; after: the corrected model."
    )
    return section("Errors per joint", table(heads, rows, name="errors") + soft(said), "errors")


def _error(joint: str, entry: JointError, scale: float) -> list[str]:
    shares = "".join(
        bar(share, scale, colour, percent(share))
        for share, colour in ((entry.torque_share_before, "before"), (entry.torque_share_after, "after"))
    )
    torque = _change(entry.torque_before, entry.torque_after, entry.torque_unit)
    position = _change(entry.position_before, entry.position_after, entry.position_unit)
    if entry.force:
        position = "prescribed"
    noise = f"{times(entry.gap[0])} &rarr; <b>{times(entry.gap[-1])}</b>" if entry.gap else "not simulated"
    return [escape(joint), torque, f'<div class="share">{shares}</div>', position, noise]


def _change(before: float, after: float, unit: str) -> str:
    return f"{rounded(before)} &rarr; <b>{rounded(after)}</b> {escape(unit)}"


def left(diagnosis: Diagnosis) -> str:
    """What the corrected model leaves unexplained, joint by joint."""
    if not diagnosis.left:
        return ""
    ordered = sorted(diagnosis.left, key=_share, reverse=True)
    scale = max(_share(ordered[0]), 0.01)
    rows = [
        [
            escape(entry.joint),
            f'<div class="share">{bar(entry.share_of_torque, scale, "amber", percent(entry.share_of_torque))}</div>',
            f"{rounded(entry.correlation_time, 2)} s",
            escape(", ".join(entry.depends_on) or "no dependence found"),
        ]
        for entry in ordered
    ]
    heads = ("joint", "share of the joint's torque", "correlation time", "changes with")
    said = (
        "Beyond noise, after the correction. The correlation time says how long it keeps its value: if that is much"
        " longer than a sample, it is no sensor noise."
    )
    return section("What is left", table(heads, rows, name="left") + soft(said), "left")


def _share(entry: Left) -> float:
    return entry.share_of_torque if math.isfinite(entry.share_of_torque) else 0.0


def where(diagnosis: Diagnosis) -> str:
    """In which joint's which equation the residual appears, and in which regime."""
    if not diagnosis.where:
        return ""
    rows = [
        [
            escape(place_phrase(place.joint, place.side)),
            f'<div class="share">{bar(place.share, 1.0, "between", percent(place.share))}</div>',
            escape(place.regime or "everywhere"),
        ]
        for place in diagnosis.where
    ]
    said = (
        "Of the calibrated model, before the findings were added. This is where the residual is seen; its cause may lie"
        " elsewhere: joints are coupled through the arm, and motor and link through the spring."
    )
    heads = ("equation", "share of what is beyond noise", "stands out for")
    return section("The residual appears in", table(heads, rows, name="places") + soft(said), "where")


def shown_at_once(diagnosis: Diagnosis) -> int:
    """Pictures that stand open: at most six, and at least two; none else that explains next to nothing."""
    telling = [k for k, each in enumerate(diagnosis.residuals) if not each.explains < OPEN_PICTURE_SHARE]
    return min(PICTURES, max(2, telling[-1] + 1 if telling else 0), len(diagnosis.residuals))


def residuals(diagnosis: Diagnosis) -> str:
    """Room for the pictures, which the page's script draws."""
    if not diagnosis.residuals:
        return ""
    rooms = [
        f'<figure><h4>{escape(trace.title)}</h4><div id="trace-{k}" data-picture></div>'
        f"<figcaption>{escape(trace.note)}</figcaption></figure>"
        for k, trace in enumerate(diagnosis.residuals)
    ]
    most = shown_at_once(diagnosis)
    shown = f'<div class="figures">{"".join(rooms[:most])}</div>'
    if rooms[most:]:
        more = f'<div class="figures">{"".join(rooms[most:])}</div>'
        shown += folded(f"{len(rooms) - most} more, which explain less", more)
    key = (
        '<p><i class="key" style="--colour:var(--before)"></i>before '
        '&emsp;<i class="key" style="--colour:var(--after)"></i>after: the corrected model</p>'
    )
    first = "The pictures that explain most come first."
    if not diagnosis.findings:
        first = "The equations in which most is left come first."
    said = (
        f"{first} Of a law that was found, before is the corrected model without that"
        " one effect, and the black line is the law along the measured motion. Of an equation, before is the model as"
        " given. What is left should look like noise, whatever it is drawn over; lines through dots are averages."
    )
    return section("Residuals before and after", key + soft(said) + shown, "residuals")
