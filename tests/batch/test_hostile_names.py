"""A study of joints, models and files with hostile names: its store, pages, pictures, tables and lines."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.batch.draws import draws_of_run
from flexdyn.batch.layout import array_name
from flexdyn.batch.results import Results
from flexdyn.batch.studyfile import read_study
from flexdyn.cli import main
from flexdyn.errors import visible
from flexdyn.io.yaml import dump_yaml
from tests.browser import open_page
from tests.test_hostile_names import HARM, HIT, NAMES, TERMINAL, urdf
from tests.viewer.arms import DRIVE

LONG = ("\u05de" * 190 + "a", "\u05de" * 190 + "b", "a/b\\c")
"""Letters of two bytes each, so that no file may have such a name; and what folders are told apart by."""
JOINTS = (*NAMES, *LONG)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Twelve runs in which the stiffness of every joint varies."""
    folder = tmp_path_factory.mktemp("study") / f"{TERMINAL}<img src=x onerror=alert(1)>"
    folder.mkdir()
    (folder / "arm.urdf").write_text(urdf(JOINTS, f"<script>{HIT}</script>"), encoding="utf-8")
    model = fd.FlexibleJointModel(fd.load_robot(folder / "arm.urdf"), {"*": DRIVE}, name=f"<script>{HIT}</script>")
    fd.save_model(model, folder / f"{TERMINAL}.yaml")
    study = {
        "flexdyn_study": 1,
        "model": f"{TERMINAL}.yaml",
        "duration": 0.02,
        "rate": 500,
        "solver": {"name": "TimeStepping", "step": 1e-3},
        "runs": 12,
        "vary": {f"joints.{name}.stiffness": {"uniform": [1000.0, 2000.0]} for name in JOINTS},
        "keep": ["q"],
        "metrics": ["tip_deflection_max"],
    }
    (folder / "study.yaml").write_text(dump_yaml(study), encoding="utf-8")
    return fd.run_study(folder / "study.yaml", folder / f"<script>{HIT.replace('/', '')}<script>.zarr")


def test_the_store_holds_every_number_by_its_name(results: Results) -> None:
    """Also those that no file may be called; they are the ones that were drawn."""
    paths = [f"joints.{name}.stiffness" for name in JOINTS]
    assert list(results.parameters) == paths
    stored = {array_name(path) for path in paths}
    assert len(stored) == len(paths)
    assert all(len(name.encode()) <= 200 and not set(name) & {"/", "\\"} for name in stored)
    table = np.array([[draws_of_run(results.study, k)[path] for path in paths] for k in range(2)])
    np.testing.assert_array_equal(table, np.array(list(results.parameters.values())).T[:2])


def test_pages_and_pictures_show_them_and_run_nothing(results: Results, tmp_path: Path) -> None:
    """The study's page in the browser, its picture at a size that stands, what a notebook shows."""
    results.plot(tmp_path / "study.png")
    results.plot(tmp_path / "study.html")
    from matplotlib.image import imread

    assert max(imread(tmp_path / "study.png").shape) < 20_000
    with open_page(tmp_path / "study.html") as page:
        page.wait_for("document.querySelectorAll('.scatterlayer').length > 0")
        page.wait_for_buttons()
        page.tab.mouse.move(300, 300)
        page.tab.wait_for_timeout(100)
        assert not page.tab.evaluate(f"Boolean({HARM})")
    for each in (results, read_study(results.path.parent / "study.yaml")):
        markup = each._repr_html_()
        assert not [tag for tag in ("<img", "<script", "<svg") if tag in markup.lower()]
        assert repr(each) == visible(repr(each))


@pytest.mark.parametrize("option", ["--summary", "--json"])
def test_the_terminal_shows_and_does_not_obey(
    results: Results, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Tables and JSON of a study, and the line on a store that is there already."""
    summary = ["--summary"] if option == "--summary" else ["--summary", "--json"]
    assert main(["batch", str(results.path), *summary]) == 0
    printed = capsys.readouterr().out
    assert all(line.isprintable() for line in printed.splitlines())
    if option == "--json":
        assert {each["name"] for each in json.loads(printed)["parameters"]} == set(results.parameters)
    assert main(["batch", str(results.path.parent / "study.yaml"), "-o", str(results.path)]) == 2
    assert all(line.isprintable() for line in capsys.readouterr().err.splitlines())


def test_what_a_console_shows_of_an_object() -> None:
    """A model, a run and a comparison of any name."""
    model = fd.load_model("scara_two_link").replace(name=f"{TERMINAL}arm")
    run = fd.simulate(model, None, 0.01)
    other = fd.Recording(run.t, run.to_recording().channels, name=TERMINAL)
    for each in (model, run, fd.compare(other, run), run.plot()):
        assert repr(each).isprintable(), type(each).__name__
