"""Units, gears, signs and offsets of a channel map, against constants written out by hand."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexdyn.errors import InputError
from tests.records.mapping import channel_map, mapped

T = [0.0, 0.5]
RAW = [3.0, -720.0]
DEG = 0.017453292519943295
TURN = 6.283185307179586


@pytest.mark.parametrize(
    ("signal", "unit", "si_per_unit"),
    [
        ("q", "deg", DEG),
        ("q", "°", DEG),
        ("theta", "rad", 1.0),
        ("theta", "radians", 1.0),
        ("q", "mrad", 1e-3),
        ("q", "arcmin", 2.908882086657216e-4),
        ("q", "arcsec", 4.84813681109536e-6),
        ("q", "turn", TURN),
        ("q", "rev", TURN),
        ("v", "rpm", 0.10471975511965977),
        ("v", "rev/min", 0.10471975511965977),
        ("omega", "deg/s", DEG),
        ("omega", "degrees/sec", DEG),
        ("omega", "turn/s", TURN),
        ("omega", "mrad/s", 1e-3),
        ("tau", "Nm", 1.0),
        ("tau", "mN m", 1e-3),
        ("tau", "mNm", 1e-3),
        ("tau_s", "N cm", 1e-2),
        ("tau_applied", "kN m", 1e3),
    ],
)
def test_units_of_revolute_joints(signal: str, unit: str, si_per_unit: float) -> None:
    """One raw unit is the SI value that tables of units give."""
    rec = mapped({"t": T, "x": RAW}, channels={f"{signal}.elbow": {"from": "x", "unit": unit}})
    np.testing.assert_allclose(rec[f"{signal}.elbow"], np.array(RAW) * si_per_unit, rtol=1e-15)
    assert "units" not in rec.meta


@pytest.mark.parametrize(
    ("signal", "unit", "si_per_unit", "si"),
    [
        ("q", "m", 1.0, "m"),
        ("q", "mm", 1e-3, "m"),
        ("theta", "um", 1e-6, "m"),
        ("v", "mm/s", 1e-3, "m/s"),
        ("omega", "m/min", 1 / 60, "m/s"),
        ("tau", "N", 1.0, "N"),
        ("tau_s", "kN", 1e3, "N"),
    ],
)
def test_lengths_and_forces_make_a_joint_prismatic(signal: str, unit: str, si_per_unit: float, si: str) -> None:
    """The recording says so for every signal of the joint, temperature excepted."""
    channels = {"tau.slide": "x", "temperature.slide": "x", f"{signal}.slide": {"from": "x", "unit": unit}}
    rec = mapped({"t": T, "x": RAW}, channels=channels)
    np.testing.assert_allclose(rec[f"{signal}.slide"], np.array(RAW) * si_per_unit, rtol=1e-15)
    assert rec.unit(f"{signal}.slide") == si
    assert rec.unit("tau.slide") == "N"
    assert rec.unit("temperature.slide") == "degC"


@pytest.mark.parametrize(
    ("unit", "raw", "celsius"),
    [("degC", 20.0, 20.0), ("K", 300.0, 26.85), ("degF", 212.0, 100.0), ("degF", -40.0, -40.0)],
)
def test_temperatures(unit: str, raw: float, celsius: float) -> None:
    """Water boils at 212 degF; both scales meet at -40."""
    rec = mapped({"t": T, "x": [raw, raw]}, channels={"temperature.elbow": {"from": "x", "unit": unit}})
    np.testing.assert_allclose(rec["temperature.elbow"], celsius, rtol=1e-12)


@pytest.mark.parametrize(
    ("unit", "seconds"), [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0), ("h", 3600.0)]
)
def test_units_of_time(unit: str, seconds: float) -> None:
    """Times come out as the nearest doubles."""
    rec = mapped({"clock": [1, 7], "x": RAW}, time={"from": "clock", "unit": unit}, channels={"q.a": "x"})
    np.testing.assert_array_equal(rec.t, [seconds, 7 * seconds if seconds >= 1 else 7 / round(1 / seconds)])


def test_an_encoder_on_the_motor() -> None:
    """Half a motor turn in counts through a gear of 100 is 1.8 degrees of the link; speeds likewise."""
    encoder = {"from": "x", "unit": "counts", "counts_per_turn": 131072, "side": "motor", "gear_ratio": 100}
    channels = {"theta.a": encoder, "omega.a": {**encoder, "unit": "counts/s"}}
    rec = mapped({"t": T, "x": [65536, -131072]}, channels=channels)
    np.testing.assert_allclose(rec["theta.a"], [1.8 * DEG, -3.6 * DEG], rtol=1e-15)
    np.testing.assert_array_equal(rec["theta.a"], rec["omega.a"])


def test_a_current_through_torque_constant_and_gear() -> None:
    """2 A at 0.05 N m/A through a gear of 100 are 10 N m at the link; a factor of one's own does as well."""
    joints = {"a": {"gear_ratio": 100, "torque_constant": 0.05}}
    channels = {
        "tau.a": {"from": "x", "unit": "A", "side": "motor"},
        "tau_applied.a": {"from": "mx", "unit": "mA", "side": "motor"},
        "tau_s.a": {"from": "x", "unit": "A", "factor": 5.0},
    }
    rec = mapped({"t": T, "x": [2.0, -4.0], "mx": [2000, -4000]}, joints=joints, channels=channels)
    for name in channels:
        np.testing.assert_allclose(rec[name], [10.0, -20.0], rtol=1e-15)


