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

In cases that lack many effects at once (published robots) what is hidden means here: what matters (many.py), and points
are the share of it that is named.

Where CASES.truth/<case>.rivals.json says that the true law stands within delta BIC 20 of its nearest rival, half is
right; what was missed stays missed, and is counted as hidden in the numbers' tolerance.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from many import agrees, tally
from many import true as true_name
from names import kind, label, parameter_errors, same
from overview import content_of, tables

POINTS = {"right": 1.0, "half": 0.5}
INSEPARABLE = 20.0
LEFT_OPEN = ("unexplained", "partly_explained")  # verdicts that say that something is left


def outcome(truth: dict[str, Any], report: dict[str, Any] | None) -> str:
    """What a report is worth, by its names alone."""
    if report is None:
        return "failed"
    if many(truth):
        return tally(truth, report).outcome
    findings = list(report["findings"])
    if any(not one["catalogued"] for one in truth["hidden"]):
        if findings or report["verdict"] == "explained":
            return "forced"
        return "right" if report["verdict"] in LEFT_OPEN else "missed"
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


def many(truth: dict[str, Any]) -> bool:
    """Whether this case lacks many effects at once."""
    return any("matters" in one for one in truth["hidden"])


def _held(finding: dict[str, Any], hidden: dict[str, Any]) -> bool:
    return any(same(other, hidden) for other in finding.get("indistinguishable_from") or [])


def score(truth: dict[str, Any], report: dict[str, Any] | None, rivals: dict[str, Any] | None = None) -> dict[str, Any]:
    """One row of the result."""
    wanted = [one for one in truth["hidden"] if one.get("matters", True)]
    row: dict[str, Any] = {
        "case": truth["case"],
        "family": truth["family"],
        "hidden": [label(one) for one in wanted],
        "kinds": [kind(one) for one in wanted],
        "outcome": outcome(truth, report),
    }
    if report is None:
        return row | {"points": 0.0} | ({"wanted": len(wanted), "found": 0.0, "names": 0} if many(truth) else {})
    findings = list(report["findings"])
    close = rivals is not None and rivals["delta_bic"] < INSEPARABLE
    row["inseparable"] = rivals if close else None
    row["points"] = 1.0 if row["outcome"] == "half" and close else POINTS.get(row["outcome"], 0.0)
    row["verdict"] = report["verdict"]
    row["named"] = [_with_rivals(finding) for finding in findings]
    row["false"] = [label(f) for f in findings if not any(same(f, o) or _held(f, o) for o in truth["hidden"])]
    if many(truth):
        row |= _many_row(truth, report)
    known = [(f, _is_true(f, truth, findings)) for f in findings]
    row["claims"] = [{"name": label(f), "probability": f.get("probability"), "true": true} for f, true in known]
    row["candidates"] = [
        [float(each["probability"]), _is_true(each, truth, report["considered"])]
        for each in report.get("considered") or []
        if each.get("probability") is not None
    ]
    pairs = [(f, one) for one in wanted for f in findings if _names(f, one, truth)]
    row["parameters"] = [e | {"of": label(one)} for f, one in pairs for e in parameter_errors(f, one)]
    row["gap"] = {name: _over_floor(report, name) for name in ("fit", "test")}
    return row


def _many_row(truth: dict[str, Any], report: dict[str, Any]) -> dict[str, Any]:
    found = tally(truth, report)
    counts = {"wanted": found.wanted, "found": found.found, "names": found.names}
    share = found.found / found.wanted if found.wanted else 1.0
    return {"points": share, **counts, "false": list(found.false), "missed": list(found.missed)}


def _names(finding: dict[str, Any], one: dict[str, Any], truth: dict[str, Any]) -> bool:
    return agrees(finding, one, rigid=bool(truth.get("rigid_model"))) if many(truth) else same(finding, one)


def _is_true(finding: dict[str, Any], truth: dict[str, Any], findings: list[dict[str, Any]]) -> bool:
    """Whether what a finding says first is so; what is outside the catalogue has no true name."""
    if many(truth):
        return true_name(finding, truth, findings)
    return any(one["catalogued"] and same(finding, one) for one in truth["hidden"])


def _with_rivals(finding: dict[str, Any]) -> str:
    return " OR ".join([label(finding), *(label(other) for other in finding.get("indistinguishable_from") or [])])


def _over_floor(report: dict[str, Any], name: str) -> float | None:
    gaps = report.get("gap") or {}
    gap = gaps.get(name) or gaps.get({"test": "check"}.get(name, name)) or {}  # schema 1 said check
    after, floor = gap.get("after"), gap.get("floor")
    return float(after) / float(floor) if after is not None and floor else None


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
            cost = read(reports / folder.name / "cost.json") or {}
            row = score(truth, read(reports / folder.name / "report.json"), rivals)
            rows.append(row | {"seconds": cost["seconds"]} if "seconds" in cost else row)
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
        options.output.write_text(json.dumps(content_of(rows), indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
