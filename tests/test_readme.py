"""The README's examples run as printed."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.cli import main
from flexdyn.effects import base

README = (Path(__file__).parents[1] / "README.md").read_text()
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)
PYTHON = [body for language, body in BLOCKS if language == "python"]
COMMANDS = [
    line for language, body in BLOCKS if language == "bash" for line in body.splitlines() if line[:8] == "flexdyn "
]


def test_readme_has_examples() -> None:
    """There is something to run: the patterns above found the blocks."""
    assert len(PYTHON) >= 7
    assert len(COMMANDS) >= 10


@pytest.mark.parametrize("body", PYTHON, ids=range(len(PYTHON)))
def test_python_example(body: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each Python block runs in an empty folder; effects that it defines are gone after it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(base, "_registry", dict(base._registry))
    exec(compile(body, "README.md", "exec", dont_inherit=True), {"__name__": "readme"})  # noqa: S102 - our own text


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the commands are typed, one after the other: later ones read what earlier ones wrote."""
    return tmp_path_factory.mktemp("readme")


@pytest.mark.parametrize("line", [line for line in COMMANDS if " paper" not in line])
def test_command_line_example(line: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each command exits with 0 (the paper's study has tests of its own; play would serve, and writes its page)."""
    monkeypatch.chdir(folder)
    words = shlex.split(line, comments=True)[1:]
    page = ["--html", "page.html"] if words[0] == "play" and "--html" not in words else []
    assert main([*words, *page]) == 0


def test_model_file_example(tmp_path: Path) -> None:
    """The YAML block is a model file that loads."""
    (body,) = [body for language, body in BLOCKS if language == "yaml"]
    (tmp_path / "model.yaml").write_text(body)
    model = fd.load_model(tmp_path / "model.yaml")
    assert not model.elastic[model.index("wrist_3_joint")]
    assert model.elastic.sum() == model.n - 1


def test_picture_is_there() -> None:
    """Every picture the README shows is in the repository."""
    for path in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (Path(__file__).parents[1] / path).is_file()
