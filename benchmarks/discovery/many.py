"""Scores of cases that lack many effects at once: how many of those that matter are named, and what is named falsely.

A name is right where effect, joint and side agree; where the model's joints are rigid, link and motor are one side. Of
an "A or B" that holds the truth half is counted, unless every name in it is true. False is what is neither hidden nor
allowed (lacking.py). Coulomb friction beside a torque offset is the same law as asymmetric friction: both are true
where that is hidden, and it counts as named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from names import SENSORS, Entry, label, place, text

SIDES = ("link", "motor")
SAME_LAW = ("coulomb_friction", "torque_offset")  # together: asymmetric friction


@dataclass(frozen=True)
class Tally:
    """What a report of such a case is worth.

    Attributes:
        wanted: number of hidden effects that matter.
        found: how many of them are named, an "A or B" half.
        either: how many of them stand in an "A or B".
        names: number of findings.
        false: findings that are not true.
        missed: what matters and is not named.
    """

    wanted: int
    found: float
    either: int
    names: int
    false: tuple[str, ...]
    missed: tuple[str, ...]

    @property
    def outcome(self) -> str:
        """In the words of score.py."""
        if self.missed:
            return "wrong" if self.false else "missed"
        if self.false:
            return "beside"
        return "half" if self.either else "right"


def agrees(finding: Entry, hidden: Entry, *, rigid: bool) -> bool:
    """Whether a finding names an effect at its place."""
    one, two = text(finding, "other"), text(hidden, "other")
    if one is not None and two is not None and one != two:
        return False
    if finding["effect"] in SENSORS and text(finding, "channel") is None:
        return (finding["effect"], text(finding, "joint")) == (hidden["effect"], hidden["joint"])
    return _place(finding, rigid) == _place(hidden, rigid)


def tally(truth: Mapping[str, Any], report: Mapping[str, Any]) -> Tally:
    """Count the names of a report."""
    rigid, findings = bool(truth.get("rigid_model")), list(report["findings"])
    wanted = [one for one in truth["hidden"] if one["matters"]]
    found, either, missed = 0.0, 0, []
    for one in wanted:
        shares = [_share(finding, one, rigid) for finding in findings]
        best = 1.0 if _same_law(one, findings) else max(shares, default=0.0)
        found, either = found + best, either + (best == 0.5)
        if best == 0.0:
            missed.append(label(one))
    false = [label(f) for f in findings if not any(true(each, truth, findings) for each in _group(f))]
    return Tally(len(wanted), found, either, len(findings), tuple(false), tuple(missed))


def true(name: Entry, truth: Mapping[str, Any], findings: Sequence[Entry]) -> bool:
    """Whether a name is hidden or allowed."""
    rigid = bool(truth.get("rigid_model"))
    if any(agrees(name, one, rigid=rigid) for one in (*truth["hidden"], *truth.get("allowed", ()))):
        return True
    asymmetric = [one for one in truth["hidden"] if one["joint"] == text(name, "joint")]
    return name["effect"] in SAME_LAW and any(_same_law(one, findings) for one in asymmetric)


def _group(finding: Entry) -> list[Entry]:
    return [finding, *(finding.get("indistinguishable_from") or [])]


def _share(finding: Entry, one: Entry, rigid: bool) -> float:
    right = [agrees(each, one, rigid=rigid) for each in _group(finding)]
    return 1.0 if all(right) else 0.5 if any(right) else 0.0


def _same_law(one: Entry, findings: Sequence[Entry]) -> bool:
    """Whether the two findings that make up asymmetric friction stand in place of it."""
    if one["effect"] != "asymmetric_friction":
        return False
    named = {f["effect"] for f in findings if text(f, "joint") == one["joint"]}
    return set(SAME_LAW) <= named


def _place(entry: Entry, rigid: bool) -> tuple[str | None, ...]:
    return tuple("motor" if rigid and word in SIDES else word for word in place(entry))
