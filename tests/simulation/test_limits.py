"""Limits of the URDF: said when a run goes beyond them, kept on request; against closed forms of a turning mass."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.cli import main
from flexdyn.simulation.limits import STOP_DAMPING_RATIO, TRAVEL

INERTIA, LOWER, UPPER, SPEED, EFFORT = 0.5, -0.8, 1.0, 3.0, 5.0
URDF = """<robot name="hinge"><link name="base"/>
<link name="bar"><inertial><mass value="1"/><inertia ixx="0.5" ixy="0" ixz="0" iyy="0.5" iyz="0" izz="0.5"/>
</inertial></link>
<joint name="hinge" type="{kind}"><parent link="base"/><child link="bar"/><axis xyz="0 0 1"/>{limit}</joint></robot>"""
LIMIT = f'<limit lower="{LOWER}" upper="{UPPER}" velocity="{SPEED}" effort="{EFFORT}"/>'


def hinge(folder: Path, limit: str = LIMIT, kind: str = "revolute") -> fd.FlexibleJointModel:
    """A mass that turns about its own centre, without gravity's help or hindrance."""
    path = folder / "hinge.urdf"
    path.write_text(URDF.format(limit=limit, kind=kind), encoding="utf-8")
    return fd.FlexibleJointModel(fd.load_robot(path))


def test_a_run_beyond_its_limits_is_warned_about(tmp_path: Path) -> None:
    """Torque at once, speed after I v/tau, range after sqrt(2 q I/tau); by how much, and when most, at the samples."""
    torque, duration = 8.0, 0.5
    with pytest.warns(fd.LimitWarning) as caught:
        run = fd.simulate(hinge(tmp_path), [torque], duration, rate=1000)
    place, speed, push = run.exceeded
    assert (place.joint, place.kind, place.limit, place.unit) == ("hinge", "position", UPPER, "rad")
    assert place.since == pytest.approx(math.sqrt(2 * UPPER * INERTIA / torque), abs=1e-3)
    assert place.by == pytest.approx(torque * duration**2 / 2 / INERTIA - UPPER, rel=1e-9)
    assert place.at == duration
    assert (speed.kind, speed.unit) == ("speed", "rad/s")
    assert speed.since == pytest.approx(SPEED * INERTIA / torque, abs=1e-3)
    assert speed.by == pytest.approx(torque * duration / INERTIA - SPEED, rel=1e-9)
    assert (push.kind, push.unit, push.by, push.since) == ("torque", "N m", torque - EFFORT, 0.0)
    told = [str(each.message) for each in caught]
    assert len(told) == 3
    assert told[0].startswith(
        "hinge: hinge exceeds its position limit of 1 rad by 1, from t = 0.354 s on, most at 0.5 s"
    )
    assert "fd.enforce_limits(model)" in told[0]
    assert [note for note in run.notes if "exceeds" in note] == [str(each) for each in run.exceeded]


def test_a_run_within_its_limits_is_not(tmp_path: Path) -> None:
    """Up to the limits themselves; and robots that state none, or write 0, are left in peace."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = fd.simulate(hinge(tmp_path), [EFFORT], 0.29, rate=1000)
        assert run.v.max() > 0.95 * SPEED
        assert run.exceeded == ()
        for limit, kind in (("", "continuous"), ('<limit effort="0" velocity="0"/>', "continuous")):
            assert fd.simulate(hinge(tmp_path, limit, kind), [50.0], 1.0).exceeded == ()


def test_many_runs_note_it_without_a_word(tmp_path: Path) -> None:
    """A thousand warnings help nobody; each run knows its own."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        runs = fd.simulate_many([hinge(tmp_path)] * 2, [8.0], duration=0.5)
    assert all(isinstance(run, fd.Run) and len(run.exceeded) == 3 for run in runs)


