"""What a study has stored, read back: numbers against closed forms, pictures, what is missing or damaged."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.batch.results import Results, open_results
from flexdyn.batch.run_study import run_study
from flexdyn.batch.stored_study import MAX_STORE_BYTES, MAX_STUDY_LETTERS
from flexdyn.batch.summary import reasons_of
from flexdyn.io.yaml import dump_yaml
from tests.batch.small import FORCE, pulse_study

OWN = """
def late(run):
    "Last position of strong pulses."
    if run.tau.max() < 6.0:
        raise RuntimeError(f"too weak: {run.tau.max()}")
    return run.q[-1, 0]
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """40 pulses of different force on springs of different stiffness; a metric that fails for the weaker ones."""
    folder = tmp_path_factory.mktemp("results")
    (folder / "own_numbers_r.py").write_text(OWN, encoding="utf-8")
    study = pulse_study(folder, metrics=["motor_torque_max", "residual_vibration", "own_numbers_r:late"])
    (folder / "study.yaml").write_text(json.dumps(study), encoding="utf-8")
    return run_study(folder / "study.yaml", folder / "out.zarr")


def test_the_dataset_holds_everything(results: Results) -> None:
    """Channels over run, time, joint; parameters by path, metrics and status over run; each with its kind and unit."""
    found = results.dataset()
    assert found["q"].dims == ("run", "time", "joint")
    assert found["q"].shape == (40, 101, 1)
    assert [found[name].attrs["kind"] for name in ("q", "command.scale", "residual_vibration", "status")] == [
        "channel",
        "parameter",
        "metric",
        "status",
    ]
    assert found["joints.lift.stiffness"].attrs["units"] == "N/m"
    assert found["q"].chunks is not None  # nothing is read before it is asked for
    assert (found["q"].isel(time=0).values == 0.0).all()


def test_summary_counts_and_reasons(results: Results) -> None:
    """A run whose metric fails has not failed; reasons that differ in a number only are one, with the first's text."""
    found = results.summary()
    weak = results.parameters["command.scale"] < 1.0
    assert (found.runs, found.done, found.failed) == (40, 40, 0)
    (reason,) = found.reasons
    assert reason.runs == weak.sum()
    assert reason.first == np.flatnonzero(weak)[0]
    assert reason.text.startswith("metric own_numbers_r:late: RuntimeError: too weak: ")
    assert dict(results.failed) == {}


def test_summary_of_metrics(results: Results) -> None:
    """The force that acted is what was asked, so its numbers are those of the scale that was drawn."""
    force = FORCE * results.parameters["command.scale"]
    found = results.summary().metrics[0]
    assert (found.name, found.unit, found.runs, found.worst) == ("motor_torque_max", "N", 40, int(force.argmax()))
    assert found.mean == pytest.approx(force.mean(), rel=1e-12)
    assert found.std == pytest.approx(force.std(ddof=1), rel=1e-12)
    assert found.quantiles[0.5] == pytest.approx(np.median(force), rel=1e-12)
    assert found.least == pytest.approx(force.min(), rel=1e-12)
    assert found.greatest == pytest.approx(force.max(), rel=1e-12)
    assert results.summary().metrics[2].runs == (force >= FORCE).sum()


def test_summary_of_parameters(results: Results) -> None:
    """The greatest force rises with the scale and knows nothing of the stiffness."""
    stiffness, scale = results.summary().parameters
    assert (stiffness.name, scale.name) == ("joints.lift.stiffness", "command.scale")
    assert scale.sensitivities["motor_torque_max"].rank_correlation == pytest.approx(1.0)
    unrelated = stiffness.sensitivities["motor_torque_max"]
    assert abs(unrelated.rank_correlation) < 2.0 * unrelated.chance
    assert stiffness.least is not None
    assert 600.0 <= stiffness.least < 700.0


def test_summary_is_plain_data(results: Results) -> None:
    """JSON takes it as it is."""
    again = json.loads(json.dumps(results.summary().to_dict()))
    assert again["metrics"][0]["quantiles"]["0.5"] == results.summary().metrics[0].quantiles[0.5]
    assert again["parameters"][1]["sensitivities"]["motor_torque_max"]["rank_correlation"] == pytest.approx(1.0)


def test_the_picture_holds_what_was_measured(results: Results, tmp_path: Path) -> None:
    """A panel for each metric over each parameter, a tornado for each metric, the quantiles of each channel."""
    picture = results.plot(tmp_path / "all.png")
    assert (tmp_path / "all.png").stat().st_size > 10_000
    curves = {curve.name: curve for panel in picture.panels for curve in panel.curves}
    dots = curves["motor_torque_max over command.scale"]
    np.testing.assert_array_equal(dots.x, results.parameters["command.scale"])
    np.testing.assert_allclose(dots.y, FORCE * dots.x, rtol=1e-12)
    q = results.dataset()["q"].values[:, :, 0]
    np.testing.assert_allclose(curves["q.lift, 50%"].y, np.median(q, axis=0), atol=1e-15)
    np.testing.assert_allclose(curves["q.lift, 5%"].y, np.quantile(q, 0.05, axis=0), atol=1e-15)
    first = next(panel for panel in picture.panels if panel.title == "motor_torque_max")
    assert first.curves[0].name == "command.scale: lowest to highest fifth"
    assert any("40 runs, 40 done" in note for note in picture.notes)


