"""What a diagnosis does with recordings as they come: blocks kept apart, short ones, fast and slow ones."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.data.rate import advice, at_needed_rates
from flexdyn.diagnose.decision.split import checked_blocks, parts, without_blocks
from flexdyn.errors import InputError
from tests.diagnose import slides

DRAG = 9.0
"""Viscous friction of the sliding mass [N s/m]."""
T = np.arange(1001) / 100.0
REC = fd.Recording(T, {"q.elbow": np.sin(T)}, name="log")


def spans(recordings: tuple[fd.Recording, ...]) -> list[tuple[float, float]]:
    """First and last times [s]."""
    return [(float(rec.t[0]), float(rec.t[-1])) for rec in recordings]


@cache
def swing(seconds: float, rate: float) -> fd.Recording:
    """The two-link arm with dry friction in the elbow, under tracking, with noise."""
    model = stiff_arm().replace(effects=[fd.effects.CoulombFriction("elbow", side="motor", level=0.6)])
    t = np.arange(round(seconds * rate) + 1) / rate
    sway = np.stack([0.6 * np.cos(2.1 * t) + 0.2 * np.cos(7 * t), 0.5 * np.cos(2.4 * t) + 0.2 * np.sin(6 * t)], axis=1)
    command = fd.PD(fd.Samples(t, sway, "cubic"), kp=400, kd=20, rate=rate)
    run = fd.simulate(model, command, q0=sway[0], v0=[0.0, 1.2], rate=rate)
    rng, log = np.random.default_rng(0), run.to_recording()
    names = [f"{signal}.{joint}" for signal in ("q", "tau") for joint in model.joint_names]
    noise = {"q": 2e-6, "tau": 0.02}
    return fd.Recording(t, {x: log[x] + rng.normal(0.0, noise[x.split(".")[0]], t.size) for x in names}, name="swing")


@cache
def rubbed() -> fd.Recording:
    """Six seconds of a sliding mass with a friction that its model lacks."""
    return slides.recording(lambda v: DRAG * v, seconds=6.0)


@cache
def stiff_arm() -> fd.FlexibleJointModel:
    """Rigid joints with rotors."""
    return fd.load_model("scara_two_link").replace(joints={"*": {"rotor_inertia": 4e-5, "gear_ratio": 50}}, effects=[])


def test_blocks_are_cut_out_of_every_recording() -> None:
    """Not a sample is in both; pieces before, between and behind are fitted."""
    fit, test = without_blocks([REC], [(2.0, 3.5), (6.0, 7.0)])
    assert spans(fit) == [(0.0, 1.99), (3.51, 5.99), (7.01, 10.0)]
    assert spans(test) == [(2.0, 3.5), (6.0, 7.0)]
    assert sum(map(len, (*fit, *test))) == len(REC)


def test_short_pieces_are_left_out_and_said() -> None:
    """Half a second before a block."""
    with pytest.warns(fd.RecordingWarning, match=r"log: 0\.49 s from t = 0 s on are too short to fit"):
        fit, _ = without_blocks([REC], [(0.5, 2.0)])
    assert spans(fit) == [(2.01, 10.0)]


def test_blocks_that_make_no_sense() -> None:
    """Each in one line."""
    for given, match in (
        ("1:2", "blocks are needed"),
        ([1.0, 2.0], "a block is a first and a last time"),
        ([(1.0, float("nan"))], "a block is a first and a last time"),
        ([(1.0, 1.5)], r"a block of 0\.5 s is too short"),
    ):
        with pytest.raises(InputError, match=f"hold_out: {match}"):
            checked_blocks(given)
    with pytest.raises(InputError, match=r"hold_out: no recording has 1 s in this block.*log 0 to 10 s"):
        without_blocks([REC], [(9.5, 12.0)])
    with pytest.raises(InputError, match=r"hold_out: nothing is left"):
        without_blocks([REC], [(0.0, 12.0)])


def test_a_diagnosis_with_a_block_kept_apart(tmp_path: Path) -> None:
    """The block is test data and nothing else is; what is missing is found in the rest."""
    found = fd.diagnose(slides.model(tmp_path), rubbed(), hold_out=[(2.0, 3.5)], progress=False)
    told = [(each.role, round(each.start, 2), round(each.end, 2)) for each in found.data]
    assert told == [("fit", 0.0, 2.0), ("fit", 3.5, 6.0), ("test", 2.0, 3.5)]
    ((effect, values, _),) = slides.named(found)
    assert effect == "viscous_friction"
    assert values == pytest.approx({"coefficient": DRAG}, rel=0.01)


def test_short_recordings_add_up(tmp_path: Path) -> None:
    """Pieces of 1.2 s, none of which could be cut: the last ones are test data as they are."""
    pieces = rubbed().split(at=[1.2, 2.4, 3.6, 4.8])
    fit, test = parts(slides.model(tmp_path), pieces)
    assert [len(fit), len(test)] == [4, 1]
    found = fd.diagnose(slides.model(tmp_path), pieces, progress=False)
    ((effect, values, _),) = slides.named(found)
    assert effect == "viscous_friction"
    assert values == pytest.approx({"coefficient": DRAG}, rel=0.01)


@pytest.mark.parametrize(
    ("seconds", "match"), [(0.4, r"t: the recording is too short.*'0\.398 s'"), (1.0, r"t: too little motion.*'1 s of")]
)
def test_one_recording_that_is_too_short_says_what_would_do(tmp_path: Path, seconds: float, match: str) -> None:
    """Less than three windows of motion, in a line."""
    with pytest.raises(InputError, match=match + r".*at least 1\.5 s of motion to fit.*add up"):
        fd.diagnose(slides.model(tmp_path), rubbed().trim(0.0, seconds - 0.002), progress=False)


def test_a_short_recording_alone_is_fitted_as_a_whole(tmp_path: Path) -> None:
    """1.8 s: what is missing is found, and the verdict is that nothing is left for a test."""
    found = fd.diagnose(slides.model(tmp_path), rubbed().trim(0.0, 1.798), progress=False)
    assert (found.verdict, [each.role for each in found.data]) == ("untested", ["fit"])
    ((effect, values, _),) = slides.named(found)
    assert effect == "viscous_friction"
    assert values == pytest.approx({"coefficient": DRAG}, rel=0.01)
    assert (found.gap_test, found.errors, found.shares) == (None, {}, None)
    assert found.gap_fit is not None
    assert found.gap_fit.after < 1.3


def test_two_short_recordings_are_fitted_together(tmp_path: Path) -> None:
    """One of 0.9 s would be too little without the other; of four, the last can be kept apart."""
    model, pieces = slides.model(tmp_path), rubbed().split(at=[0.9, 1.8, 2.7, 3.6])
    assert [len(each) for each in parts(model, pieces[:2])] == [2, 0]
    assert [len(each) for each in parts(model, pieces[:4])] == [3, 1]


def test_a_slow_recording_is_cut_only_if_enough_is_left_to_fit(tmp_path: Path) -> None:
    """At 50 Hz the least test data of 100 samples, or half, leave 1.3 s of 2.6 s."""
    model, long = slides.model(tmp_path), rubbed()
    slow = fd.Recording(long.t[::10], {name: x[::10] for name, x in long.items()}, meta=long.meta)
    assert [len(each) for each in parts(model, [slow.trim(0.0, 2.6)])] == [1, 0]
    assert [len(each) for each in parts(model, [slow.trim(0.0, 4.0)])] == [1, 1]


def test_fast_recordings_are_decimated_and_it_is_said() -> None:
    """Above 2500 Hz, to 1000 Hz or more; slower ones are handed on as they are."""
    fast, usual = swing(1.0, 7000.0), swing(6.0, 200.0)
    taken, said = at_needed_rates([fast, usual])
    assert taken[0].rate == pytest.approx(1000.0)
    assert taken[1] is usual
    (sentence,) = said
    assert sentence.startswith(
        "swing was recorded at 7000 Hz and is used at 1000 Hz: its positions through a symmetric"
    )


def test_advice_on_slow_recordings() -> None:
    """Below 100 Hz, and where a spring's vibration is not sampled."""
    model = stiff_arm()
    assert list(advice(model, [measured(model, swing(6.0, 200.0))])) == []
    slow = fd.Recording(swing(6.0, 200.0).t[::4], {x: y[::4] for x, y in swing(6.0, 200.0).items()}, name="slow")
    (said,) = advice(model, [measured(model, slow)])
    assert said.startswith("slow has 50 samples in a second")
    elastic = model.replace(joints={"*": {"rotor_inertia": 4e-5, "gear_ratio": 50, "stiffness": 4e4}})
    (told,) = advice(elastic, [measured(elastic, swing(6.0, 200.0))])
    assert told.startswith("elbow vibrates at about ")
    assert "against its spring, and swing has 200 samples in a second: record at" in told
