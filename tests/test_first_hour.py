"""The first hour of a new user, played by a script: every log is read in two tries, and the answer is the right one."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[1] / "scripts"


@pytest.mark.slow
def test_a_new_user_gets_from_a_urdf_and_three_logs_to_the_answer(tmp_path: Path) -> None:
    """A German CSV with empty cells, two ROS topics, a MATLAB struct: each fails once and says what to write."""
    if not os.environ.get("CI") and shutil.which("chromium") is None:
        pytest.skip("no chromium here; Debian, Ubuntu: apt install chromium")
    path = os.pathsep.join([str(SCRIPTS), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "first_hour", str(tmp_path)]
    done = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert "explained by Coulomb friction on the motor side of elbow" in told["report"]
    failed = {step["wanted"]: len(step["said"]) for step in told["steps"] if step["said"]}
    assert failed == {"see montag.csv": 1, "see dienstag": 1, "see mittwoch.mat": 1}
    assert (tmp_path / "report" / "report.png").stat().st_size > 10_000