def test_views_and_names_can_be_chosen(results: Results) -> None:
    """One view, one metric, one parameter; a name that is not there is refused with the near miss."""
    picture = results.plot(views="metrics", metrics=["residual_vibration"], parameters=["command.scale"])
    assert [panel.up for panel in picture.panels] == ["residual_vibration [m]"]
    picture = results.plot(views=["trajectories"], channels=["theta"])
    assert [panel.up for panel in picture.panels] == ["theta [m]"]
    cases = {
        "views": (["tornado"], r"views: no such view, got 'tornado'"),
        "metrics": (["residual_vibrations"], r"no such metric, .*did you mean 'residual_vibration'\?"),
        "parameters": (["command.scales"], r"no such parameter, .*did you mean 'command.scale'\?"),
        "channels": (["v"], r"no such channel, got 'v'; known: q, theta"),
    }
    for key, (value, line) in cases.items():
        with pytest.raises(fd.InputError, match=line):
            results.plot(**{key: value})  # type: ignore[arg-type]


def test_the_interactive_page(results: Results, tmp_path: Path) -> None:
    """It is written in one file that asks nobody for anything."""
    results.plot(tmp_path / "all.html", views=["sensitivities"])
    assert "scale +1.00" in (tmp_path / "all.html").read_text(encoding="utf-8")


def test_runs_that_fail(tmp_path: Path) -> None:
    """A stiffness below zero is no model: those runs say so and count in no number, the others are there."""
    study = pulse_study(tmp_path, vary={"joints.lift.stiffness": {"normal": [100.0, 200.0]}})
    found = run_study(study, tmp_path / "out.zarr")
    bad = np.flatnonzero(found.parameters["joints.lift.stiffness"] <= 0.0)
    assert list(found.failed) == bad.tolist()
    summary = found.summary()
    assert (summary.done, summary.failed, summary.metrics[0].runs) == (40, len(bad), 40 - len(bad))
    (reason,) = summary.reasons
    assert (reason.runs, reason.first) == (len(bad), bad[0])
    assert "joints.lift.stiffness: it must be above 0, got -" in reason.text
    picture = found.plot(views=["trajectories"])
    good = np.delete(found.dataset()["q"].values[:, :, 0], bad, axis=0)
    median = next(curve for curve in picture.panels[0].curves if curve.name == "q.lift, 50%")
    np.testing.assert_allclose(median.y, np.median(good, axis=0), atol=1e-15)
    assert picture.notes[0] == f"40 runs, 40 done, {len(bad)} of them failed."


def test_a_store_that_is_not_finished(results: Results, tmp_path: Path) -> None:
    """Runs that are not done are neither failed nor counted in any number."""
    half = tmp_path / "half.zarr"
    shutil.copytree(results.path, half)
    size = results.study.chunk
    for piece in half.rglob("c/*"):
        if piece.parent.parent.name not in ("run", "time", "joint") and int(piece.name) >= 1:
            piece.unlink()
    for piece in half.rglob("c.*"):
        if piece.parent.name not in ("run", "time", "joint") and int(piece.name.split(".")[1]) >= 1:
            piece.unlink()
    found = open_results(half)
    summary = found.summary()
    assert (summary.runs, summary.done, summary.failed) == (40, size, 0)
    assert summary.metrics[0].runs == size
    assert found.pending == 40 - size
    picture = found.plot(views=["trajectories"])
    np.testing.assert_allclose(
        next(curve for curve in picture.panels[0].curves if curve.name == "q.lift, 50%").y,
        np.median(results.dataset()["q"].values[:size, :, 0], axis=0),
        atol=1e-15,
    )


