"""scripts/install.py installs on the first run and after every change, and otherwise does nothing."""

from __future__ import annotations

import importlib.util
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

Run = Callable[..., tuple[int, list[str]]]

PROJECT = """
[project]
name = "arm"
dependencies = ["steel"]
[project.optional-dependencies]
plot = ["paint"]
all = ["arm[plot]"]
docs = ["pen", "arm[all]"]
test = ["arm[all]", "rig"]
"""
ANEW = ["paint pen rig steel", "arm-1.whl"]
"""What pip is asked for where nothing is there and the extras are those for tests and docs."""

PIP = """
import hashlib, pathlib, sys
here, asked = pathlib.Path(__file__).parent, sys.argv[1:]
if (here / "broken").exists() and (here / "broken").read_text() == asked[0]:
    sys.exit(1)
if asked[0] == "wheel":
    (pathlib.Path(asked[asked.index("--wheel-dir") + 1]) / "arm-1.whl").touch()
    sys.exit(0)
with (here / "log").open("a") as log:
    log.write(" ".join(pathlib.Path(each).name for each in asked[1:] if not each.startswith("-")) + chr(10))
text = pathlib.Path("flexdyn/__init__.py").read_text()
site = here / "site"
(site / "flexdyn").mkdir(parents=True, exist_ok=True)
(site / "flexdyn" / "__init__.py").write_text(text)
(site / "flexdyn-0.1.0.dist-info").mkdir(exist_ok=True)
(site / "flexdyn-0.1.0.dist-info" / "RECORD").write_text(hashlib.sha256(text.encode()).hexdigest())
"""
"""Notes what it was asked for, and leaves what pip leaves of a package of one file; fails where `broken` is there."""


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """The script on a checkout of three files: its exit code, and what pip was asked for so far."""
    spec = importlib.util.spec_from_file_location("install", ROOT / "scripts" / "install.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    for name in ("checkout/flexdyn/__init__.py", "checkout/flexdyn/core/arm.cpp"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("a = 1\n")
    (tmp_path / "checkout" / "pyproject.toml").write_text(PROJECT)
    (tmp_path / "pip.py").write_text(PIP)
    (tmp_path / "log").touch()

    def install(extras: str, wheel: Path | None = None, uv: str = "") -> tuple[int, list[str]]:
        pip = [sys.executable, str(tmp_path / "pip.py")]
        places = tmp_path / "checkout", tmp_path / "site", tmp_path / "stamp.json"
        code = script.main(*places, extras, pip, wheel, lambda pip: [sys.executable, "-c", uv] if uv else [])
        return code, (tmp_path / "log").read_text().splitlines()

    return install


def test_a_second_run_installs_nothing(run: Run, tmp_path: Path) -> None:
    """Nor one after an import and a build left their files, nor one for an extra that another contains."""
    assert run("test,docs") == (0, ANEW)
    (tmp_path / "checkout" / "flexdyn" / "__pycache__").mkdir()
    (tmp_path / "checkout" / "flexdyn" / "__pycache__" / "x.pyc").touch()
    (tmp_path / "checkout" / "flexdyn" / "_core.cpython-311.so").touch()
    for extras in ("test,docs", "docs", "all"):
        assert run(extras) == (0, ANEW)


def test_an_extra_that_is_not_there_is_installed(run: Run) -> None:
    """Without a build of the package, which is there; and after that, the first one is still there."""
    run("docs")
    asked = ["paint pen steel", "arm-1.whl", "paint pen rig steel"]
    assert run("test,docs")[1] == asked
    assert run("all")[1] == asked
    assert run("docs")[1] == asked


@pytest.mark.parametrize("name", ["pyproject.toml", "flexdyn/core/arm.cpp", "flexdyn/new.py", "robots/arm/arm.urdf"])
def test_a_change_is_installed(run: Run, tmp_path: Path, name: str) -> None:
    """A changed file and a new one; once."""
    run("test,docs")
    (tmp_path / "checkout" / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / "checkout" / name).write_text(PROJECT + "plot2 = []\n")
    assert run("test,docs") == (0, ANEW * 2)
    assert run("test,docs") == (0, ANEW * 2)


def test_a_wheel_takes_the_place_of_the_checkout(run: Run, tmp_path: Path) -> None:
    """Once for each wheel; a further extra leaves the package as it is, and without the wheel the checkout is back."""
    wheel = tmp_path / "given.whl"
    wheel.write_bytes(b"one")
    asked = ["given.whl", "given.whl[all]"]
    assert run("all", wheel) == (0, asked)
    assert run("all", wheel) == (0, asked)
    assert run("test", wheel) == (0, [*asked, "given.whl[test]"])
    wheel.write_bytes(b"two")
    assert len(run("all", wheel)[1]) == 5
    assert run("all")[1][5:] == ["paint steel", "arm-1.whl"]


def test_a_file_that_went_is_a_change(run: Run, tmp_path: Path) -> None:
    """The package must lose it too."""
    run("test,docs")
    (tmp_path / "checkout" / "flexdyn" / "core" / "arm.cpp").unlink()
    assert run("test,docs") == (0, ANEW * 2)


@pytest.mark.parametrize("step", ["wheel", "install"])
def test_after_a_failure_it_is_tried_again(run: Run, tmp_path: Path, step: str) -> None:
    """Of the build or of the libraries, even where the sources went back to what was installed before."""
    run("test,docs")
    source = tmp_path / "checkout" / "flexdyn" / "__init__.py"
    source.write_text("a = 2\n")
    (tmp_path / "broken").write_text(step)
    assert run("test,docs")[0] == 1
    source.write_text("a = 1\n")
    (tmp_path / "broken").unlink()
    code, asked = run("test,docs")
    assert code == 0
    assert asked[-2:] == ANEW
    assert asked.count("arm-1.whl") == 2


def test_uv_installs_and_where_it_cannot_pip_does(run: Run, tmp_path: Path) -> None:
    """The libraries say whether uv works here; the package is built and installed by what installed them."""
    as_pip = f"import runpy, sys; sys.argv[1:2] = []; runpy.run_path({str(tmp_path / 'pip.py')!r})"
    built = "import sys, pathlib; pathlib.Path(sys.argv[-1], 'arm-1.whl').touch()"
    works = f"import sys\nif sys.argv[1] == 'build':\n    {built}\nelse:\n    {as_pip}"
    code, asked = run("test,docs", uv=works)
    assert code == 0
    assert [line.removeprefix(f"{Path(sys.executable).name} ") for line in asked] == ANEW
    (tmp_path / "checkout" / "flexdyn" / "__init__.py").write_text("a = 2\n")
    assert run("test,docs", uv="import sys; sys.exit(2)")[1][2:] == ANEW


def test_what_pip_did_by_hand_is_noticed(run: Run, tmp_path: Path) -> None:
    """Another state was installed, the package was removed, or the stamp is not ours."""
    run("test,docs")
    (tmp_path / "site" / "flexdyn-0.1.0.dist-info" / "RECORD").write_text("another state")
    assert run("test,docs")[1] == ANEW * 2
    shutil.rmtree(tmp_path / "site")
    assert run("test,docs")[1] == ANEW * 3
    for k, text in enumerate(("", "[]", '{"sources": 1}')):
        (tmp_path / "stamp.json").write_text(text)
        assert run("test,docs")[1] == ANEW * (4 + k)
        assert run("test,docs")[1] == ANEW * (4 + k)
