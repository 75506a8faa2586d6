"""What a diagnosis draws: the law that it found, and measured and simulated motion, against what is known of them."""

from __future__ import annotations

import numpy as np
import pytest

from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.drawn import of_equations
from flexdyn.diagnose.decision.model_rows import ModelRows
from tests.diagnose.answers import LEVEL, dry_elbow, dry_model, dry_recording
from tests.diagnose.workspaces import workspace


def test_the_law_found_is_drawn_over_what_it_depends_on() -> None:
    """Coulomb friction over the rotor's velocity, a step of the level that was hidden; nothing is left after."""
    first = dry_elbow().residuals[0]
    assert (first.title, first.x_label) == ("Coulomb friction: elbow, motor side", "omega [rad/s]")
    omega, law = first.law.T
    moves = np.abs(omega) > 0.1
    assert moves.sum() > 100
    np.testing.assert_allclose(law[moves], LEVEL * np.sign(omega[moves]), rtol=0.01)
    assert first.explains > 0.99
    assert first.note == ""
    off = first.before - first.after
    assert np.abs(off[np.abs(first.x) > 0.1]) == pytest.approx(LEVEL, rel=0.01)
    assert np.abs(first.after).mean() < 0.02 * LEVEL


def test_pictures_stand_in_the_order_of_what_they_explain() -> None:
    """Laws first; then equations, two pictures of each: no more is explained by a later one."""
    shares = [each.explains for each in dry_elbow().residuals]
    assert len(shares) == 1 + 2 * 4
    assert shares == sorted(shares, reverse=True)
    assert shares[-1] < 0.01


def test_where_nothing_is_found_the_most_that_is_left_is_shown_first() -> None:
    """Equations of a model that lacks friction, taken for the corrected one too: the elbow's motor has it all."""
    data = (measured(dry_model(), dry_recording()),)
    space, _, _ = workspace(dry_model(), data)
    rows = ModelRows((space.equations,) * 3, space.noise, space.whiten)
    pictures = of_equations(rows, explained=False)
    assert [each.title for each in pictures[:2]] == ["elbow, motor side"] * 2
    assert pictures[0].explains > 0.99
    assert sum(each.explains for each in pictures[::2]) == pytest.approx(1.0)
    assert [each.explains for each in pictures] == sorted((each.explains for each in pictures), reverse=True)


def test_motion_agrees_with_the_errors_per_joint() -> None:
    """Root mean squares of the drawn errors are those of the table, and the missing friction is the torque's error."""
    answer = dry_elbow()
    test = {each.joint: each for each in answer.trajectories if each.role == "test"}
    assert [each.role for each in answer.trajectories] == ["test", "test", "fit", "fit"]
    for joint, entry in answer.errors.items():
        given, _, corrected = (np.sqrt(np.nanmean(row**2)) for row in test[joint].torque.errors)
        assert (given, corrected) == pytest.approx((entry.torque.before, entry.torque.after), rel=1e-9)
        position = test[joint].position
        assert position is not None
        assert position.label == "q [rad]"
        given, _, corrected = (np.sqrt(np.nanmean(row**2)) for row in position.errors)
        assert given == pytest.approx(entry.position.before, rel=0.1), "q is drawn, the table has theta as well"
        assert corrected == pytest.approx(entry.position.after, rel=0.2)
    elbow = test["elbow"].torque
    assert np.nanmedian(np.abs(elbow.errors[0])) == pytest.approx(LEVEL, rel=0.02)
    assert answer.data[1].start <= elbow.t[0] < elbow.t[-1] <= answer.data[1].end
    moved = np.nanmax(np.abs(elbow.measured))
    assert np.nanmax(np.abs(elbow.errors[2])) < 0.02 * moved