def test_a_damaged_piece_is_said(results: Results, tmp_path: Path) -> None:
    """A byte that has changed is found by its checksum, and the remedy named."""
    broken = tmp_path / "broken.zarr"
    shutil.copytree(results.path, broken)
    pieces = [path for path in (broken / "q").rglob("*") if path.is_file() and path.name != "zarr.json"]
    piece = max(pieces, key=lambda path: path.stat().st_size)
    content = bytearray(piece.read_bytes())
    content[len(content) // 2] ^= 1
    piece.write_bytes(content)
    with pytest.raises(fd.InputError, match=r"broken\.zarr: q cannot be read \(.*--resume: it redoes"):
        open_results(broken).plot(views=["trajectories"])


WRONG_STUDIES: tuple[dict[str, Any], ...]
WRONG_STUDIES = ({"runs": 0}, {"points": 10**9}, {"chunk": "1"}, {"seed": "x"}, {"rate": -1.0}, {"duration": math.inf})
WRONG_STUDIES += ({"vary": {"a": 3}}, {"vary": []}, {"keep": ["nothing"]}, {"metrics": [3]}, {"solver": {"name": "x"}})
WRONG_STUDIES += ({"model": 3}, {"command": {"pd": 3}}, {"command": 3}, {"files": []}, {"unknown": 1}, {"folder": None})
WRONG_STUDIES += ({"command": {"pd": {"reference": 3, "kp": 1.0, "kd": 1.0}}}, {"command": {"pd": {}}}, {"vary": {}})
WRONG_STUDIES += (
    {"keep": ["q", "q"]},
    {"metrics": ["", ""]},
    {"solver": {"name": "auto", "step": 1.0}},
    {"vary": {3: {}}},
)


def changed(store: Path, content: Any) -> Path:
    """The same store with other metadata."""
    (store / "zarr.json").write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return store


def test_metadata_that_no_study_wrote_are_refused(results: Results, tmp_path: Path) -> None:
    """One line, before any number is read: a study with wrong entries, text that is none, JSON that is too deep."""
    broken = Path(shutil.copytree(results.path, tmp_path / "broken.zarr"))
    content = json.loads((broken / "zarr.json").read_text(encoding="utf-8"))
    attributes = content["attributes"]
    studies: list[Any] = [dump_yaml(results.study.to_dict() | wrong) for wrong in WRONG_STUDIES]
    studies += ["", "{", 3, None, "x" * (MAX_STUDY_LETTERS + 1)]
    wrong = [content | {"attributes": attributes | {"study": study}} for study in studies]
    for each in (*wrong, [], {}, 3, {"attributes": []}, "[" * 200_000, "NaN", " " * (MAX_STORE_BYTES + 1)):
        with pytest.raises(fd.InputError, match=r"broken\.zarr: not the store of a batch study"):
            open_results(changed(broken, each))


@pytest.mark.parametrize(
    ("array", "entries"),
    [
        ("q", {"shape": [40, 101, 10**12]}),
        ("status", {"shape": [10**12]}),
        ("status", {"dimension_names": ["time"]}),
        ("residual_vibration", {"data_type": "complex128"}),
        ("joints.lift.stiffness", None),
        ("time", {"codecs": [{"name": "pickle"}]}),
    ],
)
def test_arrays_that_are_not_those_of_the_study_are_refused(
    results: Results, array: str, entries: dict[str, Any] | None, tmp_path: Path
) -> None:
    """Another shape, another kind of numbers, no such array, an unknown codec: no memory is taken for it."""
    broken = Path(shutil.copytree(results.path, tmp_path / "broken.zarr"))
    content = json.loads((broken / "zarr.json").read_text(encoding="utf-8"))
    arrays = content["consolidated_metadata"]["metadata"]
    arrays.pop(array) if entries is None else arrays[array].update(entries)
    with pytest.raises(fd.InputError, match=r"broken\.zarr: the metadata cannot be read \(.*--resume"):
        open_results(changed(broken, content)).summary()


def test_a_run_of_a_study_with_an_unknown_number_is_refused(results: Results, tmp_path: Path) -> None:
    """A store may come from elsewhere: its numbers are looked for in its model."""
    broken = Path(shutil.copytree(results.path, tmp_path / "broken.zarr"))
    content = json.loads((broken / "zarr.json").read_text(encoding="utf-8"))
    study = results.study.to_dict() | {"vary": {"joints.lift.stifness": {"uniform": [1.0, 2.0]}}}
    content["attributes"]["study"] = dump_yaml(study)
    with pytest.raises(fd.InputError, match="no such number in the model or command"):
        open_results(changed(broken, content)).extract(0, tmp_path / "run")


def test_there_is_no_store(tmp_path: Path) -> None:
    """A path that holds none is refused in one line."""
    with pytest.raises(fd.InputError, match=r"nothing\.zarr: there is no such store"):
        open_results(tmp_path / "nothing.zarr")


def test_reasons_are_counted() -> None:
    """Numbers within a reason do not tell two apart, names do; the most frequent first."""
    said = [
        (3, "m: stopped at t = 0.125 s: not finite"),
        (4, "metric a: no joint2 at 7; metric b: x"),
        (8, "m: stopped at t = 1e-05 s: not finite"),
        (9, "metric a: no joint3 at 7"),
    ]
    found = [(reason.text, reason.runs, reason.first) for reason in reasons_of(said)]
    assert found == [
        ("m: stopped at t = 0.125 s: not finite", 2, 3),
        ("metric a: no joint2 at 7", 1, 4),
        ("metric b: x", 1, 4),
        ("metric a: no joint3 at 7", 1, 9),
    ]