def test_limits_are_kept_on_request(tmp_path: Path) -> None:
    """The torque is cut at the effort; the link meets the stop at its upper end and stays; energy closes."""
    model = fd.enforce_limits(hinge(tmp_path))
    names = [type(effect).__name__ for effect in model.effects]
    assert names == ["EndStop", "TorqueSpeedLimit"]
    stop = model.effects[0]
    assert isinstance(stop, fd.effects.EndStop)
    assert (stop.lower, stop.upper) == (LOWER, UPPER)
    assert stop.stiffness == pytest.approx((SPEED / TRAVEL) ** 2 * INERTIA)
    assert stop.damping == pytest.approx(2 * STOP_DAMPING_RATIO * math.sqrt(stop.stiffness * INERTIA))
    tight = fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12)
    with pytest.warns(fd.LimitWarning, match="speed limit"):
        run = fd.simulate(model, [8.0], 2.0, tight, rate=2000)
    free = run.t < 0.4
    np.testing.assert_allclose(run.q[free, 0], EFFORT * run.t[free] ** 2 / 2 / INERTIA, atol=1e-8)
    assert run.tau_applied.max() == pytest.approx(EFFORT, rel=1e-7)
    assert run.q.max() < UPPER + 2.0 * TRAVEL
    assert run.q[-1, 0] == pytest.approx(UPPER + EFFORT / stop.stiffness, abs=1e-6)
    assert np.abs(run.energy.residual).max() < 1e-6
    assert not [each for each in run.exceeded if each.kind == "torque"]


def test_a_link_that_arrives_at_its_speed_limit_presses_no_further_than_said(tmp_path: Path) -> None:
    """Thrown at the lower stop at 3 rad/s; and numbers of one's own are taken."""
    model = fd.enforce_limits(hinge(tmp_path))
    run = fd.simulate(model, duration=0.5, v0=[-SPEED], rate=20000)
    assert LOWER - TRAVEL < run.q.min() < LOWER - 0.3 * TRAVEL
    soft = fd.enforce_limits(hinge(tmp_path), stiffness=100.0, damping=1.0).effects[0]
    assert (soft.stiffness, soft.damping) == (100.0, 1.0)  # type: ignore[attr-defined]


def test_what_is_there_stays(tmp_path: Path) -> None:
    """An end stop of the model's own is not doubled; a second call adds nothing; a robot without limits is refused."""
    own = fd.effects.EndStop("hinge", side="link", lower=-0.1, upper=0.1, stiffness=50.0, damping=1.0)
    model = fd.enforce_limits(hinge(tmp_path).replace(effects=[own]))
    assert [effect for effect in model.effects if isinstance(effect, fd.effects.EndStop)] == [own]
    assert fd.enforce_limits(model) == model
    with pytest.raises(fd.InputError, match="the robot states no limit"):
        fd.enforce_limits(hinge(tmp_path, "", "continuous"))
    with pytest.raises(fd.InputError, match="stiffness: a number above 0 is needed"):
        fd.enforce_limits(hinge(tmp_path), stiffness=-1.0)


def test_the_command_line_says_it_and_keeps_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line a limit on stderr, once; --limits keeps to them; --json lists what was passed; info names them."""
    model = hinge(tmp_path)
    fd.save_model(model, tmp_path / "model.yaml")
    fd.write_recording(fd.Recording([0.0, 0.4, 0.5], {"tau.hinge": [8.0, 8.0, 0.0]}), tmp_path / "push.csv")
    call = ["simulate", str(tmp_path / "model.yaml"), "--command", str(tmp_path / "push.csv")]
    call += ["-o", str(tmp_path / "run.npz")]
    assert main(call) == 0
    told = capsys.readouterr().err.splitlines()
    assert len([line for line in told if "exceeds" in line]) == 3
    assert main([*call, "--limits", "--json"]) == 0
    outcome = capsys.readouterr()
    assert '"kind": "torque"' not in outcome.out
    assert fd.read_recording(tmp_path / "run.npz")["tau_applied.hinge"].max() <= EFFORT * (1 + 1e-8)
    assert main(["info", str(tmp_path / "model.yaml")]) == 0
    table = " ".join(capsys.readouterr().out.split())
    assert "hinge revolute -0.8 to 1 rad 3 rad/s 5 N m" in table
