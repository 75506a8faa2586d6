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

PIP = """
import hashlib, pathlib, sys
site = pathlib.Path(__file__).parent / "site"
with (site.parent / "log").open("a") as log:
    log.write(sys.argv[-1] + chr(10))
if (site.parent / "broken").exists():
    sys.exit(1)
text = pathlib.Path("flexdyn/__init__.py").read_text()
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
    for name in ("checkout/flexdyn/__init__.py", "checkout/flexdyn/core/arm.cpp", "checkout/pyproject.toml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("a = 1\n")
    (tmp_path / "pip.py").write_text(PIP)
    (tmp_path / "log").touch()

    def install(extras: str, wheel: Path | None = None) -> tuple[int, list[str]]:
        pip = [sys.executable, str(tmp_path / "pip.py")]
        code = script.main(tmp_path / "checkout", tmp_path / "site", tmp_path / "stamp.json", extras, pip, wheel)
        return code, (tmp_path / "log").read_text().split()

    return install


def test_a_second_run_installs_nothing(run: Run, tmp_path: Path) -> None:
    """Nor one after an import and a build left their files, nor one for an extra that another contains."""
    assert run("test,docs") == (0, [".[test,docs]"])
    (tmp_path / "checkout" / "flexdyn" / "__pycache__").mkdir()
    (tmp_path / "checkout" / "flexdyn" / "__pycache__" / "x.pyc").touch()
    (tmp_path / "checkout" / "flexdyn" / "_core.cpython-311.so").touch()
    for extras in ("test,docs", "docs", "all"):
        assert run(extras) == (0, [".[test,docs]"])


def test_an_extra_that_is_not_there_is_installed(run: Run) -> None:
    """And after that, the first one is still there."""
    run("docs")
    assert run("test,docs")[1] == [".[docs]", ".[test,docs]"]
    run("all")
    assert len(run("docs")[1]) == 2


@pytest.mark.parametrize("name", ["pyproject.toml", "flexdyn/core/arm.cpp", "flexdyn/new.py", "robots/arm/arm.urdf"])
def test_a_change_is_installed(run: Run, tmp_path: Path, name: str) -> None:
    """A changed file and a new one; once."""
    run("all")
    (tmp_path / "checkout" / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / "checkout" / name).write_text("a = 2\n")
    assert len(run("all")[1]) == 2
    assert len(run("all")[1]) == 2


def test_a_wheel_takes_the_place_of_the_checkout(run: Run, tmp_path: Path) -> None:
    """Once for each wheel; a further extra leaves the package as it is, and without the wheel the checkout is back."""
    wheel = tmp_path / "arm.whl"
    wheel.write_bytes(b"one")
    asked = [str(wheel), f"{wheel}[all]"]
    assert run("all", wheel) == (0, asked)
    assert run("all", wheel) == (0, asked)
    assert run("test", wheel) == (0, [*asked, f"{wheel}[test]"])
    wheel.write_bytes(b"two")
    assert len(run("all", wheel)[1]) == 5
    assert run("all")[1][5:] == [".[all]"]


def test_a_file_that_went_is_a_change(run: Run, tmp_path: Path) -> None:
    """The package must lose it too."""
    run("all")
    (tmp_path / "checkout" / "flexdyn" / "core" / "arm.cpp").unlink()
    assert len(run("all")[1]) == 2


def test_after_a_failure_it_is_tried_again(run: Run, tmp_path: Path) -> None:
    """Even where the sources went back to what was installed before."""
    run("all")
    source = tmp_path / "checkout" / "flexdyn" / "__init__.py"
    source.write_text("a = 2\n")
    (tmp_path / "broken").touch()
    assert run("all")[0] == 1
    source.write_text("a = 1\n")
    (tmp_path / "broken").unlink()
    assert run("all") == (0, [".[all]"] * 3)


def test_what_pip_did_by_hand_is_noticed(run: Run, tmp_path: Path) -> None:
    """Another state was installed, the package was removed, or the stamp is not ours."""
    run("all")
    (tmp_path / "site" / "flexdyn-0.1.0.dist-info" / "RECORD").write_text("another state")
    assert len(run("all")[1]) == 2
    shutil.rmtree(tmp_path / "site")
    assert len(run("all")[1]) == 3
    for text in ("", "[]", '{"sources": 1}'):
        (tmp_path / "stamp.json").write_text(text)
        before = len(run("all")[1])
        assert len(run("all")[1]) == before
    assert len(run("all")[1]) == 6
