"""One name, one meaning: classes, constants, private functions; and the table of constants in docs/diagnosis.md."""

from __future__ import annotations

import ast
import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import flexdyn as fd

PACKAGE = Path(fd.__file__).parent
PAGE = Path(__file__).parents[1] / "docs" / "diagnosis.md"
FILES = sorted(path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).parts[0] != "robots")
LISTED = ("inference", "simulated")
"""Folders of `flexdyn.diagnose` whose constants choose structures: the page must list all of them."""
BUDGETS = {
    "HARMONICS_AT_ONCE": "memory",
    "SPARE_COLUMNS": "memory",
    "SPARE_ROWS": "memory",
    "POINTS_AT_ONCE": "memory and time",
    "COLUMNS_AT_ONCE": "memory and time",
    "COLUMN_COPIES": "memory",
    "MEMORY_SHARE": "memory",
    "MOST_ORDER": "a model of noise that only the studies use",
}
"""Constants of those folders that change no result."""


def constants(path: Path, holds: Callable[[ast.expr], bool] | None = None) -> Iterator[tuple[str, ast.expr]]:
    """The upper-case names of a module that hold numbers and no text, with the expressions of their values.

    Args:
        path: of the module.
        holds: whether a value counts; default: numbers and no text.
    """
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            several = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = zip(target.elts, node.value.elts, strict=True) if several else [(target, node.value)]  # type: ignore[attr-defined]
            for name, value in pairs:
                if isinstance(name, ast.Name) and name.id.isupper() and (holds or _is_number)(value):
                    yield name.id, value


def _is_number(value: ast.expr) -> bool:
    leaves = [type(each.value) for each in ast.walk(value) if isinstance(each, ast.Constant)]
    return str not in leaves and bytes not in leaves and (int in leaves or float in leaves)


def _is_text(value: ast.expr) -> bool:
    return any(isinstance(each, ast.Constant) and isinstance(each.value, str) for each in ast.walk(value))


def package_of(path: Path) -> str:
    """The folder at the root of flexdyn that a module is in."""
    return path.relative_to(PACKAGE).parts[0]


def test_a_constant_has_one_value() -> None:
    """A name that stands for different numbers in two modules misleads whoever reads both."""
    values: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for path in FILES:
        for name, value in constants(path):
            values[name][ast.unparse(value)].append(path.relative_to(PACKAGE).as_posix())
    several = {name: dict(found) for name, found in values.items() if len(found) > 1}
    assert not several


def test_a_text_has_one_name_and_one_place() -> None:
    """Texts: a name stands for one in its package, and no two modules of any packages write the same one again."""
    places: dict[tuple[str, str], list[str]] = defaultdict(list)
    for path in FILES:
        for name, value in constants(path, _is_text):
            for key in ((name, package_of(path)), (name, ast.unparse(value))):
                places[key].append(path.relative_to(PACKAGE).as_posix())
    assert not {name: found for (name, _), found in places.items() if len(found) > 1}


def defined(kind: type[ast.FunctionDef | ast.ClassDef]) -> dict[str, list[Path]]:
    """Files that define a function or class at their top level, by its name."""
    places: dict[str, list[Path]] = defaultdict(list)
    for path in FILES:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, kind):
                places[node.name].append(path)
    return places


def test_a_private_function_name_is_defined_once_in_a_package() -> None:
    """Who searches a package for a name finds one function."""
    private = {n: p for n, p in defined(ast.FunctionDef).items() if n.startswith("_") and not n.endswith("__")}
    packages = {name: list(map(package_of, found)) for name, found in private.items()}
    assert not {name: found for name, found in packages.items() if len(found) > len(set(found))}


def test_a_public_class_name_is_defined_once() -> None:
    """Likewise of classes; private ones stay in their module."""
    found = defined(ast.ClassDef)
    assert not {name: found[name] for name in found if not name.startswith("_") and len(found[name]) > 1}


ONE_MEANING = {
    "as_card": "HTML of a model, a recording and a robot",
    "draw": "a picture by Matplotlib and by Plotly, which the same page calls",
    "library": "the optional library of a file format",
    "read": "a recording from a file, for each format",
    "read_here": "what `flexdyn.records.apart` calls in a process of its own",
    "write": "a recording to a file, for each format",
}
"""Public functions that several modules have because somebody calls any of them in the same way -> what they all do."""


def test_a_public_function_name_has_one_meaning() -> None:
    """It is defined once, also across packages; a command of the program has the name of the function that it calls."""
    public = {name: found for name, found in defined(ast.FunctionDef).items() if not name.startswith("_")}
    several = {name: found for name, found in public.items() if len(found) > 1}
    commands = {
        name
        for name, found in several.items()
        if len(found) == 2 and name in fd.__all__ and package_of(found[0]) == "cli"
    }
    assert several.keys() - commands == ONE_MEANING.keys()


