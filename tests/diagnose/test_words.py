"""What the report says, word by word: names, digits, changes, and what is not said."""

from __future__ import annotations

import dataclasses
import math

import flexdyn as fd
from flexdyn.diagnose.findings_html import finding_article
from flexdyn.diagnose.result import Calibration, Finding, Number, Suspect, Tried
from flexdyn.diagnose.sections import calibration
from flexdyn.diagnose.words import estimate_text, finding_phrase, interval_text, relative, value_text
from tests.diagnose import answers


def test_words_of_rivals_and_wrong_numbers() -> None:
    """Rivals in one place share its name; a wrong number says by how much; an effect of the file is named."""
    model = fd.load_model("scara_two_link")
    rival = dataclasses.replace(answers.WRONG, place={"of": "effects[0]", "parameter": "stall_torque"})
    assert finding_phrase(model, Finding(answers.STRIBECK, 1.0, 1.0, (answers.PRESLIDING,))) == (
        "Stribeck friction or presliding friction on the motor side of elbow"
    )
    assert finding_phrase(model, Finding(answers.WRONG, 1.0, 1.0, (rival,))) == (
        "a wrong stiffness of shoulder (+31 %), or a wrong stall torque of torque speed limit on the motor side of"
        " shoulder (+31 %)"
    )


def test_digits_follow_from_the_uncertainty() -> None:
    """Two digits of the standard deviation, and the interval that holds 95 %."""
    assert value_text(1.23456, 0.05) == "1.235"
    assert value_text(123.456, 20.0) == "123"
    assert value_text(-0.000123456, 1e-6) == "\N{MINUS SIGN}1.235e\N{MINUS SIGN}04"
    assert estimate_text(Number(0.40004, 4.6e-4, "N m")) == "0.40004 ± 0.00046 N m"
    assert estimate_text(Number(1.0, 0.0, "1")) == "1"
    assert estimate_text(Number(2e6, 3e3, "N m/rad")) == "2.0000e+06 ± 3.0e+03 N m/rad"
    assert interval_text(Number(0.0, 1.0, "N m")) == "\N{MINUS SIGN}2.0 to 2.0 N m"
    assert interval_text(Number(1.0, math.nan, "N m")) == "not known"
    assert interval_text(Number(1.0, 0.0, "1")) == "chosen among a few, not measured"


def test_changes_read_as_percent() -> None:
    """Two digits below ten percent, whole ones above; no change is none; a multiple is a multiple."""
    minus = "\N{MINUS SIGN}"
    told = {factor: relative(factor) for factor in (1.0123, 0.9, 2.9, 1.0 + 1e-9, 4.0)}
    assert list(told.values()) == ["+1.2 %", f"{minus}10 %", "+190 %", "none", "4 times what is given"]


def test_a_number_beyond_its_tolerance_is_not_said_to_be_within() -> None:
    """Where something is left unexplained, it may bend a number of the file farther than its tolerance lets it."""
    bent = (Calibration("elbow", "stiffness", 2.9, 0.2, 0.02), Calibration("elbow", "damping", 1.01, 0.2, 0.02))
    diagnosis = answers.no_discrepancy()
    assert "They moved no farther than" in calibration(diagnosis)
    told = calibration(dataclasses.replace(diagnosis, calibration=bent))
    assert "1 number went beyond" in told
    assert "They moved no farther than" not in told


def test_a_number_that_could_be_anything_is_said_to_be_unknown() -> None:
    """Where its interval is wider than all that its tolerance lets it be, digits would say more than is known."""
    diagnosis = answers.no_discrepancy()
    loose = (Calibration("elbow", "stiffness", 1.09, 44.0, 0.03), Calibration("elbow", "damping", 1.01, 0.08, 0.03))
    told = calibration(dataclasses.replace(diagnosis, calibration=loose))
    assert told.count("not held by these data") == 1
    assert "1.010 \N{PLUS-MINUS SIGN} 0.080" in told


def test_a_wider_law_is_called_needless_only_where_it_is() -> None:
    """One that explained more when the simpler one was chosen is not said to be of no use."""
    model = fd.load_model("scara_two_link")
    chosen = Suspect("coulomb_friction", "elbow", "link", {"level": Number(0.02, 1e-4, "N m")})
    for behind, needless in ((-221.0, False), (5.0, True)):
        wider = Tried(Suspect("asymmetric_friction", "elbow", "link"), behind, math.nan)
        told = finding_article(model, 1, Finding(chosen, 1e4, 0.3, tried=(Tried(chosen, 0.0, 1.1), wider)))
        assert "contains it" in told
        assert ("not needed" in told) == needless


def test_a_title_says_where_each_of_its_names_acts() -> None:
    """Rivals of one place share it; those elsewhere, and wrong numbers, come with a place of their own."""
    model = fd.load_model("scara_two_link")
    here, elsewhere = answers.PRESLIDING, dataclasses.replace(answers.PRESLIDING, joint="shoulder")
    told = finding_article(model, 1, Finding(answers.STRIBECK, 1.0, 1.0, (here, elsewhere, answers.WRONG)))
    assert "<h3>1. Stribeck friction or presliding friction</h3>" in told
    place = "on the motor side of elbow, or presliding friction on the motor side of shoulder, or a wrong stiffness of"
    assert f"<p>{place} shoulder" in told
