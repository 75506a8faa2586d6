"""Parts of report.html: what the data cannot tell, what to measure next, and the data that were used."""

from __future__ import annotations

from html import escape

from flexdyn.diagnose.report.digits import rounded
from flexdyn.diagnose.report.html import section, soft, table
from flexdyn.diagnose.report.measures import Source
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import next_measurements, stopped_sentence
from flexdyn.diagnose.report.words import capital, channel_unit

ROLES = {"fit": "fit", "test": "test: no decision read it"}
FEW = 4
"""Channels whose noise is told at once; more are folded away."""


def notes(diagnosis: Diagnosis) -> str:
    """What the data cannot tell, and what to measure next."""
    stopped = stopped_sentence(diagnosis)
    told = [*([stopped] if stopped else []), *diagnosis.notes]
    said = "".join(f"<li>{escape(note)}</li>" for note in told)
    reservations = f"<ul>{said}</ul>" if said else "<p>Nothing beyond what is said above.</p>"
    wanted = "".join(f"<li>{escape(text)}</li>" for text in next_measurements(diagnosis))
    further = f"<ol>{wanted}</ol>" if wanted else "<p>Nothing: no finding waits for another measurement.</p>"
    return (
        f'<section class="pair" id="notes"><div><h2>What these data cannot tell</h2>{reservations}</div>'
        f"<div><h2>What to measure next</h2>{further}</div></section>"
    )


def plans(diagnosis: Diagnosis) -> str:
    """Room for pictures of what proposed experiments would show."""
    rooms = []
    for k, finding in enumerate(diagnosis.findings):
        plan = finding.plan
        if plan is None:
            continue
        one, other = (escape(name) for name in plan.names)
        rooms.append(
            f'<h4>{capital(one)} or {other}?</h4><p class="soft">Above: {escape(plan.motion)}. Below: what a model with'
            f" {other} would then leave unexplained, its numbers fitted again, if it is {one}; shaded: noise, two"
            f" standard deviations. Over the whole motion it adds up to {plan.apart:.0f} times the noise.</p>"
            f'<div id="plan-{k}" data-picture></div>'
        )
    return section("What the proposed experiment would show", "".join(rooms), "plans") if rooms else ""


def data(diagnosis: Diagnosis) -> str:
    """The recordings and what each span of them was used for."""
    if not diagnosis.data:
        return ""
    rows = [
        [
            escape(entry.file),
            escape(ROLES[entry.role]),
            f"{entry.start:.6g} to {entry.end:.6g} s",
            f"{entry.end - entry.start:.4g} s",
            f"{entry.rate:.6g} Hz",
            _noise(diagnosis, entry),
        ]
        for entry in diagnosis.data
    ]
    heads = ("file", "used for", "span", "length", "rate", "noise, one standard deviation")
    said = (
        "Fit: estimates, and cross-validation by blocks of it. Test: opened once, after everything was decided, for the"
        " verdict, the gap and the errors per joint."
    )
    return section("Data", table(heads, rows, name="data") + soft(said), "data")


def _noise(diagnosis: Diagnosis, entry: Source) -> str:
    levels = [
        f"{name} {rounded(level, 2)} {channel_unit(diagnosis.model, name)}".strip()
        for name, level in entry.noise.items()
    ]
    told = "<br>".join(escape(level) for level in levels)
    if len(levels) > FEW:
        return f"<details><summary>{len(levels)} channels</summary>{told}</details>"
    return told or '<span class="soft">not estimated</span>'
