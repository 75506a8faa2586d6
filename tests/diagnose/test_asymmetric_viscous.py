"""Viscous friction of either direction is named where the data hold the difference, and viscous friction where not."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.effects import ViscousFriction
from tests.diagnose.slides import model, named, recording

UP, DOWN = 8.0, 12.0


def _either_way(v: float) -> float:
    return (UP if v > 0.0 else DOWN) * v


def test_it_is_named_with_both_coefficients(tmp_path: Path) -> None:
    """A model without friction."""
    diagnosis = fd.diagnose(model(tmp_path), fit=[recording(_either_way)])
    ((effect, values, probability),) = named(diagnosis)
    assert effect == "asymmetric_viscous_friction"
    assert values == pytest.approx({"coefficient_positive": UP, "coefficient_negative": DOWN}, rel=5e-3)
    assert probability > 0.95
    assert diagnosis.verdict == "explained"


def test_the_plainer_law_is_named_where_both_directions_are_alike(tmp_path: Path) -> None:
    """Its second coefficient would be one too many."""
    ((effect, values, _),) = named(fd.diagnose(model(tmp_path), fit=[recording(lambda v: UP * v)]))
    assert effect == "viscous_friction"
    assert values == pytest.approx({"coefficient": UP}, rel=5e-3)


@pytest.mark.parametrize("half", [2.0, 5.0])
def test_beside_viscous_friction_it_is_what_the_direction_changes(tmp_path: Path, half: float) -> None:
    """The file's coefficient stays where it is, however large the difference: far beyond its tolerance."""
    given = ViscousFriction("lift", side="motor", coefficient=10.0)
    record = recording(lambda v: (10.0 - half if v > 0.0 else 10.0 + half) * v)
    diagnosis = fd.diagnose(model(tmp_path, [given]), fit=[record])
    ((effect, values, _),) = named(diagnosis)
    assert effect == "asymmetric_viscous_friction"
    assert values["coefficient_negative"] - values["coefficient_positive"] == pytest.approx(2.0 * half, rel=5e-3)
    (factor,) = [each["factor"] for each in diagnosis.to_dict()["calibration"] if each["parameter"] == "coefficient"]
    for key, true in (("coefficient_positive", 10.0 - half), ("coefficient_negative", 10.0 + half)):
        assert 10.0 * factor + values[key] == pytest.approx(true, rel=5e-3)


def test_a_wrong_coefficient_is_no_asymmetry(tmp_path: Path) -> None:
    """The file's own number is wrong by two fifths."""
    given = ViscousFriction("lift", side="motor", coefficient=10.0)
    ((effect, values, _),) = named(fd.diagnose(model(tmp_path, [given]), fit=[recording(lambda v: 14.0 * v)]))
    assert effect == "parameter_error"
    assert values == pytest.approx({"factor": 1.4}, rel=5e-3)
