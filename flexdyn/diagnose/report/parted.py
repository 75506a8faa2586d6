"""Part of report.html: shares of the gap that add up."""

from __future__ import annotations

from html import escape

from flexdyn.diagnose.report.digits import percent
from flexdyn.diagnose.report.html import bar, section, soft, table
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.words import capital, finding_phrase, plain_phrase


def shares(diagnosis: Diagnosis) -> str:
    """What goes with each step from the model as given to the corrected one, and what is left."""
    given = diagnosis.shares
    if given is None:
        return ""
    entries = [("numbers of the model file, calibrated", given.calibration, "between")]
    for finding, share in zip(diagnosis.findings, given.findings, strict=True):
        entries.append((plain_phrase(finding_phrase(diagnosis.model, finding)), share, "after"))
    entries.append(("left by the corrected model", given.left, "amber"))
    rows = [
        [escape(capital(name)), f'<div class="share">{bar(max(share, 0.0), 1.0, colour, percent(share))}</div>']
        for name, share, colour in entries
    ]
    rows.append(["<b>sum</b>", f"<b>{percent(given.calibration + sum(given.findings) + given.left)}</b>"])
    said = (
        "Of the sum of squares of what the equations leave on the test data, in units of noise. The model"
        " improves step by step, so these shares add up. In another order of the steps, effects that resemble each"
        f" other would share differently. Noise alone leaves {percent(given.noise)}."
    )
    shown = table(("step", "share that goes with it"), rows, name="shares")
    return section("Shares of the gap", shown + soft(said), "shares")
