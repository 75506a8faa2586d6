"""The architecture, held by reading every import statement; and an import of flexdyn that stays light."""

from __future__ import annotations

import ast
import functools
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import flexdyn

PACKAGE = Path(flexdyn.__file__).parent
FILES = sorted(path for path in PACKAGE.rglob("*.py") if "core" not in path.relative_to(PACKAGE).parts[:1])
HEAVY = ("scipy", "matplotlib", "h5py", "lxml", "yourdfpy", "ruamel", "typer", "rich", "trimesh", "meshcat", "mujoco")
PICTURES_AND_FORMATS = ("plotly", "jinja2", "pyarrow", "rosbags", "xarray", "pandas", "zarr", "dask", "distributed")
FORMATS = {
    "h5py": "records/hdf5",
    "jinja2": "io/html.py",
    "lxml": "robot/xmlfile.py",
    "pyarrow": "records/parquet_file.py",
    "rosbags": "records/ros",
    "ruamel": "io/yaml.py",
    "xarray": "records/dataset.py batch/results.py",
}
LAYERS = (
    ("arrays", "errors"),
    ("checks",),
    ("io",),
    ("records", "control"),
    ("_core",),
    ("effects", "robot"),
    ("model",),
    ("simulation",),
    ("comparison", "analysis"),
    ("plots",),
    ("diagnose", "viewer", "batch"),
    ("__init__",),
    ("paper",),
    ("cli",),
    ("__main__",),
)
"""The root's packages and modules in their order: each may import those of the layers before its own, and no others.

Those of one layer do not know each other. An import inside a function counts like any other. ``__init__`` is what
users import as `flexdyn`; ``_core`` is the compiled core, which recordings and commands do without.
"""
EXCEPTIONS = {
    ("simulation/run.py", "plots"): "Run.plot is a method because users look for it there; imported when it is called",
    ("simulation/run.py", "viewer"): "Run.show plays in a notebook, likewise",
    ("comparison/compare.py", "plots"): "Comparison.plot, likewise",
    ("batch/store.py", "__init__"): "the version of flexdyn, which a store of results states",
    ("batch/run_study.py", "__init__"): "the version, compared with that of the store which is to be continued",
    ("batch/dask_executor.py", "__init__"): "the version, compared between the machines of a cluster",
}
"""Imports against the order: file and what it imports -> why."""
KNOWS_ONLY = {"simulation/solvers.py": {"errors", "checks"}}
"""Files that know less than their package may: a solver's settings know no model and no run."""
PLACE = {package: place for place, layer in enumerate(LAYERS) for package in layer}
EQUATIONS = ("data", "equations", "hypothesis")
STAGES = {
    "data": (),
    "equations": ("data", "report"),
    "hypothesis": ("data", "equations"),
    "shooting": EQUATIONS,
    "inference": EQUATIONS,
    "simulated": (*EQUATIONS, "shooting", "inference"),
    "experiment": (*EQUATIONS, "shooting", "simulated", "report"),
    "decision": (*EQUATIONS, "shooting", "inference", "simulated", "experiment", "report"),
    "report": (),
    "compared": ("report",),
}
"""Folders of `flexdyn.diagnose`, and which others each may know: what compares knows no test data and no report."""


def name_of(path: Path) -> str:
    """Module name inside the package: ``effects.base``."""
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__")


@functools.cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """A file's statements that import and its calls: most tests below ask for them again."""
    looked_at = (ast.Import, ast.ImportFrom, ast.Call)
    return tuple(node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, looked_at))


def imports(path: Path) -> Iterator[str]:
    """Every module that a file imports, anywhere in it, and every name that it takes from one."""
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def package_of(path: Path) -> str:
    """What a file belongs to in the table of layers."""
    return name_of(path).split(".")[0]


def known_packages(path: Path) -> set[str]:
    """Entries of the table of layers that a file imports, besides its own."""
    parts = [module.split(".") for module in imports(path)]
    own = [part[1] if len(part) > 1 and part[1] in PLACE else "__init__" for part in parts if part[0] == "flexdyn"]
    return set(own) - {package_of(path)}


def against_the_order(path: Path) -> set[str]:
    """What a file imports that is not in a layer before its own."""
    return {known for known in known_packages(path) if PLACE[known] >= PLACE[package_of(path)]}


def test_there_is_something_to_check() -> None:
    """The walk over the package finds its modules."""
    assert {"simulation.simulate", "effects.base", "records.recording", "robot.load"} <= {
        name_of(path) for path in FILES
    }


def test_every_package_has_its_layer() -> None:
    """The table names all that stands at the root, once, and nothing else."""
    listed = [package for layer in LAYERS for package in layer]
    assert len(listed) == len(PLACE)
    assert set(listed) == {package_of(path) for path in FILES} | {"_core"}


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_imports_point_one_way(path: Path) -> None:
    """A file imports only from layers before its own, but for the listed exceptions."""
    file = path.relative_to(PACKAGE).as_posix()
    assert not {known for known in against_the_order(path) if (file, known) not in EXCEPTIONS}
    assert known_packages(path) <= KNOWS_ONLY.get(file, PLACE.keys())


def test_every_exception_is_needed() -> None:
    """No exception is left in the list after its import is gone."""
    found = {(path.relative_to(PACKAGE).as_posix(), known) for path in FILES for known in against_the_order(path)}
    assert found == EXCEPTIONS.keys()


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_forbidden_libraries(path: Path) -> None:
    """Each library that is heavy, optional or a file format has one place; nothing imports the tests."""
    here, found = package_of(path), set(imports(path))
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
    if package_of(path) == "cli":
        return
    calls = [node for node in nodes(path) if isinstance(node, ast.Call)]
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
