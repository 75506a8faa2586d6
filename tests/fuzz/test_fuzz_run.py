"""A short run of the fuzzer, and the proof that it would notice what it looks for."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from flexdyn.errors import InputError
from tests.fuzz import harness
from tests.fuzz.harness import run
from tests.fuzz.targets import TARGETS, Target

ROOT = Path(__file__).parents[2]


def test_a_short_run_finds_nothing(tmp_path: Path) -> None:
    """Some hundred inputs over all targets: each is read, or refused by one line."""
    command = [sys.executable, str(ROOT / "scripts" / "fuzz.py"), "--inputs", "300", "--seed", "5"]
    command += ["-o", str(tmp_path / "fuzz.json")]
    done = subprocess.run([*command, "--folder", str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = [line.split("|")[1].strip() for line in done.stdout.splitlines()[2:]]
    assert rows == [*(target.name for target in TARGETS), "all"]
    written = json.loads((tmp_path / "fuzz.json").read_text(encoding="utf-8"))
    assert sum(row["inputs"] for row in written["readers"]) == pytest.approx(300, abs=10)
    assert all(bound["passed"] for bound in written["bounds"])


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_damage_starts_from_files_that_are_read(
    target: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A seed that is refused for what it is would leave most of its reader untried."""
    monkeypatch.chdir(tmp_path)
    seeds = target.seeds(tmp_path)
    assert seeds
    for seed in seeds if seed_is_a_file(target) else ():
        with warnings.catch_warnings(action="ignore"):
            target.run(tmp_path, seed)


def seed_is_a_file(target: Target) -> bool:
    """Whether the target takes files, and not the number that a case is drawn from."""
    return target.suffix != ".txt"


def misbehave(folder: Path, data: bytes) -> None:
    """What no reader may do, by the last digit of the input."""
    deeds = {
        "0": "import os; os.kill(os.getpid(), 11)",
        "1": "while True: pass",
        "2": "[].x",
        "3": "raise InputError('two\\nlines\\x1b')",
        "4": "bytearray(2**40)",
        "5": "import warnings; warnings.warn('told', RuntimeWarning)",
        "6": "raise InputError('refused')",
        "7": "import os; os._exit(0)",
    }
    exec(deeds.get(data[-1:].decode(), "pass"), {"InputError": Loose if data[-1:] == b"3" else InputError})  # noqa: S102


class Loose(InputError):
    """An error that does not keep to a line."""

    def __str__(self) -> str:
        """As it was given."""
        return self.problem


def test_the_harness_notices_every_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Crashes, hangs, tracebacks and loose lines are counted, each once, and their inputs kept."""
    monkeypatch.setattr(harness, "HANG", 0.3)
    digits = iter(range(10))
    monkeypatch.setattr(harness, "input_of", lambda target, seeds, seed, number: str(number).encode())
    target = Target("all faults", ".txt", lambda folder: [b""], lambda rng, seeds: b"", misbehave, 1, batch=7)
    tally = run(target, len(list(digits)), 0, tmp_path)
    assert dict(tally.outcomes) == {"crash": 2, "hang": 1, "traceback": 2, "line": 2, "refused": 1, "read": 2}
    assert (tally.inputs, tally.bad) == (10, 7)
    kept = sorted(path.read_text() for path in (tmp_path / "faults").iterdir())
    assert kept == ["0", "1", "2", "3", "4", "5", "7"]
    counted = {"inputs": 10, "read": 2, "refused": 1, "crash": 2, "hang": 1, "traceback": 2, "line": 2}
    assert {key: tally.to_dict()[key] for key in counted} == counted
