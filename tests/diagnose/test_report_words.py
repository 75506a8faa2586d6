"""What a report says, sentence by sentence: every verdict, names, digits, probabilities, and what is not said."""

from __future__ import annotations

import dataclasses
import math
from typing import get_args

import pytest

import flexdyn as fd
from flexdyn.diagnose.report.digits import (
    estimate_text,
    evidence_text,
    factor_text,
    interval_text,
    likely,
    percent,
    probability_text,
    rounded,
    value_text,
)
from flexdyn.diagnose.report.measures import Calibration, Left
from flexdyn.diagnose.report.page import part
from flexdyn.diagnose.report.result import Diagnosis, Verdict
from flexdyn.diagnose.report.sentences import (
    error_sentence,
    finding_sentences,
    gap_sentence,
    next_measurements,
    verdict_sentence,
)
from flexdyn.diagnose.report.suspects import Considered, Finding, Number, Structure, Suspect
from flexdyn.diagnose.report.words import channel_unit, finding_phrase
from tests.diagnose import report_cases as cases


def _part(diagnosis: Diagnosis, name: str) -> str:
    """A part of the page in one line, without blanks between its elements."""
    return " ".join(part(diagnosis, name).split()).replace("> <", "><")


def _article(diagnosis: Diagnosis, place: int) -> str:
    """What the page tells of one finding, counted from 1."""
    return _part(diagnosis, "findings").split("<article")[place]


SENTENCES = {
    "explained": "The disagreement has 4 causes; the largest is Stribeck friction or presliding friction on the motor"
    " side of elbow, or spring hysteresis in the transmission of elbow (together probability 0.996); what is left is"
    " noise.",
    "no_discrepancy": "Model and measurement agree: what is left between them is noise, after 1 number of the model has"
    " moved within tolerance.",
    "unexplained": "Model and measurement disagree, and no effect is established as the cause: the most probable,"
    " Coulomb friction on the motor side of elbow, has probability 0.41, and 0.95 is required. The residual is"
    " largest on the motor side of elbow.",
    "partly": "Part of the disagreement is explained by Coulomb friction on the link side of shoulder (probability"
    " 0.97). No established effect accounts for what is left: at most 4.3 % of the torque of elbow; it changes with q"
    " and omega.",
    "not_converged": "These estimates stopped before they had converged: stiffness of elbow and damping of elbow."
    " The report claims only what has converged: a payload at frame tip (probability 0.998).",
    "untested": "There are no test data: the motion is too short to keep a part of it. Established on the data of the"
    " fit: Coulomb friction on the motor side of elbow (probability 0.998).",
    "interrupted": "This diagnosis was interrupted while simulating windows, stage 3 of 5, before it was finished."
    " Established by then: a payload at frame tip (probability 0.99). The test data had not been opened.",
    "interrupted_early": "This diagnosis was interrupted while comparing structures, pass 2 of at most 5, before it was"
    " finished. No effect had been established by then; the most probable so far was Coulomb friction on the motor side"
    " of elbow. The test data had not been opened.",
}


def test_every_verdict_has_its_sentence() -> None:
    """All seven, with the names and numbers of the diagnosis in them."""
    made = {each.__name__: each() for each in cases.CASES}
    assert {diagnosis.verdict for diagnosis in made.values()} == set(get_args(Verdict))
    assert {name: verdict_sentence(diagnosis) for name, diagnosis in made.items()} == SENTENCES


def test_verdicts_with_nothing_to_name() -> None:
    """Nothing established, nothing known of what stopped, nothing left: nothing is made up."""
    bare = dataclasses.replace(cases.interrupted(), findings=cases.interrupted().findings[1:])
    assert "No effect had been established by then." in verdict_sentence(bare)
    stopped = dataclasses.replace(cases.not_converged(), findings=(), stopped=("level of elbow",))
    assert verdict_sentence(stopped).startswith("This estimate stopped before it had converged: level of elbow.")
    assert verdict_sentence(stopped).endswith("no effect is established.")
    assert verdict_sentence(dataclasses.replace(stopped, stopped=())).startswith("An estimate stopped")
    untested = dataclasses.replace(cases.untested(), findings=())
    assert verdict_sentence(untested).endswith("it. No effect is established on the data of the fit.")
    left = dataclasses.replace(cases.partly(), left=())
    assert verdict_sentence(left).endswith("Something is left that no established effect accounts for.")
    unnamed = dataclasses.replace(cases.unexplained(), considered=(), where=())
    assert verdict_sentence(unnamed) == "Model and measurement disagree, and no effect is established as the cause."


