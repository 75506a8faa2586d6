"""What a new user types first: python -m flexdyn, completion, doctor, example."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.cli import health
from flexdyn.cli.examples import EXAMPLES, model_of_the_examples
from tests.cli.conftest import Runner

MODULE = [sys.executable, "-m", "flexdyn"]


def test_python_m_flexdyn(tmp_path: Path) -> None:
    """The same program: version, exit codes, one line on stderr."""
    good = subprocess.run([*MODULE, "--version"], capture_output=True, text=True, check=False)
    assert (good.returncode, good.stdout, good.stderr) == (0, f"flexdyn {fd.__version__}\n", "")
    bad = subprocess.run([*MODULE, "inf"], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (bad.returncode, bad.stdout) == (2, "")
    assert "did you mean 'info'" in bad.stderr


def asked(words: str) -> dict[str, str]:
    """What bash sets to ask what could follow."""
    return {"_FLEXDYN_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1)}


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("flexdyn si", ["simulate"]),
        ("flexdyn diagnose --ch", ["--check"]),
        ("flexdyn effects visc", ["viscous_friction"]),
        ("flexdyn example back", ["backlash"]),
        ("flexdyn info scara", ["scara", "scara_two_link"]),
    ],
)
def test_the_shell_is_told_what_could_follow(
    flexdyn: Runner, monkeypatch: pytest.MonkeyPatch, words: str, found: list[str]
) -> None:
    """Commands, options, and names of effects, examples and models."""
    for name, value in asked(words).items():
        monkeypatch.setenv(name, value)
    outcome = flexdyn()
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.split() == found


def test_a_shell_asks_a_process() -> None:
    """As bash does when the tabulator is pressed."""
    environment = {**os.environ, **asked("flexdyn si")}
    done = subprocess.run(MODULE, capture_output=True, text=True, check=False, env=environment)
    assert (done.returncode, done.stdout.split(), done.stderr) == (0, ["simulate"], "")


def test_completion_is_installed_for_the_users_shell(tmp_path: Path) -> None:
    """A script in the home folder that bash reads when it starts; --show-completion prints the same script."""
    home = {**os.environ, "HOME": str(tmp_path), "SHELL": "/bin/bash"}
    call = ["bash", "-c", f'"{sys.executable}" -m flexdyn "$0"; true']
    done = subprocess.run([*call, "--install-completion"], capture_output=True, text=True, check=False, env=home)
    assert "completion for bash is installed in" in done.stdout, done
    scripts = [path for path in tmp_path.rglob("*") if path.is_file() and "_FLEXDYN_COMPLETE" in path.read_text()]
    assert len(scripts) == 1
    assert scripts[0].name in (tmp_path / ".bashrc").read_text()
    shown = subprocess.run([*call, "--show-completion"], capture_output=True, text=True, check=False, env=home)
    assert shown.stdout.strip() == scripts[0].read_text().strip()


def test_an_unknown_shell_is_named(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """With those that are known."""
    monkeypatch.setenv("SHELL", "/usr/bin/ksh")
    monkeypatch.setitem(sys.modules, "shellingham", None)
    outcome = flexdyn("--install-completion")
    assert outcome.code == 2
    assert "--install-completion: the shell is not known, got 'ksh'; run it in one of bash, zsh" in outcome.err


def test_doctor_says_what_is_there_and_tests_it(flexdyn: Runner) -> None:
    """Versions, extras, a compiler, and tests that pass within seconds."""
    outcome = flexdyn("doctor", "--json")
    assert outcome.code == 0
    document = outcome.json
    assert document["versions"]["flexdyn"] == fd.__version__
    assert document["versions"]["numpy"] == np.__version__
    assert [extra["name"] for extra in document["extras"]] == list(health.EXTRAS)
    assert len(document["tests"]) == len(health.TESTS) + 1
    assert all(test["passed"] for test in document["tests"])
    assert float(document["tests"][-1]["measured"].split()[0]) < 5.0
    text = flexdyn("doctor").out
    assert "Everything that was tested works." in text
    assert all(name in text for name in health.TESTS)


def test_doctor_tells_what_is_missing_or_broken(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """A missing extra with the line that installs it, exit code 0; a test that fails, by name, exit code 1."""
    monkeypatch.setitem(sys.modules, "h5py", None)
    outcome = flexdyn("doctor")
    assert outcome.code == 0
    assert "h5py: not installed" in outcome.out
    assert "pip install 'flexdyn[hdf5]'" in outcome.out

    def broken(*arguments: object, **settings: object) -> None:
        raise RuntimeError("the core is broken")

    monkeypatch.setattr(health, "simulate", broken)
    outcome = flexdyn("doctor")
    assert outcome.code == 1
    assert "RuntimeError: the core is broken" in outcome.out
    assert (
        "Failed: two solvers agree, energy is conserved, friction as in closed form, a file is read back unchanged"
        in outcome.out
    )


def test_every_extra_of_the_package_is_looked_at() -> None:
    """Those that pyproject offers to users; "test" and "docs" are for developers."""
    from importlib.metadata import metadata

    offered = set(metadata("flexdyn").get_all("Provides-Extra") or ()) - {"all", "test", "docs"}
    assert offered <= set(health.EXTRAS)


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_holds_what_it_says(flexdyn: Runner, tmp_path: Path, name: str) -> None:
    """A model without the effect; two logs with noise, whose gap the effect explains; commands that name the files."""
    outcome = flexdyn("example", name)
    assert outcome.code == 0
    assert sorted(path.name for path in (tmp_path / name).iterdir()) == [
        "README.txt",
        "model.yaml",
        "monday.csv",
        "tuesday.csv",
    ]
    model, log = fd.load_model(tmp_path / name / "model.yaml"), fd.read_recording(tmp_path / name / "monday.csv")
    believed = model_of_the_examples()
    assert (model.joints, model.effects, model.tolerance) == (believed.joints, (), 0.03)
    truth = model.replace(effects=[EXAMPLES[name].hidden])
    short = log.trim(0.0, 0.5)
    gaps = []
    for each in (model, truth):
        run = fd.simulate(each, short, solver="DormandPrince", times=short.t - short.t[0])
        gaps.append(float(np.abs(run.theta - short.signal("theta", model.joint_names)).max()))
    assert gaps[0] > 2.0 * gaps[1], gaps
    told = (tmp_path / name / "README.txt").read_text(encoding="utf-8")
    assert f"flexdyn diagnose {name}/model.yaml {name}/monday.csv --check {name}/tuesday.csv" in told
    assert f"flexdyn diagnose {name}/model.yaml" in outcome.out
    command = next(line.strip() for line in told.splitlines() if line.strip().startswith("flexdyn simulate"))
    assert flexdyn(*command.split()[1:]).code == 0
    again = flexdyn("example", name)
    assert (again.code, "the folder is not empty" in again.err) == (2, True)


def test_the_commands_of_an_example_find_what_was_hidden(flexdyn: Runner, tmp_path: Path) -> None:
    """All of them run, in order; the diagnosis names the effect, and the corrected model is nearer to the log."""
    flexdyn("example", "stribeck_friction", "-o", "demo")
    lines = (tmp_path / "demo" / "README.txt").read_text(encoding="utf-8").splitlines()
    commands = [line.split()[1:] for line in lines if line.startswith("    flexdyn ")]
    assert [command[0] for command in commands] == ["info", "simulate", "plot", "diagnose", "simulate", "compare"]
    for command in commands:
        outcome = flexdyn(*command)
        assert outcome.code == 0, outcome
    document = json.loads((tmp_path / "demo" / "report" / "report.json").read_text(encoding="utf-8"))
    named = [(finding["effect"], finding["joint"], finding["side"]) for finding in document["findings"]]
    assert named == [("stribeck_friction", "elbow", "motor")]
    gap = document["gap"]["test"]
    assert gap["after"] < 1.1 < 5.0 < gap["before"]


def test_examples_are_listed_and_asked_back(flexdyn: Runner, tmp_path: Path) -> None:
    """Without a name all of them; a wrong one is answered by the near miss, and nothing is written."""
    outcome = flexdyn("example")
    assert outcome.code == 0
    assert all(name in outcome.out for name in EXAMPLES)
    outcome = flexdyn("example", "backlsh")
    assert outcome.code == 2
    assert "did you mean 'backlash'" in outcome.err
    assert list(tmp_path.iterdir()) == []
