"""Write the API reference: one page for each package of flexdyn that holds public names, and one list of all names.

Names are those of `flexdyn.__all__`, grouped by the package in which they are defined, so that the pages follow the
code. docs/conf.py calls `write` before every build.
"""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from typing import Any

from docs_folder import fresh

import flexdyn as fd

MODULES = ("effects", "solvers")
"""Public modules: users write `fd.effects.Payload`, `fd.solvers.DormandPrince`."""


def grouped() -> dict[str, list[str]]:
    """The public names by package, in alphabetical order."""
    groups: dict[str, list[str]] = {}
    for name in sorted(fd.__all__, key=str.lower):
        if name not in MODULES:
            groups.setdefault(getattr(fd, name).__module__.split(".")[1], []).append(name)
    return dict(sorted(groups.items()))


def write(folder: Path) -> None:
    """Write the pages into a folder, which is emptied before."""
    fresh(folder)
    pages = {
        group: [(f"fd.{name}", f"flexdyn.{name}", getattr(fd, name)) for name in names]
        for group, names in grouped().items()
    }
    for name in MODULES:
        module = getattr(fd, name)
        pages[f"fd.{name}"] = [
            (f"fd.{name}.{entry}", f"{module.__name__}.{entry}", vars(module)[entry]) for entry in public(module)
        ]
    for title, entries in pages.items():
        (folder / f"{title.removeprefix('fd.')}.md").write_text(page(title, entries), encoding="utf-8")
    (folder / "index.md").write_text(index(pages), encoding="utf-8")


def public(module: Any) -> list[str]:
    """The classes and functions that a module offers: those of its `__all__`, else those it defines."""
    names = getattr(module, "__all__", None)
    if names is None:
        names = [name for name, thing in vars(module).items() if getattr(thing, "__module__", "") == module.__name__]
    return [name for name in names if inspect.isclass(vars(module)[name]) or inspect.isfunction(vars(module)[name])]


def page(title: str, entries: list[tuple[str, str, Any]]) -> str:
    """Every entry with its signature and docstring."""
    parts = [f"# {title}\n\n{first_sentence(title)}\n"]
    for shown, path, thing in entries:
        kind, options = "autofunction", ""
        if inspect.isclass(thing):
            kind, options = "autoclass", "   :members:\n"
        parts.append(f"## {shown}\n\n```{{eval-rst}}\n.. {kind}:: {path}\n{options}```\n")
        if inspect.isclass(thing) and issubclass(thing, fd.effects.Effect) and thing in fd.effects.catalogue().values():
            parts.append(f"```pycon\n{example(thing)}\n```\n")
    return "\n".join(parts)


def example(kind: type[fd.effects.Effect]) -> str:
    """An effect with typical parameters, and what a model file has for it: the same example for every class."""
    made = kind.example("elbow")
    return f">>> fd.effects.{made}.to_dict()\n{made.to_dict()}"


def first_sentence(title: str) -> str:
    """What the docstring of the package says that it is."""
    name = title.removeprefix("fd.")
    module = getattr(fd, name) if name in MODULES else importlib.import_module(f"flexdyn.{name}")
    return inspect.cleandoc(module.__doc__ or "").split("\n")[0]


def index(pages: dict[str, list[tuple[str, str, Any]]]) -> str:
    """All public names with the first line of their docstrings."""
    tree = "\n".join(title.removeprefix("fd.") for title in pages)
    parts = [
        "# API reference\n\nAll public names, as `import flexdyn as fd` gives them. Quantities are in SI units; those "
        "of the motor are reflected to the link side of the gear. Examples need `import numpy as np` too.\n",
        f"```{{toctree}}\n:hidden:\n\n{tree}\n```\n",
    ]
    for title, entries in pages.items():
        rows = "\n".join(
            f"| [`{shown}`]({title.removeprefix('fd.')}.md) | {inspect.cleandoc(thing.__doc__ or '').splitlines()[0]} |"
            for shown, _, thing in entries
        )
        parts.append(f"## {title}\n\n{first_sentence(title)}\n\n| name | what it is |\n| --- | --- |\n{rows}\n")
    return "\n".join(parts)