def test_no_sentence_says_that_all_is_improbable_where_it_is_not() -> None:
    """Were a candidate as probable as a name must be, the report would not call another one the most probable."""
    sure = (Considered(cases.COULOMB, 0.97, 3.0), *cases.unexplained().considered)
    assert "most probable" not in verdict_sentence(dataclasses.replace(cases.unexplained(), considered=sure))


def test_a_single_thing_left_is_not_called_the_most() -> None:
    """The words "at most" stand where other joints have less."""
    alone = dataclasses.replace(cases.partly(), left=(Left("elbow", 0.043, 0.08),))
    assert "left: 4.3 % of the torque of elbow." in verdict_sentence(alone)


def test_a_finding_says_how_probable_it_and_each_of_its_names_is() -> None:
    """In words and numbers; "A or B" together, and each by itself."""
    diagnosis = cases.explained()
    _, one, *_ = diagnosis.findings
    assert finding_sentences(diagnosis)[0] == (
        "Stribeck friction (0.71) or presliding friction (0.21) on the motor side of elbow, or spring hysteresis in the"
        " transmission of elbow (0.076): virtually certain (together probability 0.996)."
    )
    assert finding_sentences(diagnosis)[1] == "A payload at frame tip: virtually certain (probability above 0.999)."
    unknown = dataclasses.replace(one, probability=math.nan)
    (told,) = finding_sentences(dataclasses.replace(diagnosis, findings=(unknown,)))
    assert told == "A payload at frame tip: of unknown probability."


def test_one_effect_on_many_joints_is_said_once() -> None:
    """With the joints, and with what holds for each of them."""
    viscous, dry = finding_sentences(cases.robot())
    assert viscous.startswith("Viscous friction on the motor side of shoulder_pan_joint, shoulder_lift_joint,")
    assert viscous.endswith("and wrist_3_joint: each virtually certain (probability above 0.999).")
    assert dry.endswith(": each extremely likely (probability 0.979 or more).")


def test_probabilities_in_words_and_digits() -> None:
    """The scale of the IPCC; never rounded up to one, nor to the 0.95 that it does not reach."""
    told = {0.9996: "above 0.999", 0.97: "0.97", 0.9499: "0.949", 0.95: "0.95", 0.5: "0.5", 0.0321: "0.032"}
    assert {value: probability_text(value) for value in told} == told
    assert (probability_text(1.0), probability_text(1e-5)) == ("above 0.999", "below 0.001")
    words = [likely(value) for value in (0.995, 0.95, 0.7, 0.4, 0.02, 0.0, math.nan)]
    assert words == [
        "virtually certain",
        "extremely likely",
        "likely",
        "about as likely as not",
        "very unlikely",
        "exceptionally unlikely",
        "of unknown probability",
    ]
    assert evidence_text(406.2) == "406 (very strong evidence)"
    assert evidence_text(-1.24) == "\N{MINUS SIGN}1.2 (positive evidence against it)"
    assert evidence_text(math.inf) == "beyond measure (very strong evidence)"


def test_gap_and_errors_are_told_with_their_data() -> None:
    """The test data where they were opened; the joint that was worst; nothing where nothing was measured."""
    diagnosis = cases.explained()
    assert gap_sentence(diagnosis) == "On the test data, the gap goes from 12.4 to 1.07; noise alone makes 1.00."
    assert gap_sentence(cases.unexplained()).startswith("On the data of the fit, the gap goes from 9.10")
    assert gap_sentence(cases.interrupted()) == "The gap was not measured."
    assert "At elbow, the joint with the greatest share before, the torque error goes from 1.7 to 0.081 N m, from" in (
        error_sentence(diagnosis)
    )
    assert error_sentence(cases.partly()) == "", "what came of it is not known"


