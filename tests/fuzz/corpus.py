"""Small valid files of every kind, written by code; damage starts from them."""

from __future__ import annotations

import io
import shutil
import zipfile
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import flexdyn as fd
from flexdyn.records import Recording, write_recording
from flexdyn.records.matlab import file as mat_file
from tests.records.ros_bags import JOINT_STATE, Maker

T = np.array([0.0, 0.1, 0.2, 0.3])
SMALL = Recording(T, {"q.a": T, "tau.a/b": -T}, meta={"a": [1, {"b": None}]})
WIDE = Recording(T, {f"{signal}.{joint}": T * 2 for signal in ("q", "v", "tau") for joint in ("elbow", "wrist")})

MAP = b"""\
flexdyn_map: 1
source: {names_line: 1, first_line: 2, delimiter: ",", decimal: ".", encoding: latin-1}
time: {from: t, unit: s, start: zero, shift: 0.012}
joints:
  elbow: {gear_ratio: 100, torque_constant: 0.05}
channels:
  q.elbow: {from: a, unit: deg, sign: -1, offset: 0.2}
  theta.elbow: {from: b, unit: counts, counts_per_turn: 131072, side: motor}
  tau.elbow: {from: c, unit: A, side: motor}
  q.slide: 3
  tau.slide: c
couplings:
  - {joints: [elbow, slide], position: [[0.5, 0.5], [0.5, -0.5]], signals: [q]}
others: drop
repair: [sort_time, {fill_nan: {longest: 0.5}}]
"""
MAPPED = "t,a,b,c\n" + "".join(f"{0.1 * k},{k},{k * k},{-k}\n" for k in range(6))

MODEL = b"""\
flexdyn: 1
robot: {urdf: scara_two_link, gravity: [0.0, 0.0, -9.81], rotor_coupling: reduced}
joints:
  "*": {damping: 1.0}
  shoulder: {rotor_inertia: 0.1, stiffness: 40.0, gear_ratio: 2.0}
  elbow: {rotor_inertia: 0.01, stiffness: 4.0e+3}
initial: {q: {shoulder: 1.0}, theta: {shoulder: 1.0}}
tolerance: {"*": 0.03, joints.shoulder.stiffness: 0.1}
effects:
- {effect: viscous_friction, joint: shoulder, side: motor, coefficient: 3.0}
- {effect: coulomb_friction, joint: elbow, side: link, level: 0.3}
- {effect: payload, mass: 1.0, frame: tool}
command: {pd: {reference: {t: [0, 1, 2], shoulder: [0, 0.5, 0]}, kp: 10.0, kd: 1.0}}
"""
LOCKED = b"""\
flexdyn: 1
robot: {urdf: arm.urdf, lock: {elbow: 0.1}, package_dirs: [.], urdf_dynamics: use}
joints: {shoulder: &a {rotor_inertia: 0.1, stiffness: 40.0}}
effects: [{effect: end_stop, joint: shoulder, lower: -1.0, upper: 1.0, stiffness: 1.0e+4, damping: 10.0}]
"""

REPORT = b"""\
{"schema": "flexdyn.diagnosis/2", "verdict": "explained",
 "findings": [
  {"effect": "backlash", "joint": "elbow", "side": null, "probability": 0.998,
   "parameters": {"half_gap": {"value": 1.2e-3, "std": 5e-5, "interval": [1.1e-3, 1.3e-3], "unit": "rad"}}},
  {"effect": "parameter_error", "joint": "elbow", "side": null, "of": "elbow", "parameter": "stiffness",
   "parameters": {"factor": {"value": 0.9, "std": 0.01}}, "probability": 1}],
 "calibration": [{"of": "shoulder", "parameter": "rotor_inertia", "factor": 0.98, "std": null, "tolerance": 0.03},
  {"of": "effects[1]", "parameter": "level", "factor": 1.1, "std": 0.1}],
 "considered": [{"effect": "coulomb_friction", "joint": "elbow", "side": "link", "parameters": {}, "probability": 0.4},
  {"effect": "sensor_offset", "channel": "q.elbow", "parameters": {}, "probability": null}]}
"""

COMMANDS = (
    b"pd: {reference: {t: [0, 1, 2], shoulder: [0, 0.5, 0], interpolation: monotone}, kp: 400, kd: 20, rate: 1000}\n",
    b"pd:\n  reference: goal.csv\n  kp: {shoulder: 10, elbow: 5.0}\n  kd: [1, 2]\n  interpolation: cubic\n"
    b"  feedback: theta\n  feedforward: {t: [0.0, 0.02], elbow: [1, 2]}\n",
    b"torques: {t: [0, 0.5, 1], elbow: [0, 2, 0], interpolation: linear}\n",
)

