"""Several files side by side as one recording: at the times of the first, nothing made up, and how is said."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.errors import InputError

T = np.arange(0.0, 2.0, 0.01)
POSITIONS = fd.Recording(T, {"q.a": np.sin(T)}, name="positions")


def currents(start: float = 0.0, **meta: object) -> fd.Recording:
    """Torques 5 t + 1, every 4 ms, 0.5 s shorter at the end."""
    t = np.arange(start, 1.5, 0.004) + 0.001
    return fd.Recording(t, {"tau.a": 5.0 * t + 1.0}, meta=meta, name="currents")


def test_the_times_are_those_of_the_first() -> None:
    """On straight lines; what the other does not cover is left out, and the notes say how it was done."""
    rec = POSITIONS.beside(currents(0.1))
    kept = T[(T >= 0.101) & (T <= 1.498)]
    np.testing.assert_array_equal(rec.t, kept)
    np.testing.assert_array_equal(rec["q.a"], np.sin(kept))
    np.testing.assert_allclose(rec["tau.a"], 5.0 * kept + 1.0, rtol=1e-12)
    assert rec.name == "positions+currents"
    said, count = rec.meta["notes"]
    assert said.startswith("currents (250 Hz) was put on the times of positions (100 Hz), on straight lines")
    assert "both clocks are assumed to agree; its samples are 1 ms from these times in the median" in said
    assert count == f"{len(kept)} of 200 samples of positions are common"


def test_samples_can_be_held() -> None:
    """As the last one said."""
    rec = POSITIONS.beside(currents(), method="hold")
    last = 0.004 * np.floor((rec.t - 0.001) / 0.004 + 1e-6) + 0.001
    np.testing.assert_allclose(rec["tau.a"], 5.0 * last + 1.0, rtol=1e-9)


def test_gaps_of_another_are_left_out() -> None:
    """Nothing is drawn across them."""
    t = np.concatenate([np.arange(0.0, 0.6, 0.004), np.arange(1.2, 2.0, 0.004)])
    rec = POSITIONS.beside(fd.Recording(t, {"tau.a": t}, name="c"))
    assert not ((rec.t > 0.6) & (rec.t < 1.19)).any()
    np.testing.assert_allclose(rec["tau.a"], rec.t, atol=1e-12)


def test_times_of_day_align_where_both_have_them() -> None:
    """A recording that started 0.25 s later stands 0.25 s later."""
    first = fd.Recording(T, {"q.a": T}, meta={"start_ns": 10**18}, name="p")
    rec = first.beside(currents(start_ns=10**18 + 250_000_000))
    np.testing.assert_allclose(rec["tau.a"], 5.0 * (rec.t - 0.25) + 1.0, rtol=1e-9)
    assert "it started 0.25 s later" in rec.meta["notes"][0]


def test_mistakes() -> None:
    """A channel twice, nothing in common, no such method."""
    for other, method, match in (
        (POSITIONS, "linear", r"q\.a: positions and positions both have it"),
        (currents().shifted(100.0), "linear", r"no two times in common.*positions 0 to 1\.99 s; currents 100\.001"),
        (currents(), "spline", r"method: no such method.*linear, hold"),
    ):
        with pytest.raises(InputError, match=match):
            POSITIONS.beside(other, method=method)
