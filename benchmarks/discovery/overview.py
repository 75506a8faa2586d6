"""Summaries of scored cases: per family, what was confused with what, and how reliable the probabilities are."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from typing import Any

import numpy as np
from calibration import candidates_of, claims_of, reliability, table

OUTCOMES = ("right", "half", "beside", "wrong", "missed", "forced", "failed")


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The numbers that the benchmark is about, per family."""
    result = {}
    for family in dict.fromkeys(row["family"] for row in rows):
        mine = [row for row in rows if row["family"] == family]
        counts = Counter(row["outcome"] for row in mine)
        errors = [e for row in mine for e in row.get("parameters", [])]
        covered = [e["covered"] for e in errors if e["covered"] is not None]
        result[family] = {
            "cases": len(mine),
            "points": sum(row["points"] for row in mine) / len(mine),
            **{name: counts[name] for name in OUTCOMES},
            "missed_in_tolerance": sum(row["outcome"] == "missed" and bool(row["inseparable"]) for row in mine),
            "false_names": sum(len(row.get("false", [])) for row in mine),
            "median_parameter_error": _median(e["relative_error"] for e in errors),
            "coverage": float(np.mean(covered)) if covered else None,
            "intervals": len(covered),
            "test_gap_over_floor": _median(row["gap"]["test"] for row in mine if row.get("gap", {}).get("test")),
            "median_seconds": _median(row["seconds"] for row in mine if row.get("seconds")),
            "greatest_seconds": max((row["seconds"] for row in mine if row.get("seconds")), default=None),
            **_of_many([row for row in mine if "wanted" in row]),
        }
    return result


def _of_many(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Pooled over cases that lack many effects: the share of what matters that is named, of names that are false."""
    if not rows:
        return {}
    wanted, names = (sum(row[key] for row in rows) for key in ("wanted", "names"))
    false = sum(len(row.get("false", [])) for row in rows)
    recall = sum(row["found"] for row in rows) / wanted if wanted else None
    return {"wanted": wanted, "names": names, "recall": recall, "false_rate": false / names if names else 0.0}


def content_of(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """What is written of scored cases."""
    found = {"reliability": reliability(claims_of(rows)), "of_candidates": reliability(candidates_of(rows))}
    kept = [{name: value for name, value in row.items() if name != "candidates"} for row in rows]
    return {"summary": summary(rows), **found, "cases": kept}


def _median(values: Iterable[float]) -> float | None:
    known = list(values)
    return float(np.median(known)) if known else None


def tables(rows: list[dict[str, Any]]) -> str:
    """Everything to print: families, confusion, what went wrong."""
    lines = []
    for family, numbers in summary(rows).items():
        shown = {k: f"{v:.3g}" if isinstance(v, float) else v for k, v in numbers.items() if v not in (None, 0)}
        lines.append(f"{family}: " + ", ".join(f"{key} {value}" for key, value in shown.items()))
    confusion: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        if "wanted" not in row:
            for name in row["kinds"] or ["nothing"]:
                confusion[name][row["outcome"]] += 1
    lines += ["", f"{'hidden':42s}" + "".join(f"{name:>8s}" for name in OUTCOMES)]
    lines += [f"{n:42s}" + "".join(f"{c[o] or '':>8}" for o in OUTCOMES) for n, c in sorted(confusion.items())]
    lines += ["", "not right:"]
    lines += [f"  {line(row)}" for row in rows if row["points"] < 1.0 or row.get("false")]
    lines += ["", "probabilities:", table(reliability(claims_of(rows)))]
    return "\n".join(lines)


def line(row: dict[str, Any]) -> str:
    """A case in one line: what it is worth, and what was hidden and named."""
    said = row.get("verdict", "no report")
    if "wanted" in row:
        missed, false = ("; ".join(row.get(key, [])) or "nothing" for key in ("missed", "false"))
        counts = f"{row['found']:g} of {row['wanted']} found among {row['names']} names"
        return f"{row['case']} {row['outcome']} ({said}): {counts}; missed: {missed}; false: {false}"
    named = "; ".join(row.get("named", [])) or said
    return f"{row['case']} {row['outcome']} ({said}): {' + '.join(row['hidden']) or 'nothing'} -> {named}"
