"""What a release is made from says the same everywhere, and the compiled core stands by itself."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

import flexdyn as fd
from flexdyn import _core

ROOT = Path(__file__).parents[1]
CONDA_NAMES = {"pin": "pinocchio", "meshcat": "meshcat-python"}
ALONE = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("_core", sys.argv[1])
core = importlib.util.module_from_spec(spec)
spec.loader.exec_module(core)
print("numpy" in sys.modules, "pinocchio" in sys.modules, core.Plant.__name__)
"""


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    """The file pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def recipe() -> dict[str, Any]:
    """The conda recipe."""
    content = YAML(typ="safe").load((ROOT / "scripts" / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    assert isinstance(content, dict)
    return content


def test_one_version(project: dict[str, Any], recipe: dict[str, Any]) -> None:
    """That of pyproject.toml; where a file must name it too, it is the same."""
    version = project["project"]["version"]
    assert fd.__version__ == version
    assert str(recipe["context"]["version"]) == version
    assert str(YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"]) == version
    heading = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert heading is not None
    assert heading[1] == version


def test_the_conda_recipe_asks_for_the_same_libraries(project: dict[str, Any], recipe: dict[str, Any]) -> None:
    """By their names there."""
    asked = [re.fullmatch(r"([\w.-]+?)([<>=].*)", entry) for entry in project["project"]["dependencies"]]
    wanted = {CONDA_NAMES.get(found[1], found[1]): found[2] for found in asked if found}
    assert len(wanted) == len(project["project"]["dependencies"])
    there = dict(entry.split() for entry in recipe["requirements"]["run"])
    assert there.pop("python") == project["project"]["requires-python"]
    assert there == wanted


def test_a_wheel_for_every_python_that_is_promised(project: dict[str, Any]) -> None:
    """The classifiers name the Pythons that cibuildwheel builds for."""
    prefix = "Programming Language :: Python :: 3."
    promised = [text.removeprefix(prefix) for text in project["project"]["classifiers"] if text.startswith(prefix)]
    assert [f"cp3{minor}-*" for minor in promised] == project["tool"]["cibuildwheel"]["build"]
    assert f">=3.{promised[0]}" == project["project"]["requires-python"]


def test_the_release_tries_every_python_without_a_compiler(project: dict[str, Any]) -> None:
    """The workflow names the Pythons that are promised, builds on four machines, and publishes last, tags alone."""
    content = YAML(typ="safe").load((ROOT / ".ci" / "release.yml").read_text(encoding="utf-8"))
    jobs = content["jobs"]
    builds = project["tool"]["cibuildwheel"]["build"]
    promised = ["3." + name.removeprefix("cp3").removesuffix("-*") for name in builds]
    assert jobs["without_compiler"]["strategy"]["matrix"]["python"] == promised
    built = jobs["wheels"]["strategy"]["matrix"]["machine"]
    assert [machine.split("-")[0] for machine in built] == ["ubuntu", "ubuntu", "macos", "macos"]
    assert set(jobs["without_compiler"]["strategy"]["matrix"]["machine"]) <= set(built)
    for name, job in jobs.items():
        needed = job.get("needs", [])
        assert {needed} <= jobs.keys() if isinstance(needed, str) else set(needed) <= jobs.keys(), name
    assert jobs["publish"]["if"] == "github.ref_type == 'tag'"
    assert (ROOT / "scripts" / "wheel_check.py").is_file()


def test_pixi_installs_what_pip_installs(project: dict[str, Any]) -> None:
    """It is not run here: the tables name this project with its extra, a compiler, and each Python that is promised."""
    pixi = project["tool"]["pixi"]
    assert pixi["pypi-dependencies"] == {project["project"]["name"]: {"path": ".", "extras": ["all"]}}
    assert {*pixi["dependencies"]} == {"python", "cxx-compiler"}
    promised = [int(build.removeprefix("cp3").removesuffix("-*")) for build in project["tool"]["cibuildwheel"]["build"]]
    assert pixi["dependencies"]["python"] == f">=3.{promised[0]},<3.{promised[-1] + 1}"


def test_the_core_needs_no_other_package() -> None:
    """A Python that sees no installed package loads it: it is linked to no library of Pinocchio's or NumPy's."""
    words = [sys.executable, "-I", "-S", "-c", ALONE, str(_core.__file__)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("False False Plant\n", "")


@pytest.mark.parametrize(("library", "remedy"), [("libgomp.so.1", "apt install libgomp1"), ("libz.so.1", "has it")])
def test_a_library_of_the_system_is_missing(library: str, remedy: str, tmp_path: Path) -> None:
    """Pinocchio's wheel brings all but one: small images lack it, and the program says so in one line."""
    (tmp_path / "flexdyn").mkdir()
    said = f"{library}: cannot open shared object file: No such file or directory"
    (tmp_path / "flexdyn" / "__init__.py").write_text(f"raise ImportError({said!r})\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "flexdyn_program", "doctor"],
        cwd=tmp_path,  # which stands first on the path: that folder is its flexdyn
        env={"PYTHONPATH": str(ROOT / "scripts")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert library in done.stderr
    assert remedy in done.stderr
