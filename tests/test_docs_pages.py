"""The generated pages of the site: every effect, every public name, every link."""

from __future__ import annotations

import doctest
import importlib
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import flexdyn as fd

ROOT = Path(__file__).parents[1]
PARTS = ("## What it looks like in data", "## What it is confused with", "## Where it was seen", "$$")


@pytest.fixture(scope="module")
def scripts() -> Iterator[dict[str, ModuleType]]:
    """The scripts that write the pages, as docs/conf.py imports them."""
    sys.path.insert(0, str(ROOT / "scripts"))
    yield {name: importlib.import_module(f"docs_{name}") for name in ("effects", "api", "repository")}
    sys.path.remove(str(ROOT / "scripts"))


def test_every_effect_has_a_page(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    """With prose, equation, parameters and drawing."""
    scripts["effects"].write(tmp_path, ROOT / "docs" / "effects.yaml")
    own = scripts["effects"].own_effects()
    assert {path.stem for path in tmp_path.glob("*.md")} == set(own)
    assert {path.stem for path in tmp_path.glob("*.svg")} == set(own)
    for name, kind in own.items():
        text = (tmp_path / f"{name}.md").read_text(encoding="utf-8")
        assert all(part in text for part in (*PARTS, f"({name}.svg)"))
        for field in kind.parameters():
            (row,) = [line for line in text.splitlines() if line.startswith(f"| `{field.name}` |")]
            assert f"| {field.metadata['unit']} |" in row


def test_prose_names_effects_that_are_there(scripts: dict[str, ModuleType]) -> None:
    """A name in backquotes that looks like an effect's is one."""
    prose = scripts["effects"].read_prose(ROOT / "docs" / "effects.yaml")
    known = set(prose) | {
        field.name for kind in scripts["effects"].own_effects().values() for field in kind.parameters()
    }
    for name, parts in prose.items():
        named = re.findall(r"`(\w+)`", " ".join(parts[key] for key in ("data", "confused_with", "seen")))
        assert set(named) - known - {"damping"} == set(), name


@pytest.mark.parametrize(
    ("robot", "effect", "parameter", "scale", "digits"),
    [
        ("emps", "coulomb_friction", "level", 1.0, 1),
        ("double_pendulum", "coulomb_friction", "level", 1.0, 3),
        ("kuka_kr300", "parallel_spring", "stiffness", 1.0, 0),
        ("kuka_kr300", "parallel_spring", "rest", 1.0, 2),
        ("friction_damper", "backlash", "half_gap", 1e3, 2),
        ("kinova_gen3", "coulomb_friction", "level", 1.0, 2),
        ("kinova_gen3", "viscous_friction", "coefficient", 1.0, 2),
        ("kinova_gen3", "payload", "mass", 1.0, 2),
    ],
)
def test_prose_has_the_numbers_of_the_results(
    scripts: dict[str, ModuleType], robot: str, effect: str, parameter: str, scale: float, digits: int
) -> None:
    """Of every finding of this effect on a measured robot."""
    seen = scripts["effects"].read_prose(ROOT / "docs" / "effects.yaml")[effect]["seen"]
    result = json.loads((ROOT / "benchmarks" / "results" / f"{robot}.json").read_text(encoding="utf-8"))
    answers = result["diagnoses"].values() if "diagnoses" in result else [result["diagnosis"]]
    findings = [each for answer in answers for each in answer["findings"] if each["effect"] == effect]
    assert findings
    for finding in findings:
        assert f"{scale * finding['parameters'][parameter]['value']:.{digits}f}" in seen


def test_an_effect_without_prose_is_refused(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    """The site is not built without it."""
    text = (ROOT / "docs" / "effects.yaml").read_text(encoding="utf-8")
    (tmp_path / "effects.yaml").write_text(text.replace("\npayload:\n", "\nload:\n"), encoding="utf-8")
    with pytest.raises(ValueError, match="payload lacks symbols, equation, data, confused_with, seen"):
        scripts["effects"].read_prose(tmp_path / "effects.yaml")


def test_every_public_name_is_in_the_reference(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    """Once, on the page of its package."""
    scripts["api"].write(tmp_path)
    text = "".join(path.read_text(encoding="utf-8") for path in tmp_path.glob("*.md") if path.stem != "index")
    shown = re.findall(r"^\.\. auto\w+:: (\S+)$", text, flags=re.MULTILINE)
    assert len(shown) == len(set(shown))
    assert {f"flexdyn.{name}" for name in fd.__all__} - {"flexdyn.effects", "flexdyn.solvers"} <= set(shown)
    assert {f"flexdyn.effects.{name}" for name in fd.effects.__all__} <= set(shown)
    assert {path.rpartition(".")[2] for path in shown} >= {"RungeKutta4", "DormandPrince", "Rosenbrock", "TimeStepping"}
    index = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert all(f"[`fd.{name}`]" in index for name in fd.__all__ if name not in ("effects", "solvers"))


def test_every_effect_of_the_reference_has_an_example_that_runs(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    """Its constructor as text makes the same effect, and its model file's entry stands below."""
    scripts["api"].write(tmp_path)
    text = (tmp_path / "effects.md").read_text(encoding="utf-8")
    shown = "\n".join(re.findall(r"^```pycon\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL))
    test = doctest.DocTestParser().get_doctest(shown, {"fd": fd}, "effects", None, None)
    assert len(test.examples) == len(fd.effects.catalogue())
    said: list[str] = []
    assert doctest.DocTestRunner(verbose=False).run(test, out=said.append).failed == 0, "".join(said)


def test_links_lead_to_the_pages_of_the_site(scripts: dict[str, ModuleType]) -> None:
    """A page outside docs/ is led to its copy, a picture stays where it is, another file keeps its name alone."""
    source, target = ROOT / "docs" / "measured.md", ROOT / "docs" / "measured.md"
    text = (
        "[EMPS](../benchmarks/results/emps/page.md#a) ![x](../benchmarks/figures/play.png) [rules](../pyproject.toml)"
    )
    assert scripts["repository"].relinked(text, source, target) == (
        "[EMPS](generated/repository/measured_emps.md#a) ![x](../benchmarks/figures/play.png) rules"
    )
    with pytest.raises(FileNotFoundError, match="nowhere"):
        scripts["repository"].relinked("[x](nowhere.md)", source, target)


def test_pages_of_the_repository_keep_their_pictures(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    """Measured robots and shipped models, with pictures that are found from where the pages stand."""
    scripts["repository"].write(tmp_path)
    names = {path.stem for path in tmp_path.glob("*.md")}
    assert {f"robot_{name}" for name in fd.shipped_models()} | {"measured_emps", "benchmarks", "contributing"} <= names
    for path in tmp_path.glob("*.md"):
        for link in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", path.read_text(encoding="utf-8")):
            assert (tmp_path / link).resolve().is_file()
