"""Whether a case can be answered at all: delta BIC of the true law to a rival, computed from the truth.

    python benchmarks/discovery/separable.py CASES REPORTS

For every report that says "A or B", each rival that it names takes the place of the true law in the simulator, its
parameters and all known numbers of the arm (within their tolerance) fitted to the true motion. Where something hidden
was missed and nothing false was named, the rival is no law at all. The least delta BIC goes to
CASES.truth/<case>.rivals.json, where score.py reads it: it bounds that of the nearest rival from above.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from arm_draw import JOINTS, LINKS, TwoLinkArm
from cases import FAMILIES, make_case, scale_of
from hidden import LAWS, Hidden, Site, draw
from layout import Array
from model_text import known_effects
from names import SENSORS, same, text
from plants import Case
from scipy.optimize import least_squares
from score import INSEPARABLE, outcome
from visible import make_filter, reported, surprises
from wide import split

KNOWN = ("stiffness", "damping", "rotor_inertia", "viscous", "coulomb", "mass", "com", "inertia")
EVALUATIONS = 10
DISCS = {"kinematic_error", "encoder_eccentricity"}
SIGNED = ("offset", "gain", "phase", "rest", "cos_1", "sin_1", "cos_2", "sin_2", "lower", "upper", "coefficient")


def site_of(entry: Mapping[str, Any], given: TwoLinkArm) -> Site | None:
    """The site of a report's finding, None if it has none in this arm."""
    name = str(entry["effect"])
    if name == "payload":
        return name, 1, "link"
    if name in SENSORS:
        signal, _, joint = (text(entry, "channel") or "").partition(".")
        return (name, JOINTS.index(joint), signal) if joint in JOINTS else None
    if name == "parameter_error":
        of, number = text(entry, "of") or "", text(entry, "parameter") or ""
        if of.startswith("effects["):
            _, j, wrong, _ = known_effects(given)[int(of[8:-1])]
            return name, j, wrong
        if (of, number) == ("tool", "link_mass"):  # the tool is a point: more of it is a payload
            return "payload", 1, "link"
        names = JOINTS if of in JOINTS else LINKS
        return (name, names.index(of), number) if of in names else None
    place = text(entry, "joint") or ""
    known = name in LAWS or name == "joint_elasticity"  # the simulator lacks some laws of the catalogue
    return (name, JOINTS.index(place), str(entry["side"])) if place in JOINTS and known else None


def calibrated(arm: TwoLinkArm, logs: Array) -> TwoLinkArm:
    """The arm with its known numbers times exp(logs) (16,)."""
    pairs = np.exp(logs).reshape(-1, 2)
    old = {name: getattr(arm, name) for name in KNOWN}
    return arm.replace(**{name: tuple(np.array(old[name]) * f) for name, f in zip(KNOWN, pairs, strict=True)})


def written(case: Case) -> Array:
    """Logarithms of the given over the true numbers (16,), zero where there is none."""
    true = np.array([getattr(case.arm, name) for name in KNOWN])
    given = np.array([getattr(case.given, name) for name in KNOWN])
    fine = (true > 0.0) & (given > 0.0) & np.isfinite(given)
    return np.asarray(np.where(fine, np.log(np.where(fine, given / np.where(fine, true, 1.0), 1.0)), 0.0).ravel())


def starts(case: Case, true: Hidden, site: Site | None) -> list[Hidden | None]:
    """Rivals at a site from where a fit may begin: those of the same shape as the true law at its own numbers.

    The same error of the other encoder is the true one turned round; a transmission's error is that of either encoder,
    one way round or the other.
    """
    if site is None:
        return [None]
    scale = scale_of(np.random.default_rng(0), case.arm, case.fit, case.controls[0], site[1], 1.0)
    rival = draw(site, scale)
    alike = (rival.effect == true.effect and rival.effect in SENSORS) or {rival.effect, true.effect} <= DISCS
    if not alike or rival.joint != true.joint:
        return [rival]
    turned = {key: -value if key in ("offset", "gain") else value for key, value in true.parameters.items()}
    if "phase" not in turned:
        return [dataclasses.replace(rival, parameters=turned)]
    phases = [turned["phase"] + np.pi * half for half in ((1,) if rival.effect == true.effect else (0, 1))]
    return [dataclasses.replace(rival, parameters=turned | {"phase": phase}) for phase in phases]


