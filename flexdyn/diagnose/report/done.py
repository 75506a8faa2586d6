"""Parts of report.html: what was done, on which data, and how well the final fit is determined."""

from __future__ import annotations

from html import escape

from flexdyn.diagnose.report.digits import MINUS, counted, grouped, rounded
from flexdyn.diagnose.report.html import folded, section, soft, table
from flexdyn.diagnose.report.measures import RecordingSpan
from flexdyn.diagnose.report.record import Record, Statistics
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.words import channel_unit

ROLES = {"fit": "fit: estimates and the choice of structures", "test": "test: no decision read it"}
NOISE_CHANNELS_OPEN = 4
"""Channels whose noise is told at once; more are folded away."""
CORRELATED = 10
"""Correlations that stand open; the others are folded away."""


def data(diagnosis: Diagnosis) -> str:
    """Program, command, files, and what each span of the recordings was used for."""
    body = _record(diagnosis.record)
    if diagnosis.data:
        rows = [_source(diagnosis, entry) for entry in diagnosis.data]
        heads = ("recording", "used for", "span", "length", "rate", "channels", "noise, standard deviation")
        body += f"<h4>Spans of the recordings</h4>{table(heads, rows, name='data')}" + soft(
            "Fit: numbers are estimated and structures are compared on the same span. Test: opened once, after"
            " everything was decided, for the verdict, the gap and the errors per joint."
        )
    return section("What was done", body, "data")


def _record(entry: Record) -> str:
    call = f"<code>{escape(entry.command)}</code>" if entry.command else "called from Python"
    told = f'<p class="done">flexdyn {escape(entry.version)}, {escape(_date(entry.date))}: {call}</p>'
    if not entry.files:
        return told
    rows = [
        [escape(each.path), escape(each.use), f"{grouped(each.bytes)} bytes", escape(_date(each.modified))]
        for each in entry.files
    ]
    return told + table(("file", "used for", "size", "last changed"), rows, name="data")


def _date(text: str) -> str:
    """ISO 8601 as it is read: a space between day and time."""
    return text.replace("T", " ")


def _source(diagnosis: Diagnosis, entry: RecordingSpan) -> list[str]:
    channels = "<br>".join(escape(name) for name in entry.channels)
    many = counted(len(entry.channels), "channel")
    return [
        escape(entry.file),
        escape(ROLES[entry.role]),
        f"{entry.start:.6g} to {entry.end:.6g} s",
        f"{entry.end - entry.start:.4g} s" + (f"<br>{grouped(entry.samples)} samples" if entry.samples else ""),
        f"{entry.rate:.6g} Hz",
        f"<details><summary>{many}</summary>{channels}</details>" if channels else "",
        _noise(diagnosis, entry),
    ]


def _noise(diagnosis: Diagnosis, entry: RecordingSpan) -> str:
    levels = [
        f"{name} {rounded(level, 2)} {channel_unit(diagnosis.model, name)}".strip()
        for name, level in entry.noise.items()
    ]
    told = "<br>".join(escape(level) for level in levels)
    if len(levels) > NOISE_CHANNELS_OPEN:
        return f"<details><summary>{counted(len(levels), 'channel')}</summary>{told}</details>"
    return told or '<span class="soft">not estimated</span>'


def fit(diagnosis: Diagnosis) -> str:
    """Statistics of the final fit and correlations of its numbers."""
    given = diagnosis.fit
    if given is None:
        return ""
    lines = "".join(f"<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>" for name, value in _lines(given))
    body = f'<div class="wide"><table class="statistics">{lines}</table></div>'
    if given.correlations:
        rows = [
            [escape(one), escape(other), f"{value:+.3f}".replace("-", MINUS)]
            for one, other, value in given.correlations
        ]
        heads = ("number", "and", "correlation")
        body += f"<h4>Correlations</h4>{table(heads, rows[:CORRELATED], numbers=(2,), name='correlations')}"
        if rows[CORRELATED:]:
            rest = table(heads, rows[CORRELATED:], numbers=(2,), name="correlations")
            body += folded(f"{len(rows) - CORRELATED} more", rest)
        body += soft(
            "Those below 0.1 are left out. If the correlation of two numbers is near 1 or -1, the data determine"
            " a combination of them, and not each by itself."
        )
    return section("Statistics of the final fit", body, "fit")


def _lines(given: Statistics) -> list[tuple[str, str]]:
    """In the order and words of lmfit."""
    return [
        ("fitting method", given.method),
        ("data points", grouped(given.points)),
        ("variables", grouped(given.variables)),
        ("chi-square", rounded(given.chi_square, 6)),
        ("reduced chi-square", rounded(given.reduced, 6)),
        ("Akaike info crit", rounded(given.aic, 6)),
        ("Bayesian info crit", rounded(given.bic, 6)),
    ]
