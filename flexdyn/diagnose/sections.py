"""The parts of report.html, from the verdict to what to measure next; every name in them is escaped."""

from __future__ import annotations

import math
from html import escape

from flexdyn.diagnose.findings_html import finding_article
from flexdyn.diagnose.result import Calibration, Diagnosis, Gap, Number
from flexdyn.diagnose.words import (
    FEW,
    capital,
    causes,
    counted,
    estimate_text,
    gap_sentence,
    gap_stages,
    next_measurements,
    number_phrase,
    place_phrase,
    relative,
    times,
    verdict_sentence,
)

TAGS = {"no_discrepancy": "no discrepancy", "explained": "explained", "unexplained": "unexplained"}
COLOURS = ("before", "between", "after")
NOTHING, BEYOND = "0%", "55%"
"""Lengths of bars without a number: room is left for the words behind them."""
SHOWN = 12
"""Rows of the calibration that stand open; the others are folded away."""
LIMIT = 3.0
"""Tolerances by which a number may move and be calibrated."""
EDGE = 3.2
"""Half the width of a calibration's picture, in tolerances."""


def head(diagnosis: Diagnosis) -> str:
    """The verdict in a sentence, all causes where it does not name them, and the gap."""
    phrases = causes(diagnosis)
    entries = "".join(f"<li>{escape(phrase)}</li>" for phrase in phrases)
    named = f"<ol>{entries}</ol>" if len(phrases) > FEW else ""
    return (
        f'<header class="{escape(diagnosis.verdict)}"><div class="of"><span class="tag">'
        f"{escape(TAGS.get(diagnosis.verdict, diagnosis.verdict))}</span>"
        f"<span>Diagnosis of {escape(diagnosis.model.name)}</span></div>"
        f'<h1 id="verdict">{escape(verdict_sentence(diagnosis))}</h1>'
        f'{named}<p class="lead">{escape(gap_sentence(diagnosis))}</p></header>'
    )


def gap(diagnosis: Diagnosis) -> str:
    """The gap as bars, on both kinds of data on one scale."""
    given = (("On data not used in the fit", diagnosis.check), ("On the data of the fit", diagnosis.fit))
    groups = [(title, entry) for title, entry in given if entry is not None]
    if not groups:
        return ""
    numbers = [value for _, entry in groups for value in vars(entry).values() if math.isfinite(value)]
    scale = max(numbers, default=1.0) or 1.0
    shown = "".join(_gap_bars(title, entry, scale) for title, entry in groups)
    return (
        f'<section><h2>How far model and measurement are apart</h2><div class="pair">{shown}</div>'
        '<p class="soft">Simulated against measured positions over windows of 0.5 s (root mean square), in units of'
        " what sensor and torque noise alone make there. A perfect model reaches the dashed line.</p></section>"
    )


def _gap_bars(title: str, entry: Gap, scale: float) -> str:
    rows = []
    floor = f'<i class="floor" style="left:{_percent(entry.floor, scale)}"></i>' if math.isfinite(entry.floor) else ""
    for (name, value), colour in zip(gap_stages(entry), COLOURS, strict=True):
        bar = _bar(value, scale, colour, times(value), floor)
        rows.append(f"<span>{name}</span>{bar}")
    floor_text = f"dashed: noise alone, {times(entry.floor)}" if floor else ""
    return f'<div><h4>{title}</h4><div class="bars">{"".join(rows)}</div><p class="soft mark">{floor_text}</p></div>'


def _bar(value: float, scale: float, colour: str, text: str, mark: str = "") -> str:
    """A bar, its number behind it."""
    width = _percent(value, scale) if math.isfinite(value) else NOTHING if math.isnan(value) else BEYOND
    return (
        f'<div class="track">{mark}<div class="bar" style="width:{width};--colour:var(--{colour})"></div>'
        f'<span style="left:{width}">{escape(text)}</span></div>'
    )


def _percent(value: float, scale: float) -> str:
    """Of a track's width; the last part of it is left for the number."""
    return f"{84.0 * min(max(value / scale, 0.0), 1.0):.2f}%"


def where(diagnosis: Diagnosis) -> str:
    """Which joint's which equation held the gap, and in which regime."""
    if not diagnosis.where:
        return ""
    rows = "".join(
        f"<tr><td>{escape(place_phrase(place.joint, place.side))}</td>"
        f'<td class="share">{_bar(place.share, 1.0, "after", _share(place.share))}</td>'
        f"<td>{escape(place.regime or 'everywhere')}</td></tr>"
        for place in diagnosis.where
    )
    return (
        '<section><h2>Where the gap was</h2><div class="wide"><table><tr><th style="width:34%">where</th>'
        f'<th style="width:32%">share of the gap</th><th>stands out for</th></tr>{rows}</table></div></section>'
    )


def findings(diagnosis: Diagnosis) -> str:
    """Every finding: what, how much, and why this name."""
    if not diagnosis.findings:
        return ""
    title = "What was found" if len(diagnosis.findings) > 1 else "What was found, and why it has this name"
    shown = "".join(finding_article(diagnosis.model, k, entry) for k, entry in enumerate(diagnosis.findings, start=1))
    return f"<section><h2>{title}</h2>{shown}</section>"


