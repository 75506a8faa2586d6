"""Command lines drawn at random: every command, its options with values that fit and values that do not."""

from __future__ import annotations

import contextlib
import io
import random
import re
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import numpy as np

from flexdyn.cli import main
from flexdyn.errors import InputError
from flexdyn.records import Recording, write_recording
from tests.fuzz import corpus
from tests.fuzz.mutate import NUMBERS, WORDS, any_bytes, any_text

MODELS = ("scara_two_link", "scara", "model.yaml", "bad.yaml", "arm.urdf", "bad.urdf", "nothing", "ur5", ".", "")
RUNS = ("run.csv", "run.npz", "run.h5", "run.mat", "bad.csv", "bad.npz", "bad.h5", "nothing.csv", "model.yaml", ".", "")
PAIRS = ("run.csv+bad.csv", "half.csv+run.npz", "run.csv+half.csv", "run.csv+", "+", "run.csv+nothing.csv+bad.h5")
SPANS = ("0:0.01", "0.005:", ":", "0:0", "1:0", "nan:inf", "0:1:2", "x:y", "-1:1e309", "")
OUTPUTS = ("out.csv", "out.npz", "out.html", "out.svg", "out.txt", "out", "no/out.csv", ".", "")
PAGES = ("out.html", "out.htm", "out.txt", "no/out.html", "run.csv", ".", "")
VALUES = ("0.1,0.2", "elbow=1.57", "elbow=", "=1", "elbow=nan", "1e308,1e308", "0.1", "a,b", ",", "equilibrium")
SIMULATE = ("--solver", "--step", "--rtol", "--atol", "--smoothing", "--rate", "--q0", "--v0", "--theta0", "--omega0")
TIMES = ("0.01", "0", "-1", "nan", "inf", "1e-9", "x", "")
COMMANDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "info": (MODELS, ("--q", "--modes", "--json")),
    "simulate": (MODELS, (*SIMULATE, "--limits", "--json", "--command", "--map")),
    "new": (("scara", "arm.urdf", "bad.urdf", "nothing"), ("--force",)),
    "effects": (("coulomb_friction", "coulomb", "hysteresis", "", "x" * 3000), ("--json",)),
    "compare": ((*RUNS, *PAIRS), ("--from", "--to", "--json", "--map")),
    "plot": ((*RUNS, *PAIRS), ("--view", "--joint", "--from", "--to", "--map")),
    "batch": (("study.yaml", "bad.yaml", "model.yaml", "nothing.yaml", "."), ("--summary", "--json", "--view")),
    "diagnose": (MODELS, ("--check", "--map", "--trim", "--hold-out", "--expect", "--explain", "--json")),
    "play": ((*MODELS[:6], *RUNS, *PAIRS), ("--model", "--map", "--rigid", "--command", "--magnify", "--no-open")),
    "compare-models": ((*MODELS, "report", "bad.h5"), ("--json",)),
    "paper": ((), ("--diagnose", "--json")),
    "doctor": ((), ("--json",)),
    "example": (("nothing", "", "x\x1b[31m"), ()),
}
FLAGS = ("--modes", "--json", "--limits", "--force", "--summary", "--rigid", "--no-open", "--diagnose")


def prepare(folder: Path) -> list[bytes]:
    """The files that the command lines name."""
    corpus.models(folder)
    corpus.studies(folder)
    (folder / "study.yaml").write_bytes(corpus.STUDY.replace(b"runs: 4", b"runs: 0"))
    t = np.linspace(0.0, 0.02, 5)
    run = Recording(t, {f"{signal}.{joint}": t for signal in ("q", "v", "tau") for joint in ("shoulder", "elbow")})
    for name in ("run.csv", "run.npz", "run.h5", "run.mat"):
        write_recording(run, folder / name)
    write_recording(Recording(t, {"omega.elbow": t}), folder / "half.csv")
    (folder / "map.yaml").write_bytes(corpus.MAP)
    corpus.commands(folder)
    (folder / "command.yaml").write_bytes(corpus.COMMANDS[1])
    (folder / "report").mkdir(exist_ok=True)
    (folder / "report" / "model.yaml").write_bytes(corpus.MODEL)
    with _without_long_work():  # what it imports is there for every child
        return [b""]


