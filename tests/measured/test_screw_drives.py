"""The screw drives: Stribeck friction where the authors have it, and in no other direction."""

from __future__ import annotations

from pathlib import Path

import pytest
from screw_result import Studied
from screw_study import DRIVES, bounds, studied

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "screw_drives"

pytestmark = pytest.mark.skipif(
    not (DATA / "driveNo1").is_dir(), reason=f"{DATA} is absent: recordings of three screw drives are read there"
)
NAMED = {
    "driveNo1": {1: ("stribeck_friction",), -1: ("stribeck_friction",)},
    "driveNo2": {1: (), -1: ()},
    "driveNo3": {1: (), -1: ("stribeck_friction",)},
}
"""By drive and direction; the authors' parameters have it for drives 1 and 3."""


@pytest.fixture(scope="module")
def made() -> tuple[Studied, ...]:
    """All three drives."""
    return tuple(studied(DATA, drive) for drive in DRIVES)


def test_verdicts(made: tuple[Studied, ...]) -> None:
    """Each direction by itself."""
    found = {of.drive.name: {way: curve.named for way, curve in of.curves.items()} for of in made}
    assert found == NAMED


def test_nothing_is_named_that_other_runs_do_not_confirm(made: tuple[Studied, ...]) -> None:
    """Both halves of the speeds, and the start-stop files."""
    assert all(each.passed for each in bounds(made))
    named = [each for of in made for curve in of.curves.values() for each in curve.trials if each.named]
    assert all(min(each.prediction) > 0.0 and each.check > -4.0 for each in named)


def test_the_lead_screws_rise_predicts_the_start_stop_files(made: tuple[Studied, ...]) -> None:
    """At 50 and 200 rpm, both ways: Coulomb and viscous friction alone are two times further off, or more."""
    assert made[0].stretches
    for each in made[0].stretches:
        assert abs(each.predicted - each.torque) < 0.5 * abs(each.plain - each.torque)


def test_directions_differ_in_level(made: tuple[Studied, ...]) -> None:
    """The worm under load takes twice as much one way as the other: it is self-locking."""
    forward, back = (made[2].curves[way].level for way in (1, -1))
    assert back[0] - forward[0] > 10.0 * (forward[1] + back[1])
