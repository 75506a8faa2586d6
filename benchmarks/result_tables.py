"""Result files as Markdown: the tables that the benchmarks print and the README shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]], *, text: int = 1) -> str:
    """A Markdown table; its first columns are text, the others numbers."""
    ruler = [*["---"] * text, *["---:"] * (len(header) - text)]
    return "\n".join("| " + " | ".join(row) + " |" for row in (header, ruler, *rows))


def accuracy_table(results: Mapping[str, Any]) -> str:
    """Errors of every solver against the closed form, and what an evaluation costs."""
    cases = results["cases"]
    header = [
        "solver",
        *(f"error [rad], {name}" for name in cases),
        "evaluations in 5 s",
        "one evaluation / one ABA call",
    ]
    rows = []
    for name, cost in results["cost_in_aba_calls"].items():
        found = [case["solvers"][name] for case in cases.values()]
        errors = [f"{each['error_rad']:.1e}" for each in found]
        rows.append([name, *errors, f"{found[0]['evaluations']:,}", f"{cost:.2f}"])
    return markdown_table(header, rows)


def peers_table(results: Mapping[str, Any]) -> str:
    """Peers beside flexdyn: one step, then five seconds of motion."""
    arms = list(results["arms"].values())
    return "\n\n".join((_steps(arms), _motions(arms)))


def _steps(arms: Sequence[Mapping[str, Any]]) -> str:
    header = ["time of one step / flexdyn's", *(f"{arm['joints']} joints" for arm in arms)]
    rows = [[name, *(f"{arm['steps'][name]['ratio']:.2f}" for arm in arms)] for name in arms[0]["steps"]]
    return markdown_table(header, rows)


def _motions(arms: Sequence[Mapping[str, Any]]) -> str:
    header = ["time of 5 s of motion / flexdyn's"]
    for arm in arms:
        header += [f"{arm['joints']} joints", "greatest error [rad]"]
    rows = []
    for name in arms[0]["motions"]:
        row = [name]
        for arm in arms:
            motion = arm["motions"][name]
            row += [f"{motion['ratio']:.2f}", f"{motion['error_rad']:.0e}"]
        rows.append(row)
    return markdown_table(header, rows)


def effect_checks_table(results: Mapping[str, Any]) -> str:
    """What was measured of every effect."""
    header = [
        "effect",
        "energy it took in 1.5 s",
        "ledger left over",
        "mirrored motion",
        "neutral",
        "difference from SciPy",
    ]
    rows = []
    for name, row in results["effects"].items():
        identical = len(row["neutral"]) == len(results["solvers"])
        neutral = "bit for bit" if identical else f"only {', '.join(row['neutral'])}"
        numbers = [_size(row["ledger"]), _size(row["mirror"]), neutral, _size(row["scipy"])]
        rows.append([f"`{name}`", _taken(row), *numbers])
    return markdown_table(header, rows)


def _taken(row: Mapping[str, Any]) -> str:
    if "taken" not in row or row["taken"] == 0.0:
        return "-"
    # What rounding gives in a millisecond is nothing.
    return f"{row['taken']:.2g} J" + ("" if row["least_power"] > -1e-9 else ", both ways")


def _size(number: float) -> str:
    return "0" if number == 0.0 else f"{number:.0e}"
