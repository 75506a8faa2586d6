"""Studies from end to end: each run is the one that simulate makes, wherever and in whatever order it was done."""

from __future__ import annotations

import importlib
import itertools
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import flexdyn as fd
from flexdyn.batch.cases import Cases
from flexdyn.batch.chunk import Done, Task
from flexdyn.batch.draws import draws_of_run
from flexdyn.batch.progress import Progress
from flexdyn.batch.studyfile import read_study
from flexdyn.errors import InputError
from tests.batch.studies import STUDY, tree, write_study

DRIVER = importlib.import_module("flexdyn.batch.run_study")
FRAGILE = """
import numpy as np

def fragile(run):
    "The last position of the elbow, or nothing where the spring is soft."
    if run.model.joints["shoulder"].stiffness < 40:
        raise RuntimeError("too soft")
    return run.q[-1, 1]

fragile.unit = "rad"
"""


def test_every_run_is_that_of_simulate(tmp_path: Path) -> None:
    """Channels and drawn numbers of each run, bit for bit those of a model made by hand from the drawn numbers."""
    path = write_study(tmp_path)
    data = fd.run_study(path, tmp_path / "out.zarr", workers=2).dataset()
    study, base = read_study(path), fd.load_model(tmp_path / "arm.yaml")
    for k in range(12):
        values = draws_of_run(study, k)
        stiffness, inertia, level = values.values()
        effects = [*base.effects[:1], base.effects[1].replace(level=level), base.effects[2]]
        joints = {"shoulder": {"stiffness": stiffness}, "elbow": {"rotor_inertia": inertia}}
        model = base.replace(joints=joints, effects=effects)
        run = fd.simulate(model, tmp_path / "torque.csv", 0.2, fd.solvers.TimeStepping(step=1e-3), rate=100)
        one = data.isel(run=k)
        np.testing.assert_array_equal(one.q, run.q)
        np.testing.assert_array_equal(one.theta, run.theta)
        assert {name: float(one[name]) for name in values} == values
        assert one.status == "ok"
    np.testing.assert_array_equal(data.time, run.t)
    assert data.joint.values.tolist() == ["shoulder", "elbow"]
    assert (data.tip_deflection_max > 0).all()


def test_what_the_store_says_of_itself(tmp_path: Path) -> None:
    """It opens in xarray without a warning: dimensions, units, kinds, the study and nothing of time or machine."""
    fd.run_study(write_study(tmp_path), tmp_path / "out.zarr")
    data = xarray.open_zarr(tmp_path / "out.zarr")
    assert dict(data.sizes) == {"run": 12, "time": 21, "joint": 2}
    assert data.q.dims == ("run", "time", "joint")
    assert data.q.attrs["units"] == "rad"
    assert data["joints.shoulder.stiffness"].attrs["units"] == "N m/rad"
    assert data.tip_deflection_max.attrs["units"] == "m"
    kinds = {str(name): array.attrs["kind"] for name, array in data.data_vars.items()}
    assert kinds.pop("status") == "status"
    assert sorted(kinds.values()) == ["channel"] * 2 + ["metric"] + ["parameter"] * 3
    assert data.attrs["flexdyn"] == fd.__version__


def test_workers_leave_no_trace(tmp_path: Path) -> None:
    """One thread or three, the store is the same to the last byte."""
    path = write_study(tmp_path)
    for workers in (1, 3):
        fd.run_study(path, tmp_path / f"{workers}.zarr", workers=workers)
    assert tree(tmp_path / "1.zarr") == tree(tmp_path / "3.zarr")


def test_a_run_is_the_same_in_a_chunk_of_any_size_and_a_study_of_any_length(tmp_path: Path) -> None:
    """Run k depends on (seed, k) alone."""
    found = []
    for chunk, runs in ((1, 5), (4, 12), (12, 12)):
        path = write_study(tmp_path / f"{chunk}", chunk=chunk, runs=runs)
        found.append(fd.run_study(path, tmp_path / f"{chunk}.zarr").dataset().isel(run=slice(0, 5)).load())
    for one, other in itertools.pairwise(found):
        xarray.testing.assert_equal(one, other)


def test_a_study_without_channels_or_without_metrics(tmp_path: Path) -> None:
    """Either is enough."""
    only = fd.run_study(write_study(tmp_path, keep=None), tmp_path / "metrics.zarr").dataset()
    assert "q" not in only
    assert np.isfinite(only.tip_deflection_max).all()
    only = fd.run_study(write_study(tmp_path, metrics=None), tmp_path / "channels.zarr").dataset()
    assert "tip_deflection_max" not in only
    assert np.isfinite(only.q).all()


def test_a_run_that_fails_says_why_and_the_others_go_on(tmp_path: Path) -> None:
    """A level that is drawn below 0 makes no model: reason and NaN; the rest is done."""
    vary: dict[str, Any] = {"effects[1].level": {"normal": [0.005, 0.01]}}
    seen: list[Progress] = []
    results = fd.run_study(write_study(tmp_path, vary=vary), tmp_path / "out.zarr", progress=seen.append)
    data = results.dataset().load()
    negative = data["effects[1].level"].values < 0
    assert 0 < negative.sum() < 12
    assert [("coulomb_friction.level" in text) for text in data.status.values] == negative.tolist()
    assert np.isnan(data.q.values).all(axis=(1, 2)).tolist() == negative.tolist()
    assert np.isnan(data.tip_deflection_max.values).tolist() == negative.tolist()
    assert set(results.failed) == set(np.flatnonzero(negative).tolist())
    assert (seen[-1].done, seen[-1].failed) == (12, negative.sum())