def run(folder: Path, data: bytes) -> None:
    """Run one command line in this process.

    Raises:
        InputError: it was refused, with the last line that it printed.
        AssertionError: an exit code or a line on stderr that no command line may lead to.
    """
    rng = random.Random(data)
    _damage(rng, folder)
    out, err = io.StringIO(), io.StringIO()
    arguments = _arguments(rng)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), _without_long_work():
        code = main(arguments)
    lines = err.getvalue().splitlines()
    strange = [line for line in lines if not line.startswith("flexdyn: ") or not line.isprintable()]
    assert not strange, (arguments, strange[:1])
    assert code in (0, 2), (arguments, code, lines[-1:])
    printed = re.sub(r"\x1b\[[0-9;]*m", "", out.getvalue())
    assert all(line.isprintable() for line in printed.splitlines()), arguments
    if code:
        assert lines, (arguments, "exit code 2 without a line")
        raise InputError(lines[-1])


@contextlib.contextmanager
def _without_long_work() -> Iterator[None]:
    """Arguments and files are read and checked as always; a whole diagnosis, the paper's study and tests do not run."""
    not_here = InputError("that is not done here")
    with (
        patch("flexdyn.diagnose.diagnose", side_effect=not_here),
        patch("flexdyn.paper.run_paper_study", side_effect=not_here),
        patch("flexdyn.cli.health.self_test", return_value=[]),
    ):
        yield


def _arguments(rng: random.Random) -> list[str]:
    command = rng.choice([*COMMANDS, *COMMANDS, "nothing", "--version", "", "-x"])
    targets, options = COMMANDS.get(command, (("x",), ("--y",)))
    arguments = [command, *(rng.choice(targets) for _ in range(_places(rng, command)))]
    if command == "diagnose":
        arguments += [rng.choice((*RUNS, *PAIRS)) for _ in range(rng.choice((0, 1, 1, 1, 2)))]
    if command == "simulate":
        arguments += ["--duration", rng.choice(TIMES)]
    for option in rng.sample(options, min(len(options), int(rng.expovariate(0.7)))):
        arguments.append(option)
        if option not in FLAGS:
            arguments.append(_value(rng, option))
    if command in ("simulate", "compare", "plot", "batch", "diagnose", "paper"):
        arguments += ["-o", rng.choice(OUTPUTS)]
    if command == "new":
        arguments += ["-o", rng.choice(("out.yaml", "out", "no/out.yaml"))]
    if command == "play":  # without a file it would serve the page until somebody ends it
        arguments += ["--html", rng.choice(PAGES)]
    if rng.random() < 0.1:
        arguments.insert(rng.randrange(len(arguments)), rng.choice((*WORDS, *NUMBERS)))
    return [argument.replace("\0", "") for argument in arguments]


def _places(rng: random.Random, command: str) -> int:
    """How many models or recordings a command is given."""
    fitting = {"compare": (2,), "plot": (1, 2), "play": (1, 1, 2), "compare-models": (1, 2, 2, 3)}
    return rng.choice(fitting.get(command, (0,) if command in ("paper", "doctor") else (1,)))


def _value(rng: random.Random, option: str) -> str:
    if option in ("--command", "--map"):
        return rng.choice(("map.yaml", "command.yaml", "bad.yaml", "run.csv", "bad.csv", "nothing"))
    if option == "--rate":  # of so short runs; a rate that takes gigabytes is refused elsewhere
        return rng.choice(("1000", "0", "-1", "nan", "inf", "x", "1e300"))
    if option == "--step":
        return rng.choice(("1e-4", "1e-3", "10", "0", "-1", "nan", "inf", "x", "1e300"))
    solvers = ("auto", "TimeStepping", "RungeKutta4", "DormandPrince")
    names = ("coulomb_friction", "coulomb_friction@elbow", "channel_lag@q.elbow", "payload", "@", "a@b@c")
    fitting = {"--solver": solvers, "--view": ("phase", "torques", "x"), "--check": (*RUNS, *PAIRS), "--model": MODELS}
    fitting |= dict.fromkeys(("--trim", "--hold-out"), SPANS) | dict.fromkeys(("--expect", "--explain"), names)
    return rng.choice((*fitting.get(option, VALUES), *fitting.get(option, VALUES), *WORDS, *NUMBERS))


def _damage(rng: random.Random, folder: Path) -> None:
    """Fresh damage to one of the files called bad."""
    kind = rng.choice(("yaml", "urdf", "csv", "npz", "h5", "json"))
    if kind == "json":
        (folder / "report" / "report.json").write_bytes(any_text(rng, [corpus.REPORT]))
        return
    seeds = {"yaml": [corpus.MODEL, corpus.LOCKED, corpus.MAP, *corpus.COMMANDS], "urdf": [corpus.URDF]}
    whole = seeds.get(kind) or [(folder / f"run.{kind}").read_bytes()]
    (folder / f"bad.{kind}").write_bytes((any_text if kind in ("yaml", "urdf", "csv") else any_bytes)(rng, whole))
