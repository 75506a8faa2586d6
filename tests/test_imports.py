"""The architecture, held by reading every import statement; and an import of flexdyn that stays light."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import flexdyn

PACKAGE = Path(flexdyn.__file__).parent
FILES = sorted(path for path in PACKAGE.rglob("*.py") if "core" not in path.relative_to(PACKAGE).parts[:1])
HEAVY = ("scipy", "matplotlib", "h5py", "lxml", "yourdfpy", "ruamel", "typer", "rich", "trimesh", "meshcat", "mujoco")
PICTURES_AND_FORMATS = ("plotly", "pyarrow", "rosbags", "xarray", "pandas", "zarr", "dask", "distributed")
FORMATS = {
    "h5py": "records/hdf5",
    "lxml": "robot/xmlfile.py",
    "pyarrow": "records/parquet_file.py",
    "rosbags": "records/ros",
    "ruamel": "yamlfile.py",
    "xarray": "records/dataset.py batch/results.py",
}
NEVER = {
    "effects": ("simulate", "records", "diagnose"),
    "commands": ("simulate", "records", "diagnose"),
    "solvers": ("simulate", "records", "diagnose"),
    "records": ("model", "effects", "_core", "simulate"),
    "simulate": ("diagnose", "batch", "viewer"),
    "diagnose": ("viewer", "cli"),
    "errors": ("model", "robot", "effects", "records", "simulate", "_core"),
}
EQUATIONS = ("data", "equations", "hypothesis")
STAGES = {
    "data": (),
    "equations": ("data", "report"),
    "hypothesis": ("data", "equations"),
    "shooting": (),
    "inference": EQUATIONS,
    "experiment": (*EQUATIONS, "shooting", "report"),
    "decision": (*EQUATIONS, "shooting", "inference", "experiment", "report"),
    "report": (),
}
"""Folders of `flexdyn.diagnose`, and which others each may know: what compares knows no test data and no report."""


def name_of(path: Path) -> str:
    """Module name inside the package: ``effects.base``."""
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__")


def imports(path: Path) -> Iterator[str]:
    """Every module that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            yield str(node.module)
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_there_is_something_to_check() -> None:
    """The walk over the package finds its modules."""
    assert {"simulate", "effects.base", "records.recording", "robot.load"} <= {name_of(path) for path in FILES}


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_forbidden_imports(path: Path) -> None:
    """Who may know whom (docs/architecture.md): a law knows no solver, a recording no model, nobody the tests."""
    here = name_of(path).split(".")[0]
    found = set(imports(path))
    for layer, forbidden in NEVER.items():
        if here == layer:
            for module in found:
                parts = module.split(".")
                assert not (parts[0] == "flexdyn" and parts[1:2] and parts[1] in forbidden), f"{path}: {module}"
    roots = {module.split(".")[0] for module in found}
    assert not roots & {"tests", "benchmarks", "scripts", "pytest"}
    if here == "records":
        assert "pinocchio" not in roots
    if here != "viewer":
        assert "meshcat" not in roots
    if here != "batch":
        assert not roots & {"dask", "distributed", "zarr"}
    for library, owner in FORMATS.items():
        if library in roots:
            owned = any(path.is_relative_to(PACKAGE / place) for place in owner.split())
            assert owned, f"{path} imports {library}, which belongs to {owner}"


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_of_the_diagnosis_knows_those_before_it(stage: str) -> None:
    """One way through the folders, no ring; a report does not know how it was found."""
    for path in (PACKAGE / "diagnose" / stage).rglob("*.py"):
        known = {module.split(".")[2] for module in imports(path) if module.startswith("flexdyn.diagnose.")}
        assert not known & STAGES.keys() - {stage, *STAGES[stage]}, path


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_print_stays_in_the_command_line(path: Path) -> None:
    """A library does not write to the terminal."""
    if name_of(path).split(".")[0] == "cli":
        return
    calls = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Call)]
    assert not [call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "print"]


def test_import_stays_light() -> None:
    """Importing flexdyn, and simulating a model made in Python, loads no library that it may not need."""
    code = (
        "import sys, flexdyn as fd\n"
        f"heavy = {HEAVY + PICTURES_AND_FORMATS!r}\n"
        "print([name for name in heavy if name in sys.modules])\n"
        "print(sorted(name for name in sys.modules if name.startswith('flexdyn.cli')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["[]", "[]"]
    assert done.stderr == ""
