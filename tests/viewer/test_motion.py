"""What is shown of runs, recordings and models: every joint where it was, and a note where that is assumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.model.model_file import model_in
from flexdyn.viewer.motion import at_rest, of_recording, of_run
from flexdyn.viewer.sources import first, same_arm, second
from tests.viewer.arms import rigid_run, shapeless, two_link_run

T = [0.0, 0.5, 1.0]


def model() -> fd.FlexibleJointModel:
    """Shoulder and elbow, both elastic."""
    return fd.load_model("scara_two_link")


def test_a_run_is_shown_as_it_is() -> None:
    """Positions and deflections of the run itself, sample by sample."""
    run = two_link_run()
    shown = of_run(run)
    assert np.array_equal(shown.q, run.q)
    assert np.array_equal(shown.deflection, run.theta - run.q)
    assert shown.notes == ()


def test_a_rigid_joint_has_no_deflection_to_show() -> None:
    """No dial where theta = q by construction."""
    shown = of_run(rigid_run())
    assert np.isnan(shown.deflection).all()
    assert shown.label == "scara_two_link, rigid"


def test_a_measured_deflection_is_shown_on_a_joint_taken_for_rigid() -> None:
    """And none where theta was recorded as q, as a rigid run does."""
    rigid = rigid_run().model
    channels = {name: [0.0, 1.0, 2.0] for name in ("q.shoulder", "theta.shoulder", "q.elbow")}
    channels["theta.elbow"] = [0.0, 1.5, 2.0]
    shown = of_recording(fd.Recording(T, channels), rigid, at_rest(rigid))
    assert np.isnan(shown.deflection[:, 0]).all()
    assert shown.deflection[:, 1].tolist() == [0.0, 0.5, 0.0]


def test_a_joint_with_theta_alone_stands_at_theta() -> None:
    """Its link is shown at the rotor's angle, and the page says so."""
    recording = fd.Recording(T, {"theta.shoulder": [0.1, 0.2, 0.3], "q.elbow": [1, 2, 3], "theta.elbow": [1, 2.5, 3]})
    shown = of_recording(recording, model(), at_rest(model()))
    assert shown.q.tolist() == [[0.1, 1.0], [0.2, 2.0], [0.3, 3.0]]
    assert np.isnan(shown.deflection[:, 0]).all()
    assert shown.deflection[:, 1].tolist() == [0.0, 0.5, 0.0]
    assert len(shown.notes) == 1
    assert "shoulder" in shown.notes[0]
    assert "only theta was measured" in shown.notes[0]


def test_a_joint_that_was_not_measured_stands_where_the_model_starts() -> None:
    """Or moves as in the arm it is compared with; the page says so."""
    recording = fd.Recording(T, {"q.shoulder": [0.1, 0.2, 0.3]})
    alone = first(recording, model())
    assert alone.motion.q[:, 1].tolist() == [model().initial.get("q", {}).get("elbow", 0.0)] * 3
    assert "elbow" in alone.motion.notes[0]
    run = two_link_run()
    beside = second(recording, None, first(run, None))
    assert beside.q[:, 1] == pytest.approx(np.interp(T, run.t, run.q[:, 1]))


def test_a_recording_without_positions_is_refused() -> None:
    """One line names what is there and what is needed."""
    recording = fd.Recording(T, {"tau.shoulder": [0, 0, 0], "q.wrist": [0, 0, 0]})
    with pytest.raises(fd.InputError, match=r"no position of any joint.*tau.shoulder, q.wrist.*q.shoulder or theta"):
        first(recording, model())


def test_a_recording_of_a_run_knows_its_model() -> None:
    """NPZ and HDF5 keep the model; CSV does not, and is told how to name it."""
    recording = two_link_run().to_recording()
    assert same_arm(first(recording, None).model, two_link_run().model)
    bare = fd.Recording(recording.t, recording.channels)
    assert model_in(bare) is None
    with pytest.raises(fd.InputError, match=r"does not say which arm.*--model MODEL"):
        first(bare, None)
    assert same_arm(first(bare, "scara_two_link").model, two_link_run().model)


@pytest.mark.parametrize("text", [3, "", "a: [", "flexdyn: 1\nrobot: {urdf: /nowhere/arm.urdf}", "[]"])
def test_a_model_that_cannot_be_read_is_named(text: object) -> None:
    """Whatever a recording's meta holds, one line says what is wrong with it."""
    recording = fd.Recording(T, {"q.elbow": [0, 0, 0]}, meta={"model": text})
    with pytest.raises(
        fd.InputError, match=r"the model that the recording holds cannot be read.*--model MODEL"
    ) as seen:
        first(recording, None)
    assert "\n" not in str(seen.value)


def test_another_arm_is_refused(tmp_path: Path) -> None:
    """Other joints, or the same names in other places."""
    shown = first(two_link_run(), None)
    with pytest.raises(fd.InputError, match="another arm, shapeless"):
        second(shapeless(tmp_path), None, shown)
    urdf = (Path(fd.load_model("scara_two_link").robot.source)).read_text(encoding="utf-8")  # type: ignore[arg-type]
    longer = tmp_path / "longer.urdf"
    longer.write_text(urdf.replace('xyz="1.05 0', 'xyz="1.15 0'), encoding="utf-8")
    assert longer.read_text(encoding="utf-8") != urdf
    with pytest.raises(fd.InputError, match="another arm"):
        second(fd.FlexibleJointModel(fd.load_robot(longer)), None, shown)


def test_something_else_is_refused() -> None:
    """One line says what can be played."""
    with pytest.raises(fd.InputError, match="neither a run nor a recording"):
        first(3, None)  # type: ignore[arg-type]


def test_between_and_beyond_its_samples() -> None:
    """Linear between samples, standing still before the first and after the last."""
    recording = fd.Recording([1.0, 2.0], {"q.shoulder": [0.0, 1.0], "q.elbow": [2.0, 2.0]})
    shown = of_recording(recording, model(), at_rest(model())).at(np.array([0.0, 1.25, 9.0]))
    assert shown.q.tolist() == [[0.0, 2.0], [0.25, 2.0], [1.0, 2.0]]
