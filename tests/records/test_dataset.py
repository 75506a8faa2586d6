"""Recordings as xarray datasets: what an xarray user expects, and back bit for bit."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import flexdyn as fd
from flexdyn.errors import InputError, MissingExtra
from flexdyn.records import Recording
from flexdyn.records.units import SIGNALS

T = np.array([0.0, 0.1, 0.2])
DOUBLES = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False), st.sampled_from([-0.0, 5e-324, 1.7976931348623157e308])
)
NAMES = st.one_of(
    st.builds("{}.{}".format, st.sampled_from(sorted(SIGNALS)), st.sampled_from(["a", "b", "arm.left", "x/y"])),
    st.sampled_from(["joint", "joint_type", "q", "entry", "supplied.a", "power", "t.a", "meta", "tau"]),
)


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    """Any mixture of signals, joints and other channels; some joints slide."""
    names = draw(st.lists(NAMES, min_size=1, max_size=12, unique=True))
    slides = draw(st.sets(st.sampled_from(["a", "b"])))
    units = {name: "m" for name in names if name.split(".")[0] in ("q", "theta") and name.split(".")[-1] in slides}
    channels = {name: draw(hnp.arrays(np.float64, 3, elements=DOUBLES)) for name in names}
    return Recording(T, channels, meta={"units": units, "n": [1, None]} if units else None, name="log")


@settings(max_examples=50, deadline=None)
@given(rec=recordings())
def test_there_and_back_is_bit_for_bit(rec: Recording) -> None:
    """Samples, order of channels and meta survive, whatever is stacked."""
    dataset = rec.to_xarray()
    back = Recording.from_xarray(dataset)
    assert back == rec
    assert back.name == "log"
    assert not any(np.isnan(variable.values).any() for variable in dataset.data_vars.values())


def test_signals_of_every_joint_are_stacked() -> None:
    """Variables over (t, joint) with units and names for plots; a signal that one joint lacks invents no NaN."""
    rec = Recording(T, {"q.a": T, "tau.a": -T, "q.b": 2 * T, "temperature.b": T, "power": T})
    dataset = rec.to_xarray()
    assert dataset["q"].dims == ("t", "joint")
    np.testing.assert_array_equal(dataset["q"].sel(joint="b"), 2 * T)
    assert set(dataset.data_vars) == {"q", "tau.a", "temperature.b", "power"}
    assert dataset["q"].attrs == {"long_name": "link position", "units": "rad"}
    assert dataset["temperature.b"].attrs["units"] == "degC"
    assert dataset["t"].attrs["units"] == "s"
    assert json.loads(dataset.attrs["channels"]) == list(rec.channels)


def test_joints_that_slide() -> None:
    """The type of each joint tells which unit its numbers have."""
    units = {"q.a": "m", "tau.a": "N"}
    dataset = Recording(T, {"q.a": T, "q.b": T, "tau.a": T, "tau.b": T}, meta={"units": units}).to_xarray()
    assert list(dataset["joint_type"].values) == ["prismatic", "revolute"]
    assert dataset["q"].attrs["units"] == "m or rad"
    del dataset.attrs["meta"]
    assert Recording.from_xarray(dataset).meta["units"] == units


def test_what_is_left_of_a_dataset_is_a_recording() -> None:
    """Slices in time, joints left out and put in another order, variables dropped."""
    rec = Recording(T, {"q.a": T, "tau.a": -T, "q.b": 2 * T, "tau.b": T}, meta={"units": {"q.b": "m", "tau.b": "N"}})
    dataset = rec.to_xarray()
    assert Recording.from_xarray(dataset.isel(t=slice(1, None), joint=[0])) == Recording(
        T[1:], {"q.a": T[1:], "tau.a": -T[1:]}
    )
    assert list(Recording.from_xarray(dataset.drop_vars("tau").transpose("joint", "t")).channels) == ["q.a", "q.b"]


def test_datasets_by_other_hands() -> None:
    """Integers, other orders of dimensions, labels of any type, other labelled dimensions."""
    dataset = xr.Dataset(
        {
            "q": (("joint", "t"), np.arange(6).reshape(2, 3), {"units": "radians"}),
            "force": (("t", "axis"), np.ones((3, 2)), {"units": "N"}),
        },
        {"t": T, "joint": ["a", "b"], "axis": [1, 2]},
    )
    rec = Recording.from_xarray(dataset)
    assert list(rec.channels) == ["q.a", "q.b", "force.1", "force.2"]
    np.testing.assert_array_equal(rec["q.b"], [3.0, 4.0, 5.0])
    assert rec.meta == {"units": {"force.1": "N", "force.2": "N"}}


@pytest.mark.parametrize(
    ("dataset", "words"),
    [
        ({"q.a": T}, "dataset: not a dataset, got 'dict'; give an xarray.Dataset"),
        (xr.Dataset({"q.a": ("t", T)}), r"no coordinate t; .*ds\.rename\(time='t'\)"),
        (xr.Dataset({"q.a": ("time", T)}, {"time": T}), "no coordinate t"),
        (xr.Dataset({"q.a": ("t", T)}, {"t": T.astype("M8[s]")}), "t: the column holds dates or durations"),
        (xr.Dataset({"q.a": ("t", T)}, {"t": -T}), "t: row 1: time runs backwards"),
        (xr.Dataset({"q.a": ("t", [0.0, np.nan, 1.0])}, {"t": T}), r"q\.a: row 1: not a finite number"),
        (xr.Dataset({"q.a": ("t", ["x", "y", "z"])}, {"t": T}), r"q\.a: the column holds"),
        (xr.Dataset({"q": (("t", "k"), np.ones((3, 2)))}, {"t": T}), r"dimensions \('t', 'k'\).*ds\.drop_vars\('q'\)"),
        (xr.Dataset({"mean": 1.0, "q.a": ("t", T)}, {"t": T}), r"mean: the variable has the dimensions \(\)"),
        (xr.Dataset({"q.a": ("t", T, {"units": "deg"})}, {"t": T}), r"q\.a: the unit is not SI, got 'deg'"),
        (xr.Dataset({"q.a": ("t", T)}, {"t": T}, {"meta": "{"}), "meta is not a JSON object"),
        (
            xr.Dataset({"q": (("t", "joint"), np.ones((3, 1))), "q.a": ("t", T)}, {"t": T, "joint": ["a"]}),
            r"q\.a: the channel is there twice",
        ),
        (xr.Dataset(coords={"t": T}), "no channel beside t"),
    ],
)
def test_what_is_no_recording_is_refused(dataset: Any, words: str) -> None:
    """One line with the remedy in xarray's words."""
    with pytest.raises(InputError, match=words):
        Recording.from_xarray(dataset)


