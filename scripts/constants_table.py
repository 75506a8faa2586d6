"""The table of the constants that decide, from the source of `flexdyn.diagnose.constants`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import pairwise

from flexdyn.diagnose import constants


def listed(derived: bool) -> Iterator[tuple[str, str, str]]:
    """Name, value as it is written, and docstring of every constant: those before "Derived", or those after."""
    with open(constants.__file__, encoding="utf-8") as file:
        text = file.read()
    first_derived = text[: text.index("\n# Derived\n")].count("\n") + 1
    body = ast.parse(text).body
    for node, after in pairwise(body):
        if isinstance(node, ast.Assign) and (node.lineno > first_derived) == derived:
            (target,) = node.targets
            docstring = ast.literal_eval(after.value) if isinstance(after, ast.Expr) else ""
            yield ast.unparse(target), ast.unparse(node.value), " ".join(docstring.split())


def constants_table(derived: bool) -> str:
    """The table of those constants; other tables of the site are made of results, this one of the code."""
    lines = ["| constant | value | meaning [unit] and source |", "|---|---|---|"]
    lines += [f"| `{name}` | `{value}` | {text} |" for name, value, text in listed(derived)]
    return "\n".join(lines)
