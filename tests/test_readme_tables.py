"""The tables of README and docs are those that the results, the catalogue and the shipped robots give."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

import flexdyn as fd
from flexdyn.records import SUFFIXES
from flexdyn.simulation.solvers import SOLVERS

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """scripts/readme_tables.py as a module."""
    spec = importlib.util.spec_from_file_location("readme_tables", ROOT / "scripts" / "readme_tables.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_pages_show_what_their_sources_give(script: ModuleType) -> None:
    """No table is older than the file or code it is made from, and every table stands somewhere."""
    shown = set()
    for page in script.pages():
        text = page.read_text(encoding="utf-8")
        assert script.stale(text, page) == [], page
        assert script.filled(text, page) == text
        shown |= set(script.markers(text))
    assert shown == set(script.TABLES)


def test_links_of_a_table_lead_from_the_page(script: ModuleType) -> None:
    """At the root, one folder down and two."""
    text = "<!-- table:robots -->\n<!-- /table:robots -->\n"
    for page, link in (("README.md", "(robots/"), ("docs/x.md", "(../robots/"), ("docs/howto/x.md", "(../../robots/")):
        assert f"]{link}panda/README.md)" in script.filled(text, ROOT / page)


TABLES = [
    "accuracy",
    "coverage",
    "discovery",
    "peers",
    "effects",
    "effect_checks",
    "formats",
    "fuzz",
    "libraries",
    "lines",
    "long_pages",
    "long_runs",
    "measured",
    "measured_names",
    "noise_estimators",
    "random_growth",
    "random_runs",
    "rates",
    "robots",
    "same_results",
    "signals_in_diagnosis",
    "signals_on_robots",
    "slowest_files",
    "smoothers",
    "wheels",
]


@pytest.mark.parametrize("name", TABLES)
def test_filling_twice_changes_nothing_more(script: ModuleType, name: str) -> None:
    """A stale table is noticed, filled between its markers only, and then stays as it is."""
    text = f"before\n<!-- table:{name} -->\nold\n<!-- /table:{name} -->\nafter\n"
    once = script.filled(text)
    assert script.stale(text) == [name]
    assert script.stale(once) == []
    assert once.startswith(f"before\n<!-- table:{name} -->\n| ")
    assert once.endswith(f" |\n<!-- /table:{name} -->\nafter\n")
    assert script.filled(once) == once


def test_a_sanitizers_run_is_recorded(script: ModuleType, tmp_path: Path) -> None:
    """With pytest's own counts; a second run replaces the first, and the other sanitizers' stay."""
    report, results = tmp_path / "tests.xml", tmp_path / "sanitizers.json"
    for kind, failed, findings in (("thread", 1, 2), ("address,undefined", 0, 0), ("thread", 0, 0)):
        counts = f'tests="1436" failures="{failed}" errors="0" skipped="2"'
        report.write_text(f'<testsuites><testsuite name="pytest" {counts}/></testsuites>', encoding="utf-8")
        words = [kind, str(report), "--findings", str(findings), "-o", str(results)]
        subprocess.run([sys.executable, str(ROOT / "scripts" / "sanitizer_result.py"), *words], check=True)
    content = json.loads(results.read_text(encoding="utf-8"))
    assert [(row["sanitizer"], row["passed"], row["findings"]) for row in content["runs"]] == [
        ("address,undefined", 1434, 0),
        ("thread", 1434, 0),
    ]
    assert all(bound["passed"] for bound in content["bounds"])
    table = script.OF_RESULTS["sanitizers"][1](content)
    assert table.splitlines()[2].startswith("| address,undefined | ")
    assert table.endswith("| 1,434 | 0 | 2 | 0 |")


@pytest.mark.parametrize(
    "text",
    [
        "<!-- table:speed -->\n<!-- /table:speed -->",
        "<!-- table:effects -->\n",
        "<!-- /table:effects -->\n<!-- table:effects -->\n",
        "<!-- table:effects -->\n<!-- /table:robots -->",
    ],
)
def test_a_wrong_marker_is_refused(script: ModuleType, text: str) -> None:
    """A table that nobody makes, or a marker without its partner, is an error and not silently left."""
    with pytest.raises(ValueError, match="table"):
        script.filled(text)


def test_the_effects_table_has_every_effect_of_flexdyn(script: ModuleType) -> None:
    """One row an effect, with its law and the unit of each parameter; a user's own effects are not shown."""
    rows = {row.split("`")[1]: row for row in script.effects().splitlines()[2:]}
    own = {name: kind for name, kind in fd.effects.catalogue().items() if kind.__module__.startswith("flexdyn.")}
    assert rows.keys() == own.keys()
    for name, kind in own.items():
        assert kind.law in rows[name]
        assert all(f"`{field.name}` [{field.metadata['unit']}]" in rows[name] for field in kind.parameters())


def test_every_effect_is_measured(script: ModuleType) -> None:
    """Each of flexdyn's own effects has a row of measured properties; neutral, each one changes no solver's run."""
    rows = [row.split("`")[1] for row in script.TABLES["effect_checks"]().splitlines()[2:]]
    assert rows == [name for name, kind in fd.effects.catalogue().items() if kind.__module__.startswith("flexdyn.")]
    results = json.loads((ROOT / "benchmarks" / "results" / "effects.json").read_text(encoding="utf-8"))
    assert set(results["solvers"]) == set(SOLVERS)
    for name, row in results["effects"].items():
        assert row["neutral"] == results["solvers"]
        assert row["scipy"] <= 1e-6
        assert row["events"] > 0 or fd.effects.catalogue()[name].stage != "dry"


