"""Code outside flexdyn/effects asks what an effect declares, and names no single one: users' effects count as well."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import flexdyn
from flexdyn import _core
from flexdyn.effects import base, catalogue

PACKAGE = Path(flexdyn.__file__).parent
OWN = ("effects", "paper", "core")
"""Folders that may name effects: their own, the study of the paper, whose model is a list of effects, and the C++."""
MAKES = {
    "cli/examples.py": ("StribeckFriction CoulombFriction ViscousFriction Backlash", "each example hides one of these"),
    "cli/health.py": ("ViscousFriction", "checks a motion with friction that has a closed form"),
    "cli/info.py": ("payload", "the key of its document is a word and no effect"),
    "diagnose/experiment/reach.py": ("Payload", "hangs a known mass at the tip"),
    "diagnose/hypothesis/hypothesis.py": ("SensorOffset", "an offset of about a count of every encoder is no finding"),
    "diagnose/report/suspects.py": ("ParameterError", "tells a number of the file that is wrong as an effect"),
    "model/actuator.py": ("MotorTorque MotorWinding SupplyLimit", "makes the laws of a motor from its data sheet"),
    "model/resolved_parameters.py": ("ParameterError", "applies errors of numbers to the numbers"),
    "model/uncertain_parameters.py": ("ParameterError", "makes the error of a number of the file"),
    "model/urdf_dynamics.py": ("ViscousFriction CoulombFriction", "makes friction of the URDF's <dynamics>"),
    "simulation/limits.py": ("EndStop TorqueSpeedLimit", "makes effects of the URDF's <limit>"),
}
"""Files that name single effects -> which ones, and why: nearly all because they make effects of something else."""
TELLS = {
    "cli/diagnose.py": {"channel_lag", "coulomb_friction"},  # examples in the help of an option
    "robot/normalise.py": {"asymmetric_friction"},  # what a user should write; a robot knows no effects to ask
}
"""Files whose sentences name effects."""
ALSO_ELSEWHERE = {
    "damping": "of a joint, and of the URDF's <dynamics>",
    "stiffness": "of a joint",
    "offset": "a number of the linear regressor",
    "factor": "of the error of a number, in files of a diagnosis",
    "lower": "the bound of a parameter",
    "cubic": "the kind of an interpolation",
}
"""Names of parameters of effects that `analysis` and `diagnose` write for something else -> what."""
FILES = sorted(path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).parts[0] not in OWN)


@functools.cache
def single_effects() -> frozenset[str]:
    """Names of flexdyn's classes of which no other class of flexdyn is a kind."""

    def leaves(kind: type[base.Effect]) -> Iterator[str]:
        own = [each for each in kind.__subclasses__() if each.__module__.startswith("flexdyn.effects")]
        if not own:
            yield kind.__name__
        for each in own:
            yield from leaves(each)

    return frozenset(leaves(base.Effect))


@functools.cache
def in_text() -> re.Pattern[str]:
    """The name of an effect, as model files have it, as a word."""
    own = [name for name, kind in catalogue().items() if kind.__module__.startswith("flexdyn.")]
    return re.compile(rf"\b({'|'.join(own)})\b")


def described(tree: ast.AST) -> Iterator[ast.expr]:
    """Docstrings, also those below a constant: strings that stand alone."""
    yield from (node.value for node in ast.walk(tree) if isinstance(node, ast.Expr))


def in_messages(path: Path) -> set[str]:
    """Effects in sentences that a user reads; names of one word, as ``payload``, are plain English too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    own = set(described(tree))
    texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and node not in own]
    sentences = [each for each in texts if isinstance(each, str) and " " in each]
    return {match[1] for each in sentences for match in in_text().finditer(each) if "_" in match[1]}


def named(path: Path) -> set[str]:
    """Single effects that code names: classes, and strings without a space."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        word = getattr(node, "id", None) or getattr(node, "attr", None)
        if isinstance(node, ast.Name | ast.Attribute) and word in single_effects():
            found.add(str(word))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " not in node.value:
            found |= {match[1] for match in in_text().finditer(node.value)}
    return found


def test_the_kinds_are_no_single_effects() -> None:
    """There is something to look for: laws of the catalogue and of motors, and not their bases."""
    own = {kind.__name__ for kind in catalogue().values() if kind.__module__.startswith("flexdyn.")}
    assert own <= single_effects()
    assert "MotorTorque" in single_effects()
    assert not {"JointEffect", "SensorEffect", "MemoryEffect", "CouplingEffect", "WaveEffect"} & single_effects()


@pytest.mark.parametrize("folder", sorted({path.relative_to(PACKAGE).parts[0] for path in FILES}))
def test_code_names_no_single_effect(folder: str) -> None:
    """It asks for a property that the class declares; every listed file needs its entry."""
    inside = [path for path in FILES if path.relative_to(PACKAGE).parts[0] == folder]
    naming = {path.relative_to(PACKAGE).as_posix(): found for path in inside if (found := named(path))}
    listed = {file: set(names.split()) for file, (names, _) in MAKES.items() if file.split("/")[0] == folder}
    assert naming == listed


def test_the_core_names_laws_in_two_files() -> None:
    """A new law needs its row, its formula and nothing else; a law written in Python is of no row."""
    core = Path(__file__).parents[1] / "flexdyn" / "core"
    files = [path for path in core.glob("*.?pp") if path.name not in ("law_table.hpp", "laws.hpp")]
    assert len(files) > 40
    found = {law for path in files for law in re.findall(r"LawKind::(\w+)", path.read_text(encoding="utf-8"))}
    assert found == {"callback"}
    rows = re.findall(r"LawKind::(\w+), Stage", (core / "law_table.hpp").read_text(encoding="utf-8"))
    assert sorted(rows) == sorted(row.name for row in _core.law_table())


def test_messages_ask_for_names_too() -> None:
    """They take a name from the class or from the catalogue; every listed file needs its entry."""
    told = {path.relative_to(PACKAGE).as_posix(): in_messages(path) for path in FILES}
    assert {file: found for file, found in told.items() if found} == TELLS


@pytest.mark.parametrize("folder", ["analysis", "diagnose"])
def test_code_names_no_parameter_of_an_effect(folder: str) -> None:
    """It asks for what the parameter or its class declares: `cycles`, `around`, `step`, `chosen`, `by_factor`."""
    own = [kind for kind in catalogue().values() if kind.__module__.startswith("flexdyn.")]
    names = {field.name for kind in own for field in kind.parameters()} - ALSO_ELSEWHERE.keys()
    for path in sorted((PACKAGE / folder).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        words = {
            node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        assert not words & names, path


def test_no_other_code_names_a_parameter_of_one_effect() -> None:
    """Likewise of names of more than one word, such as ``stall_torque``: shorter ones have other meanings too."""
    own = [kind for kind in catalogue().values() if kind.__module__.startswith("flexdyn.")]
    names = {field.name for kind in own for field in kind.parameters() if "_" in field.name}
    makes = {PACKAGE / file for file in MAKES}
    for path in (each for each in FILES if each not in makes):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        words = {str(getattr(node, "value", "")) for node in ast.walk(tree) if isinstance(node, ast.Constant)}
        words |= {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        assert not words & names, path