def test_a_rotary_motor_of_a_prismatic_joint() -> None:
    """A screw of 5 mm has 2 pi/0.005 rad/m: one turn of its motor is 5 mm, and power goes through unchanged."""
    joints = {"slide": {"gear_ratio": TURN / 0.005}}
    channels = {
        "q.slide": {"from": "mm", "unit": "mm"},
        "theta.slide": {"from": "turns", "unit": "turn", "side": "motor"},
        "omega.slide": {"from": "rpm", "unit": "rpm", "side": "motor"},
        "tau.slide": {"from": "Nm", "unit": "N m", "side": "motor"},
    }
    raw = {"t": T, "mm": [5.0, 10.0], "turns": [1.0, 2.0], "rpm": [60.0, 120.0], "Nm": [0.1, -0.2]}
    rec = mapped(raw, joints=joints, channels=channels)
    np.testing.assert_allclose(rec["theta.slide"], rec["q.slide"], rtol=1e-14)
    np.testing.assert_allclose(rec["omega.slide"], [0.005, 0.010], rtol=1e-14)
    np.testing.assert_allclose(rec["tau.slide"] * rec["omega.slide"], [0.1 * TURN, -0.4 * TURN], rtol=1e-14)
    assert [rec.unit(name) for name in rec.channels] == ["m", "m", "m/s", "N"]


def test_sign_and_offset() -> None:
    """The sign turns the raw number, the offset is added last and in SI."""
    entry = {"from": "x", "unit": "deg", "sign": -1, "offset": 0.2, "side": "motor", "gear_ratio": 3}
    rec = mapped({"t": T, "x": [90.0, -180.0]}, channels={"theta.a": entry})
    np.testing.assert_allclose(rec["theta.a"], [-30 * DEG + 0.2, 60 * DEG + 0.2], rtol=1e-15)


def test_si_comes_through_bit_for_bit() -> None:
    """A column that is only renamed keeps every bit, the sign of zero too."""
    raw = np.array([-0.0, 5e-324, 1 / 3, -1e308])
    rec = mapped({"t": [0, 1, 2, 3], "x": raw}, channels={"q.a": "x", "note": "x"})
    for name in ("q.a", "note"):
        np.testing.assert_array_equal(rec[name].view(np.int64), raw.view(np.int64))