def delta_bic(case: Case, true: Hidden, site: Site | None) -> float:
    """BIC of the rival at a site, or of none, less that of the true law, on the fit's motion without noise.

    Infinite where the filter, to which a lag is one of first order, does not follow the truth itself: it says nothing.
    """
    found, z = make_filter(case), reported(case, case.fit)
    if float((surprises(case.fit, z, case.arm, case.hidden, found) ** 2).sum()) > INSEPARABLE:
        return np.inf
    others = [one for one in case.hidden if one is not true]
    prior = written(case)
    best = np.inf
    for rival in starts(case, true, site):
        keys = list(rival.parameters) if rival else []
        first = np.array([rival.parameters[key] for key in keys] if rival else [])
        unit = np.where(first == 0.0, 1.0, np.abs(first))

        def residual(x: Array, rival: Hidden | None = rival, keys: list[str] = keys, unit: Array = unit) -> Array:
            free = [v if key in SIGNED else abs(v) + 1e-9 for key, v in zip(keys, x[16:] * unit, strict=True)]
            all_of = list(others)
            if rival is not None:
                numbers = dict(zip(keys, free, strict=True))
                all_of.append(Hidden(rival.effect, rival.joint, rival.side, numbers, rival.place))
            errors = surprises(case.fit, z, calibrated(case.arm, case.tolerance * x[:16]), all_of, found)
            return np.concatenate([errors.ravel() / np.sqrt(case.sensors.every), x[:16] - prior / case.tolerance])

        x0 = np.concatenate([np.zeros(16), first / unit])
        fit = least_squares(residual, x0, diff_step=1e-3, x_scale=1.0, max_nfev=EVALUATIONS)
        best = min(best, 2.0 * fit.cost)
    extra = len(keys) - len(true.parameters)
    return float(best - ((prior / case.tolerance) ** 2).sum() + extra * np.log(z.size))


def nearest(truth: dict[str, Any], report: dict[str, Any]) -> dict[str, Any] | None:
    """The closest of the rivals that a report names beside what was hidden; None if it names none or none fits."""
    case = make_case(truth["family"], truth["seed"], truth["number"], truth["fit"], truth["check"])
    found: dict[str, Any] | None = None
    for one, entry in zip(case.hidden, truth["hidden"], strict=True):
        if one.effect == "joint_elasticity":
            continue
        for site in rival_sites(entry, report, case.given):
            delta = delta_bic(case, one, site)
            if np.isfinite(delta) and (found is None or delta < found["delta_bic"]):
                found = {"rival": site and list(site), "delta_bic": delta}
    return found


def rival_sites(entry: dict[str, Any], report: dict[str, Any], given: TwoLinkArm) -> list[Site | None]:
    """Sites of what a report names beside something hidden; none at all where it names nothing in its place."""
    groups = [[f, *(f.get("indistinguishable_from") or [])] for f in report["findings"]]
    mine = [group for group in groups if any(same(name, entry) for name in group)]
    if not mine:
        return [None]
    sites = [site_of(name, given) for group in mine for name in group if not same(name, entry)]
    return [site for site in sites if site is not None and site[0] != "joint_elasticity"]


def can_be_made(family: str) -> bool:
    """Whether the true arm of a family is one of this simulator's and what is hidden in it has a rival."""
    return split(family)[0] in FAMILIES and split(family)[0] != "outside"


def main() -> int:
    """Compute what is missing for every report that says "A or B", or too little."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("cases", type=Path)
    parser.add_argument("reports", type=Path)
    o = parser.parse_args()
    secret = o.cases.parent / f"{o.cases.name}.truth"
    for file in sorted(o.reports.glob("*/report.json")):
        truth_file, result = secret / f"{file.parent.name}.json", secret / f"{file.parent.name}.rivals.json"
        if result.exists() or not truth_file.exists():
            continue
        report, truth = json.loads(file.read_text("utf-8")), json.loads(truth_file.read_text("utf-8"))
        if not can_be_made(truth["family"]) or outcome(truth, report) not in ("half", "missed"):
            continue
        row = nearest(truth, report)
        if row is not None:
            result.write_text(json.dumps(row) + "\n", encoding="utf-8")
            print(f"{truth['case']}: {row['rival']} {row['delta_bic']:.1f}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