STUDY = b"""\
flexdyn_study: 1
model: model.yaml
duration: 0.05
rate: 1000
solver: {name: TimeStepping, step: 1.0e-3}
runs: 4
seed: 7
vary:
  joints.shoulder.stiffness: {uniform: [30.0, 50.0]}
  joints.elbow.damping: {normal: [1.0, 0.1]}
keep: [q, theta]
"""
GRID = b"""\
flexdyn_study: 1
model: scara_two_link
command: run.csv
duration: 0.02
vary: {joints.elbow.stiffness: {grid: [30.0, 40.0, 50.0]}, joints.shoulder.rotor_inertia: {lognormal: [0.1, 0.2]}}
runs: 3
keep: [q]
chunk: 2
"""

URDF = b"""\
<?xml version="1.0"?>
<robot name="arm">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"><visual><geometry><box size="0.1 0.1 0.1"/></geometry><material name="grey"/></visual></link>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0" rpy="0 0 0.3"/><mass value="2.0"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <visual><geometry><mesh filename="package://arm/upper.stl" scale="1 1 1"/></geometry></visual>
  </link>
  <link name="lower">
    <inertial><mass value="1.0"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision>
  </link>
  <link name="finger"/><link name="tool"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2.0" upper="2.0" effort="10" velocity="3"/><dynamics damping="0.1" friction="0.2"/>
  </joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/></joint>
  <joint name="grip" type="prismatic"><parent link="lower"/><child link="finger"/>
    <limit lower="0" upper="0.1" effort="1" velocity="1"/><mimic joint="elbow" multiplier="0.1" offset="0.01"/></joint>
  <joint name="flange" type="fixed"><parent link="lower"/><child link="tool"/><origin xyz="0.3 0 0"/></joint>
</robot>
"""


def written(recordings: tuple[Recording, ...], suffix: str, folder: Path) -> list[bytes]:
    """The recordings as files of one format."""
    files = []
    for number, recording in enumerate(recordings):
        path = folder / f"seed{number}{suffix}"
        if not path.exists():
            write_recording(recording, path)
        files.append(path.read_bytes())
    return files


def tables(folder: Path) -> list[bytes]:
    """CSV as other programs write it."""
    return [
        b't,q.a,tau.a\n0,1,2\n0.1,1.5,2\n0.2,2,3\n"0.3",-1e-3,4\n',
        b"t;q.a [rad];v.a\r\n0;1,5;2\r\n0,1;1,6;3\r\n",
        b"# a comment\n# t is time\nt\tq.elbow\tv.elbow\n0\t1\t2\n1\t1\t2\n2\t1\t2\n",
        b"t,q.a\n2024-01-02 03:04:05.6,1\n2024-01-02 03:04:05.7,2\n2024-01-02 03:04:05.8,2\n",
        *written((SMALL, WIDE), ".csv", folder),
    ]


MATLAB_HEAD = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024 HDF5 schema 1.00 ."
PACKED: tuple[dict[str, Any], ...] = ({}, {"chunks": (2,), "compression": "gzip", "shuffle": True})


def hdf5(folder: Path) -> list[bytes]:
    """As flexdyn writes them, and as most programs do: in the oldest form, which has no checksums to find damage by."""
    files = written((SMALL, WIDE), ".h5", folder)
    for packed in PACKED:
        with h5py.File(folder / "oldest.h5", "w", libver="earliest") as file:
            file.create_dataset("t", data=T, **packed)
            file.create_dataset("q/elbow", data=T, **packed).attrs["unit"] = "rad"
            file.create_dataset("tau/elbow", data=-T, **packed)
        files += [(folder / "oldest.h5").read_bytes()] * 2
    return files


