"""report.html: one complete page, which loads nothing else."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from html import escape
from pathlib import Path

from flexdyn.diagnose.report.apart import errors, gap, left, residuals, where
from flexdyn.diagnose.report.calibrated import calibration
from flexdyn.diagnose.report.compared import structures
from flexdyn.diagnose.report.done import data, fit
from flexdyn.diagnose.report.found import findings
from flexdyn.diagnose.report.head import head, tail
from flexdyn.diagnose.report.material import notes, plans
from flexdyn.diagnose.report.motions import motion_figures, motions
from flexdyn.diagnose.report.parted import shares
from flexdyn.diagnose.report.pictures import experiment_figure, residual_figure
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.errors import MissingExtra

HERE = Path(__file__).parent
PARTS = (
    head,
    gap,
    errors,
    motions,
    findings,
    shares,
    residuals,
    left,
    where,
    calibration,
    fit,
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
    content, laws = _without_pictures("\n".join(part(diagnosis) for part in PARTS))
    figures = _figures(diagnosis)
    library, script = (get_plotlyjs() if figures else ""), _own("page.js")
    # The script unpacks the library and runs it as an element of its own, whose text must have this hash.
    hashes = " ".join(f"'sha256-{_sha256(text)}'" for text in (library, script))
    kind = "Interrupted diagnosis" if diagnosis.verdict == "interrupted" else "Diagnosis"
    filled = {
        "POLICY": f"{POLICY}; script-src {hashes}",
        "TITLE": escape(f"{kind} of {diagnosis.model.name}"),
        "STYLE": _own("page.css"),
        "CONTENT": content,
        "FIGURES": _packed(json.dumps({"figures": figures, "laws": laws}, allow_nan=False)),
        "PLOTLY": _packed(library),
        "SCRIPT": script,
    }
    return re.sub(r"\{\{([A-Z]+)\}\}", lambda hole: filled[hole[1]], _own("page.html"))


def _without_pictures(content: str) -> tuple[str, list[str]]:
    """The page with places for the pictures of laws, and these as SVG text: packed, they take a tenth of the room."""
    pictures: list[str] = []

    def place(found: re.Match[str]) -> str:
        pictures.append(base64.b64decode(found[1]).decode("utf-8"))
        return f'data-law="{len(pictures) - 1}"'

    return re.sub(r'src="data:image/svg\+xml;base64,([^"]+)"', place, content), pictures


def _figures(diagnosis: Diagnosis) -> dict[str, object]:
    """What the page's script draws, by the room that it stands in."""
    traces: dict[str, object] = {"motion": motion_figures(diagnosis)} if diagnosis.trajectories else {}
    traces |= {f"trace-{k}": residual_figure(trace) for k, trace in enumerate(diagnosis.residuals)}
    plans = ((k, finding.plan) for k, finding in enumerate(diagnosis.findings))
    return traces | {f"plan-{k}": experiment_figure(plan) for k, plan in plans if plan is not None}


def _own(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def _packed(text: str) -> str:
    """Text of a third of the length, in letters that no HTML parser can take for markup."""
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")


def _sha256(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