def test_an_integration_that_bursts(tmp_path: Path) -> None:
    """Runge-Kutta at a step far too long for some of the springs: those runs fail with time and reason."""
    vary = {"joints.shoulder.stiffness": {"grid": [20.0, 5e7]}}
    solver = {"name": "RungeKutta4", "step": 1e-3, "smoothing": 0.1}
    data = fd.run_study(write_study(tmp_path, vary=vary, runs=None, solver=solver), tmp_path / "out.zarr").dataset()
    good, bad = data.status.values
    assert good == "ok"
    assert "RungeKutta4 stopped at t = " in bad
    assert "not finite" in bad


def test_a_metric_that_raises(tmp_path: Path) -> None:
    """Its number is NaN and its reason in the status; the run's channels and other metrics stay."""
    path = write_study(tmp_path, metrics=["tip_deflection_max", "own_metric_fragile:fragile"])
    (tmp_path / "own_metric_fragile.py").write_text(FRAGILE)
    data = fd.run_study(path, tmp_path / "out.zarr").dataset().load()
    soft = data["joints.shoulder.stiffness"].values < 40
    assert 0 < soft.sum() < 12
    own = data["own_metric_fragile:fragile"]
    assert np.isnan(own.values).tolist() == soft.tolist()
    assert own.attrs["units"] == "rad"
    reason = "metric own_metric_fragile:fragile: "
    assert [text.startswith(reason) and "too soft" in text for text in data.status.values] == soft.tolist()
    assert np.isfinite(data.q).all()
    np.testing.assert_array_equal(own.values[~soft], data.q.values[~soft, -1, 1])


def test_a_controller_is_varied(tmp_path: Path) -> None:
    """Gains over a grid: each run is that of its gain, and follows better than the one before."""
    pd = {"pd": {"reference": "path.csv", "kp": 20.0, "kd": 0.4}}
    vary = {"command.pd.kp": {"grid": [5.0, 20.0, 80.0]}}
    path = write_study(tmp_path, command=pd, vary=vary, runs=None, metrics=["tracking_error_rms"])
    data = fd.run_study(path, tmp_path / "out.zarr").dataset()
    reference = fd.read_recording(tmp_path / "path.csv")
    for k, kp in enumerate((5.0, 20.0, 80.0)):
        command = fd.PD(reference, kp=kp, kd=0.4)
        run = fd.simulate(
            fd.load_model(tmp_path / "arm.yaml"), command, 0.2, fd.solvers.TimeStepping(step=1e-3), rate=100
        )
        np.testing.assert_array_equal(data.q[k], run.q)
    assert (np.diff(data.tracking_error_rms.values) < 0).all()


def test_from_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A path, a mapping or a Study; the mapping's paths are relative to the working folder."""
    path = write_study(tmp_path)
    monkeypatch.chdir(tmp_path)
    for name, study in (("path", path), ("mapping", STUDY), ("study", read_study(path))):
        fd.run_study(study, f"{name}.zarr")
    assert tree(tmp_path / "path.zarr") == tree(tmp_path / "mapping.zarr") == tree(tmp_path / "study.zarr")
    with pytest.raises(InputError, match="study: the path of a study file is needed"):
        fd.run_study(3, "other.zarr")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"workers: a number of at least 1 is needed, got 0"):
        fd.run_study(path, "other.zarr", workers=0)
    with pytest.raises(InputError, match="workers and a scheduler"):
        fd.run_study(path, "other.zarr", workers=2, scheduler="tcp://127.0.0.1:1")
    assert not Path("other.zarr").exists()


def test_what_a_killed_worker_leaves_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker dies while it writes and another does its chunk: the store is that of a study in which nobody died."""
    path = write_study(tmp_path)
    fd.run_study(path, tmp_path / "whole.zarr")

    class Twice(Task):
        """Leaves half a piece behind before it does a chunk."""

        def __call__(self, chunk: int, stopped: Any = None) -> Done:
            """As a worker of a cluster would that was killed, and one that took over."""
            (Path(self.store) / "q" / f"c.{chunk}.0.0123.partial").write_bytes(b"half")
            return super().__call__(chunk, stopped)

    monkeypatch.setattr(DRIVER, "Task", Twice)
    fd.run_study(path, tmp_path / "out.zarr")
    assert tree(tmp_path / "out.zarr") == tree(tmp_path / "whole.zarr")


def test_memory_does_not_grow_with_the_number_of_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The driver of 200,000 runs holds no more than that of 2,000, but for their numbers while the store is made."""

    class Nothing(Task):
        """Stands for runs that take no time."""

        def __call__(self, chunk: int, stopped: Any = None) -> Done:
            """Nothing is done and nothing written."""
            return Done(chunk, 128, 0)

    monkeypatch.setattr(DRIVER, "Task", Nothing)
    peaks = []
    for runs in (1000, 2000, 200_000):  # the first loads what is loaded late
        path = write_study(tmp_path, runs=runs, chunk=128)
        tracemalloc.start()
        fd.run_study(path, tmp_path / f"{runs}.zarr", workers=2)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[2] - peaks[1] < 200_000 * 8 * 4


def test_one_run_again(tmp_path: Path) -> None:
    """A case of a study is all that simulate needs to make that very run."""
    path = write_study(tmp_path)
    data = fd.run_study(path, tmp_path / "out.zarr").dataset()
    cases = Cases(read_study(path))
    case = cases.case(5)
    run = fd.simulate(case.model, case.command, 0.2, cases.solver, rate=100, **case.starts)
    np.testing.assert_array_equal(run.q, data.q[5])
