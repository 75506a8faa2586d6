"""Score reports of the diagnosis against the truth.

    python benchmarks/discovery/score.py CASES REPORTS [-o RESULT.json]

CASES is a folder of `make.py` (its truth stands in CASES.truth), REPORTS holds <case>/report.json. A case is

    right   everything hidden is named, effect, joint and side, alone, and nothing beside it
    half    the same, but one of the names is an "A or B" that holds the truth
    beside  everything hidden is named, and something false beside it
    wrong   something hidden is not named, and something false is
    missed  something hidden is not named, and nothing false is
    forced  the effect is outside the catalogue, and a name was given all the same
    failed  there is no report

Where CASES.truth/<case>.rivals.json says that the true law stands within delta BIC 20 of its nearest rival, half is
right; what was missed stays missed, and is counted as hidden in the numbers' tolerance.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from names import kind, label, parameter_errors, same

POINTS = {"right": 1.0, "half": 0.5}
INSEPARABLE = 20.0
OUTCOMES = ("right", "half", "beside", "wrong", "missed", "forced", "failed")


def outcome(truth: dict[str, Any], report: dict[str, Any] | None) -> str:
    """What a report is worth, by its names alone."""
    if report is None:
        return "failed"
    findings = list(report["findings"])
    if any(not one["catalogued"] for one in truth["hidden"]):
        if findings or report["verdict"] == "explained":
            return "forced"
        return "right" if report["verdict"] == "unexplained" else "missed"
    alone, either, found = 0, 0, set()
    for one in truth["hidden"]:
        exact = [k for k, f in enumerate(findings) if k not in found and same(f, one)]
        rivals = [k for k, f in enumerate(findings) if k not in found and _held(f, one)]
        if exact or rivals:
            k = (exact or rivals)[0]
            found.add(k)
            unsure = not exact or bool(findings[k].get("indistinguishable_from"))
            alone, either = alone + (not unsure), either + unsure
    false = len(findings) - len(found)
    if alone + either < len(truth["hidden"]):
        return "wrong" if false else "missed"
    if false:
        return "beside" if found else "wrong"
    return "half" if either else "right"


def _held(finding: dict[str, Any], hidden: dict[str, Any]) -> bool:
    return any(same(other, hidden) for other in finding.get("indistinguishable_from") or [])


def score(truth: dict[str, Any], report: dict[str, Any] | None, rivals: dict[str, Any] | None = None) -> dict[str, Any]:
    """One row of the result."""
    row: dict[str, Any] = {
        "case": truth["case"],
        "family": truth["family"],
        "hidden": [label(one) for one in truth["hidden"]],
        "kinds": [kind(one) for one in truth["hidden"]],
        "outcome": outcome(truth, report),
    }
    if report is None:
        return row | {"points": 0.0}
    close = rivals is not None and rivals["delta_bic"] < INSEPARABLE
    row["inseparable"] = rivals if close else None
    row["points"] = 1.0 if row["outcome"] == "half" and close else POINTS.get(row["outcome"], 0.0)
    row["verdict"] = report["verdict"]
    row["named"] = [_with_rivals(finding) for finding in report["findings"]]
    pairs = [(f, one) for one in truth["hidden"] for f in report["findings"] if same(f, one)]
    row["false"] = [label(f) for f in report["findings"] if not any(same(f, o) or _held(f, o) for o in truth["hidden"])]
    row["parameters"] = [e | {"of": label(one)} for f, one in pairs for e in parameter_errors(f, one)]
    row["gap"] = {name: _over_floor(report, name) for name in ("fit", "check")}
    row["seconds"] = report.get("seconds")
    return row


def _with_rivals(finding: dict[str, Any]) -> str:
    return " OR ".join([label(finding), *(label(other) for other in finding.get("indistinguishable_from") or [])])


def _over_floor(report: dict[str, Any], name: str) -> float | None:
    gap = (report.get("gap") or {}).get(name) or {}
    after, floor = gap.get("after"), gap.get("floor")
    return float(after) / float(floor) if after is not None and floor else None


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
            "check_gap_over_floor": _median(row["gap"]["check"] for row in mine if row.get("gap", {}).get("check")),
            "median_seconds": _median(row["seconds"] for row in mine if row.get("seconds")),
            "greatest_seconds": max((row["seconds"] for row in mine if row.get("seconds")), default=None),
        }
    return result


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
        for name in row["kinds"] or ["nothing"]:
            confusion[name][row["outcome"]] += 1
    lines += ["", f"{'hidden':42s}" + "".join(f"{name:>8s}" for name in OUTCOMES)]
    lines += [f"{n:42s}" + "".join(f"{c[o] or '':>8}" for o in OUTCOMES) for n, c in sorted(confusion.items())]
    lines += ["", "not right:"]
    for row in rows:
        if row["points"] < 1.0:
            named = "; ".join(row.get("named", [])) or row.get("verdict", "no report")
            lines.append(f"  {row['case']} {row['outcome']}: {' + '.join(row['hidden']) or 'nothing'} -> {named}")
    return "\n".join(lines)


def read(file: Path) -> dict[str, Any] | None:
    """A JSON file, None if it is not there."""
    return dict(json.loads(file.read_text(encoding="utf-8"))) if file.exists() else None


def score_folder(cases: Path, reports: Path) -> list[dict[str, Any]]:
    """Rows of all cases in a folder."""
    secret = cases.parent / f"{cases.name}.truth"
    rows = []
    for folder in sorted(cases.iterdir()):
        truth = read(secret / f"{folder.name}.json")
        if truth is not None:
            rivals = read(secret / f"{folder.name}.rivals.json")
            rows.append(score(truth, read(reports / folder.name / "report.json"), rivals))
    return rows


def main() -> int:
    """Score, print, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("cases", type=Path)
    parser.add_argument("reports", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    rows = score_folder(options.cases, options.reports)
    print(tables(rows))
    if options.output:
        content = {"summary": summary(rows), "cases": rows}
        options.output.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