def test_a_method_says_no_more_than_the_function_of_its_name() -> None:
    """In one module one of the two calls the other, because an object knows some of the arguments."""
    others = []
    for path in FILES:
        body = ast.parse(path.read_text(encoding="utf-8")).body
        functions = {node.name: node for node in body if isinstance(node, ast.FunctionDef)}
        methods = [(each, node) for each in body if isinstance(each, ast.ClassDef) for node in each.body]
        for kind, node in methods:
            if isinstance(node, ast.FunctionDef) and node.name in functions:
                ours, its = (_called(each) for each in (node, functions[node.name]))
                if node.name not in ours | its:
                    others.append(f"{path.relative_to(PACKAGE).as_posix()}: {kind.name}.{node.name}")
    assert not others


def _called(function: ast.FunctionDef) -> set[str]:
    """Names of the functions and methods that a function calls."""
    calls = [each.func for each in ast.walk(function) if isinstance(each, ast.Call)]
    return {getattr(each, "id", "") or getattr(each, "attr", "") for each in calls}


def table() -> list[tuple[str, str, str]]:
    """Name, value and file of the page's budgets and tolerances; a row may have several of one file."""
    text = PAGE.read_text(encoding="utf-8").split("## Budgets and tolerances of the numerics\n")[1].split("\n## ")[0]
    rows = [
        [cell.strip() for cell in line.strip("|").split(" | ")] for line in text.splitlines() if line.startswith("| `")
    ]
    found = []
    for names, values, file, *_ in rows:
        each = re.findall(r"`(\w+)`", names)
        for name, value in zip(each, values.split("; ") if len(each) > 1 else [values], strict=True):
            found.append((name, value, file.strip("`")))
    return found


def _number(expression: ast.expr | str) -> object:
    """The value of an expression of numbers, of ``math.log`` or of ``log``."""
    source = expression if isinstance(expression, str) else ast.unparse(expression)
    return eval(source.replace("math.", ""), {"__builtins__": {}, "log": math.log})  # noqa: S307


@pytest.mark.parametrize(("name", "value", "file"), table())
def test_the_page_says_what_the_code_says(name: str, value: str, file: str) -> None:
    """A row of the table names a constant of that file, with its value."""
    code = dict(constants(PACKAGE / "diagnose" / file))
    assert name in code, f"{file} has no {name}"
    assert _number(code[name]) == _number(value)


def test_natural_sizes_are_within_the_range_of_the_page() -> None:
    """The sentence that stands for all classes of effects."""
    (words,) = re.findall(r"`natural_size` \(([^:]*):", " ".join(PAGE.read_text(encoding="utf-8").split()))
    low, high = (float(each) for each in words.split(" to "))
    sizes = [getattr(each, "natural_size", None) for each in vars(fd.effects).values() if isinstance(each, type)]
    known = [size for size in sizes if isinstance(size, float) and math.isfinite(size)]
    assert (min(known), max(known)) == (low, high)


def test_the_page_lists_what_chooses_structures() -> None:
    """Every other constant of the folders that compare structures is on the page, unless it changes no result."""
    named = {(name, file) for name, _, file in table()}
    missing = [
        (name, path.relative_to(PACKAGE / "diagnose").as_posix())
        for folder in LISTED
        for path in sorted((PACKAGE / "diagnose" / folder).glob("*.py"))
        for name, _ in constants(path)
        if name not in BUDGETS and (name, path.relative_to(PACKAGE / "diagnose").as_posix()) not in named
    ]
    assert not missing


def test_every_constant_of_the_diagnosis_says_what_it_is() -> None:
    """A docstring follows each, or the group that it is assigned with: what it is, its unit, where it comes from."""
    silent = []
    for path in sorted((PACKAGE / "diagnose").rglob("*.py")):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        names = {name for name, _ in constants(path) if not name.startswith("_")}
        for node, after in zip(body, [*body[1:], None], strict=True):
            if not isinstance(node, ast.Assign | ast.AnnAssign):
                continue
            text = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            own = {each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)}
            silent += [f"{path.name}: {name}" for name in sorted(own & names) if not text]
    assert not silent


def test_few_constants_decide() -> None:
    """The method has at most 25 constants; what is computed from others stands below a line of its own."""
    text = (PACKAGE / "diagnose" / "constants.py").read_text(encoding="utf-8").split("\n# Derived\n")[0]
    assert 0 < len([node for node in ast.parse(text).body if isinstance(node, ast.Assign)]) <= 25
