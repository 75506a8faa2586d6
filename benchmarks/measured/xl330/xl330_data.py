"""XL330 on a pendulum: its logs, and the servo simulated from its goal alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.simulation.electrical import with_asked_torque

Array = NDArray[np.float64]
HERE = Path(__file__).parent
LOGS = (
    (100, "sin_sin"),
    (100, "lift_and_drop"),
    (200, "up_and_down"),
    (200, "sin_time_square"),
    (400, "sin_sin"),
    (400, "lift_and_drop"),
    (800, "up_and_down"),
    (800, "sin_time_square"),
)
"""Gain of the firmware, and what the goal does."""
DIVISOR, COUNTS, FULL = 256.0, 4096.0, 885.0
"""Of the firmware: PWM counts are gain/256 times position counts, 4096 to a turn, and 885 are the whole supply."""
SOLVER = fd.solvers.TimeStepping(step=1e-3)
"""Of the closed loops: a step of the firmware's tick."""
SECONDS = 6.0
"""Of every log that count [s]."""


@dataclass(frozen=True, eq=False)
class Log:
    """One log.

    Attributes:
        gain: of the firmware, as set.
        name: of the log.
        recording: position and goal from 0 s to `SECONDS`.
        released: when the motor is let go [s]; None: never.
    """

    gain: int
    name: str
    recording: fd.Recording
    released: float | None

    @property
    def firmware(self) -> fd.Firmware:
        """The servo's controller at this gain."""
        return fd.Firmware(kp=self.gain / DIVISOR, counts_per_turn=COUNTS, full_pwm=FULL)

    @property
    def powered(self) -> fd.Recording:
        """As long as the motor is driven, without the last sample before it is let go."""
        return self.recording if self.released is None else self.recording.trim(end=self.released - 0.01)


def read_logs(folder: Path) -> tuple[Log, ...]:
    """All eight."""
    return tuple(_read(folder, gain, motion) for gain, motion in LOGS)


def _read(folder: Path, gain: int, motion: str) -> Log:
    name = f"kp{gain}_{motion}"
    whole = fd.read_recording(folder / f"xl330_{name}.csv", map=HERE / "map.yaml", name=name).trim(end=SECONDS)
    off = np.flatnonzero(whole["torque_enable"] < 0.5)
    channels = {key: whole[key] for key in ("q.servo", "goal.servo")}
    recording = fd.Recording(whole.t, channels, name=name)
    return Log(gain, name, recording, float(whole.t[off[0]]) if len(off) else None)


def of_duties(logs: Sequence[Log]) -> list[fd.Recording]:
    """Position and duty of logs in which the motor is driven for long enough to be diagnosed.

    The duty is that of the firmware's law along the measured positions, as `fd.diagnose` takes it of goals; the logs
    have different gains, and a model file has one.
    """
    plain = fd.load_model(HERE / "plain.yaml")
    motor = motor_of(plain)
    found = []
    for log in logs:
        servo = {"servo": {"actuator": fd.Actuator(dc_motor=motor, firmware=log.firmware)}}
        asked = with_asked_torque(plain.replace(joints=servo), log.powered)["tau.servo"]
        duty = asked / (motor.stall_torque(1.0) * motor.supply)
        channels = {"q.servo": log.powered["q.servo"], "duty.servo": duty}
        found.append(fd.Recording(log.powered.t, channels, name=log.name))
    return found


def motor_of(model: fd.FlexibleJointModel) -> fd.DCMotor:
    """The servo's motor.

    Raises:
        ValueError: the model has none.
    """
    actuator = model.joints["servo"].actuator
    if actuator is None:
        raise ValueError("the servo has no actuator")
    return actuator.dc_motor


def from_goals(model: fd.FlexibleJointModel, logs: Sequence[Log]) -> list[Array]:
    """Position of every log (samples,) [rad], simulated from its goal and its first position alone.

    The firmware's loop is closed on the simulated position. Where the motor is let go the arm swings on without an
    actuator; its gear and friction stay. A simulation that fails gives NaN.
    """
    commands = [fd.Servo(reference=_goal(log), firmware=log.firmware, feedback="q") for log in logs]
    runs = [
        fd.simulate(model, command, _end(log), SOLVER, times=_driven(log), q0=[float(log.recording["q.servo"][0])])
        for log, command in zip(logs, commands, strict=True)
    ]
    loose = model.replace(joints={"servo": {"actuator": None}})
    return [
        run.q[:, 0] if log.released is None else np.append(run.q[:-1, 0], _swing(loose, log, run))
        for log, run in zip(logs, runs, strict=True)
    ]


def errors(model: fd.FlexibleJointModel, logs: Sequence[Log]) -> Array:
    """Mean absolute error of the position of every log (logs,) [rad]."""
    simulated = from_goals(model, logs)
    pairs = zip(simulated, logs, strict=True)
    return np.array([np.abs(each - log.recording["q.servo"]).mean() for each, log in pairs])


def _goal(log: Log) -> fd.Samples:
    return fd.Samples(log.recording.t, {"servo": log.recording["goal.servo"]})


def _end(log: Log) -> float:
    return float(log.recording.t[-1]) if log.released is None else log.released


def _driven(log: Log) -> Array:
    """Times of the samples up to the end of the drive, which is the last."""
    t = log.recording.t
    return t if log.released is None else np.append(t[t < log.released], log.released)


def _swing(loose: fd.FlexibleJointModel, log: Log, run: fd.Run) -> Array:
    """Positions from where the motor is let go (samples,) [rad]."""
    t = log.recording.t
    after = t[t >= _end(log)] - _end(log)
    state = {f"{key}0": getattr(run, key)[-1] for key in ("q", "v", "theta", "omega")}
    return fd.simulate(loose, None, max(float(after[-1]), 1e-3), SOLVER, times=after, **state).q[:, 0]
