"""Derivatives of the residuals with respect to errors of the measured channels."""

from __future__ import annotations

import dataclasses

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.data.sensors import true_channel
from flexdyn.diagnose.equations.computed_positions import acting_on, lost_share
from flexdyn.diagnose.equations.equations import Equations, Torques
from flexdyn.diagnose.equations.held_torque import centred
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.springs import spring_torque
from flexdyn.effects import SensorEffect
from flexdyn.effects.channels import by_channel


def of_sensor(equations: Equations, effect: SensorEffect, instead: SensorEffect | None = None) -> Array:
    """First-order change of the rows (rows,) by the error that a sensor effect adds: the true channel is smaller by it.

    A position that is computed from the other encoder changes with it. So does friction that takes a share of the load;
    the change of other friction is neglected.

    Args:
        equations: of the model.
        effect: of a sensor.
        instead: one that the model has, in whose place it comes; None: it is another one.
    """
    signal, j = effect.signal, equations.true.index(effect.joint)
    has = [effect if each == instead else each for each in by_channel(equations.model.effects).get(effect.channel, ())]
    recorded = {id(along): data for along, data in zip(equations.motions, equations.data, strict=True)}

    def error(along: SmoothedMotion) -> Array:
        """What the sensor's effect adds to its channel (samples,)."""
        # The data of a motion are without the model's sensor effects: one of these is moved on the recorded channel.
        seen: Array = getattr(along.data, signal)[:, j]
        data = recorded[id(along)]
        if instead is None:
            return _true(effect, along.data, seen) - seen
        return true_channel(has, getattr(data, signal)[:, j], data) - seen

    def torques(along: SmoothedMotion) -> Torques:
        """The error where the channel enters: as torque of the motor, or of the transmission."""
        if signal == "tau":
            return _smoothed(equations, along, centred(error(along)), 0), None, None
        return None, None, _smoothed(equations, along, error(along), 0)

    if signal in ("tau", "tau_s"):
        return equations.of_terms(j, torques)
    return np.concatenate(
        [_rows_of_encoder_error(equations, each, signal, j, error(each)).ravel() for each in equations.motions]
    )


def of_lag_shape(equations: Equations, effect: SensorEffect) -> Array:
    """Change of the rows (rows,) by the shape of the filter that makes a torque late.

    A filter is the mean d of its impulse response and the variance s^2 of that, to second order:
    ``tau(t) = y(t + d) - s^2 y''(t + d)/2``. A delay has s = 0, a low pass of first order s = d. This is the
    difference between these two.

    Args:
        equations: of a model that has the lag.
        effect: the lag.
    """
    j = equations.true.index(effect.joint)

    def torques(along: SmoothedMotion) -> Torques:
        """Half the squared lag times the second derivative of the torque."""
        ahead = centred(getattr(along.data, effect.signal)[:, j])  # y(t + d): the data are without the model's lags
        return 0.5 * effect.lateness**2 * _smoothed(equations, along, ahead, 2), None, None

    return equations.of_terms(j, torques)


def of_hold_shape(equations: Equations, j: int) -> Array:
    """Change of the rows (rows,) by what a joint's torque did between its samples: ``dt^2/12 tau''``.

    Taken as held, it is right to second order if the drive held it. A logger may have stored the mean of a faster
    command: then it is smoother than it is taken for, by a filter of the variance ``dt^2/12``; or one of its values.
    """

    def torques(along: SmoothedMotion) -> Torques:
        """A twelfth of the squared sample time times the second derivative of the torque."""
        ahead = centred(along.data.tau[:, j])
        return along.dt**2 / 12.0 * _smoothed(equations, along, ahead, 2), None, None

    return equations.of_terms(j, torques)


def _true(effect: SensorEffect, data: Measured, seen: Array) -> Array:
    if effect.late_by and effect.signal == "tau":
        return np.asarray(np.interp(data.t + effect.lateness, data.t, seen))
    return true_channel([effect], seen, data)


def _rows_of_encoder_error(equations: Equations, along: SmoothedMotion, signal: str, j: int, wrong: Array) -> Array:
    """Change of the rows of one recording (times, equations) by the error of an encoder (samples,)."""
    model, combined = equations.true, equations.combined
    d0, d1, d2 = (_smoothed(equations, along, wrong, order) for order in range(3))
    alone, sign = not along.data.both[j], 1.0 if signal == "theta" else -1.0
    rows = np.zeros((equations.filters.count(len(along.t)), len(equations.kinds)))
    if signal == "q" or alone:
        rows += combined(along, None, -along.dragged(j, (d0, d1, d2)), None)
    if model.elastic[j]:
        rotor = -model.rotor_inertia[j] * d2 if signal == "theta" or alone else 0.0
        link, motor = (0.0 * d0, 0.0 * d0) if alone else _spring_change(equations, along, signal, j, d0, d1)
        rows += combined(along, rotor - motor - _share_lost(equations, along, j) * link, link, -link, only=j)
    elif not alone:
        wound = np.zeros_like(along.q)
        wound[:, j] = sign * d0
        rows += combined(along, -sign * model.rotor_inertia[j] * d2, None, None, only=j, wound=wound)
    return rows


def _spring_change(
    equations: Equations, along: SmoothedMotion, signal: str, j: int, d0: Array, d1: Array
) -> tuple[Array, Array]:
    """Change of the spring's torque on the link, and on the rotor (samples,), by changes of a position and its rate."""
    names, changed = ("theta", "omega") if signal == "theta" else ("q", "v"), {}
    for name, change in zip(names, (d0, d1), strict=True):
        changed[name] = getattr(along, name).copy()
        changed[name][:, j] += change
    moved = spring_torque(equations.true, acting_on(equations.true, j), dataclasses.replace(along, **changed), j)
    link, motor = (moved - equations.spring(along, j)).T.copy()
    return link, motor


def _share_lost(equations: Equations, along: SmoothedMotion, j: int) -> Array:
    """Share of the spring's torque that friction of the motor takes (samples,) [1]."""
    carried = equations.spring(along, j)[:, 0]
    return lost_share(equations.true, j, carried, along.theta[:, j], along.omega[:, j], along.t)


def _smoothed(equations: Equations, along: SmoothedMotion, x: Array, order: int) -> Array:
    """A derivative of the error of a channel after the first filter (samples,)."""
    y = equations.filters.first.apply(x, order)
    if equations.computed.any() or equations.replayed.any():
        return equations.filters.first.apply(y, 0)
    spare = (len(y) - len(along.t)) // 2
    return y[spare : len(y) - spare]
