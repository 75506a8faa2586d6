"""Lines of code by package at two commits, as JSON for the table of docs/architecture.md.

    python scripts/lines.py 4c4b2ea HEAD -o benchmarks/results/lines.json
    python scripts/readme_tables.py

A line of code has something on it that is no comment and no docstring. Of templates, style sheets and scripts of pages
every line counts that is not empty. Data, documentation and shipped models are not counted.
"""

from __future__ import annotations

import argparse
import ast
import io
import json
import re
import shutil
import subprocess
import sys
import tarfile
import tokenize
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("flexdyn", "benchmarks", "scripts", "tests")
NO_CODE = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
CPP_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def python_lines(text: str) -> int:
    """Lines of a Python file on which something stands that is no comment and no docstring."""
    texts: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            texts.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    filled: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in NO_CODE:
            filled.update(range(token.start[0], token.end[0] + 1))
    return len(filled - texts)


def cpp_lines(text: str) -> int:
    """Lines of a C++ file on which something stands that is no comment."""
    return filled_lines(CPP_COMMENT.sub(lambda found: "\n" * found[0].count("\n"), text))


def filled_lines(text: str) -> int:
    """Lines that are not empty."""
    return sum(bool(line.strip()) for line in text.splitlines())


COUNTERS: dict[str, Callable[[str], int]] = {
    ".py": python_lines,
    ".cpp": cpp_lines,
    ".hpp": cpp_lines,
    ".html": filled_lines,
    ".css": filled_lines,
    ".js": filled_lines,
}


def package_of(path: str) -> str:
    """What a file is counted under: a package of flexdyn, its root, or another folder of the repository."""
    parts = PurePosixPath(path).parts
    if parts[0] != "flexdyn":
        return f"{parts[0]}/"
    return f"flexdyn/{parts[1]}/" if len(parts) > 2 else "flexdyn/*.py"


def counted(files: Mapping[str, str]) -> dict[str, dict[str, int]]:
    """Files, lines and lines of code by package.

    Args:
        files: path -> text.
    """
    found: dict[str, dict[str, int]] = {}
    for path, text in files.items():
        entry = found.setdefault(package_of(path), {"files": 0, "lines": 0, "code": 0})
        entry["files"] += 1
        entry["lines"] += len(text.splitlines())
        entry["code"] += COUNTERS[PurePosixPath(path).suffix](text)
    return found


def _git(*words: str) -> bytes:
    git = shutil.which("git") or sys.exit("lines: git is missing")
    return subprocess.run([git, *words], cwd=ROOT, check=True, capture_output=True).stdout


def files_at(commit: str) -> Iterator[tuple[str, str]]:
    """Path and text of every file that is counted, at a commit."""
    with tarfile.open(fileobj=io.BytesIO(_git("archive", commit, *FOLDERS))) as archive:
        for member in archive.getmembers():
            content = archive.extractfile(member) if PurePosixPath(member.name).suffix in COUNTERS else None
            if content is not None:
                yield member.name, content.read().decode()


def at(commit: str) -> dict[str, Any]:
    """A commit's short name, its day and its counts."""
    name, day = _git("log", "-1", "--format=%h %cs", commit).decode().split()
    return {"commit": name, "day": day, "packages": counted(dict(files_at(commit)))}


def main() -> None:
    """Count and write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("before", help="a commit")
    parser.add_argument("now", help="another one")
    parser.add_argument("-o", "--output", type=Path, required=True, help="JSON file")
    options = parser.parse_args()
    content = {"before": at(options.before), "now": at(options.now)}
    options.output.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
