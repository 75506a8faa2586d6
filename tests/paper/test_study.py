"""The study end to end: it runs once, and what it writes is looked at from outside."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.image
import numpy as np
import pytest

from flexdyn.errors import InputError, MissingExtra
from flexdyn.paper import Check, PaperStudy, run_paper_study
from flexdyn.paper.chapter import Chapter, checked_statement
from flexdyn.paper.report import summary_data, summary_text
from flexdyn.records import Recording, read_recording

FIGURES = (
    "fig1_friction_law",
    "fig3_joint_responses",
    "fig3_rigid_limit",
    "fig4_torque",
    "fig5_damping",
    "fig5_decay_rates",
    "fig5_friction",
    "end_force",
    "rotor_inertia",
    "tip_deflection",
)
JOINTS = ("shoulder", "elbow")


class Done(NamedTuple):
    """A finished study, its folder and what it said on the way."""

    study: PaperStudy
    out: Path
    lines: list[str]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """The study, written over the leftovers of another."""
    out = tmp_path_factory.mktemp("paper") / "made" / "by_the_study"
    (out / "runs").mkdir(parents=True)
    for stale in ("summary.json", "summary.md", "fig4_torque.png", "runs/fig3_flexible.npz"):
        (out / stale).write_text("stale")
    lines: list[str] = []
    return Done(run_paper_study(out, progress=lines.append), out, lines)


def recording(done: Done, name: str) -> Recording:
    """A run as it was saved."""
    return read_recording(done.out / "runs" / f"{name}.npz")


def columns(rec: Recording, signal: str) -> Any:
    """One signal of both joints (samples, 2)."""
    return np.column_stack([rec[f"{signal}.{joint}"] for joint in JOINTS])


def test_every_check_holds(done: Done) -> None:
    """Each statement's value is within its bound, and each is stated once."""
    assert done.study.passed
    assert all(each.passed and each.value <= each.bound for each in done.study.checks)
    names = [each.name for each in done.study.checks]
    assert len(set(names)) == len(names) >= 20


def test_bounds_are_those_promised(done: Done) -> None:
    """Equations to 1e-11 relative, the smooth motion to 1e-8 rad, the slope to 0.1."""
    bounds = {each.name: each.bound for each in done.study.checks}
    assert sum(bound == 1e-11 for bound in bounds.values()) == 4
    assert bounds["A smooth motion of 5 s equals an independent integration"] == 1e-8
    assert bounds["The distance to the rigid arm falls as 1/K: slope -1"] == 0.1


def test_only_the_files_named_are_left(done: Done) -> None:
    """Everything written is listed, stale files are replaced, nothing half written stays."""
    assert {path for path in done.out.rglob("*") if path.is_file()} == set(done.study.files)
    assert (done.out / "summary.md").read_text(encoding="utf-8").startswith("# The paper's study")


@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_printable(done: Done, name: str) -> None:
    """PNG of a column's or a page's width at 300 dpi, with something drawn in it, and a vector PDF beside it."""
    image = matplotlib.image.imread(done.out / f"{name}.png")
    height, width = image.shape[:2]
    assert width in (1050, 2148)
    assert 700 <= height <= 1300
    ink = (image[..., :3].min(-1) < 0.5).mean()
    assert 0.01 < ink < 0.3
    pdf = (done.out / f"{name}.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-")
    assert b"/FontFile2" in pdf
    assert len(pdf) > 5000


def test_summary_json_is_what_was_found(done: Done) -> None:
    """The file is strict JSON, equals the study's summary, and holds finite numbers only."""
    text = (done.out / "summary.json").read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=lambda constant: pytest.fail(f"{constant} in the summary"))
    assert data == done.study.summary
    assert data["schema"] == "flexdyn.paper/1"
    assert data["passed"] is True
    assert data["checks"] == [dataclasses.asdict(each) for each in done.study.checks]
    numbers = list(_numbers(data))
    assert len(numbers) > 100
    assert all(math.isfinite(number) for number in numbers)


def _numbers(data: Any) -> Iterator[float]:
    if isinstance(data, dict | list):
        for each in data.values() if isinstance(data, dict) else data:
            yield from _numbers(each)
    elif isinstance(data, int | float):
        yield data
    else:
        assert isinstance(data, str)


def test_slope_follows_from_the_distances(done: Done) -> None:
    """The stored distances themselves fall as 1/K between any two stiff arms, and not so at the softest."""
    numbers = done.study.summary["numbers"]["The rigid arm as the limit of stiff joints"]
    K, rms = np.array(numbers["K"]), np.array(numbers["rms_distance_rad"])
    slopes = np.diff(np.log(rms)) / np.diff(np.log(K))
    assert np.abs(slopes[K[:-1] > 500] + 1).max() < 0.02
    assert slopes[0] < -1.5
    assert numbers["slope"] == pytest.approx(-1, abs=0.01)


