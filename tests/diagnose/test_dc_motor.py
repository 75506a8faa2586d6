"""A joint under voltage is diagnosed from volts, or from goals alone, and its motor encoder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.number_columns import of_numbers
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.effects import CoulombFriction, Effect, ParameterError, ViscousFriction
from flexdyn.model.uncertain_parameters import file_numbers, with_factors
from flexdyn.simulation.electrical import with_asked_torque
from tests.diagnose.slides import named
from tests.simulation.test_dc_motor import B, model

RATE, SECONDS, NOISE = 500.0, 10.0, 2e-5
FIRMWARE = {"kp": 3.0, "counts_per_turn": 65536, "full_pwm": 14160}
HIDDEN = (
    CoulombFriction("swing", side="motor", level=0.03),
    ViscousFriction("swing", side="motor", coefficient=0.012),
)


def arm(folder: Path, effects: Any = ()) -> fd.FlexibleJointModel:
    """A pendulum on a servo, without friction as given."""
    bare = model(folder, effects, gravity=9.81, motor={"supply": 12.0}).replace(tolerance=0.03)
    actuator = fd.Actuator(dc_motor=bare.joints["swing"].actuator.dc_motor, firmware=fd.Firmware(**FIRMWARE))
    made: fd.FlexibleJointModel = bare.replace(joints={"swing": {"actuator": actuator}})
    return made


def record(truth: fd.FlexibleJointModel, *, goal: bool = False, size: float = 1.0) -> fd.Recording:
    """Motor encoder, and volts or goals."""
    t = np.arange(round(SECONDS * RATE)) / RATE
    wave = size * (0.9 * np.sin(1.3 * t) + 0.5 * np.sin(4.1 * t) + 0.25 * np.sin(9.3 * t + 1.0))
    asked = {"goal.swing": 0.8 * wave, "q.swing": 0.0 * t} if goal else {"voltage.swing": 2.0 * wave}
    run = fd.simulate(truth, fd.Recording(t, asked), rate=RATE)
    seen = run.theta[:, 0] + np.random.default_rng(0).normal(0.0, NOISE, len(run.t))
    name, values = next(iter(asked.items()))
    return fd.Recording(run.t, {name: values[: len(run.t)], "theta.swing": seen})


@pytest.mark.parametrize("goal", [False, True], ids=["volts", "goals"])
def test_dry_and_viscous_friction_are_named_beside_the_back_emf(tmp_path: Path, goal: bool) -> None:
    """Viscous friction is told from back-EMF by what is known of the motor, whose tolerance is in its error."""
    truth = arm(tmp_path, HIDDEN)
    diagnosis = fd.diagnose(arm(tmp_path), fit=[record(truth, goal=goal)])
    found = {effect: values for effect, values, _ in named(diagnosis)}
    assert found.keys() == {"coulomb_friction", "viscous_friction"}
    assert found["coulomb_friction"]["level"] == pytest.approx(0.03, rel=0.02)
    viscous = next(each for each in diagnosis.findings if each.suspect.effect == "viscous_friction")
    number = viscous.suspect.parameters["coefficient"]
    back_emf = B
    assert abs(number.value - 0.012) < 3.0 * number.std
    assert number.std == pytest.approx(0.03 * back_emf, rel=0.5)  # of the motor's tolerance, not of the noise
    assert diagnosis.verdict == "explained"
    diagnosis.save(tmp_path / "report")
    assert "ohm" in (tmp_path / "report" / "report.html").read_text()
    corrected = fd.load_model(tmp_path / "report" / "model.yaml")
    assert corrected.joints["swing"].actuator is not None


def test_a_right_model_lacks_nothing(tmp_path: Path) -> None:
    """Nothing is named where the motor is as its file says."""
    diagnosis = fd.diagnose(arm(tmp_path), fit=[record(arm(tmp_path))])
    assert (diagnosis.verdict, diagnosis.findings) == ("no_discrepancy", ())


def test_a_motor_within_its_tolerance_is_calibrated(tmp_path: Path) -> None:
    """5 % more torque per ampere, with a tolerance of 3 %: the steady speed tells the back-EMF exactly."""
    wrong = ParameterError("swing", parameter="torque_constant", factor=1.05)
    diagnosis = fd.diagnose(arm(tmp_path), fit=[record(arm(tmp_path, [wrong]))])
    assert diagnosis.findings == ()
    factor = next(each.factor for each in diagnosis.calibration if each.parameter == "torque_constant")
    assert factor == pytest.approx(1.05, abs=2e-3)


def test_resistance_looks_like_a_weaker_motor_with_friction(tmp_path: Path) -> None:
    """Half as much resistance again is kt times 2/3 and viscous friction, which the report says."""
    wrong = ParameterError("swing", parameter="resistance", factor=1.5)
    diagnosis = fd.diagnose(arm(tmp_path), fit=[record(arm(tmp_path, [wrong]))])
    told = {
        (suspect.effect, suspect.place.get("parameter"))
        for finding in diagnosis.findings
        for suspect in (finding.suspect, *finding.rivals)
    }
    assert ("parameter_error", "resistance") in told
    assert diagnosis.verdict in ("explained", "partly_explained")


def _equations(folder: Path, effects: list[Effect]) -> Equations:
    given = arm(folder, effects)
    data = (measured(given, with_asked_torque(given, record(arm(folder, HIDDEN)))),)
    bare, _ = prepared(given, data)
    return bare.equations


def test_columns_of_the_motors_numbers_are_slopes_of_the_rows(tmp_path: Path) -> None:
    """Also where they have moved already."""
    moved = [ParameterError("swing", parameter="torque_constant", factor=1.1)]
    for equations in (_equations(tmp_path, []), _equations(tmp_path, list(moved))):
        numbers = [
            each for each in file_numbers(equations.model) if each.parameter in ("torque_constant", "resistance")
        ]
        columns = of_numbers(equations, tuple(numbers))
        for number, column in zip(numbers, columns.T, strict=True):
            ahead, behind = (equations.of(with_factors(equations.model, {number: f})).residual for f in (1.001, 0.999))
            slope = (ahead - behind) / 0.002
            np.testing.assert_allclose(column, slope, atol=2e-3 * np.abs(slope).max())


def test_needed_torque_is_that_of_the_volts(tmp_path: Path) -> None:
    """What the model needs for its own motion is what its motor was asked for, at another torque constant as well."""
    for effects in ([], [ParameterError("swing", parameter="torque_constant", factor=1.2)]):
        truth = arm(tmp_path, effects)
        bare, _ = prepared(truth, (measured(truth, with_asked_torque(truth, record(truth))),))
        equations, along = bare.equations, bare.equations.motions[0]
        needed, asked = equations.needed(along, 0), along.tau[:, 0]
        assert needed @ asked / (asked @ asked) == pytest.approx(1.0, abs=2e-3)
        assert float(np.std(needed - asked)) < 0.05 * float(np.std(asked))  # the encoder's noise