def calibration(diagnosis: Diagnosis) -> str:
    """Numbers that moved within their tolerance, those that moved farthest first."""
    if not diagnosis.calibration:
        return ""
    ordered = sorted(diagnosis.calibration, key=_drift, reverse=True)
    top = "<tr><th>number</th><th>factor</th><th>change</th><th>in its tolerances, 95 % interval</th></tr>"
    rows = [_calibrated(diagnosis, entry) for entry in ordered]
    shown = f'<div class="wide"><table>{top}{"".join(rows[:SHOWN])}</table></div>'
    if rows[SHOWN:]:
        rest = f'<div class="wide"><table>{top}{"".join(rows[SHOWN:])}</table></div>'
        shown += f"<details><summary>{len(rows) - SHOWN} more, which moved less</summary>{rest}</details>"
    beyond = sum(_drift(entry) > LIMIT for entry in ordered)
    said = "They moved no farther than their stated tolerance lets them, so they are no findings."
    if beyond:
        said = (
            f"{counted(beyond, 'number')} went beyond what the stated tolerance lets them, bent by what is left"
            " unexplained; the others are within it. None of them is a finding."
        )
    return (
        "<section><h2>Numbers of the model that were calibrated</h2>"
        f'<p class="soft">{said} true = factor &times; given.</p>{shown}</section>'
    )


def _drift(entry: Calibration) -> float:
    size = abs(entry.factor - 1.0) / entry.tolerance if entry.tolerance > 0.0 else abs(entry.factor - 1.0)
    return size if math.isfinite(size) else 0.0


def _calibrated(diagnosis: Diagnosis, entry: Calibration) -> str:
    name = number_phrase(diagnosis.model, entry.of, entry.parameter)
    held = entry.tolerance <= 0.0 or entry.std < LIMIT * entry.tolerance
    factor = estimate_text(Number(entry.factor, entry.std, "1")) if held else "not held by these data"
    tolerance = f'<span class="soft">\N{PLUS-MINUS SIGN}{100.0 * entry.tolerance:.3g} %</span>'
    return (
        f'<tr><td>{escape(name)} {tolerance}</td><td class="n">{factor}</td>'
        f'<td class="n">{relative(entry.factor)}</td><td>{_drift_picture(entry)}</td></tr>'
    )


def _drift_picture(entry: Calibration) -> str:
    """A dot with its interval on an axis from -3 to 3 tolerances."""
    if not (entry.tolerance > 0.0 and math.isfinite(entry.factor)):
        return ""
    centre = (entry.factor - 1.0) / entry.tolerance
    half = 1.96 * entry.std / entry.tolerance if math.isfinite(entry.std) else 0.0
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


def residuals(diagnosis: Diagnosis) -> str:
    """Room for the pictures, which the page's script draws."""
    if not diagnosis.residuals:
        return ""
    rooms = "".join(f'<div id="trace-{k}"></div>' for k in range(len(diagnosis.residuals)))
    return (
        "<section><h2>What the model leaves unexplained</h2><p>"
        '<i class="key" style="--colour:var(--before)"></i>model as given '
        '&emsp;<i class="key" style="--colour:var(--after)"></i>corrected model</p>'
        '<p class="soft">What is left should look like noise, whatever it is drawn over. Lines through dots are'
        " averages: before, they show the law that was missing.</p>"
        f'<div class="figures">{rooms}</div></section>'
    )


def notes(diagnosis: Diagnosis) -> str:
    """What the data cannot tell, and what to measure next."""
    said = "".join(f"<li>{escape(note)}</li>" for note in diagnosis.notes)
    reservations = f"<ul>{said}</ul>" if said else "<p>Nothing beyond what is said above.</p>"
    wanted = "".join(f"<li>{escape(text)}</li>" for text in next_measurements(diagnosis))
    further = f"<ol>{wanted}</ol>" if wanted else "<p>Nothing: the answer does not hang on another measurement.</p>"
    return (
        f'<section class="pair"><div><h2>What these data cannot tell</h2>{reservations}</div>'
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
            f'<div id="plan-{k}"></div>'
        )
    if not rooms:
        return ""
    return f"<section><h2>What the proposed experiment would show</h2>{''.join(rooms)}</section>"


def tail(diagnosis: Diagnosis) -> str:
    """Where the corrected model is, and how long it took."""
    took = f" The diagnosis took {diagnosis.seconds:.0f} s." if diagnosis.seconds >= 1.0 else ""
    return (
        "<footer>Beside this page: <code>model.yaml</code>, the corrected model (<code>flexdyn simulate"
        f" model.yaml -o run.h5</code>), and <code>report.json</code>, the same for programs.{took}</footer>"
    )


def _share(share: float) -> str:
    return f"{100.0 * share:.0f} %" if math.isfinite(share) else "unknown"
