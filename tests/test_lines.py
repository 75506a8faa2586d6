"""Lines of code: what counts as one, and under which package."""

from __future__ import annotations

import importlib.util
from pathlib import Path

SCRIPT = Path(__file__).parents[1] / "scripts" / "lines.py"
PYTHON = '''"""A module."""

# A comment.
LIMIT = 3  # with a comment
"""What it is."""


def text() -> str:
    """A docstring
    of two lines.
    """
    return """a text
of two lines"""
'''
CPP = """// A comment.
#include <cmath>

/* Two lines
   of it. */
int f() { return 1; }  // code before a comment
"""


def test_comments_docstrings_and_empty_lines_do_not_count() -> None:
    """In Python, C++ and templates; by package of flexdyn, its root and other folders."""
    spec = importlib.util.spec_from_file_location("lines", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    files = {
        "flexdyn/errors.py": PYTHON,
        "flexdyn/records/csv/read.py": PYTHON,
        "flexdyn/core/f.cpp": CPP,
        "flexdyn/io/page.html": "<p>\n\n</p>\n",
        "tests/records/test_csv.py": "x = 1\n",
    }
    python = {"files": 1, "lines": 13, "code": 4}
    assert script.counted(files) == {
        "flexdyn/*.py": python,
        "flexdyn/records/": python,
        "flexdyn/core/": {"files": 1, "lines": 6, "code": 2},
        "flexdyn/io/": {"files": 1, "lines": 3, "code": 2},
        "tests/": {"files": 1, "lines": 1, "code": 1},
    }