@given(
    raw=st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=5),
    sign=st.sampled_from([1, -1]),
    offset=st.floats(-10, 10),
    ratio=st.floats(0.01, 1000),
    signal=st.sampled_from(["theta", "omega", "tau"]),
)
def test_the_inverse_map_leads_back(raw: list[float], sign: int, offset: float, ratio: float, signal: str) -> None:
    """A map with the inverse factor, sign and offset undoes another."""
    times = list(range(len(raw)))
    unit = {"theta": "deg", "omega": "rpm", "tau": "mN m"}[signal]
    si = {"theta": DEG / ratio, "omega": TURN / 60 / ratio, "tau": ratio / 1000}[signal]
    there = {"from": "x", "unit": unit, "side": "motor", "gear_ratio": ratio, "sign": sign, "offset": offset}
    back = {"from": "y", "factor": 1 / si, "sign": sign, "offset": -sign * offset / si}
    first = mapped({"t": times, "x": raw}, channels={f"{signal}.a": there})[f"{signal}.a"]
    second = mapped({"t": times, "y": first}, channels={f"{signal}.a": back})[f"{signal}.a"]
    np.testing.assert_allclose(second, raw, rtol=1e-12, atol=1e-13 * (1 + abs(offset) / si))


def test_units_that_the_file_states() -> None:
    """They hold where the map says nothing, and the map may repeat them in another spelling."""
    raw, units = {"t": [0, 500], "x": RAW}, {"x": "deg", "t": "ms"}
    for entry in ("x", {"from": "x", "unit": "degrees"}):
        rec = mapped(raw, units, channels={"q.a": entry})
        np.testing.assert_allclose(rec["q.a"], np.array(RAW) * DEG, rtol=1e-15)
        np.testing.assert_array_equal(rec.t, T)


@pytest.mark.parametrize(
    ("units", "entries", "line"),
    [
        (
            {"x": "deg"},
            {"unit": "rad"},
            "channels.q.a.unit: not the unit that the file states, got 'rad'; the file says",
        ),
        ({"x": "furlong"}, {}, "channels.q.a.unit: no such unit, got 'furlong'"),
        ({"x": None}, {}, "channels.q.a.unit: the file states the column's unit in a way that is not read"),
        ({"x": "counts"}, {}, "channels.q.a.counts_per_turn: unit: counts needs counts_per_turn"),
        ({"x": "A"}, {}, "channels.q.a.unit: a unit of current does not fit q.a, got 'A'"),
    ],
)
def test_units_of_the_file_that_do_not_fit(units: dict[str, str | None], entries: dict[str, Any], line: str) -> None:
    """A contradiction between file and map is for the user to settle."""
    with pytest.raises(InputError, match=re.escape(line)):
        mapped({"t": T, "x": RAW}, units, channels={"q.a": {"from": "x", **entries}})


def test_a_unit_that_is_not_read_can_be_stated() -> None:
    """The map's word is enough, as a unit or as a factor."""
    for entry in ({"unit": "deg"}, {"factor": DEG}):
        rec = mapped({"t": T, "x": RAW}, {"x": None}, channels={"q.a": {"from": "x", **entry}})
        np.testing.assert_allclose(rec["q.a"], np.array(RAW) * DEG, rtol=1e-15)


def test_channels_that_are_no_signals() -> None:
    """Units that are known become SI, others stay as labels; a factor leaves none."""
    channels = {
        "current.a": {"from": "x", "unit": "mA"},
        "reference.a": {"from": "x", "unit": "deg"},
        "voltage": {"from": "x", "unit": "V"},
        "level": {"from": "x", "unit": "bar", "factor": 1e5},
    }
    rec = mapped({"t": T, "x": [1000.0, 2000.0]}, channels=channels)
    assert {name: (rec[name][0], rec.unit(name)) for name in channels} == {
        "current.a": (1.0, "A"),
        "reference.a": (pytest.approx(1000 * DEG), "rad"),
        "voltage": (1000.0, "V"),
        "level": (1e8, ""),
    }


@pytest.mark.parametrize("signal", ["q", "v", "tau"])
def test_a_joint_turns_or_slides(signal: str) -> None:
    """Degrees and metres at one joint contradict each other, whichever signals they belong to."""
    units = {"q": ("deg", "mm"), "v": ("rpm", "mm/s"), "tau": ("N m", "N")}
    other = "v" if signal == "q" else "q"
    channels = {
        f"{signal}.a": {"from": "x", "unit": units[signal][1]},
        f"{other}.a": {"from": "y", "unit": units[other][0]},
    }
    with pytest.raises(
        InputError, match=rf"channels\.{other}\.a\.unit: the joint slides by {signal}\.a, and .* otherwise"
    ):
        channel_map(channels=channels)
