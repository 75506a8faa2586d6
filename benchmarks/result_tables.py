"""Result files as Markdown: the tables that the benchmarks print and README and docs show."""

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


_FAMILIES = {
    "single": "one effect",
    "hard": "one effect of 0.3 of the size, ten times the noise, masses wrong too",
    "pair": "two effects",
    "triple": "three effects",
    "motor_only": "one effect, encoders on the motors alone",
    "link_only": "one effect, encoders on the links alone",
    "rigid": "one effect on an arm of rigid joints, or a joint that is elastic after all",
    "six": "one effect on a six-joint arm",
    "published": "a dozen effects of a robot whose model is its published one",
    "published_six": "the same with six joints",
    "none": "nothing",
    "outside": "something that is not in the catalogue",
}
"""What the hidden-effect benchmark hides, in the order of the table."""


def discovery_table(results: Mapping[str, Any]) -> str:
    """What the diagnosis said of hidden effects, family by family; every case is in one of four columns."""
    header = [
        "what is hidden",
        "cases",
        "right",
        '"A or B"',
        "a false name",
        "not found",
        "points",
        "error of the numbers",
        "truth in the 95 % interval",
        "gap on the check / noise",
        "time [s]",
    ]
    summary = {family.removesuffix("_wide"): row for family, row in results["summary"].items()}
    unknown = summary.keys() - _FAMILIES
    if unknown:
        raise ValueError(f"no words for: {', '.join(sorted(unknown))}")
    rows = []
    for family, words in _FAMILIES.items():
        if family in summary:
            row = summary[family]
            false, silent = row["wrong"] + row["beside"] + row["forced"], row["missed"] + row["failed"]
            counts = [f"{count}" for count in (row["cases"], row["right"], row["half"], false, silent)]
            numbers = (
                _number(row["points"], ".1%"),
                _number(row["median_parameter_error"], ".2%"),
                _number(row["coverage"], ".0%"),
                _number(row["test_gap_over_floor"], ".2f"),
                _number(row["median_seconds"], ".0f"),
            )
            rows.append([words, *counts, *numbers])
    return markdown_table(header, rows)


def reliability_table(results: Mapping[str, Any]) -> str:
    """How often candidates with some probability are true: all that the reports list, and those that were named."""
    header = ["probability", "candidates", "mean probability", "true", "named", "mean probability", "true"]
    both = [
        {(each["from"], each["to"]): each for each in results[key]["bins"]} for key in ("of_candidates", "reliability")
    ]
    rows = []
    for low, high in sorted({place for bins in both for place in bins}):
        cells = [f"{low:g} to {high:g}"]
        for bins in both:
            row = bins.get((low, high))
            cells += (
                ["-", "-", "-"]
                if row is None
                else [f"{row['count']}", f"{row['probability']:.3f}", f"{row['true']:.0%}"]
            )
        rows.append(cells)
    return markdown_table(header, rows)


MEASURED = {
    "emps": "EMPS, one sliding axis in its control loop",
    "double_pendulum": "double pendulum, two quasi-direct drives",
    "kuka_kr300": "KUKA KR 300, six axes",
    "screw_drives": "screw drives",
    "xl330": "XL330, a hobby servo from its goal alone",
    "friction_damper": "friction damper, prescribed motion",
    "kinova_gen3": "Kinova Gen3, sweeps of single joints in one direction",
}
"""Studies of measured robots, in the order of the table."""


def measured_table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """Measured robots: what was named, what must hold beside what does, and what it took.

    Args:
        results: result files by name; one that is not there has no rows.
    """
    rows = []
    for name, words in MEASURED.items():
        if name not in results:
            continue
        found = results[name]
        robot = [f"[{words}](benchmarks/results/{name}/page.md)", _named(found, likely=True)]
        for k, bound in enumerate(found["bounds"]):
            value = f"{bound['value']:.3g}" + ("" if bound["passed"] else " (not reached)")
            beside = found.get("beside", {}).get(bound["name"], {})
            others = [_number(beside.get(key), ".3g") for key in ("published", "plain")]
            cost = _cost(found.get("cost")) if k == 0 else ["", ""]
            rows.append([*(robot if k == 0 else ["", ""]), bound["name"], *others, value, f"{bound['bound']:g}", *cost])
    header = [
        "robot",
        "named, with probability",
        "what must hold",
        "published or best known",
        "plain model",
        "found",
        "at most",
        "processor time [s]",
        "memory [MB]",
    ]
    return markdown_table(header, rows, text=3)


def _cost(cost: Mapping[str, Any] | None) -> list[str]:
    """Processor time and peak memory of a study."""
    return [_number((cost or {}).get(key), ".0f") for key in ("processor_seconds", "peak_megabytes")]