def test_netcdf(tmp_path: Path) -> None:
    """NetCDF by SciPy loses nothing."""
    rec = Recording(T, {"q.a": [5e-324, -0.0, 1 / 3], "tau.a": T, "q.b": T}, meta={"units": {"q.b": "m"}}, name="log")
    rec.to_xarray().to_netcdf(tmp_path / "log.nc", engine="scipy")
    with xr.open_dataset(tmp_path / "log.nc", engine="scipy") as dataset:
        assert Recording.from_xarray(dataset) == rec


@pytest.mark.parametrize("name", ["scara", "panda"])
def test_runs(name: str) -> None:
    """A run's dataset holds its arrays, joint by joint, and is its recording."""
    run = fd.simulate(fd.load_model(name), duration=0.05, theta0="equilibrium")
    dataset = run.to_xarray()
    for signal in ("q", "theta", "v", "omega", "tau", "tau_applied", "tau_s"):
        assert dataset[signal].dims == ("t", "joint")
        np.testing.assert_array_equal(dataset[signal].values, getattr(run, signal))
    np.testing.assert_array_equal(dataset["t"].values, run.t)
    assert tuple(dataset["joint"].values) == run.joint_names
    assert Recording.from_xarray(dataset) == run.to_recording()
    kinds = dataset["joint_type"].values if "joint_type" in dataset.coords else ["revolute"] * run.model.n
    assert list(kinds) == ["prismatic" if kind == "prismatic" else "revolute" for kind in run.model.robot.kinds]


def test_the_energy_of_a_run() -> None:
    """The ledger closes in the dataset too, and a recording carries it."""
    run = fd.simulate(fd.load_model("scara"), duration=0.05)
    dataset = run.to_xarray(energy=True)
    mechanical = dataset["kinetic"] + dataset["spring"] + dataset["gravity"]
    came = dataset["supplied"].sum("joint") + dataset["external"]
    residual = mechanical - run.energy.initial - came + dataset["dissipated"].sum("entry")
    assert float(np.abs(residual).max()) <= run.energy.tolerance
    assert {dataset[name].attrs["units"] for name in ("kinetic", "supplied", "dissipated")} == {"J"}
    assert list(dataset["entry"].values) == list(run.energy.dissipated)
    rec = Recording.from_xarray(dataset)
    assert rec.unit("kinetic") == "J"
    for entry, lost in run.energy.dissipated.items():
        np.testing.assert_array_equal(rec[f"dissipated.{entry}"], lost)


def test_without_xarray_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both directions say what to install."""
    rec = Recording(T, {"q.a": T})
    dataset = rec.to_xarray()
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(MissingExtra, match=r"flexdyn\[xarray\]"):
        rec.to_xarray()
    with pytest.raises(MissingExtra, match=r"flexdyn\[xarray\]"):
        Recording.from_xarray(dataset)
