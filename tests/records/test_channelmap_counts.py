"""Volts, duties, and counts of a PWM or an ADC through a channel map."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.records.channelmap.apply import apply_map
from flexdyn.records.table import Table

RAW = np.array([0.0, 100.0, -200.0])


def read(channel: str, entry: object, values: np.ndarray = RAW) -> np.ndarray:
    """One channel of a log."""
    content = {"flexdyn_map": 1, "time": {"rate": 100}, "channels": {channel: entry}}
    made = apply_map(Table({"raw": values.copy()}, {}), fd.ChannelMap.from_dict(content))
    return np.asarray(made.columns[channel])


@pytest.mark.parametrize(
    ("channel", "entry", "wanted"),
    [
        ("voltage.arm", {"from": "raw", "unit": "mV"}, RAW / 1e3),
        ("duty.arm", {"from": "raw", "unit": "%"}, RAW / 100.0),
        ("duty.arm", {"from": "raw", "unit": "percent", "sign": -1}, -RAW / 100.0),
        ("duty.arm", {"from": "raw", "full_counts": 885}, RAW / 885.0),
        ("duty.arm", {"from": "raw", "unit": "counts", "full_counts": 885}, RAW / 885.0),
        ("voltage.arm", {"from": "raw", "full_counts": 4095, "full_scale": 24, "offset": -12}, RAW * 24 / 4095 - 12),
        ("tau.arm", {"from": "raw", "full_counts": 2048, "full_scale": 50.0}, RAW * 50 / 2048),
        ("duty.arm", {"from": "raw", "full_counts": 255, "full_scale": 50, "unit": "%"}, RAW * 0.5 / 255),
        (
            "tau.arm",
            {
                "from": "raw",
                "full_counts": 2048,
                "full_scale": 10,
                "unit": "A",
                "side": "motor",
                "gear_ratio": 100,
                "torque_constant": 0.05,
            },
            RAW * 10 / 2048 * 0.05 * 100,
        ),
        (
            "tau.arm",
            {"from": "raw", "full_counts": 2048, "full_scale": 9e3, "unit": "mA", "torque_constant": 0.1},
            RAW * 9 / 2048 * 0.1,
        ),
        ("goal.arm", {"from": "raw", "unit": "counts", "counts_per_turn": 4096}, RAW * 2 * np.pi / 4096),
    ],
)
def test_what_is_read(channel: str, entry: object, wanted: np.ndarray) -> None:
    """In SI, with sign and offset."""
    np.testing.assert_allclose(read(channel, entry), wanted, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (
            {"from": "raw", "full_counts": 885, "factor": 2},
            "channels.voltage.arm.full_counts: full_counts gives the scale already",
        ),
        ({"from": "raw", "full_counts": 885}, "channels.voltage.arm.full_scale: full_counts needs full_scale"),
        ({"from": "raw", "full_scale": 24}, "channels.voltage.arm.full_counts: full_scale needs full_counts"),
        ({"from": "raw", "full_counts": 0, "full_scale": 1}, "full_counts: a number above zero is needed"),
        (
            {"from": "raw", "full_counts": 9, "full_scale": 24, "unit": "rad"},
            "a unit of angle does not fit voltage.arm",
        ),
        ({"from": "raw", "unit": "A"}, "a unit of current does not fit voltage.arm"),
    ],
)
def test_mistakes(entry: dict[str, object], said: str) -> None:
    """One line with the key."""
    with pytest.raises(InputError) as caught:
        read("voltage.arm", entry)
    assert said in str(caught.value)