def test_the_robots_table_has_every_shipped_model(script: ModuleType) -> None:
    """The paper's arm stands there with its two joints and the stiffness of Table I."""
    rows = script.robots().splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(fd.shipped_models())
    (paper,) = [row for row in rows if "scara_two_link" in row]
    assert "| 2 | 5.5 N m/rad |" in paper


def test_the_formats_table_has_every_suffix(script: ModuleType) -> None:
    """Each suffix once, with an extra that pip knows, and a peak below the bound of its benchmark."""
    rows = [row.strip("| ").split(" | ") for row in script.formats().splitlines()[2:]]
    assert sorted(suffix for row in rows for suffix in row[0].replace("`", "").split()) == sorted(SUFFIXES)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = {name for row in rows for name in re.findall("`(.*)`", row[1])}
    assert extras == {"hdf5", "parquet", "ros"}
    assert extras < project["optional-dependencies"].keys()
    assert all(row[3] == "-" or 1.0 <= float(row[3]) < 3.0 for row in rows)


def test_the_table_of_hidden_effects_has_every_case_in_one_column(script: ModuleType) -> None:
    """Names that are false, beside a right one or not, are counted together; what is not known is a dash."""
    outcomes = {"right": 93, "half": 2, "beside": 1, "wrong": 1, "missed": 2, "forced": 0, "failed": 1}
    numbers = {
        "median_parameter_error": 0.00412,
        "coverage": 1.0,
        "test_gap_over_floor": 1.034,
        "median_seconds": 22.6,
    }
    nothing = dict.fromkeys(numbers) | {"cases": 40, "points": 1.0} | dict.fromkeys(outcomes, 0) | {"right": 40}
    results = {"summary": {"none": nothing, "single": {"cases": 100, "points": 0.94, **outcomes, **numbers}}}
    rows = [row.strip("| ").split(" | ") for row in script.discovery_table(results).splitlines()[2:]]
    assert rows == [
        ["one effect", "100", "93", "2", "2", "3", "94.0 %", "0.41 %", "100 %", "1.03", "23"],
        ["nothing", "40", "40", "0", "0", "0", "100.0 %", "-", "-", "-", "-"],
    ]
    with pytest.raises(ValueError, match="strange"):
        script.discovery_table({"summary": {"strange": nothing}})


def test_the_table_of_rates_says_which_names_stay(script: ModuleType) -> None:
    """Alone or as "A or B"; what is new is counted, and a refusal stands in the place of names."""

    def at(rate: float, *names: list[str]) -> dict[str, object]:
        return {"rate": rate, "names": [{"names": each, "probability": 0.97} for each in names]}

    a, b, c = "coulomb_friction (x)", "viscous_friction (x)", "backlash (x)"
    refused = {"rate": 10.0, "names": [], "refused": "too slow"}
    found = {"what": "arm", "at": [at(1000.0, [a], [b]), at(500.0, [b, a], [c]), refused]}
    lines = script.rates_table({"robots": {"emps": [found]}}).splitlines()[2:]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    assert [row[-2] for row in rows] == ["", "the same, 1 new", "0 of 2"]
    assert [row[0] for row in rows] == ["arm", "", ""]
    assert rows[2][2] == "too slow"


def test_every_family_of_hidden_effects_has_a_row(script: ModuleType) -> None:
    """None that the benchmark can make is left out of the table."""
    text = (ROOT / "benchmarks" / "discovery" / "README.md").read_text(encoding="utf-8")
    table = text.partition("| family |")[2].partition("\n\n")[0]
    families = [name for row in table.splitlines() for name in re.findall(r"`(\w+)`", row.split("|")[1:2][0])]
    assert len(families) == 12
    row = dict.fromkeys(("right", "half", "beside", "wrong", "missed", "forced", "failed"), 0) | {"cases": 0}
    rest = dict.fromkeys(("points", "median_parameter_error", "coverage", "test_gap_over_floor", "median_seconds"))
    table = script.discovery_table({"summary": dict.fromkeys(families, row | rest)})
    assert len(table.splitlines()) == 2 + len(families)


@pytest.mark.parametrize("name", ["analytic_two_link", "effects", "peers"])
def test_results_say_how_they_were_made(name: str) -> None:
    """A committed result names its command, versions and date, and every bound it was held to held."""
    results = json.loads((ROOT / "benchmarks" / "results" / f"{name}.json").read_text(encoding="utf-8"))
    assert results["command"] == f"python benchmarks/{name}.py -o benchmarks/results/{name}.json"
    assert {"flexdyn", "pin", "numpy", "scipy", "mujoco", "python"} <= results["versions"].keys()
    assert results["date"].count("-") == 2
    assert [bound["name"] for bound in results["bounds"] if not bound["passed"]] == []


def test_our_own_code_stays_only_for_the_reasons_that_count() -> None:
    """It is right on every input, and the library is wrong on one, more than twice slower or an extra."""
    results = json.loads((ROOT / "benchmarks" / "results" / "libraries.json").read_text(encoding="utf-8"))
    for each in [one for part in results["parts"].values() for one in part]:
        assert not [case["name"] for case in each["cases"] if case["ours"]], each["task"]
        wrong = any(case["library"] for case in each["cases"])
        slow = any(ratio > 2.0 for ratio in each["library_time_over_ours"].values())
        extra = any("extra" in reason for reason in each["reasons"])
        assert each["decision"] == ("ours" if wrong or slow or extra else "library"), each["task"]
        assert bool(each["reasons"]) == (each["decision"] == "ours")
        if each["decision"] == "ours":
            assert importlib.util.find_spec(each["ours"]) is not None
