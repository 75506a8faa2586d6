"""Why an effect was named or was not: from the structures, the probabilities and the Bayes factors."""

from __future__ import annotations

import dataclasses

import pytest

import flexdyn as fd
from flexdyn.diagnose.report.explain import check_target, known_suspects, target_of
from flexdyn.diagnose.report.ranked import beyond, ranks
from tests.diagnose import report_cases as cases


def test_a_name_that_was_given() -> None:
    """Its probability, its ranks, its Bayes factor."""
    told = cases.explained().explain("parameter_error@shoulder.stiffness")
    assert told == (
        "Wrong stiffness of shoulder (+31 %)\n"
        "  Named: its probability is 0.97 (extremely likely).\n"
        "  It stands in 3 of 4 ranked structures (ranks 1, 2, 3), which together have probability 0.97.\n"
        "  Log Bayes factor of the best structure with it against the best without it: 4.1 (strong evidence).\n"
        "  No other effect is listed that explains the data equally well."
    )
    assert "Named: its probability is above 0.999" in cases.explained().explain("payload")
    assert cases.explained().explain("payload@tip") == cases.explained().explain("payload")
    assert "on channel q.elbow" in cases.explained().explain("sensor_offset@q.elbow")


def test_one_of_several_names() -> None:
    """What it cannot be told from, what that has together, and what would tell; the search's own note comes last."""
    told = cases.explained().explain("presliding_friction@elbow")
    assert "Named as one of 3: together they have probability 0.996; alone it has 0.21 (unlikely)." in told
    assert (
        "The data do not separate it from Stribeck friction on the motor side of elbow (probability 0.71) and" in told
    )
    assert f"What would tell them apart: {cases.SWEEPS}" in told
    assert told.endswith(cases.RIVAL_NOTE)


def test_a_name_that_was_not_given() -> None:
    """Every side of the joint in a paragraph of its own; with the side in the target, that side alone."""
    told = cases.explained().explain("coulomb_friction@elbow")
    motor, link = told.split("\n\n")
    assert motor.startswith("Coulomb friction on the motor side of elbow\n  Not named: its probability is 0.02")
    assert "and 0.95 is required." in motor
    assert "It stands in none of the 4 ranked structures." in motor
    assert "strong evidence against it" in motor
    assert cases.explained().explain("coulomb_friction@elbow.link") == link
    assert cases.explained().explain("coulomb_friction") == told


def test_a_number_that_was_calibrated() -> None:
    """It moved within its tolerance: that is why it is no finding."""
    told = cases.explained().explain("parameter_error@elbow.stiffness")
    assert "Calibrated, and no finding: factor 0.98 with standard deviation 0.004, at a tolerance of 3.0 %" in told


def test_a_candidate_that_stands_in_structures_only() -> None:
    """Its probability is the sum over those that hold it, its evidence that of the best of them."""
    diagnosis = dataclasses.replace(cases.explained(), findings=(), considered=())
    told = diagnosis.explain("parameter_error@shoulder.stiffness")
    assert "Not named: its probability is 0.97 (extremely likely)." in told
    assert "differ by a log evidence of 4.1" in told


def test_an_effect_that_was_no_candidate() -> None:
    """It exists, its joint exists, and nobody compared it."""
    assert cases.explained().explain("backlash@elbow").endswith("Not named: the search compared no such candidate.")
    told = cases.interrupted().explain("backlash@elbow")
    assert "no such candidate before it was interrupted." in told
    assert told.endswith("The diagnosis was interrupted: this is what was known then.")


def test_a_finding_below_what_is_required_is_not_called_named() -> None:
    """It is listed, and that is said."""
    told = cases.not_converged().explain("coulomb_friction@elbow")
    assert "Listed among the findings, below 0.95: its probability is 0.6 (more likely than not)." in told


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("coulom_friction@elbow", "no such effect, got 'coulom_friction'; did you mean 'coulomb_friction'?"),
        ("coulomb_friction@elbwo", "no such place, got 'coulomb_friction@elbwo'; did you mean 'elbow'?"),
        ("sensor_offset@q.elbwo", "did you mean 'elbow'?"),
        ("parameter_error@elbow.stifness", "did you mean 'parameter_error@elbow.stiffness'?"),
    ],
)
def test_unknown_targets_name_the_near_miss(target: str, words: str) -> None:
    """An error of one line."""
    with pytest.raises(fd.InputError) as caught:
        cases.explained().explain(target)
    assert words in str(caught.value)


def test_targets_can_be_checked_before_the_work() -> None:
    """Every candidate's own target is sound."""
    model = fd.load_model("scara_two_link")
    for suspect in known_suspects(cases.explained()):
        check_target(model, target_of(suspect))
    with pytest.raises(fd.InputError, match="no such effect"):
        check_target(model, "gremlin@elbow")


def test_ranks_of_several_names_count_any_of_them() -> None:
    """A finding stands where one of its names stands."""
    structures = cases.ranked()
    friction = ranks(structures, [cases.STRIBECK, cases.PRESLIDING])
    assert (friction.among, friction.holding) == (4, (1, 2, 4))
    assert friction.probability == pytest.approx(0.93)
    assert friction.other == structures[2]
    assert friction.log_bayes_factor == pytest.approx(2.3)
    assert ranks(structures, [cases.PAYLOAD]).log_bayes_factor is None, "no structure does without it"
    assert ranks((), [cases.PAYLOAD]).best is None
    assert beyond(structures[0], structures[3]) == [cases.WRONG]
