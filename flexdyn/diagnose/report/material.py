"""Parts of report.html: what the data cannot tell and what to measure next."""

from __future__ import annotations

from html import escape

from flexdyn.diagnose.report.html import section
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import next_measurements, stopped_sentence
from flexdyn.diagnose.report.words import capital


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
