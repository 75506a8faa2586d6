"""The checks of doctor: versions, extras, a compiler, and a self-test against closed forms."""

from __future__ import annotations

import math
import platform
import re
import shutil
import sys
import tempfile
import time
from importlib import import_module, metadata
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.control.samples import Samples
from flexdyn.effects import ViscousFriction
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model
from flexdyn.records import read_recording, write_recording
from flexdyn.simulation import solvers
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.simulate import simulate

EXTRAS: dict[str, tuple[str, tuple[str, ...]]] = {
    "plot": ("pictures and reports", ("matplotlib", "plotly")),
    "hdf5": ("HDF5 and MATLAB v7.3", ("h5py",)),
    "parquet": ("Parquet", ("pyarrow",)),
    "ros": ("ROS bags and MCAP", ("rosbags",)),
    "xarray": ("xarray datasets", ("xarray",)),
    "pandas": ("pandas data frames", ("pandas",)),
    "batch": ("batch studies", ("zarr", "numcodecs", "google_crc32c", "dask", "distributed", "xarray")),
}
"""What each extra is for, and the modules that it brings."""
COMPILERS = ("c++", "g++", "clang++", "cl")
AGREE, CLOSED, DECAY = 1e-8, 1e-9, 1e-5
"""Bounds of the self-test: [rad], relative, [rad/s]; far above the errors of a correct installation."""


def versions() -> dict[str, str]:
    """Versions by name; of the interpreter and the system too."""
    found = {"Python": platform.python_version(), "system": f"{platform.system()} {platform.machine()}"}
    required = [each for each in metadata.requires("flexdyn") or () if "extra ==" not in each]
    for name in ("flexdyn", *(re.split(r"[^\w.-]", each)[0] for each in required)):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed as a package"
    return found | {"flexdyn stands in": str(Path(sys.modules["flexdyn"].__file__ or "").parent)}


def extras() -> list[dict[str, Any]]:
    """Whether each extra's libraries can be imported, and if not, why."""
    found = []
    for name, (_, modules) in EXTRAS.items():
        states = {module: _imported(module) for module in modules}
        wrong = [f"{module}: {state}" for module, state in states.items() if state]
        found.append({"name": name, "works": not wrong, "state": "; ".join(wrong) or "installed"})
    return found


def _imported(module: str) -> str:
    """What is wrong with a module; empty if nothing is."""
    try:
        import_module(module)
    except ModuleNotFoundError as error:
        return "not installed" if error.name == module else f"lacks {error.name}"
    except Exception as error:  # a broken library may raise anything
        return f"cannot be imported ({type(error).__name__}: {error})"
    return ""


def compiler() -> str | None:
    """Path of a C++ compiler, if one is found."""
    return next((path for name in COMPILERS if (path := shutil.which(name))), None)


def self_test() -> list[dict[str, Any]]:
    """Tests with known answers, each with the measured value."""
    began = time.perf_counter()
    tests = [_guarded(name, run) for name, run in TESTS.items()]
    seconds = time.perf_counter() - began
    return [*tests, {"name": "time for all", "passed": True, "measured": f"{seconds:.2f} s"}]


def _guarded(name: str, run: Any) -> dict[str, Any]:
    try:
        passed, measured = run()
    except Exception as error:  # doctor reports any failure
        passed, measured = False, f"{type(error).__name__}: {error}"
    return {"name": name, "passed": bool(passed), "measured": measured}


def _arm() -> FlexibleJointModel:
    return load_model("scara_two_link")


def _solvers() -> tuple[bool, str]:
    """Two solvers that share no formula give one motion."""
    model = _arm().replace(effects=[])
    t = np.linspace(0.0, 1.0, 51)
    push = Samples(t, np.column_stack([0.3 * np.sin(6.0 * t), 0.2 * np.cos(5.0 * t)]), "cubic")
    exact = simulate(model, push, solver=solvers.DormandPrince(rtol=1e-11, atol=1e-12), rate=100.0)
    steps = simulate(model, push, solver=solvers.RungeKutta4(step=2e-4), rate=100.0)
    apart = float(np.abs(exact.q - steps.q).max())
    return apart < AGREE, f"apart by {apart:.1e} rad, at most {AGREE:g}"


def _energy() -> tuple[bool, str]:
    """The energy of a swing without friction is constant."""
    tight = solvers.DormandPrince(rtol=1e-11, atol=1e-12)
    run = simulate(_arm().replace(effects=[]), duration=1.0, v0=[0.8, -0.5], solver=tight)
    energy = run.energy.mechanical
    drift = float(np.abs(energy - energy[0]).max() / energy[0])
    return drift < CLOSED, f"drift {drift:.1e}, at most {CLOSED:g}"


def _friction() -> tuple[bool, str]:
    """With an almost locked elbow, viscous friction b slows the shoulder as v = exp(-b t/M)."""
    locked, b = ViscousFriction("elbow", side="link", coefficient=1e9), 0.7
    model = _arm().replace(
        joints={"*": {"stiffness": math.inf}},
        effects=[locked, ViscousFriction("shoulder", side="link", coefficient=b)],
        initial={},
    )
    M = float(LinkSide(model).mass_matrix(np.zeros(2))[0, 0])
    run = simulate(model, duration=1.0, v0=[1.0, 0.0], solver="Rosenbrock")
    apart = float(np.abs(run.v[:, 0] - np.exp(-b * run.t / M)).max())
    return apart < DECAY, f"apart by {apart:.1e} rad/s, at most {DECAY:g}"


def _files() -> tuple[bool, str]:
    """A recording written and read back is the same, bit for bit."""
    rec = simulate(_arm(), duration=0.2).to_recording()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        write_recording(rec, path)
        return read_recording(path).same_as(rec), f"{len(rec)} samples through CSV"


TESTS = {
    "two solvers agree": _solvers,
    "energy is conserved": _energy,
    "friction as in closed form": _friction,
    "a file is read back unchanged": _files,
}
