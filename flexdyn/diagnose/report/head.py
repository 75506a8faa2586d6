"""Top and foot of report.html: the verdict, what it says in numbers, what lies beside the page."""

from __future__ import annotations

from html import escape

from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import error_sentence, finding_sentences, gap_sentence, model_sentence
from flexdyn.diagnose.report.verdicts import FINDINGS_IN_ONE_SENTENCE, verdict_sentence

TAGS = {
    "no_discrepancy": "no discrepancy",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "unexplained",
    "not_converged": "not converged",
    "interrupted": "interrupted",
}


def head(diagnosis: Diagnosis) -> str:
    """The verdict in a sentence, all findings where it does not name them, the gap and the worst joint."""
    tag = f'<span class="tag">{escape(TAGS[diagnosis.verdict])}</span>'
    stop = ""
    if diagnosis.verdict == "interrupted":
        stop, tag = '<p class="stop">INTERRUPTED</p>', ""
    entries = "".join(f"<li>{escape(text)}</li>" for text in finding_sentences(diagnosis))
    unsure = any(finding.rivals for finding in diagnosis.findings)
    named = f"<ul>{entries}</ul>" if len(diagnosis.findings) > FINDINGS_IN_ONE_SENTENCE or unsure else ""
    numbers = " ".join(text for text in (gap_sentence(diagnosis), error_sentence(diagnosis)) if text)
    lead = escape(numbers).replace(" %", "&nbsp;%")
    missing = model_sentence(diagnosis)
    warning = f'<p class="warn">{escape(missing)}</p>' if missing else ""
    return (
        f'<header class="{diagnosis.verdict}">{stop}<div class="of">{tag}'
        f"<span>Diagnosis of {escape(diagnosis.model.name)}</span></div>"
        f'<h1 id="verdict">{escape(verdict_sentence(diagnosis))}</h1>'
        f'{named}<p class="lead">{lead}</p>{warning}</header>'
    )


def tail(diagnosis: Diagnosis) -> str:
    """Where the corrected model is, and how long it took."""
    took = f" The diagnosis took {diagnosis.seconds:.0f} s." if diagnosis.seconds >= 1.0 else ""
    what = "what was known of the corrected model" if diagnosis.verdict == "interrupted" else "the corrected model"
    play = "<code>flexdyn simulate model.yaml -o run.h5</code>"
    model = f"<code>model.yaml</code>, {what} ({play}), and " if diagnosis.write_model else ""
    missing = model_sentence(diagnosis)
    return (
        f"<footer>Beside this page: {model}<code>report.json</code>, the same for programs."
        f"{f' {escape(missing)}' if missing else ''}{took} Why an effect was named, or was not:"
        " <code>flexdyn diagnose ... --explain EFFECT@JOINT</code>.</footer>"
    )
