"""Every public name has an example in its docstring, and the examples run."""

from __future__ import annotations

import doctest
import inspect
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