def test_evidence_is_read_off_the_structures() -> None:
    """How many hold it and what the best one without it has; no claim that no other effect does as well."""
    diagnosis = cases.explained()
    told = _article(diagnosis, 3)
    assert "3 of the 4 ranked structures hold it. The best one without it has nothing instead" in told
    assert "its log evidence is lower by 4.1, its probability 0.03." in told
    assert "Every one of the 4 ranked structures holds one of these names." in _article(diagnosis, 1)
    better = (*diagnosis.structures, Structure((cases.COULOMB,), 0.001, -1200.0))
    told = _article(dataclasses.replace(diagnosis, structures=better), 3)
    assert "has Coulomb friction on the motor side of elbow instead; its log evidence is higher by 4.2" in told
    assert "No other effect" not in told
    none = _article(dataclasses.replace(diagnosis, structures=()), 3)
    assert "ranked structures" not in none


def test_a_weak_finding_is_said_to_be_weak() -> None:
    """Below 0.95 it is not established; a gap that grows with it is not a gain."""
    weak = Finding(cases.COULOMB, 0.6, -0.4, -0.031)
    told = _article(dataclasses.replace(cases.unexplained(), findings=(weak,)), 1)
    assert "more likely than not, not established: 0.95 is required" in told
    assert "If it alone is left out, the improvement on the test data grows by 3.1 %." in told
    assert "weak evidence against it" in told


def test_words_of_rivals_and_wrong_numbers() -> None:
    """Rivals in one place share its name; a wrong number says by how much; an effect of the file is named."""
    model = fd.load_model("scara_two_link")
    rival = dataclasses.replace(cases.WRONG, place={"of": "effects[0]", "parameter": "stall_torque"})
    assert finding_phrase(model, Finding(cases.STRIBECK, 1.0, 1.0, 1.0, (cases.PRESLIDING,))) == (
        "Stribeck friction or presliding friction on the motor side of elbow"
    )
    assert finding_phrase(model, Finding(cases.WRONG, 1.0, 1.0, 1.0, (rival,))) == (
        "a wrong stiffness of shoulder (+31 %), or a wrong stall torque of torque speed limit on the motor side of"
        " shoulder (+31 %)"
    )


def test_a_title_says_where_each_of_its_names_acts() -> None:
    """Rivals of one place share it; those elsewhere, and wrong numbers, come with a place of their own."""
    here, elsewhere = cases.PRESLIDING, dataclasses.replace(cases.PRESLIDING, joint="shoulder")
    finding = Finding(cases.STRIBECK, 1.0, 1.0, 1.0, (here, elsewhere, cases.WRONG))
    told = _article(dataclasses.replace(cases.no_discrepancy(), findings=(finding,)), 1)
    assert "<h3>1. Stribeck friction or presliding friction on the motor side of elbow, or presliding" in told
    assert "friction on the motor side of shoulder, or a wrong stiffness of shoulder (+31 %)</h3>" in told


def test_digits_follow_from_the_uncertainty() -> None:
    """Two digits of the standard deviation, and the interval that holds 95 %."""
    assert value_text(1.23456, 0.05) == "1.235"
    assert value_text(123.456, 20.0) == "123"
    assert value_text(-0.000123456, 1e-6) == "\N{MINUS SIGN}1.235e\N{MINUS SIGN}04"
    assert estimate_text(Number(0.40004, 4.6e-4, "N m")) == "0.40004 [0.39914, 0.40094] N m"
    assert estimate_text(Number(1.0, 0.0, "1")) == "1"
    assert estimate_text(Number(2e6, 3e3, "N m/rad")) == "2.0000e+06 [1.9941e+06, 2.0059e+06] N m/rad"
    assert interval_text(Number(0.0, 1.0, "N m")) == "\N{MINUS SIGN}2.0 to 2.0 N m"
    assert interval_text(Number(1.0, math.nan, "N m")) == "not known"
    assert interval_text(Number(1.0, 0.0, "1")) == "chosen among a few, not measured"
    assert [rounded(value) for value in (0.0, 40.0, 1234.0, math.nan)] == ["0", "40.0", "1.23e+03", "unknown"]
    assert [percent(value) for value in (0.31, 0.0145, -0.2)] == ["31 %", "1.5 %", "\N{MINUS SIGN}20 %"]


