"""Tables of the two noise estimators and the two smoothers, of their result files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from result_tables import markdown_table


def noise_estimators_table(results: Mapping[str, Any]) -> str:
    """Simulated noise of a known size, then the encoders of measured robots."""
    header = ["noise of the encoder, simulated", "`estimate_noise` / true", "`reading_noise` / true"]
    header += ["noise of the acceleration / predicted by `estimate_noise`", "by `reading_noise`"]
    rows = [
        [kind, *(f"{each['median']:.2f}" for each in found.values())] for kind, found in results["simulated"].items()
    ]
    robots = []
    for robot, encoders in results["recorded"].items():
        ratios = [each["reading_std"] / each["std"] for each in encoders.values()]
        span = f"{min(ratios):.2f}" if len(ratios) == 1 else f"{min(ratios):.2f} to {max(ratios):.2f}"
        robots.append([robot, str(len(ratios)), span])
    measured = markdown_table(["measured robot", "encoders", "`reading_noise` / `estimate_noise`"], robots)
    return f"{markdown_table(header, rows)}\n\n{measured}"


def smoothers_table(results: Mapping[str, Any]) -> str:
    """What either smoother leaves of an exact equation."""
    cases = results["cases"]
    noises = [row["noise"] for row in next(iter(cases.values()))["left"]]
    header = ["motion, width of the second Gaussian"]
    for noise in noises:
        told = f"noise {1e6 * noise:g} um" if noise else "no noise"
        header += [f"{told}: Gaussian, N", "polynomial, N"]
    rows = [[name, *(_short(left) for row in case["left"] for left in row["rms"])] for name, case in cases.items()]
    return markdown_table(header, rows)


def signals_in_diagnosis_table(results: Mapping[str, Any]) -> str:
    """Names and intervals of hidden-effect cases, with one part of the diagnosis exchanged."""
    header = ["diagnosis", "cases", "right", "half right", "other", "false names", "intervals that hold the truth"]
    rows = []
    for name, families in results["variants"].items():
        found = list(families.values())
        cases, right, half, false = (_sum(found, key) for key in ("cases", "right", "half", "false_names"))
        held = sum(round(each["coverage"] * each["intervals"]) for each in found if each["intervals"])
        counts = (cases, right, half, cases - right - half, false)
        rows.append([name, *map(str, counts), f"{held} of {_sum(found, 'intervals')}"])
    return markdown_table(header, rows)


def signals_on_robots_table(results: Mapping[str, Any]) -> str:
    """Names and gaps of measured robots, likewise."""
    rows = []
    for robot, variants in results["robots"].items():
        for name, found in variants.items():
            names = ", ".join(each.replace("_", " ").replace("@", " (") + ")" for each in found["names"])
            rows.append([robot, name, names, ", ".join(f"{gap:.3g}" for gap in found["gap"])])
    return markdown_table(["robot", "diagnosis", "named", "gap on the test data"], rows, text=3)


def _sum(found: Sequence[Mapping[str, Any]], key: str) -> int:
    return sum(int(each[key]) for each in found)


def _short(value: float) -> str:
    return f"{value:.1e}" if value < 1e-3 else f"{value:.2g}"
