"""Ctrl-C in a diagnosis that is under way: heard at once, answered within three seconds."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.load import slowed

PROGRAM = """
import sys
from flexdyn.cli import main
from flexdyn.diagnose.decision import run
say = run.tell
def told(stage, share):
    say(stage, share)
    print(stage, flush=True)
run.tell = told
sys.exit(main(sys.argv[1:]))
"""
"""The command, which tells every stage on stdout."""
HEARD, ANSWERED = 0.5, 3.0
"""Time from Ctrl-C to its line, and to the end of the program, the report written [s]; on a free machine."""


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    """Half a minute of six joints with hidden friction: a diagnosis takes a good while."""
    model = fd.load_model("ur5")
    t = np.arange(0.0, 30.0, 0.01)
    draw = np.random.default_rng(2)
    rates, phases = draw.uniform(0.7, 2.5, (2, model.n)), draw.uniform(0.0, 6.0, (2, model.n))
    sway = sum(0.3 * np.sin(rates[k] * t[:, None] + phases[k]) for k in range(2))
    robot = model.replace(effects=[*model.effects, fd.effects.CoulombFriction("elbow_joint", side="motor", level=5.0)])
    run = fd.simulate(robot, fd.PD(fd.Samples(t, sway, "cubic"), kp=2000.0, kd=100.0), q0=sway[0])
    log = run.to_recording()
    names = [f"{signal}.{joint}" for signal in ("q", "theta", "tau") for joint in model.joint_names]
    noise = {"q": 1e-6, "theta": 1e-6, "tau": 0.05}
    seen = {name: log[name] + draw.normal(0.0, noise[name.split(".")[0]], run.t.size) for name in names}
    fd.write_recording(fd.Recording(run.t, seen), tmp_path / "log.npz")
    return tmp_path


@pytest.mark.parametrize("after", [0.5, pytest.param(4.0, marks=pytest.mark.slow)])
def test_ctrl_c_is_answered_in_time(folder: Path, after: float) -> None:
    """One line at once, then a report that says what was in work; nothing is claimed."""
    command = [sys.executable, "-c", PROGRAM, "diagnose", "ur5", "log.npz", "-o", "out"]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=folder, env=os.environ, **pipes) as program:
        assert program.stdout is not None
        while not program.stdout.readline().startswith("comparing structures"):
            assert program.poll() is None, "it ended before anything was compared"
        time.sleep(after)
        before = slowed()
        assert program.poll() is None, "it had ended before anybody could stop it"
        program.send_signal(signal.SIGINT)
        began = time.monotonic()
        assert program.stderr is not None
        first = program.stderr.readline()
        heard = time.monotonic() - began
        rest = program.stderr.read()
        program.stdout.read()
        code = program.wait()
        taken = time.monotonic() - began
    assert first == "flexdyn: stopping; what is known by now follows\n"
    slower = max(before, slowed())
    assert heard < HEARD * slower
    assert taken < ANSWERED * slower
    assert (code, rest.splitlines()[-1]) == (130, "flexdyn: interrupted")
    document = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
    assert (document["verdict"], document["findings"]) == ("interrupted", [])
    assert document["stopped_at"].startswith("comparing structures")
    assert not (folder / "out" / "model.yaml").exists()
