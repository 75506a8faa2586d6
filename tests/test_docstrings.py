"""Every public name has an example in its docstring, and the examples run; docstrings name arguments and errors."""

from __future__ import annotations

import ast
import doctest
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import base

CATALOGUE = fd.effects.catalogue().values()
"""These have an example made by the site, see test_docs_pages.py."""
PUBLIC = {
    **{name: getattr(fd, name) for name in fd.__all__},
    **{
        f"{module}.{name}": getattr(getattr(fd, module), name)
        for module in ("effects", "solvers")
        for name in getattr(fd, module).__all__
    },
}
NAMES = sorted(name for name, each in PUBLIC.items() if callable(each) and each not in CATALOGUE)
DESCRIBED = ("analysis", "comparison", "control", "effects", "io", "model", "records", "robot", "simulation")
"""Packages of which every public function and method says what it takes and which errors it raises."""
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize("name", NAMES)
def test_the_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In an empty folder, with flexdyn as fd and NumPy as np, and says what stands there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(base, "_registry", dict(base._registry))  # effects that the example defines are gone after it
    names: dict[str, Any] = {"fd": fd, "np": np}
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(PUBLIC[name]) or "", names, name, None, None)
    assert test.examples, "no example"
    said: list[str] = []
    result = doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(test, out=said.append)
    assert result.failed == 0, "".join(said)


def public_functions(package: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Place and node of the public functions and methods of a package, nested ones and overrides left out."""
    folder = Path(fd.__file__).parent / package
    for path in sorted(folder.rglob("*.py")):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        kinds = [each for each in body if isinstance(each, ast.ClassDef) and not each.name.startswith("_")]
        for node in [*body, *(each for kind in kinds for each in kind.body)]:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                yield f"{path.relative_to(folder).as_posix()}: {node.name}", node


def inherited(function: ast.FunctionDef) -> bool:
    """Whether another method of this name in `flexdyn.effects`, that of a base class, says what it takes."""
    return (
        any(
            node.name == function.name and "Args:" in (ast.get_docstring(node) or "")
            for _, node in public_functions("effects")
        )
        or "see the base class" in (ast.get_docstring(function) or "").lower()
    )


@pytest.mark.parametrize("package", DESCRIBED)
def test_docstrings_name_arguments(package: str) -> None:
    """Two or more of them: each in a section of its own, or within the sentence."""
    silent = []
    for place, node in public_functions(package):
        told = ast.get_docstring(node) or ""
        names = [each.arg for each in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]]
        names = [each for each in names if each not in ("self", "cls")]
        lacking = [name for name in names if not re.search(rf"\b{name}\b", told)]
        section = "Args:" in told
        if len(names) > 1 and ((section and lacking) or len(lacking) == len(names)) and not inherited(node):
            silent.append(f"{place}: {', '.join(lacking)}")
    assert not silent


@pytest.mark.parametrize("package", DESCRIBED)
def test_docstrings_name_errors(package: str) -> None:
    """An `InputError` that a function raises itself."""
    silent = []
    for place, node in public_functions(package):
        raised = [each.exc for each in ast.walk(node) if isinstance(each, ast.Raise) and each.exc is not None]
        own = [each for each in raised if isinstance(each, ast.Call) and ast.unparse(each.func) == "InputError"]
        if own and "InputError" not in (ast.get_docstring(node) or ""):
            silent.append(place)
    assert not silent
