"""What the inputs are tried on: every reader, the command line, and the border of the core."""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path

import flexdyn as fd
from flexdyn.batch.results import open_results
from flexdyn.batch.studyfile import read_study
from flexdyn.cli.recordings import load
from flexdyn.records.apart import caller
from flexdyn.simulation.command_input import make_drive
from tests.fuzz import command_line, core_border, corpus, meshes
from tests.fuzz.mutate import Mutator, a_number, any_archive, any_bytes, any_store, any_text


@dataclass(frozen=True)
class Target:
    """One reader, or whatever else takes inputs.

    Attributes:
        name: of it.
        suffix: of its files.
        seeds: makes the valid files that damage starts from, in a folder.
        mutate: makes an input of the seeds.
        run: tries an input in a folder; a FlexdynError is an answer, any other exception a fault.
        share: of a hundred inputs, how many are for it.
        batch: inputs that one child tries, one after the other.
        apart: whether another process does the work.
    """

    name: str
    suffix: str
    seeds: Callable[[Path], list[bytes]]
    mutate: Mutator
    run: Callable[[Path, bytes], None]
    share: float
    batch: int = 1000
    apart: bool = False

    def end(self) -> None:
        """End the processes that did the work, so that their memory is counted."""
        caller._release_all(caller._Server.end)


def _recording(folder: Path, data: bytes, *, suffix: str) -> None:
    path = folder / f"input{suffix}"
    path.write_bytes(data)
    fd.read_recording(path)


def _model(folder: Path, data: bytes) -> None:
    (folder / "input.yaml").write_bytes(data)
    model = fd.load_model(folder / "input.yaml")
    assert isinstance(hash(model), int)


def _urdf(folder: Path, data: bytes) -> None:
    (folder / "input.urdf").write_bytes(data)
    robot = fd.load_robot(folder / "input.urdf")
    fd.FlexibleJointModel(robot)


def _study(folder: Path, data: bytes) -> None:
    (folder / "input.yaml").write_bytes(data)
    read_study(folder / "input.yaml")


@cache
def _before(folder: Path) -> fd.FlexibleJointModel:
    return fd.load_model(folder / "model.yaml")


def _report(folder: Path, data: bytes) -> None:
    (folder / "report.json").write_bytes(data)
    found = fd.compare_models([_before(folder), folder / "model.yaml"])
    json.dumps(found.to_dict())
    str(found)


@cache
def _scara() -> fd.FlexibleJointModel:
    return fd.load_model("scara_two_link")


def _command(folder: Path, data: bytes, *, suffix: str) -> None:
    (folder / f"input{suffix}").write_bytes(data)
    make_drive(_scara(), folder / f"input{suffix}", None)


def _side_by_side(folder: Path, data: bytes) -> None:
    (folder / "input.csv").write_bytes(data)
    load(folder / "input.csv+other.csv")
    load(Path(f"other.csv+{folder / 'input.csv'}"))


def _store(folder: Path, data: bytes) -> None:
    place = folder / "store.zarr"
    shutil.rmtree(place, ignore_errors=True)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        archive.extractall(place)
    results = open_results(place)
    json.dumps(asdict(results.summary()))
    assert repr(results).isprintable()
    results.extract(0, folder / "extracted")


def _map(folder: Path, data: bytes) -> None:
    (folder / "input.yaml").write_bytes(data)
    fd.read_recording(folder / "log.csv", map=folder / "input.yaml")


def _reader(
    name: str, suffix: str, seeds: Callable[[Path], list[bytes]], share: float, mutate: Mutator = any_bytes
) -> Target:
    apart = name in ("HDF5", "MAT 5", "MAT 7.3")
    return Target(name, suffix, seeds, mutate, partial(_recording, suffix=suffix), share, apart=apart)


def _shape(name: str, seeds: Callable[[Path], list[bytes]], mutate: Mutator) -> Target:
    suffix = f".{name.lower()}"
    return Target(name, suffix, seeds, mutate, partial(meshes.shown, suffix=suffix), 0.6, batch=200, apart=True)


def _written(suffix: str) -> Callable[[Path], list[bytes]]:
    return partial(corpus.written, (corpus.SMALL, corpus.WIDE), suffix)


TARGETS = (
    _reader("CSV", ".csv", corpus.tables, 34, any_text),
    _reader("NPZ", ".npz", _written(".npz"), 12, any_archive),
    _reader("HDF5", ".h5", corpus.hdf5, 2),
    _reader("Parquet", ".parquet", _written(".parquet"), 10),
    _reader("MAT 5", ".mat", _written(".mat"), 2),
    _reader("MAT 7.3", ".mat", corpus.mat73, 1.2),
    _reader("ROS 1 bag", ".bag", corpus.ros1, 4),
    _reader("MCAP", ".mcap", corpus.mcap, 4),
    _reader("ROS 2 bag", ".db3", corpus.db3, 3),
    Target("model", ".yaml", corpus.models, any_text, _model, 1.5),
    Target("URDF", ".urdf", lambda folder: [corpus.URDF], any_text, _urdf, 6),
    _shape("STL", meshes.stl, any_bytes),
    _shape("OBJ", meshes.obj, any_text),
    _shape("DAE", meshes.dae, any_text),
    Target("study", ".yaml", corpus.studies, any_text, _study, 0.6),
    Target("channel map", ".yaml", corpus.maps, any_text, _map, 2.5),
    Target("command file", ".yaml", corpus.commands, any_text, partial(_command, suffix=".yaml"), 1.5),
    Target("command table", ".csv", corpus.torques, any_text, partial(_command, suffix=".csv"), 2),
    Target("side by side", ".csv", corpus.halves, any_text, _side_by_side, 2),
    Target("report", ".json", corpus.reports, any_text, _report, 0.6),
    Target("store", ".zip", corpus.stores, any_store, _store, 0.6),
    Target("command line", ".txt", command_line.prepare, a_number, command_line.run, 0.8, batch=200),
    Target("border of the core", ".txt", lambda folder: [b""], a_number, core_border.run, 4, batch=500),
)
