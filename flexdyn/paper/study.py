"""`flexdyn paper`: the whole study, from the equations to figures, checks and runs for playback."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexdyn.errors import check_installed
from flexdyn.io.files import make_folder, write_text
from flexdyn.paper import style
from flexdyn.paper.arm_end import end_force, tip_deflection
from flexdyn.paper.cases import PaperCases
from flexdyn.paper.chapter import Chapter, Check
from flexdyn.paper.damping import damping
from flexdyn.paper.friction import friction_effect, friction_law
from flexdyn.paper.report import readings, summary_data, summary_text
from flexdyn.paper.responses import responses
from flexdyn.paper.rigid_limit import rigid_limit
from flexdyn.paper.rotor_inertia import rotor_inertia
from flexdyn.paper.verification import verification

CHAPTERS: tuple[tuple[str, Callable[[PaperCases], Chapter]], ...] = (
    ("equations against Pinocchio and SciPy", verification),
    ("friction law, Fig. 1", friction_law),
    ("torque and joint responses, Fig. 4 and 3", responses),
    ("rigid arm as the limit of large K", rigid_limit),
    ("effect of friction, Fig. 5", friction_effect),
    ("growing damping", damping),
    ("rotor inertia", rotor_inertia),
    ("end-effector deflection", tip_deflection),
    ("end-of-arm force", end_force),
)


@dataclass(frozen=True)
class PaperStudy:
    """The results of the study.

    Attributes:
        summary: the content of summary.json.
        checks: every statement with its value and bound.
        files: everything written.
    """

    summary: dict[str, Any]
    checks: tuple[Check, ...]
    files: tuple[Path, ...]

    @property
    def passed(self) -> bool:
        """Whether every check holds."""
        return all(check.passed for check in self.checks)


def run_paper_study(out: Path, *, diagnose: bool = False, progress: Callable[[str], None] | None = None) -> PaperStudy:
    """Reproduce the paper's study on the shipped ``scara_two_link``.

    Writes into `out`, each file completely or not at all: figures as PNG (300 dpi) and PDF, ``summary.md``,
    ``summary.json`` and ``runs/NAME.npz``. Existing files are replaced.

    Args:
        out: the folder; it is created if it does not exist.
        diagnose: whether to hide the arm's friction and let the diagnosis find it; its report goes to ``diagnosis``.
        progress: called with a line when a part begins, and by the diagnosis while it works.

    Returns:
        The study; a check that fails is reported in it, not raised.

    Raises:
        InputError: the folder cannot be made or written.
        MissingExtra: matplotlib is not installed, or plotly, which the report of a diagnosis needs.
    """
    from flexdyn import __version__

    style.require_matplotlib()
    out, say = Path(out), progress or (lambda line: None)
    make_folder(out / "runs")
    parts = [*CHAPTERS, _diagnosis(out, say, len(CHAPTERS) + 1)] if diagnose else CHAPTERS
    cases, chapters, files = PaperCases(), list[Chapter](), list[Path]()
    for place, (title, part) in enumerate(parts, 1):
        say(f"{place} of {len(parts)}: {title}")
        chapter = part(cases)
        chapters.append(chapter)
        files += chapter.files
        for figure in chapter.figures:
            files += style.save_figure(figure, out)
        for name, run in chapter.runs.items():
            files.append(out / "runs" / f"{name}.npz")
            run.save(files[-1])
    read = readings(cases)
    data = summary_data(chapters, read, __version__)
    write_text(out / "summary.json", json.dumps(data, indent=1, allow_nan=False) + "\n")
    write_text(out / "summary.md", summary_text(chapters, read, __version__))
    files += [out / "summary.json", out / "summary.md"]
    return PaperStudy(data, tuple(check for chapter in chapters for check in chapter.checks), tuple(files))


def _diagnosis(out: Path, say: Callable[[str], None], place: int) -> tuple[str, Callable[[PaperCases], Chapter]]:
    """The part that hides friction and finds it; it takes longer than all others."""
    from flexdyn.paper.hidden_friction import FOLDER, hidden_friction

    check_installed("plotly", "plot")
    make_folder(out / FOLDER)
    title = "friction hidden, and found"

    def part(cases: PaperCases) -> Chapter:
        """The chapter, whose stages are told as they come."""
        return hidden_friction(
            cases, out / FOLDER, lambda stage, share: say(f"{place} of {place}: {title}: {stage}, {100 * share:.0f} %")
        )

    return title, part
