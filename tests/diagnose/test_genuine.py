"""Prior odds that an effect is what its name says, and laws that contain one another."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.constants import OFTEN, PREVALENCE_ODDS, SELDOM
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.inference.apart import genuine
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.scan import nested
from flexdyn.model.uncertain_parameters import FileNumber


def _candidate(kind: str, channel: str = "") -> Candidate:
    """One place of an effect, which makes nothing."""
    place = {"effect": kind, **({"channel": channel} if channel else {"joint": "a"})}
    return Candidate(kind, Proposal(place, lambda point, x: None, sizes=(1.0,)), None, [()], [np.array([0])], 1)


def test_friction_that_varies_and_constant_friction_are_two_laws() -> None:
    """One that varies by less than its mean is both; presliding friction slides as Coulomb friction."""
    coulomb = _candidate("coulomb_friction")
    assert not nested(_candidate("position_dependent_friction"), coulomb)
    assert nested(_candidate("presliding_friction"), coulomb)


@pytest.mark.parametrize("kind", ["viscous_friction", "stribeck_friction", "backlash"])
@pytest.mark.parametrize("ratio", [0.0, 0.5, 4.0])
def test_a_genuine_effect_is_more_likely_than_an_imitation(kind: str, ratio: float) -> None:
    """By Bayes' rule, the imitation's probability by drawing shares of what it imitates."""
    drawn = np.random.default_rng(1).random(400_000)
    stands_out = drawn / (1.0 - drawn)  # a share s is R = s/(1 - s) over the rest
    imitation = float((stands_out >= ratio).mean())
    odds = PREVALENCE_ODDS[fd.effects.registered()[kind].prevalence]
    assert genuine(_candidate(kind), ratio) == pytest.approx(odds / (odds + imitation), rel=5e-3)


@pytest.mark.parametrize(
    ("parameter", "tolerance", "prior"),
    [
        ("rotor_inertia", 0.05, OFTEN),
        ("rotor_inertia", 0.5, OFTEN),
        ("rotor_inertia", 0.03, SELDOM),
        ("stiffness", 0.05, SELDOM),
    ],
)
def test_rotors_are_often_guessed_unless_the_file_says_that_they_are_known(
    parameter: str, tolerance: float, prior: float
) -> None:
    """The prior odds are those of `genuine` where nothing stands out."""
    number = FileNumber("elbow", parameter, 1e-4, tolerance, "elbow")
    candidate = Candidate(parameter, None, number, [()], [np.array([0])], 1)
    assert genuine(candidate, 0.0) == pytest.approx(prior / (1.0 + prior))


def test_genuine_is_a_probability_that_grows_with_what_stands_out() -> None:
    """Up to certainty where nothing is left."""
    values = [genuine(_candidate("backlash"), float(r)) for r in (0.0, 0.1, 1.0, 10.0, 1e6)]
    assert np.all(np.diff(values) > 0.0)
    assert values[0] == pytest.approx(SELDOM / (1.0 + SELDOM))
    assert genuine(_candidate("backlash"), np.inf) == pytest.approx(1.0)


def test_a_late_torque_is_common_and_a_late_encoder_is_not() -> None:
    """Drives filter their currents."""
    late = [genuine(_candidate("channel_lag", channel), 1.0) for channel in ("tau.a", "theta.a", "q.a")]
    assert late[0] > late[1] == late[2]


def test_friction_that_the_model_has_is_seldom_missing_again() -> None:
    """Nor is friction behind the gear as common as that of the drive; a Stribeck peak on top of Coulomb friction is."""

    def friction(kind: str, side: str = "motor", joint: str = "a") -> Candidate:
        place = {"effect": kind, "joint": joint, "side": side}
        return Candidate(kind, Proposal(place, lambda point, x: None, sizes=(1.0,)), None, [()], [np.array([0])], 1)

    has = [fd.effects.CoulombFriction("a", side="motor", level=1.0)]
    first, again = (genuine(friction("coulomb_friction"), 1.0, (), each) for each in ((), has))
    assert first > 0.99
    assert again == pytest.approx(2.0 * SELDOM / (1.0 + 2.0 * SELDOM))
    assert genuine(friction("asymmetric_friction"), 1.0, (), has) == again
    assert genuine(friction("coulomb_friction", joint="b"), 1.0, (), has) == first
    assert genuine(friction("stribeck_friction"), 1.0, (), has) == genuine(friction("stribeck_friction"), 1.0)
    assert again < genuine(friction("coulomb_friction", "link"), 1.0) < first
    assert genuine(friction("coulomb_friction"), 1.0, ("coulomb_friction",), has) > again


def test_drives_that_are_far_apart_seldom_touch() -> None:
    """A coupling is common where one joint carries the other, and seldom else: there are many such pairs."""
    place = {"effect": "joint_coupling", "joint": "a", "side": "motor", "other": "b"}
    near, far = (Proposal(place, lambda point, x: None, sizes=(1.0,), seldom=seldom) for seldom in (False, True))
    both = [Candidate("joint_coupling", each, None, [()], [np.array([0])], 1) for each in (near, far)]
    assert [genuine(each, 1.0) for each in both] == pytest.approx(
        [2.0 * OFTEN / (1.0 + 2.0 * OFTEN), 2.0 * SELDOM / (1.0 + 2.0 * SELDOM)]
    )