def mat73(folder: Path) -> list[bytes]:
    """MAT-files of version 7.3, which is written where a variable is too large for version 5; and MATLAB's own form."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mat_file, "LARGEST_V5", 0)
        files = written((SMALL, WIDE), ".mat", folder)
    for packed in PACKED:
        with h5py.File(folder / "oldest.mat", "w", libver="earliest", userblock_size=512) as file:
            for name, values in (("t", T), ("q/elbow", T), ("tau/elbow", -T)):
                file.create_dataset(name, data=values[None], **{**packed, **({"chunks": (1, 2)} if packed else {})})
                file[name].attrs["MATLAB_class"] = np.bytes_("double")
            for name in ("q", "tau"):
                file[name].attrs["MATLAB_class"] = np.bytes_("struct")
        data = (folder / "oldest.mat").read_bytes()
        files += [MATLAB_HEAD.ljust(124) + b"\0\2IM" + data[128:]] * 2
    return files


def bags(folder: Path, *, kinds: tuple[str, ...]) -> list[bytes]:
    """Bags by rosbags, packed and plain."""
    files = []
    for kind in kinds:
        maker = Maker(ros1=kind.startswith("bag"))
        states = [maker.state(row, ["a", "b"], [row, 2 * row], [1, 2]) for row in range(1, 6)]
        messages = [("/joint_states", JOINT_STATE, row, state) for row, state in enumerate(states, 1)]
        place = folder / kind.replace(" ", "_")
        if not place.exists():
            place.mkdir()
            maker.write(place, kind, messages)
        files.append(next(path for path in place.iterdir() if path.is_file()).read_bytes())
    return files


ros1 = partial(bags, kinds=("bag", "bag bz2", "bag lz4"))
mcap = partial(bags, kinds=("mcap", "mcap zstd"))
db3 = partial(bags, kinds=("db3",))


def models(folder: Path) -> list[bytes]:
    """Model files, and the URDF that one of them names."""
    (folder / "arm.urdf").write_bytes(URDF)
    return [MODEL, LOCKED]


def reports(folder: Path) -> list[bytes]:
    """A report of a diagnosis, and the model that it belongs to."""
    (folder / "model.yaml").write_bytes(MODEL)
    return [REPORT]


def studies(folder: Path) -> list[bytes]:
    """Study files, with the model and the command that they name."""
    (folder / "model.yaml").write_bytes(MODEL[: MODEL.index(b"command")])
    rest = np.linspace(0.0, 0.02, 5)
    write_recording(Recording(rest, {"tau.shoulder": rest, "tau.elbow": rest}), folder / "run.csv")
    return [STUDY, GRID]


def commands(folder: Path) -> list[bytes]:
    """Command files, and the recording that one of them names."""
    rest = np.linspace(0.0, 0.02, 5)
    write_recording(Recording(rest, {"q.shoulder": rest, "q.elbow": -rest}), folder / "goal.csv")
    return [*COMMANDS]


def torques(folder: Path) -> list[bytes]:
    """Commands as tables: torques of both joints, of one, and with the first state."""
    return [
        b"t,tau.shoulder,tau.elbow\n0,1,2\n0.1,1.5,2\n0.2,2,3\n",
        b"t;tau.elbow [N m]\n0;1,5\n0,1;1,6\n",
        b"t,q.shoulder,v.elbow,tau.shoulder,tau.elbow\n0,1,0.1,2,0\n0.5,1,0.1,2,1\n1,1,0.1,2,2\n",
    ]


def halves(folder: Path) -> list[bytes]:
    """Tables that stand beside another one, ``other.csv``, which is there."""
    write_recording(Recording(T * 1.5, {"tau.wrist": T, "v.wrist": -T}), folder / "other.csv")
    return [
        b"t,q.wrist,v.elbow\n0,1,2\n0.1,1.5,2\n0.2,2,3\n0.3,2,3\n0.4,2,3\n",
        b"# start_ns: 5\nt;q.a [rad];v.a\n0;1,5;2\n0,1;1,6;3\n0,2;1,6;3\n",
        *written((SMALL,), ".csv", folder),
    ]


def stores(folder: Path) -> list[bytes]:
    """Archives of stores: of a study that is done, and of one that lacks a chunk."""
    (folder / "study.yaml").write_bytes(studies(folder)[1])
    place = folder / "seed.zarr"
    if not place.exists():
        fd.run_study(folder / "study.yaml", place)
    whole = shutil.make_archive(str(folder / "whole"), "zip", place)
    left = io.BytesIO()
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(left, "w") as copy:
        for name in source.namelist():
            if "/c.1" not in name:
                copy.writestr(name, source.read(name))
    return [Path(whole).read_bytes(), left.getvalue()]


def maps(folder: Path) -> list[bytes]:
    """A channel map, and a table that it fits."""
    (folder / "log.csv").write_text(MAPPED)
    return [MAP]
