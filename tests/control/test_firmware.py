"""A servo's firmware: counts of its encoder to counts of its PWM, and a servo that is simulated from its goal alone."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.simulation.electrical import firmware_duty
from tests.simulation.test_dc_motor import model

COUNT = math.tau / 4096


def firmware(**settings: float) -> fd.Firmware:
    """Of a small servo: 4096 counts a turn, 885 counts of PWM."""
    return fd.Firmware(**{"kp": 1.5, "counts_per_turn": 4096, "full_pwm": 885} | settings)


def pwm(settings: fd.Firmware, errors: list[float]) -> list[int]:
    """PWM counts at the ticks, of errors in position counts."""
    duty = firmware_duty(settings, COUNT * np.array(errors), np.zeros(len(errors)))
    return [round(each * settings.full_pwm) for each in duty]


def test_whole_counts_rounded_towards_zero() -> None:
    """Of 0.49 counts nothing is seen; of 7 counts 10.5 PWM counts give 10."""
    assert pwm(firmware(), [0.49, 0.51, 7.0, -7.0]) == [0, 1, 10, -10]


def test_saturation_and_dead_band() -> None:
    """All of the PWM, or less where it is limited; errors of the dead band are none."""
    assert pwm(firmware(), [1000.0, -1000.0]) == [885, -885]
    assert pwm(firmware(pwm_limit=300.0), [1000.0]) == [300]
    assert pwm(firmware(dead_band=3.0), [3.0, 4.0]) == [0, 6]


def test_integral_stands_still_while_it_is_cut() -> None:
    """10 counts over 100 ticks of 1 ms sum up to 1 count s; at the limit nothing is added."""
    settings = firmware(kp=0.0, ki=20.0)
    assert pwm(settings, [10.0] * 100)[-1] == pytest.approx(20, abs=1)
    wound = pwm(firmware(kp=1.0, ki=20.0), [2000.0] * 1000 + [0.0])
    assert wound[-2:] == [885, 0]


def test_derivative_of_the_error() -> None:
    """A step of 4 counts in a tick of 1 ms is 4000 counts/s."""
    assert pwm(firmware(kp=0.0, kd=0.01), [0.0, 4.0, 4.0]) == [0, 40, 0]


def test_a_servo_is_simulated_from_its_goal_alone(tmp_path: Path) -> None:
    """The same law written by hand as a controller gives the same motion."""
    settings = firmware(kp=400 / 256)
    arm = model(tmp_path, gravity=9.81, motor={"supply": 7.4})
    goals = fd.Samples(np.arange(0.0, 1.0, 0.02), 0.6 * np.sin(4.0 * np.arange(0.0, 1.0, 0.02)))
    full = 7.4 * arm.joints["swing"].actuator.per_volt(8.0)

    def law(t: float, state: fd.State) -> list[float]:
        goal = goals.values[min(int(t / 0.02 + 1e-6), len(goals.t) - 1), 0]
        counts = round(goal / COUNT) - round(float(state.theta[0]) / COUNT)
        return [full * max(-885, min(885, math.trunc(400 / 256 * counts))) / 885]

    ours = fd.simulate(arm, fd.Servo(reference=goals, firmware=settings), duration=0.9)
    by_hand = fd.simulate(arm, fd.Controller(law, rate=1000), duration=0.9)
    np.testing.assert_allclose(ours.q, by_hand.q, atol=1e-9)
    own = arm.replace(
        joints={"swing": {"actuator": fd.Actuator(dc_motor=arm.joints["swing"].actuator.dc_motor, firmware=settings)}}
    )
    recording = fd.Recording(goals.t, {"goal.swing": goals.values[:, 0], "q.swing": np.zeros(len(goals.t))})
    np.testing.assert_allclose(fd.simulate(own, recording, duration=0.9).q, ours.q, atol=1e-12)


def test_late_firmware(tmp_path: Path) -> None:
    """The first duty arrives two ticks late."""
    arm = model(tmp_path, motor={"supply": 7.4})
    late = fd.Servo(reference=fd.Samples([0.0, 1.0], [1.0, 1.0]), firmware=firmware(), delay=2)
    run = fd.simulate(arm, late, duration=0.01)
    assert (run.tau[:2, 0] == 0.0).all()
    assert run.tau[2, 0] > 0.0


def test_mistakes(tmp_path: Path) -> None:
    """Gains beside firmware, no gains at all, a motor without a supply, a number without sense."""
    goal = fd.Samples([0.0, 1.0], [0.1, 0.1])
    with pytest.raises(InputError, match=r"servo.position_gain: firmware has gains of its own; leave it out"):
        fd.Servo(reference=goal, firmware=firmware(), position_gain=3.0)
    with pytest.raises(InputError, match=r"servo: a servo needs its gains; give position_gain and velocity_gain, or"):
        fd.Servo(reference=goal)
    with pytest.raises(InputError, match=r"servo.firmware.swing: firmware needs a motor under voltage; give joints.sw"):
        fd.simulate(model(tmp_path), fd.Servo(reference=goal, firmware=firmware()))
    with pytest.raises(InputError, match=r"full_pwm: a finite number above 0 is needed"):
        firmware(full_pwm=0.0)