def test_changes_read_as_percent() -> None:
    """Two digits below ten percent, whole ones above; no change is none; a multiple is a multiple."""
    minus = "\N{MINUS SIGN}"
    told = {factor: factor_text(factor) for factor in (1.0123, 0.9, 2.9, 1.0 + 1e-9, 4.0)}
    assert list(told.values()) == ["+1.2 %", f"{minus}10 %", "+190 %", "none", "4 times what is given"]


def test_a_number_beyond_its_tolerance_is_not_said_to_be_within() -> None:
    """Where something is left unexplained, it may bend a number of the file farther than its tolerance lets it."""
    bent = (Calibration("elbow", "stiffness", 2.9, 0.2, 0.02), Calibration("elbow", "damping", 1.01, 0.2, 0.02))
    diagnosis = cases.no_discrepancy()
    assert "They moved by no more than 3" in _part(diagnosis, "calibration")
    told = _part(dataclasses.replace(diagnosis, calibration=bent), "calibration")
    assert "1 number moved by more than 3" in told
    assert "They moved by no more" not in told


def test_a_number_that_could_be_anything_is_said_to_be_unknown() -> None:
    """Where its interval is wider than all that its tolerance lets it be, digits would say more than is known."""
    loose = (Calibration("elbow", "stiffness", 1.09, 44.0, 0.03), Calibration("elbow", "damping", 1.01, 0.08, 0.03))
    told = _part(dataclasses.replace(cases.no_discrepancy(), calibration=loose), "calibration")
    assert told.count("not held by these data") == 1
    assert "<td>factor 1</td><td>1.010</td><td>0.080</td><td>0.853 to 1.167</td>" in told


def test_a_calibrated_number_stands_beside_what_was_given() -> None:
    """In its unit where the model file has it; a link's by its factor, as the URDF holds the number."""
    drives = {"*": {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5}}
    spring = fd.effects.ParallelSpring("elbow", side="link", stiffness=2.0, rest=0.1)
    model = fd.load_model("scara_two_link").replace(joints=drives, effects=[spring])
    moved = (
        Calibration("elbow", "damping", 1.02, 0.01, 0.03),
        Calibration("effects[0]", "stiffness", 0.9, 0.05, 0.1),
        Calibration("link1", "link_com", 1.05, 0.01, 0.03),
    )
    told = _part(dataclasses.replace(cases.no_discrepancy(), calibration=moved, model=model), "calibration")
    assert "<td>1.5 N m s/rad</td><td>1.530</td><td>0.015</td><td>1.501 to 1.559</td><td>+2 %</td>" in told
    assert "<td>2 N m/rad</td><td>1.80</td><td>0.10</td><td>1.60 to 2.00</td><td>\N{MINUS SIGN}10 %</td>" in told
    assert "<td>factor 1</td><td>1.050</td><td>0.010</td><td>1.030 to 1.070</td><td>+5 %</td>" in told


def test_what_to_measure_next_follows_from_the_answer() -> None:
    """The telling motion; where something is left, more of that joint; without test data, another recording."""
    assert next_measurements(cases.explained()) == [cases.SWEEPS]
    assert next_measurements(cases.interrupted())[0].startswith("Run the diagnosis to its end")
    first, *_, last = next_measurements(cases.unexplained())
    assert first.startswith("More motion of elbow (q between 0.4 and 0.6 rad), slower")
    assert last.startswith("A second recording of another motion")
    assert next_measurements(cases.partly())[0].startswith("More motion of shoulder, slower")
    assert next_measurements(cases.no_discrepancy()) == []


@pytest.mark.parametrize(
    ("channel", "unit"), [("q.elbow", "rad"), ("omega.elbow", "rad/s"), ("tau_s.elbow", "N m"), ("q.nobody", "")]
)
def test_channels_have_units(channel: str, unit: str) -> None:
    """By their signal and joint."""
    assert channel_unit(fd.load_model("scara_two_link"), channel) == unit


def test_a_suspect_without_a_number_is_named_all_the_same() -> None:
    """A wrong number of a link, an effect at a frame."""
    model = fd.load_model("scara_two_link")
    assert finding_phrase(model, Finding(cases.MASS, 1.0, 1.0, 1.0)) == "a wrong mass of link2"
    assert finding_phrase(model, Finding(Suspect("payload", None, None), 1.0, 1.0, 1.0)) == (
        "a payload at the end of the arm"
    )
