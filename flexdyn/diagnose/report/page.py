"""report.html: one complete page, which loads nothing else."""

from __future__ import annotations

import base64
import json
import math
import zlib
from pathlib import Path
from typing import Any

from flexdyn.diagnose.constants import IN_TOLERANCE
from flexdyn.diagnose.report import calibrated, digits, pictures, ranked, sentences, suspects, words
from flexdyn.diagnose.report.document import CONSIDERED
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.effects import catalogue
from flexdyn.errors import needed
from flexdyn.io import html

KNOWN = {
    name: value
    for module in (calibrated, digits, pictures, ranked, sentences, suspects, words)
    for name, value in vars(module).items()
    if not name.startswith("_")
}
"""What templates may call: all that these modules offer."""


def report_page(diagnosis: Diagnosis) -> str:
    """The page's text.

    Names of any origin are safe in it: they are escaped, and the browser runs only the scripts whose hashes the page's
    policy names.

    Raises:
        MissingExtra: plotly is not installed.
    """
    with needed("plotly", "plot"):
        from plotly.offline import get_plotlyjs
    figures = _figures(diagnosis)
    # The script unpacks the library and runs it as an element of its own.
    library = get_plotlyjs() if figures else ""
    script = "".join(Path(__file__).with_name(f"{name}.js").read_text("utf-8") for name in ("looks", "page"))
    kind = "Interrupted diagnosis" if diagnosis.verdict == "interrupted" else "Diagnosis"
    return html.page(
        "diagnose/report/page.html",
        f"{kind} of {diagnosis.model.name}",
        scripts=(library, script),
        figures=_packed(json.dumps(figures, allow_nan=False)),
        library=_packed(library),
        **_known(diagnosis),
    )


def part(diagnosis: Diagnosis, name: str) -> str:
    """One of the parts of the page.

    Args:
        diagnosis: to be shown.
        name: of the part.
    """
    return html.render(f"diagnose/report/{name}.html", **_known(diagnosis))


def _known(diagnosis: Diagnosis) -> dict[str, Any]:
    """All values of the templates."""
    return {
        **KNOWN,
        "CONSIDERED": CONSIDERED,
        "IN_TOLERANCE": IN_TOLERANCE,
        "catalogue": catalogue(),
        "isfinite": math.isfinite,
        "isnan": math.isnan,
        "diagnosis": diagnosis,
        "model": diagnosis.model,
    }


def _figures(diagnosis: Diagnosis) -> dict[str, object]:
    """What the page's script draws, by the id of its element."""
    traces: dict[str, object] = {"motion": pictures.motion_figures(diagnosis)} if diagnosis.trajectories else {}
    traces |= {f"trace-{k}": pictures.residual_figure(trace) for k, trace in enumerate(diagnosis.residuals)}
    traces |= {f"force-{k}": pictures.force_figure(loop) for k, loop in enumerate(diagnosis.loops)}
    plans = ((k, finding.plan) for k, finding in enumerate(diagnosis.findings))
    return traces | {f"plan-{k}": pictures.experiment_figure(plan) for k, plan in plans if plan is not None}


def _packed(text: str) -> str:
    """Text of a third of the length, in letters that no HTML parser can take for markup."""
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")