def rates_table(results: Mapping[str, Any]) -> str:
    """Names at the full, half and a tenth of the sampling rate, and whether each name of the full rate stays.

    Args:
        results: of `benchmarks/measured/rates.py`.
    """
    rows = []
    for found in (each for robot in MEASURED for each in results["robots"].get(robot, [])):
        first = found["at"][0]["names"]
        for k, at in enumerate(found["at"]):
            names = "; ".join(_likely(each) for each in at["names"]) or "nothing"
            cells = [found["what"] if k == 0 else "", f"{at['rate']:.4g}", at.get("refused", names.replace("_", " "))]
            rows.append([*cells, "" if k == 0 else _agreement(first, at["names"]), _seconds(at)])
    header = ["robot", "rate [Hz]", "named, with probability", "names of the full rate", "processor time [s]"]
    return markdown_table(header, rows, text=4)


def _likely(found: Mapping[str, Any]) -> str:
    """A finding of `rates.py`: its names, the first one first, and its probability."""
    names = " or ".join(dict.fromkeys(found["names"]))
    return names if found["probability"] is None else f"{names} {found['probability']:.3f}"


def _agreement(first: Sequence[Mapping[str, Any]], now: Sequence[Mapping[str, Any]]) -> str:
    """Whether the first name of each finding is still there, alone or as "A or B", and whether others have come."""
    stay = [any(each["names"][0] in other["names"] for other in now) for each in first]
    new = [other for other in now if not any(set(each["names"]) & set(other["names"]) for each in first)]
    said = "the same" if all(stay) else f"{sum(stay)} of {len(stay)}"
    return said + (f", {len(new)} new" if new else "")


def _seconds(at: Mapping[str, Any]) -> str:
    return _number(at.get("processor_seconds"), ".1f")


def measured_names_table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """Measured robots and what was named, nothing else; `results` as `measured_table` takes it."""
    rows = [
        [f"[{words}](benchmarks/results/{name}/page.md)", _named(results[name])]
        for name, words in MEASURED.items()
        if name in results
    ]
    return markdown_table(["robot", "named"], rows, text=2)


def _named(found: Mapping[str, Any], *, likely: bool = False) -> str:
    """The effects that a study named, each with its joint, or with the drive and direction.

    Args:
        found: a result file.
        likely: with the probability of every finding, where it has one.
    """
    if "drives" in found:
        names = [
            f"{name} ({drive['what']}, {direction})"
            for drive in found["drives"].values()
            for direction, each in drive["directions"].items()
            for name in each["named"]
        ]
    else:
        several = found.get("diagnoses", {})
        names = [
            _finding(each, label, likely=likely)
            for label, diagnosis in (several or {"": found["diagnosis"]}).items()
            for each in diagnosis["findings"]
        ]
    return ", ".join(name.replace("_", " ") for name in names) or "nothing"


def _finding(found: Mapping[str, Any], label: str, *, likely: bool) -> str:
    """One finding: all its names, where it acts (by the diagnosis' label where there are several), its probability."""
    names = dict.fromkeys((found["effect"], *(rival["effect"] for rival in found["indistinguishable_from"])))
    where = label.rpartition("Hz_")[2].replace("lb", " lb") or found["joint"]
    said = f"{found['probability']:.3f}" if found["probability"] < 0.9995 else "above 0.999"
    return f"{' or '.join(names)} ({where})" + (f" {said}" if likely else "")


def _number(number: float | None, form: str) -> str:
    return "-" if number is None else format(number, form).replace("%", " %")


def _taken(row: Mapping[str, Any]) -> str:
    if "taken" not in row or row["taken"] == 0.0:
        return "-"
    # What rounding gives in a millisecond is nothing.
    return f"{row['taken']:.2g} J" + ("" if row["least_power"] > -1e-9 else ", both ways")


def _size(number: float) -> str:
    return "0" if number == 0.0 else f"{number:.0e}"


def libraries_table(results: Mapping[str, Any]) -> str:
    """Libraries beside our own code: where each is wrong, who is faster, and what is kept."""
    header = ["task", "library", "right: ours", "right: library", "time of the library / ours", "kept", "because"]
    rows = []
    for found in [each for part in results["parts"].values() for each in part]:
        cases, times = found["cases"], found["library_time_over_ours"].values()
        right = [f"{sum(not case[who] for case in cases)} of {len(cases)}" for who in ("ours", "library")]
        spread = f"{min(times):.1f} to {max(times):.1f}" if len(times) > 1 else "".join(f"{each:.1f}" for each in times)
        because = "; ".join(found["reasons"]) or "right, and not slower than that"
        rows.append([found["task"], found["library"], *right, spread or "-", found["decision"], because])
    return markdown_table(header, rows, text=7)
