"""The ready maps read the recordings of real machines, and what comes out obeys their physics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io

import flexdyn as fd
from flexdyn.checks import Array

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"
MAPS = ROOT / "benchmarks" / "measured"
STEADY = "steady_state/0.096kg"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the measured recordings are not beside the repository")


def read(data: str, ready: str) -> fd.Recording:
    """A recording through a ready map."""
    return fd.read_recording(DATA / data, map=MAPS / ready)


def correlation(one: Array, other: Array) -> float:
    """Of two signals, from -1 to 1."""
    return float(np.corrcoef(one, other)[0, 1])


@pytest.mark.parametrize("name", ["DATA_EMPS", "DATA_EMPS_PULSES"])
def test_emps(name: str) -> None:
    """1 kHz for 24.84 s; force is gtau*vir, and with the published mass and friction it moves the carriage so."""
    rec = read(f"emps/{name}.mat", "emps/map.yaml")
    assert (len(rec), rec.unit("theta.carriage"), rec.unit("tau.carriage")) == (24841, "m", "N")
    assert rec.duration == pytest.approx(24.84)
    raw = scipy.io.loadmat(DATA / "emps" / f"{name}.mat")
    np.testing.assert_allclose(rec["tau.carriage"], (raw["gtau"] * raw["vir"]).ravel(), rtol=1e-6)
    # The servo follows its reference, and the force is what 95.1 kg, 203.5 N s/m and 20.4 N of friction take.
    assert np.abs(rec["theta.carriage"] - rec["reference.carriage"]).max() < 1.5e-3
    window = np.hanning(41) / np.hanning(41).sum()
    position = np.convolve(rec["theta.carriage"], window, "same")
    v = np.gradient(position, rec.t)
    a = np.gradient(v, rec.t)
    moving = slice(100, -100)
    force = 95.1089 * a + 203.5034 * v + 20.3935 * np.tanh(v / 1e-3) - 3.1648
    measured = np.convolve(rec["tau.carriage"], window, "same")
    assert np.linalg.norm((force - measured)[moving]) < 0.06 * np.linalg.norm(measured[moving])


@pytest.mark.parametrize("letter", "ABC")
def test_kuka(letter: str) -> None:
    """Motor and link encoder of axes 1 to 3 agree within 3 mrad over the run, and part as the torque winds the gear."""
    rec = read(f"kuka_kr300/recorded_{letter}.mat", "kuka_kr300/map.yaml")
    assert len(rec) == 2501
    assert rec.duration == pytest.approx(10.0)
    assert rec.joints == tuple(f"axis{i}" for i in range(1, 7))
    for axis in ("axis1", "axis2", "axis3"):
        deflection = rec[f"theta.{axis}"] - rec[f"q.{axis}"]
        assert np.ptp(rec[f"q.{axis}"]) > 0.1
        assert np.ptp(deflection) < 3e-3
        assert correlation(deflection, rec[f"tau.{axis}"]) > 0.6
        assert correlation(rec[f"omega.{axis}"], rec[f"v.{axis}"]) > 0.999
    for axis in rec.joints:
        slope = np.gradient(rec[f"theta.{axis}"], rec.t)
        assert correlation(slope, rec[f"omega.{axis}"]) > 0.99
        assert np.abs(slope).max() == pytest.approx(np.abs(rec[f"omega.{axis}"]).max(), rel=0.2)
        assert (rec[f"tau.{axis}"] * rec[f"omega.{axis}"]).mean() > 0  # the motors pay for the friction
    # The second axis carries the weight of the arm: kN m, once the gear is counted.
    assert 4e3 < np.abs(rec["tau.axis2"]).max() < 6e3
    # The run starts at the pose that the offsets of the map stand for.
    assert abs(rec["q.axis2"][0] + np.pi / 2) < 0.01
    assert abs(rec["q.axis3"][0] - np.pi / 2) < 0.01


@pytest.mark.parametrize("stamp", ["20230629-143524", "20230629-143601", "20230629-154220", "20230629-154548"])
def test_double_pendulum(stamp: str) -> None:
    """Velocities are the derivatives of positions; torque from the current follows the torque asked for."""
    rec = read(f"dfki_double_pendulum/{stamp}.csv", "double_pendulum/map.yaml")
    assert 400 < rec.rate < 600
    for joint in ("joint1", "joint2"):
        travelled = np.concatenate([[0.0], np.cumsum(np.diff(rec.t) * rec[f"omega.{joint}"][1:])])
        position = rec[f"theta.{joint}"] - rec[f"theta.{joint}"][0]
        assert np.abs(travelled - position).max() < 1e-9 * np.ptp(position)
        assert correlation(rec[f"tau.{joint}"], rec[f"tau_applied.{joint}"]) > 0.8


@pytest.mark.parametrize(
    ("drive", "ready", "joint", "ratio"),
    [
        ("driveNo1", "map_lead_screw.yaml", "nut", 2 * np.pi / 0.002),
        ("driveNo2", "map_lead_screw.yaml", "nut", 2 * np.pi / 0.002),
        ("driveNo3", "map_worm.yaml", "wheel", 60.0),
    ],
)
@pytest.mark.parametrize("rpm", [-200, -100, -20, 20, 100, 200])
def test_screw_drives(drive: str, ready: str, joint: str, ratio: float, rpm: int) -> None:
    """The mean speed is the file name's in rpm; the torque works against friction and stays below nominal."""
    rec = read(f"screw_drives/{drive}/{STEADY}/{'n' if rpm < 0 else ''}{abs(rpm)}.csv", f"screw_drives/{ready}")
    motor = rec[f"omega.{joint}"] * ratio
    assert motor.mean() == pytest.approx(rpm * np.pi / 30, rel=0.05)
    shaft = rec[f"tau.{joint}"] / ratio
    assert 0 < (shaft * motor).mean() < 9.84e-3 * abs(rpm) * np.pi / 30
    assert rec.unit(f"omega.{joint}") == ("m/s" if joint == "nut" else "rad/s")


def test_starts_and_stops_of_a_screw_drive() -> None:
    """500 samples at 40 ms; between its starts the drive rests."""
    rec = read("screw_drives/driveNo1/start_stop/50.csv", "screw_drives/map_lead_screw.yaml")
    assert len(rec) == 500
    assert rec.duration == pytest.approx(499 * 0.04, rel=1e-3)
    assert (rec["omega.nut"] == 0).any()
    assert np.abs(rec["omega.nut"]).max() > 0.5 * 50 / 60 * 0.002


def test_a_file_with_a_shorter_head() -> None:
    """One file lacks two lines of its head: the map says other lines, the rest stays."""
    content = fd.read_map(MAPS / "screw_drives" / "map_lead_screw.yaml").to_dict()
    content["source"] |= {"names_line": 11, "first_line": 13}
    rec = fd.read_recording(
        DATA / "screw_drives" / "driveNo1" / STEADY / "n2.csv", map=fd.ChannelMap.from_dict(content)
    )
    assert rec["omega.nut"].mean() * 60 / 0.002 == pytest.approx(-2, abs=0.3)
