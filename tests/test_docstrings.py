"""Every public name has an example in its docstring, and the examples run."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd

NAMES = sorted(name for name in fd.__all__ if not inspect.ismodule(getattr(fd, name)))
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize("name", NAMES)
def test_the_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In an empty folder, with flexdyn as fd and NumPy as np, and says what stands there."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"fd": fd, "np": np}
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(getattr(fd, name)) or "", names, name, None, None)
    assert test.examples, "no example"
    said: list[str] = []
    result = doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(test, out=said.append)
    assert result.failed == 0, "".join(said)
