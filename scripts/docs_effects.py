"""Write one page for each effect of the catalogue: equation, drawing, what data show, confusions, sightings.

Name, sides, parameters and drawing come from the effect's class; the equation and the prose from docs/effects.yaml.
docs/conf.py calls `write` before every build.
"""

from __future__ import annotations

import dataclasses
import inspect
import textwrap
from pathlib import Path
from typing import Any

from docs_folder import fresh
from ruamel.yaml import YAML

import flexdyn as fd
from flexdyn.cli.effects import meanings
from flexdyn.plots import draw_law, example_entry

PROSE = ("symbols", "equation", "data", "confused_with", "seen")
Prose = dict[str, Any]


def own_effects() -> dict[str, type[fd.effects.Effect]]:
    """The effects of flexdyn itself by name, in the order of the catalogue."""
    return {name: kind for name, kind in fd.effects.catalogue().items() if kind.__module__.startswith("flexdyn.")}


def read_prose(path: Path) -> dict[str, Prose]:
    """What the classes do not say, by effect.

    Raises:
        ValueError: an effect without an entry, or an entry without one of its parts.
    """
    prose: dict[str, Prose] = YAML(typ="safe").load(path.read_text(encoding="utf-8"))
    for name, kind in own_effects().items():
        entry = prose.get(name, {})
        numbers = {field.name for field in kind.parameters()}
        missing = [part for part in PROSE if not entry.get(part)]
        missing += sorted(f"the symbol of {each}" for each in numbers ^ set(entry.get("symbols", numbers)))
        if missing:
            raise ValueError(f"{path.name}: {name} lacks {', '.join(missing)}")
    return prose


def write(folder: Path, prose_file: Path) -> None:
    """Write the pages and drawings into a folder, which is emptied before."""
    fresh(folder)
    prose = read_prose(prose_file)
    for name, kind in own_effects().items():
        draw_law(kind, folder / f"{name}.svg")
        (folder / f"{name}.md").write_text(page(kind, prose[name]), encoding="utf-8")


def page(kind: type[fd.effects.Effect], prose: Prose) -> str:
    """The text of one page; the drawing stands beside it under the same name."""
    about = inspect.cleandoc(kind.__doc__ or "").partition("\n\nArgs:")[0].replace("``", "`")
    summary, _, details = about.partition("\n\n")
    entry = ", ".join(f"{key}: {value}" for key, value in example_entry(kind, "JOINT").items())
    lines = textwrap.fill(f"- {{{entry}}}", 84, subsequent_indent="   ")
    parts = [
        f"# {kind.name}\n",
        f"{summary}\n",
        f"$$\n{prose['equation'].strip()}\n$$\n",
        f"![The law of {kind.name}]({kind.name}.svg)\n\n{details}\n",
        parameters(kind, prose["symbols"]),
        f"In a model file:\n\n```text\n{lines}\n```\n",
        f"In Python: `fd.effects.{kind.__name__}`. {neutral(kind)}\n",
        f"## What it looks like in data\n\n{prose['data'].strip()}\n",
        f"## What it is confused with\n\n{prose['confused_with'].strip()}\n",
        f"## Where it was seen\n\n{prose['seen'].strip()}\n",
    ]
    return "\n".join(parts)


def parameters(kind: type[fd.effects.Effect], symbols: dict[str, str]) -> str:
    """Table of the numbers of an effect."""
    meaning = meanings(kind)
    rows = ["| parameter | symbol | unit | default | may be | meaning |", "| --- | --- | --- | --- | --- | --- |"]
    for field in kind.parameters():
        unit, lower, strict = (field.metadata[key] for key in ("unit", "lower", "strict"))
        bound = "any number" if lower == float("-inf") else f"{'above' if strict else 'at least'} {lower:g}"
        default = "-" if field.default is dataclasses.MISSING else f"{field.default:g}"
        cells = [f"`{field.name}`", f"${symbols[field.name]}$", unit, default, bound, meaning.get(field.name, "")]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def neutral(kind: type[fd.effects.Effect]) -> str:
    """At which numbers the effect changes nothing."""
    values = ", ".join(f"`{key}` = {value:g}" for key, value in kind.neutral.items())
    return f"It changes nothing at {values}."
