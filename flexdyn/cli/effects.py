"""flexdyn effects: the catalogue."""

from __future__ import annotations

import dataclasses
import inspect
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any

import typer

from flexdyn.cli import completion
from flexdyn.cli.options import JsonOption, output_file, output_option
from flexdyn.cli.output import cell, show, show_json, table
from flexdyn.effects import Effect, catalogue
from flexdyn.effects.catalogue import find_effect
from flexdyn.errors import InputError
from flexdyn.plots import SUFFIXES, draw_law, example_entry

_NOWHERE = {
    "inertia": "of the whole arm: neither joint nor side",
    "model": "neither joint nor side: of says which joint, link or effect",
}


def effects(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="An effect to describe in full.", autocompletion=completion.effect_names),
    ] = None,
    output: Annotated[Path | None, output_option("FILE", "Draw the law of NAME into this .png, .pdf or .svg.")] = None,
    as_json: JsonOption = False,
) -> None:
    """List the effects that a model can have; describe one and draw its law.

    In a law x is the position and u the velocity on the effect's side (link: q, v; motor: theta, omega), Sgn the
    set-valued sign, tau the motor's torque. For a prismatic joint, N m becomes N, and rad becomes m;
    a phase stays in rad, and a harmonic is in rad/m.
    """
    if name is None and output is not None:
        raise InputError("say which effect to draw", key="NAME", remedy=f"one of {', '.join(catalogue())}")
    chosen = _named(name) if name is not None else None
    if chosen is not None and output is not None:
        draw_law(chosen, output_file("--output", output, SUFFIXES))
    if as_json:
        show_json(effect_document(chosen) if chosen else [effect_document(kind) for kind in catalogue().values()])
    elif chosen is None:
        show(_overview())
    else:
        show(_page(chosen), _parameters(chosen))
        if output is not None:
            show(f"law drawn in {output}")


def effect_document(kind: type[Effect]) -> dict[str, Any]:
    """The description of an effect, as in the JSON document."""
    return {
        "effect": kind.name,
        "class": kind.__name__,
        "sides": list(kind.sides),
        "stage": kind.stage,
        "law": kind.law,
        "parameters": [
            {
                "name": field.name,
                "unit": field.metadata["unit"],
                "default": None if field.default is dataclasses.MISSING else field.default,
                "required": field.default is dataclasses.MISSING,
                "lower": field.metadata["lower"],
                "strict": field.metadata["strict"],
            }
            for field in kind.parameters()
        ],
        "names": _names(kind),
        "neutral": dict(kind.neutral),
        "summary": kind.summary(),
        "example": example_entry(kind, "JOINT"),
    }


def _named(name: str) -> type[Effect]:
    """Find an effect by its name or its class name; for a part of a name (stribeck) the error gives the whole name."""
    by_class = {kind.__name__: kind for kind in catalogue().values()}
    first_words = {kind.rpartition("_")[0]: kind for kind in catalogue()}
    near = get_close_matches(name, first_words, n=1, cutoff=0.8)
    if near and name not in by_class and name not in catalogue():
        raise InputError("no such effect", key="effect", value=name, remedy=f"did you mean '{first_words[near[0]]}'?")
    return by_class.get(name) or find_effect(name)


def _overview() -> Any:
    rows = [
        (kind.name, ", ".join(kind.sides) or "-", kind.law, _listed(kind), _neutral(kind))
        for kind in catalogue().values()
    ]
    return table("Effects", ("effect", "side", "law", "parameters [unit]", "neutral at"), rows)


def _page(kind: type[Effect]) -> str:
    text = inspect.cleandoc(kind.__doc__ or "").partition("\n\nArgs:")[0]
    sides = f"side: {' or '.join(kind.sides)}" if kind.sides else _NOWHERE.get(kind.stage, "neither joint nor side")
    text = text.replace("``", "")
    neutral = f"neutral at {_neutral(kind)}: it changes nothing there"
    return f"{kind.name}\n\n{text}\n\nlaw: {kind.law}\n{sides}\n{neutral}\nin a model file: {_yaml(kind)}\n"


def _parameters(kind: type[Effect]) -> Any:
    """The table of an effect's parameters: unit, default, what values it may have, and meaning."""
    told = meanings(kind)
    rows = []
    for field in kind.parameters():
        lower, strict = field.metadata["lower"], field.metadata["strict"]
        bound = "any" if lower == float("-inf") else f"{'above' if strict else 'at least'} {cell(lower)}"
        default = "-" if field.default is dataclasses.MISSING else cell(field.default)
        rows.append((field.name, field.metadata["unit"], default, bound, told.get(field.name, "")))
    rows += [(name, "-", "-", "a name", told.get(name, "")) for name in _names(kind)]
    return table("Parameters", ("name", "unit", "default", "value", "meaning"), rows)


def meanings(kind: type[Effect]) -> dict[str, str]:
    """The text of the docstring for each parameter, without the unit, which has a column of its own."""
    arguments = inspect.cleandoc(kind.__doc__ or "").partition("Args:\n")[2].splitlines()
    found: dict[str, str] = {}
    last = ""
    for line in arguments:
        if line.startswith("    ") and line[4:5].strip():
            last, _, meaning = line.strip().partition(": ")
            found[last] = meaning
        elif last and line.startswith("        "):
            found[last] += f" {line.strip()}"
    units = {field.name: f"[{field.metadata['unit']}]" for field in kind.parameters()}
    return {
        key: text.replace(f" {units.get(key)}", "").replace(units.get(key, "\0"), "").strip(" .")
        for key, text in found.items()
    }


def _listed(kind: type[Effect]) -> str:
    listed = []
    for field in kind.parameters():
        default = "" if field.default is dataclasses.MISSING else f" = {cell(field.default)}"
        listed.append(f"{field.name} [{field.metadata['unit']}]{default}")
    return ", ".join(listed + _names(kind))


def _names(kind: type[Effect]) -> list[str]:
    """Parameters that are names and no numbers: a frame, another joint."""
    numbers = {field.name for field in kind.parameters()}
    every = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]
    return [name for name in every if name not in {"joint", "side", *numbers}]


def _neutral(kind: type[Effect]) -> str:
    return ", ".join(f"{key} = {cell(value)}" for key, value in kind.neutral.items()) or "-"


def _yaml(kind: type[Effect]) -> str:
    entries = example_entry(kind, "JOINT")
    return "- {" + ", ".join(f"{key}: {value}" for key, value in entries.items()) + "}"
