"""The program as a process: exit codes, pipes, interruption, faults, and what its start costs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.cli import failures
from tests.cli.conftest import Runner

CALL = [sys.executable, "-c", "import sys; from flexdyn.cli import main; sys.exit(main())"]


def test_version_and_help(flexdyn: Runner) -> None:
    """--version is one line; --help, and nothing at all, name every command."""
    assert flexdyn("--version").out == f"flexdyn {fd.__version__}\n"
    text = flexdyn("--help").out
    assert all(command in text for command in ("info", "new", "effects", "simulate", "batch", "paper"))
    assert flexdyn() == flexdyn("--help")
    for command in ("info", "new", "effects", "simulate", "batch", "paper"):
        outcome = flexdyn(command, "--help")
        assert outcome.code == 0
        assert "Usage: flexdyn" in outcome.out


def test_the_start_imports_nothing_heavy() -> None:
    """--help needs neither scipy nor matplotlib nor any file format's library."""
    script = (
        "import sys; from flexdyn.cli import main; code = main(['--help']); "
        "heavy = {'scipy', 'matplotlib', 'h5py', 'lxml', 'yourdfpy', 'ruamel', 'meshcat'} & set(sys.modules); "
        "sys.exit(str(heavy) if heavy else code)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_exit_codes_reach_the_shell(tmp_path: Path) -> None:
    """0 done, 2 the user's mistake; the installed entry point is this main."""
    good = subprocess.run([*CALL, "info", "double_pendulum"], capture_output=True, text=True, check=False)
    assert (good.returncode, good.stderr) == (0, "")
    bad = subprocess.run([*CALL, "info", "double_pendulm"], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert bad.returncode == 2
    assert bad.stdout == ""
    assert bad.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "arguments", [["effects"], ["effects", "--json"], ["--help"], ["info", "tiago_dual", "--json"]]
)
def test_a_reader_that_goes_away_is_no_error(arguments: list[str]) -> None:
    """As in ``flexdyn effects | head``: nothing on stderr."""
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        done = subprocess.run([*CALL, *arguments], stdout=pipe, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (141, "")


def test_a_full_disk_is_said(tmp_path: Path) -> None:
    """Output that cannot be written is one line, not a traceback."""
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("this system has no /dev/full")
    with full.open("w", encoding="utf-8") as stream:
        done = subprocess.run(
            [*CALL, "effects", "--json"], stdout=stream, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 2
    assert done.stderr == "flexdyn: output: No space left on device\n"


def test_ctrl_c_ends_a_long_simulation(tmp_path: Path) -> None:
    """Exit code 130, one line, and no half-written run."""
    arguments = ["simulate", "scara_two_link", "--duration", "1e5", "--rate", "1", "--v0", "1,1", "-o", "run.npz"]
    script = (
        "import sys, _thread, threading; from flexdyn.cli import main; "
        "threading.Timer(1.0, _thread.interrupt_main).start(); sys.exit(main())"
    )
    command = [sys.executable, "-c", script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "flexdyn: interrupted\n")
    assert not list(tmp_path.iterdir())


def test_ctrl_c_while_the_arguments_are_read_is_said_too(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """Typer itself would leave without a word."""

    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("flexdyn.cli.app.Commands.parse_args", interrupted)
    outcome = flexdyn("info", "double_pendulum")
    assert (outcome.code, outcome.out, outcome.err) == (130, "", "flexdyn: interrupted\n")


def test_a_fault_of_ours_is_exit_code_1(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line with the way to the traceback; with FLEXDYN_DEBUG the traceback itself."""

    def fault(*arguments: object) -> None:
        raise ZeroDivisionError("a bug\nof ours")

    monkeypatch.setattr("flexdyn.cli.info.model_document", fault)
    outcome = flexdyn("info", "double_pendulum")
    assert outcome.code == 1
    assert outcome.err == (
        "flexdyn: internal error: ZeroDivisionError: a bug of ours; run with FLEXDYN_DEBUG=1 for the traceback\n"
    )
    monkeypatch.setenv("FLEXDYN_DEBUG", "1")
    outcome = flexdyn("info", "double_pendulum")
    assert outcome.code == 1
    assert "Traceback" in outcome.err
    assert "test_program.py" in outcome.err


def test_too_much_to_hold_is_the_users_to_lessen(capsys: pytest.CaptureFixture[str]) -> None:
    """Out of memory is told with the remedy."""
    assert failures.print_error(MemoryError()) == 2
    assert "--rate" in capsys.readouterr().err


def test_closed_streams_do_not_matter(tmp_path: Path) -> None:
    """As in ``flexdyn new ... >&- 2>&-``: it does its work and stays silent."""
    script = "import sys; sys.stdout = sys.stderr = None; from flexdyn.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", script, "new", "double_pendulum", "-o", "arm.yaml"]
    assert subprocess.run(command, check=False, cwd=tmp_path).returncode == 0
    assert (tmp_path / "arm.yaml").is_file()
