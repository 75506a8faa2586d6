"""Recordings as xarray datasets, and back without loss.

A signal that every joint has becomes one variable over ``(t, joint)``. A signal that only some joints have becomes
variables over ``t`` named ``q.elbow``, so that no NaN is needed. Other channels are variables over ``t``. Every
variable has ``units`` and ``long_name``. Where a joint is prismatic, the coordinate ``joint_type`` says which, and
``units`` of a variable with joints of both kinds names both. The attributes ``channels`` and ``meta`` keep order and
meta as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError, needed
from flexdyn.records.meta import as_json, from_json
from flexdyn.records.recording import Recording
from flexdyn.records.table import Table, as_floats
from flexdyn.records.units import SIGNALS, signal_unit

LONG_NAMES = {
    "t": "time",
    "q": "link position",
    "v": "link velocity",
    "theta": "rotor position, reflected",
    "omega": "rotor velocity, reflected",
    "tau": "commanded motor torque, reflected",
    "tau_applied": "motor torque after actuator effects, reflected",
    "tau_s": "torque in the transmission",
    "temperature": "temperature",
}


def to_dataset(rec: Recording) -> Any:
    """The xarray dataset of a recording.

    Raises:
        MissingExtra: xarray is not installed.
    """
    xarray = xarray_library()
    joints = list(rec.joints)
    prismatic = np.array(
        [any(rec.unit(f"{s}.{j}") != SIGNALS[s] for s in rec.signals if rec.has(s, j)) for j in joints], bool
    )
    stacked = [signal for signal in rec.signals if _stacks(rec, signal, prismatic)]
    variables: dict[str, Any] = {}
    for name, values in rec.channels.items():
        signal = name.partition(".")[0]
        if signal not in stacked or "." not in name:
            variables[name] = ("t", values, _attributes(rec.unit(name), signal))
        elif signal not in variables:
            units = dict.fromkeys(rec.unit(f"{signal}.{joint}") for joint in joints)
            variables[signal] = (("t", "joint"), rec.signal(signal, joints), _attributes(" or ".join(units), signal))
    coordinates: dict[str, Any] = {"t": ("t", rec.t, _attributes("s", "t"))}
    if stacked:
        coordinates["joint"] = joints
    if stacked and prismatic.any():
        coordinates["joint_type"] = ("joint", np.where(prismatic, "prismatic", "revolute"))
    attributes = {"name": rec.name, "channels": json.dumps(list(rec.channels))}
    if rec.meta:
        attributes["meta"] = as_json(rec.meta)
    return xarray.Dataset(variables, coordinates, attributes)


def table_of(dataset: Any) -> Table:
    """The raw table of a dataset: variables over ``t``, or over ``t`` and one labelled dimension such as ``joint``.

    Args:
        dataset: from `to_dataset`, possibly trimmed or reordered, or from another source; the coordinate ``t`` is in
            [s].

    Returns:
        Columns by channel: those that ``channels`` names first and in its order.

    Raises:
        InputError: no dataset, no numeric coordinate ``t``, variables of other dimensions or types.
        MissingExtra: xarray is not installed.
    """
    if not isinstance(dataset, xarray_library().Dataset):
        raise InputError("not a dataset", key="dataset", value=type(dataset).__name__, remedy="give an xarray.Dataset")
    if "t" not in dataset.coords or dataset.coords["t"].dims != ("t",):
        remedy = "give a coordinate t in seconds, such as ds.rename(time='t')"
        raise InputError("the dataset has no coordinate t", remedy=remedy, channel="t")
    table = Table(meta=from_json(str(dataset.attrs["meta"])) if "meta" in dataset.attrs else {})
    table.add("t", _variable_numbers(dataset.coords["t"].values, "t"))
    table.units["t"] = str(dataset.coords["t"].attrs.get("units", ""))
    for name, values, unit in _dataset_channels(dataset):
        table.add(name, values)
        table.units[name] = unit
    ordered = dict.fromkeys(("t", *filter(table.columns.__contains__, _order(dataset)), *table.columns))
    table.columns = {name: table.columns[name] for name in ordered}
    _forget_units(table)
    return table


def xarray_library() -> Any:
    """The module xarray."""
    with needed("xarray", "xarray"):
        import xarray
    return xarray


def _stacks(rec: Recording, signal: str, prismatic: Any) -> bool:
    """Whether one variable can hold the signal of every joint, with units that the joints' types determine."""
    if signal in rec or "joint" in rec or "joint_type" in rec:
        return False
    return all(
        rec.has(signal, joint) and rec.unit(f"{signal}.{joint}") == signal_unit(signal, prismatic=slides)
        for joint, slides in zip(rec.joints, prismatic, strict=True)
    )


def _attributes(unit: str, signal: str) -> dict[str, str]:
    long_name = {"long_name": LONG_NAMES[signal]} if signal in LONG_NAMES else {}
    return long_name | ({"units": unit} if unit else {})


def _dataset_channels(dataset: Any) -> Iterator[tuple[str, Array, str]]:
    """Name, samples and unit of every channel."""
    sliding = _sliding(dataset)
    for variable, array in dataset.data_vars.items():
        unit = str(array.attrs.get("units", ""))
        if array.dims == ("t",):
            yield str(variable), _variable_numbers(array.values, str(variable)), unit
            continue
        labelled = [dimension for dimension in array.dims if dimension != "t" and dimension in dataset.coords]
        if len(array.dims) != 2 or "t" not in array.dims or len(labelled) != 1:
            remedy = f"give it the dimensions t and joint, or drop it: ds.drop_vars({str(variable)!r})"
            raise InputError(f"the variable has the dimensions {array.dims}", key=str(variable), remedy=remedy)
        values = array.transpose("t", labelled[0]).values
        for column, label in enumerate(dataset.coords[labelled[0]].values):
            name = f"{variable}.{label}"
            mixed = variable in SIGNALS and " or " in unit
            known = signal_unit(str(variable), prismatic=str(label) in sliding) if mixed else unit
            yield name, _variable_numbers(values[:, column], name), known


def _sliding(dataset: Any) -> set[str]:
    """Joints that the coordinate ``joint_type`` calls prismatic."""
    if "joint_type" not in dataset.coords or dataset.coords["joint_type"].dims != ("joint",):
        return set()
    pairs = zip(dataset.coords["joint"].values, dataset.coords["joint_type"].values, strict=True)
    return {str(joint) for joint, kind in pairs if str(kind) == "prismatic"}


def _variable_numbers(values: Any, name: str) -> Array:
    """A column of its own."""
    if np.asarray(values).dtype.kind in "mM":
        remedy = "give seconds as doubles: (time - time[0]) / np.timedelta64(1, 's')"
        raise InputError("the column holds dates or durations", remedy=remedy, channel=name)
    return as_floats(values, name, copy=True)


def _order(dataset: Any) -> list[str]:
    try:
        order = json.loads(str(dataset.attrs.get("channels", "[]")))
    except (ValueError, RecursionError):
        order = []
    return [name for name in order if isinstance(name, str)] if isinstance(order, list) else []


def _forget_units(table: Table) -> None:
    """Leave out meta data of channels that the dataset does not have any more."""
    units = table.meta.get("units")
    if isinstance(units, dict):
        table.meta["units"] = {name: unit for name, unit in units.items() if name in table.columns}
        if not table.meta["units"]:
            del table.meta["units"]
