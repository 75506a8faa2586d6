"""The files of slowest_files.py: within every limit, and as dear to read as they can be made."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import flexdyn as fd
from flexdyn.batch.studyfile import read_study
from tests.fuzz import corpus
from tests.records.ros_bags import JOINT_STATE, Maker

YAML = 499_000  # bytes, of 500,000
ZEROS = 30_000_000  # numbers, 240 MB: the most that small files may unpack to


@dataclass(frozen=True)
class Case:
    """One file.

    Attributes:
        reader: whose.
        name: what is dear about it.
        suffix: of it.
        make: writes it at a path, of about so many megabytes.
        read: what is timed.
        limit: of the format by which no file can be dearer; empty: time grows with the file.
        apart: whether another process reads it.
    """

    reader: str
    name: str
    suffix: str
    make: Callable[[Path, float], None]
    read: Callable[[Path], Any] = fd.read_recording
    limit: str = ""
    apart: bool = False


def _csv(columns: int, cell: str, *, dates: bool = False) -> Callable[[Path, float], None]:
    def stamp(k: int) -> str:
        clock = f"{k // 36_000 % 24:02}:{k // 600 % 60:02}:{k / 10 % 60:04.1f}"
        return f"2024-01-{1 + k // 864_000:02} {clock}" if dates else str(k)

    def make(path: Path, megabytes: float) -> None:
        rest = f",{cell}" * columns
        rows = max(3, round(megabytes * 1e6 / (len(rest) + 12)))
        names = ",".join(["t", *(f"q.j{k}" for k in range(columns))])
        path.write_text(names + "\n" + "".join(f"{stamp(k)}{rest}\n" for k in range(rows)), encoding="utf-8")

    return make


def _zeros(columns: int) -> dict[str, np.ndarray[Any, Any]]:
    count = ZEROS // columns
    found = {f"q.j{k}": np.zeros(count) for k in range(columns - 1)}
    return {"t": np.arange(float(count)), **found}


def _npz(path: Path, megabytes: float) -> None:
    np.savez_compressed(path, **_zeros(30))  # type: ignore[arg-type]


def _many(path: Path, megabytes: float) -> None:
    t = np.arange(3.0)
    fd.write_recording(fd.Recording(t, {f"q.j{k}": t for k in range(9_990)}), path)


def _mat(path: Path, megabytes: float) -> None:
    from scipy.io import savemat

    savemat(path, {name.replace(".", "_"): values for name, values in _zeros(30).items()}, do_compression=True)


def _hdf5(path: Path, megabytes: float) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in _zeros(30).items():
            file.create_dataset(name, data=values, compression="gzip", chunks=(1000,))


def _parquet(path: Path, megabytes: float) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table(_zeros(30)), path, row_group_size=2000)


def _bag(kind: str) -> Callable[[Path, float], None]:
    def make(path: Path, megabytes: float) -> None:
        (path.parent / "made").mkdir()
        maker = Maker(ros1=kind.startswith("bag"))
        count = round(megabytes * 1e6 / 250)
        states = ((row, maker.state(row * 1000, ["a"], [row])) for row in range(1, count))
        maker.write(
            path.parent / "made", kind, [("/joint_states", JOINT_STATE, row * 1000, each) for row, each in states]
        )
        next(each for each in (path.parent / "made").rglob("*") if each.suffix == path.suffix).rename(path)

    return make


def _yaml(head: bytes, entry: str, tail: bytes = b"") -> Callable[[Path, float], None]:
    def make(path: Path, megabytes: float) -> None:
        corpus.models(path.parent)
        corpus.studies(path.parent)
        corpus.maps(path.parent)
        room = YAML - len(head) - len(tail)
        lines: list[str] = []
        while room > 0:
            lines.append(entry.replace("NUMBER", str(len(lines))))
            room -= len(lines[-1])
        path.write_bytes(head + "".join(lines[:-1]).encode() + tail)

    return make


def _urdf(path: Path, megabytes: float) -> None:
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    shape = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    each = shape * round(4.6e6 / 1000 / len(shape))
    links = "".join(f'<link name="l{k}">{body}{each}</link>' for k in range(1000))
    joints = "".join(
        f'<joint name="j{k}" type="{"continuous" if k < 200 else "fixed"}"><parent link="l{k}"/>'
        f'<child link="l{k + 1}"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint>'
        for k in range(999)
    )
    path.write_text(f'<robot name="r">{links}{joints}</robot>'[:4_999_999], encoding="utf-8")


def _model_of(path: Path) -> None:
    fd.FlexibleJointModel(fd.load_robot(path))


def _mapped(path: Path) -> None:
    fd.read_recording(path.parent / "log.csv", map=path)


EFFECTS = corpus.MODEL[: corpus.MODEL.index(b"command")]
GRID = corpus.STUDY[: corpus.STUDY.index(b"runs")] + b"keep: [q]\nvary:\n  joints.shoulder.stiffness: {grid: [1"
CASES = (
    Case("CSV", "two columns of one digit", ".csv", _csv(1, "1")),
    Case("CSV", "100 columns of one digit", ".csv", _csv(100, "1")),
    Case("CSV", "9,999 columns", ".csv", _csv(9_998, "1"), limit="columns"),
    Case("CSV", "dates, and quoted numbers", ".csv", _csv(1, '"1"', dates=True)),
    Case("NPZ", "240 MB of zeros, packed", ".npz", _npz),
    Case("NPZ", "9,990 channels of three samples", ".npz", _many, limit="columns"),
    Case("HDF5", "240 MB of zeros, in chunks of 8 kB", ".h5", _hdf5, limit="time", apart=True),
    Case("HDF5", "9,990 channels of three samples", ".h5", _many, limit="time", apart=True),
    Case("Parquet", "240 MB of zeros, in groups of 2,000 rows", ".parquet", _parquet),
    Case("Parquet", "9,990 channels of three samples", ".parquet", _many, limit="columns"),
    Case("MAT 5", "240 MB of zeros, packed", ".mat", _mat, limit="time", apart=True),
    Case("MAT 5", "9,990 channels of three samples", ".mat", _many, limit="time", apart=True),
    Case("ROS 1 bag", "messages of one joint, bz2", ".bag", _bag("bag bz2")),
    Case("MCAP", "messages of one joint, zstd", ".mcap", _bag("mcap zstd")),
    Case("ROS 2 bag", "messages of one joint", ".db3", _bag("db3")),
    Case(
        "model",
        "500 kB of effects",
        ".yaml",
        _yaml(EFFECTS, "- {effect: payload, mass: 1.0}\n"),
        fd.load_model,
        "bytes",
    ),
    Case("model", "500 kB of brackets", ".yaml", _yaml(b"robot: [", "1,"), fd.load_model, "bytes"),
    Case("study", "500 kB of values of a grid", ".yaml", _yaml(GRID, ",NUMBER.5", b"]}\n"), read_study, "bytes"),
    Case(
        "channel map",
        "500 kB of channels",
        ".yaml",
        _yaml(corpus.MAP[: corpus.MAP.index(b"  q.slide")], "  q.jNUMBER: 3\n"),
        _mapped,
        "bytes",
    ),
    Case("URDF", "5 MB, 1,000 links, 200 joints that move", ".urdf", _urdf, _model_of, "bytes"),
)
