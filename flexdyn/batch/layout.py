"""The arrays of a study's store: names, shapes, units, which follow from the study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.batch.cases import Cases
from flexdyn.records.dataset import LONG_NAMES
from flexdyn.records.units import signal_unit

DONE = "ok"
NOT_DONE = "not done"
_LONGEST_ARRAY = 200  # bytes
_FILL = {"string": NOT_DONE, "float64": np.nan, "int64": 0}


@dataclass(frozen=True)
class StoreArray:
    """One array of a store.

    Attributes:
        name: of the array.
        dims: of ``run``, ``time``, ``joint``.
        shape: in runs, samples, joints.
        piece: shape of each of the pieces that it is cut into, all alike: a chunk of runs, or all of a coordinate.
        dtype: as zarr calls it: ``float64``, ``int64`` or ``string``.
        attrs: kind, units, long_name; ``name`` where the array's own is another, see `array_name`.
        values: of a coordinate, which is written at once; None: chunk by chunk.
    """

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    piece: tuple[int, ...]
    dtype: str
    attrs: Mapping[str, str]
    values: Any = None

    @property
    def fill(self) -> Any:
        """The value where nothing is written yet."""
        return _FILL[self.dtype]


def layouts(cases: Cases) -> Iterator[StoreArray]:
    """Every array of a study's store; ``status`` is the last.

    Args:
        cases: of the study.
    """
    study, names, times = cases.study, np.array(cases.model.joint_names, dtype=object), cases.times
    yield _coordinate("run", "int64", {"long_name": "number of the run"}, np.arange(study.count))
    yield _coordinate("time", "float64", {"units": "s", "long_name": "time"}, times)
    yield _coordinate("joint", "string", {"long_name": "joint"}, names)
    runs, chunk, rest = (study.count,), (study.chunk,), (len(times), len(names))
    kinds = dict.fromkeys(cases.model.robot.kinds)
    for signal in study.keep:
        units = [signal_unit(signal, prismatic=kind == "prismatic") for kind in kinds]
        attrs = {"kind": "channel", "units": " or ".join(units), "long_name": LONG_NAMES[signal]}
        yield StoreArray(signal, ("run", "time", "joint"), runs + rest, chunk + rest, "float64", attrs)
    for path in study.vary:
        attrs = {"kind": "parameter", "units": cases.places[path].unit, "long_name": path}
        yield _column(path, runs, chunk, attrs)
    for metric in cases.metrics:
        attrs = {"kind": "metric", "units": metric.unit, "long_name": metric.description}
        yield _column(metric.name, runs, chunk, attrs)
    attrs = {"kind": "status", "long_name": f"{DONE}, or why the run or a metric of it failed"}
    yield StoreArray("status", ("run",), runs, chunk, "string", attrs)


def _coordinate(name: str, dtype: str, attrs: Mapping[str, str], values: NDArray[Any]) -> StoreArray:
    return StoreArray(name, (name,), values.shape, values.shape, dtype, attrs, values)


def _column(name: str, runs: tuple[int, ...], chunk: tuple[int, ...], attrs: Mapping[str, str]) -> StoreArray:
    """One number a run."""
    stored = array_name(name)
    told = attrs if stored == name else {**attrs, "name": name}
    return StoreArray(stored, ("run",), runs, chunk, "float64", told)


def array_name(name: str) -> str:
    """The array of a number or metric: Zarr makes groups of slashes, and file systems take some 250 bytes.

    Args:
        name: path of a number, or a metric's name.
    """
    safe = name.replace("%", "%25").replace("/", "%2F").replace("\\", "%5C")
    if len(safe.encode()) <= _LONGEST_ARRAY:
        return safe
    begin = safe.encode()[: _LONGEST_ARRAY // 2].decode(errors="ignore")
    return f"{begin}%{sha256(name.encode()).hexdigest()[:32]}"
