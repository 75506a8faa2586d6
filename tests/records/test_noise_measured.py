"""Noise of real recordings, where they stand beside the repository."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexdyn.records import Recording
from flexdyn.records.signals.derivatives import derivatives
from flexdyn.records.signals.noise import estimate_noise

DATA = Path(__file__).parents[3] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no measured recordings in {DATA}")


@pytest.fixture(scope="module")
def emps() -> Recording:
    """The EMPS axis: 24.8 s at 1 kHz; position [m] and drive voltage."""
    from scipy.io import loadmat

    file = loadmat(DATA / "emps" / "DATA_EMPS.mat", squeeze_me=True)
    return Recording(file["t"], {"q.x": file["qm"], "reference": file["qg"]}, meta={"units": {"q.x": "m"}})


@pytest.fixture(scope="module")
def pendulum() -> Recording:
    """The double pendulum under open-loop torque: 10 s at some 500 Hz."""
    path = DATA / "dfki_double_pendulum" / "20230629-143524.csv"
    table = np.genfromtxt(path, delimiter=",", names=True)
    joints = {f"{ours}.j{k}": table[f"{theirs}{k}"] for k in (1, 2) for ours, theirs in NAMES.items()}
    return Recording(table["time"], joints)


NAMES = {"q": "pos_meas", "v": "vel_meas", "tau": "tau_con", "tau_s": "tau_meas"}


@needs_data
def test_emps_is_as_noisy_as_its_encoder(emps: Recording) -> None:
    """0.1 um counts, stored in halves: readings err by about a quarter of a count; one count's 29 nm bounds it."""
    noise = emps.noise("q.x")
    assert noise.unit == "m"
    assert noise.step == pytest.approx(5e-8, rel=1e-6)
    assert 5e-8 / np.sqrt(12) <= noise.std < 1.2 * 1e-7 / np.sqrt(12)


@needs_data
def test_emps_command_has_no_top() -> None:
    """The controller differentiates over two samples: its voltage has a null at 500 Hz, which is no motion."""
    from scipy.io import loadmat

    file = loadmat(DATA / "emps" / "DATA_EMPS.mat", squeeze_me=True)
    noise = estimate_noise(file["t"], file["vir"], unit="V")
    assert not noise.white
    assert noise.std == pytest.approx(6e-3, rel=0.3)
    assert noise.seen_above is not None
    assert noise.seen_above < 200.0


@needs_data
def test_emps_acceleration(emps: Recording) -> None:
    """From an encoder of 0.1 um the acceleration is known to some hundredths of m/s^2; the axis makes up to 5."""
    view = derivatives(emps, cutoff=100.0)
    acceleration = view.second("q.x")
    still = np.abs(view.first("q.x")) < 1e-4
    assert 0.5 < np.abs(acceleration).max() < 20.0
    assert 0.3 * view.std("q.x", "second") < np.std(acceleration[still]) < 0.2
    assert view.std("q.x", "second") < 0.05


@needs_data
def test_the_pendulums_encoders(pendulum: Recording) -> None:
    """16 bits over 25 rad: steps of 3.8148e-4 rad; readings err by 0.3 to 0.9 of one; torque is sensed in steps too."""
    step = 25 / 65535
    for joint in ("j1", "j2"):
        noise = pendulum.noise(f"q.{joint}")
        assert noise.step == pytest.approx(step, rel=1e-6)
        assert step / np.sqrt(12) <= noise.std < 0.9 * step
        assert pendulum.noise(f"tau_s.{joint}").step == pytest.approx(24 / 4095, rel=1e-6)


@needs_data
def test_the_pendulums_velocities_are_differences(pendulum: Recording) -> None:
    """Derived by the drive: not white, negative at lag one, and as noisy as differences of the readings must be."""
    noise = pendulum.noise("v.j2")
    assert not noise.white
    assert noise.autocorrelation[1] < -0.2
    reading = pendulum.noise("q.j2")
    differences = np.sqrt(2 * (1 - reading.autocorrelation[1])) * reading.std * 500.0
    assert noise.std == pytest.approx(differences, rel=0.15)


@needs_data
def test_the_pendulums_clock(pendulum: Recording) -> None:
    """A stutter of 3.7 ms in 2 ms: refused by filters with the remedy, which keeps torque and motion."""
    assert np.diff(pendulum.t).max() == pytest.approx(3.7e-3, abs=0.1e-3)
    with pytest.raises(ValueError, match=r"not uniform.*resample\(rate=500\)"):
        derivatives(pendulum)
    view = derivatives(pendulum.resample(rate=500.0))
    assert 1.0 < view.smoother.cutoff < 60.0
    assert set(np.unique(view.recording["tau.j1"])) <= set(pendulum["tau.j1"])
    slow = view.first("q.j1") - view.value("v.j1")
    assert np.std(slow) < 0.1 * np.std(view.first("q.j1"))
    assert estimate_noise(view.t, view.first("q.j1")).std < 0.05 * pendulum.noise("v.j1").std
