"""report.html: one page with everything in it, which asks nobody for anything."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from html import escape
from pathlib import Path

from flexdyn.diagnose.report.apart import errors, gap, left, residuals, where
from flexdyn.diagnose.report.calibrated import calibration
from flexdyn.diagnose.report.compared import structures
from flexdyn.diagnose.report.found import findings
from flexdyn.diagnose.report.head import head, tail
from flexdyn.diagnose.report.material import data, notes, plans
from flexdyn.diagnose.report.pictures import experiment_figure, residual_figure
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.errors import MissingExtra

HERE = Path(__file__).parent
PARTS = (
    head,
    gap,
    errors,
    findings,
    left,
    residuals,
    where,
    calibration,
    structures,
    notes,
    plans,
    data,
    tail,
)
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"


def page(diagnosis: Diagnosis) -> str:
    """The page's text.

    Names of any origin are safe in it: they are escaped, and the browser runs only the scripts whose hashes the page's
    policy names.

    Raises:
        MissingExtra: matplotlib or plotly is not installed.
    """
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise MissingExtra("plotly", "plot") from None
    figures = _figures(diagnosis)
    # `</script` would end the element; in JavaScript text `<\/script` means the same.
    library = get_plotlyjs().replace("</script", "<\\/script") if figures else ""
    script = _own("page.js")
    hashes = " ".join(f"'sha256-{_sha256(text)}'" for text in (library, script))
    filled = {
        "POLICY": f"{POLICY}; script-src {hashes}",
        "TITLE": escape(f"Diagnosis of {diagnosis.model.name}"),
        "STYLE": _own("page.css"),
        "CONTENT": "\n".join(part(diagnosis) for part in PARTS),
        "FIGURES": _json(figures),
        "PLOTLY": library,
        "SCRIPT": script,
    }
    return re.sub(r"\{\{([A-Z]+)\}\}", lambda hole: filled[hole[1]], _own("page.html"))


def _figures(diagnosis: Diagnosis) -> dict[str, dict[str, object]]:
    """What the page's script draws, by the room that it stands in."""
    traces = {f"trace-{k}": residual_figure(trace) for k, trace in enumerate(diagnosis.residuals)}
    plans = ((k, finding.plan) for k, finding in enumerate(diagnosis.findings))
    return traces | {f"plan-{k}": experiment_figure(plan) for k, plan in plans if plan is not None}


def _own(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def _json(figures: dict[str, dict[str, object]]) -> str:
    """JSON that no HTML parser can take for markup."""
    text = json.dumps(figures, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _sha256(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