def test_summary_embeds_every_figure_and_lists_every_run(done: Done) -> None:
    """Every link of the Markdown leads to a file, and every figure and run stands in it."""
    text = (done.out / "summary.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert {link for link in links if link.endswith(".png")} == {f"{name}.png" for name in FIGURES}
    assert all((done.out / link).is_file() for link in links)
    assert all(f"runs/{path.stem}.npz" in text for path in done.study.files if path.suffix == ".npz")
    for word in ("eq. 10", "eq. 11", "eq. 17", "N m/rad", "area moment", "0.63/3.5", "Sgn(0)", "chosen"):
        assert word in text
    assert not re.search(r"\bnan\b|\binf\b|(?<!\\)<", text)


def test_tables_of_the_summary_are_whole(done: Done) -> None:
    """Every row of a table has as many cells as its head."""
    block: list[int] = []
    for line in (done.out / "summary.md").read_text(encoding="utf-8").splitlines():
        if not line.startswith("|"):
            block = []
            continue
        block.append(len(re.findall(r"(?<!\\)\|", line)))
        assert block[-1] == block[0]


def test_saved_runs_hold_the_torque_limit(done: Done) -> None:
    """In the driven runs the applied torque is what was asked, clipped to the line of Table I."""
    for name in ("fig3_flexible", "fig3_rigid", "fig5_flexible_friction", "fig5_rigid_friction"):
        rec = recording(done, name)
        omega, asked = columns(rec, "omega"), columns(rec, "tau")
        top, bottom = np.maximum(0, 0.63 - 0.18 * omega), np.minimum(0, -0.63 - 0.18 * omega)
        np.testing.assert_allclose(columns(rec, "tau_applied"), np.clip(asked, bottom, top), atol=1e-12)


def test_damping_suppresses_the_vibration_in_the_saved_runs(done: Done) -> None:
    """The largest deflection of the last two seconds falls with v, by much less than half at v = 0.5."""
    peaks = []
    for name in ("damping_v_0.01", "damping_v_0.5", "damping_v_2"):
        rec = recording(done, name)
        late = rec.t > rec.t[-1] - 2.0
        peaks.append(np.linalg.norm((columns(rec, "theta") - columns(rec, "q"))[late], axis=1).max())
    assert peaks[0] > peaks[1] > peaks[2]
    assert peaks[1] > 0.5 * peaks[0]
    assert peaks[2] < 0.6 * peaks[0]


def test_push_bends_the_springs_by_the_lever_arm(done: Done) -> None:
    """-0.2 N along x at the tip (1.05, 1.05) bends both springs by 0.2 * 1.05/K, 2.19 degrees, before the arm gives."""
    numbers = done.study.summary["numbers"]["The end-of-arm force"]
    np.testing.assert_allclose(numbers["deflection_deg"], -np.degrees(0.2 * 1.05 / 5.5), rtol=0.06)
    assert numbers["tip_moved_mm"][0] < -80


def test_readings_measure_the_misprints(done: Done) -> None:
    """Each reading says what is printed, what is read and why; the sign of eq. 10 misses by two links at most."""
    readings = {each["where"]: each for each in done.study.summary["readings"]}
    assert all(all(each.values()) for each in readings.values())
    assert "2.10 m" in readings["eq. 10"]["why"]
    assert "0.1564" in readings["eq. 17"]["why"]


def test_progress_names_every_part(done: Done) -> None:
    """One line as each part begins, counted."""
    total = len(done.lines)
    assert [line.split(":")[0] for line in done.lines] == [f"{k} of {total}" for k in range(1, total + 1)]


def test_a_check_that_fails_is_reported() -> None:
    """A value past its bound or no number is no pass, and the summary says so without breaking."""
    good, bad, none = (checked_statement("is small", value, 1.0, "m") for value in (1.0, 1.5, math.nan))
    assert (good.passed, bad.passed, none.passed) == (True, False, False)
    chapter = Chapter("Part", "Text.", (good, bad, none), {"found": [1.0, math.inf]})
    text = summary_text([chapter], [], "0")
    assert "1 of 3 checks hold" in text
    assert text.count("**NO**") == 2
    data = summary_data([chapter], [], "0")
    assert data["passed"] is False
    assert data["checks"][2]["value"] is None
    json.dumps(data, allow_nan=False)
    assert not PaperStudy(data, (good, bad), ()).passed


def test_folder_that_cannot_be_made(tmp_path: Path) -> None:
    """A file in the folder's place is answered by one line that names it, before anything is computed."""
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match=r"taken.*cannot be made") as caught:
        run_paper_study(tmp_path / "taken", progress=pytest.fail)
    assert "\n" not in str(caught.value)


def test_without_matplotlib(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The extra to install is named, and nothing is left behind."""
    for module in ("matplotlib", "matplotlib.figure", "matplotlib.style"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtra, match=r"flexdyn\[plot\]"):
        run_paper_study(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_import_stays_light() -> None:
    """Importing the study brings neither matplotlib nor SciPy."""
    script = "import sys, flexdyn.paper; print([m for m in ('matplotlib', 'scipy') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_check_is_plain_data() -> None:
    """A check has the five fields that the summary writes."""
    assert [field.name for field in dataclasses.fields(Check)] == ["name", "value", "bound", "passed", "note"]
