"""The study of `paper --diagnose` on recordings that flexdyn did not make: closed form, integrated by Numba."""

from __future__ import annotations

import layout as at
import numpy as np
import pytest
from two_link_run import Control, Plant, Truth, controlled, replayed, start

import flexdyn as fd
from flexdyn.paper import bench, hidden_friction
from flexdyn.paper.cases import PaperCases

LENGTH, MASS, TIP = 1.05, 0.405 * 1.05, 0.1  # Table I
ROD = MASS * LENGTH**2 / 12.0


@pytest.fixture(scope="module")
def plant() -> Plant:
    """The paper's arm with eq. 1 on both links, every number written out once more."""
    P = at.neutral()
    P[:, at.ROTOR], P[:, at.K] = 0.1, 5.5
    P[:, at.STALL], P[:, at.NO_LOAD] = 0.63, 3.5
    P[:, at.LINK + at.VISCOUS] = 0.01
    P[:, at.LINK + at.POSITIVE] = P[:, at.LINK + at.NEGATIVE] = 0.02
    P[:, at.LINK + at.EXCESS], P[:, at.LINK + at.VELOCITY] = 0.01, 0.05
    outer = MASS * (0.5 * LENGTH) ** 2 + ROD + TIP * LENGTH**2
    inner = MASS * (0.5 * LENGTH) ** 2 + ROD + (MASS + TIP) * LENGTH**2
    turn = LENGTH * (0.5 * MASS * LENGTH + TIP * LENGTH)
    return Plant(P, np.array([outer + inner, turn, outer, 0.0, 0.0]))


def moved(plant: Plant, corners: tuple[bench.Corners, bench.Corners]) -> Truth:
    """The arm under the bench's control law, as the other simulator has it."""
    wanted = bench.corner_motion(corners)
    forward = bench.feedforward(PaperCases().arm(), wanted)
    gains = np.full(2, bench.KP), np.full(2, bench.KD), np.full(2, bench.MOTOR_STEP)
    return controlled(plant, Control(wanted, forward, *gains, bench.FILTERED))


def pulsed(plant: Plant) -> Truth:
    """The arm under the torque of Fig. 4, from rest."""
    t = np.arange(12_001) * 1e-3
    tau = np.where(t < 0.6 - 1e-9, 0.6, np.where(t < 1.2 - 1e-9, -0.6, 0.0))
    return replayed(plant, start(plant, np.array([0.0, 0.5 * np.pi])), np.stack([tau, tau], axis=1))


def test_both_simulators_move_the_arm_alike(plant: Plant) -> None:
    """Under the torque of Fig. 4 for 12 s, stick and slip included: flexdyn's events against the closed form."""
    theirs, ours = pulsed(plant), bench.Bench(PaperCases()).runs["check_fig4"]
    np.testing.assert_allclose(ours.q, theirs.y[:, 0:2], atol=2e-6)
    np.testing.assert_allclose(ours.theta, theirs.y[:, 2:4], atol=2e-6)


@pytest.fixture(scope="module")
def answer(plant: Plant) -> fd.Diagnosis:
    """What the study says of recordings of the other simulator."""
    noise = np.random.default_rng(11)
    runs = moved(plant, bench.FIT), pulsed(plant), moved(plant, bench.CHECK)
    fit, *check = (bench.bench_recording(run.t, run.y[:, 0:2], run.y[:, 2:4], run.tau, noise) for run in runs)
    return fd.diagnose(hidden_friction.without_dry_friction(PaperCases().model), [fit], check)


@pytest.mark.slow
def test_the_hidden_friction_is_found_in_what_another_simulator_made(answer: fd.Diagnosis) -> None:
    """Every effect that the study hides is named, nothing else is, and its numbers hold the true ones."""
    found = {(each.suspect.effect, each.suspect.joint, each.suspect.side): each for each in answer.findings}
    lost = hidden_friction.hidden(PaperCases().model)
    hidden = {(each.name, each.joint, each.side): each for each in lost}  # type: ignore[attr-defined]
    assert found.keys() == hidden.keys()
    for place, effect in hidden.items():
        assert not found[place].rivals
        for name, number in found[place].suspect.parameters.items():
            assert abs(number.value - getattr(effect, name)) <= max(4.0 * number.std, 1e-12)


@pytest.mark.slow
def test_the_corrected_model_simulates_them_to_noise(answer: fd.Diagnosis) -> None:
    """Nothing is left."""
    assert answer.verdict == "explained"
    assert answer.gap_test is not None
    assert answer.gap_test.after < 1.2 * answer.gap_test.floor
