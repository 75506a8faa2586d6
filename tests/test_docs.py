"""What README and documentation show runs: every page in an empty folder, block by block from top to bottom.

A block whose first line is a comment with a file name is written to that file. Python is executed, in one namespace
for the page; lines of `bash` blocks that begin with flexdyn are run; model files, studies and channel maps are read.
Only blocks of `text` are not looked at.
"""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

import flexdyn as fd
from flexdyn.batch.studyfile import read_study
from flexdyn.cli import main
from flexdyn.effects import base

ROOT = Path(__file__).parents[1]
SITE = sorted(path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts)
PAGES = [*sorted(ROOT.glob("*.md")), *SITE]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", flags=re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"(?:# |<!-- )([\w-]+\.\w+)(?: -->)?\n")
READERS = {"flexdyn": fd.load_model, "flexdyn_study": read_study, "flexdyn_map": fd.read_map}
LINK = re.compile(r"!?\[[^\]]*\]\(([^)#\s:]+)(?:#[^)\s]*)?\)")


def page_id(path: Path) -> str:
    """A page's name in the test's output."""
    return path.relative_to(ROOT).with_suffix("").as_posix()


class Page:
    """A page that is worked through."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.names: dict[str, Any] = {"__name__": "page"}
        self.ran = 0

    def work_through(self) -> None:
        """Write, run or read every block, in the working directory."""
        text = self.path.read_text(encoding="utf-8")
        for found in BLOCK.finditer(text):
            language, body = found[1], found[2]
            where = f"{self.path.name}:{text.count(chr(10), 0, found.start()) + 1}"
            if language == "text":
                continue
            self.ran += 1
            file = NAMED.match(body)
            if file:
                Path(file[1]).write_text(body, encoding="utf-8")
            if language == "python":
                exec(compile(body, where, "exec", dont_inherit=True), self.names)  # noqa: S102 - our own text
            elif language == "bash":
                for line in body.splitlines():
                    self.type_in(line, where)
            elif language == "yaml":
                assert file, f"{where}: the first line names no file"
                READERS[next(iter(YAML(typ="safe").load(body)))](file[1])
            else:
                assert file, f"{where}: {language} is neither run nor saved"

    def type_in(self, line: str, where: str) -> None:
        """A command of flexdyn exits with 0; any other is a script of ours or a tool of .venv: CI runs these."""
        words = shlex.split(line, comments=True)
        if not words:
            return
        if words[0] != "flexdyn":
            tool = Path(sys.executable).parent / words[0].removeprefix(".venv/bin/")
            assert (ROOT / words[0]).is_file() or tool.is_file(), f"{where}: {line}"
        elif words[1] != "paper":  # it has tests of its own
            serving = words[1] == "play" and "--html" not in words
            assert main([*words[1:], *(["--html", "page.html"] if serving else [])]) == 0, f"{where}: {line}"


@pytest.mark.parametrize("path", PAGES, ids=page_id)
def test_every_block_of_a_page_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In an empty folder; effects that the page defines are gone after it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(base, "_registry", dict(base._registry))
    Page(path).work_through()


def test_the_pages_have_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The pattern above finds them: as many fences as blocks and directives need, and each kind is met."""
    texts = [path.read_text(encoding="utf-8") for path in PAGES]
    assert {"python", "bash", "yaml", "text"} <= {language for text in texts for language, _ in BLOCK.findall(text)}
    for path, text in zip(PAGES, texts, strict=True):
        opened = len(re.findall(r"^```\w", text, flags=re.MULTILINE))
        assert opened == len(BLOCK.findall(text)), path
    broken = tmp_path / "broken.md"
    broken.write_text("```python\nassert False\n```\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError):
        Page(broken).work_through()


@pytest.mark.parametrize("path", PAGES, ids=page_id)
def test_every_link_leads_to_a_file(path: Path) -> None:
    """Of the repository, or of the pages that the site's build makes."""
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for link in LINK.findall(text):
        there = (path.parent / link).resolve()
        assert there.exists() or (ROOT / "docs" / "generated") in there.parents, link


def rows_of_where_is_what() -> list[list[str]]:
    """The table of the architecture that says where to find things, cell by cell."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = text.partition("## Where is what")[2].partition("\n## ")[0]
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in re.findall(r"^\|.*\|$", table, re.MULTILINE)[2:]
    ]


@pytest.mark.parametrize("row", rows_of_where_is_what(), ids=lambda row: row[0])
def test_the_architecture_says_where_things_are(row: list[str]) -> None:
    """Every file that the table names is there, and every name beside it: defined in Python, a word in C++."""
    _, where, names = row
    files = re.findall(r"`(flexdyn/[\w/.]+)`", where)
    words = re.findall(r"`(\w+)`", names)
    assert files
    assert words
    for file in files:
        text = (ROOT / file).read_text(encoding="utf-8")
        for word in words:
            defined = rf"^\s*(def|class) {word}\b|^{word}\b.* = " if file.endswith(".py") else rf"\b{word}\b"
            assert re.search(defined, text, re.MULTILINE), f"{file} does not define {word}"


@pytest.mark.parametrize(
    "question",
    ["The Stribeck law", "Stick-slip", "noise", "gives an effect its name", "How to add an effect", "run is stored"],
)
def test_a_strangers_question_has_a_row(question: str) -> None:
    """What somebody asks who opens the repository for the first time; the test above holds that the row is true."""
    assert any(question in row[0] for row in rows_of_where_is_what())
    assert "architecture.md#where-is-what" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_the_readme_stays_short() -> None:
    """What a visitor needs, on 150 lines; the rest is in docs/."""
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150
