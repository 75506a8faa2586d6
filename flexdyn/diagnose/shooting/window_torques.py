"""Torques that act within windows: as recorded, or shifted in time by delays of commands and lags of records."""

from __future__ import annotations

import math

import numpy as np

from flexdyn import _core
from flexdyn.analysis.analysed_model import command_delays
from flexdyn.arrays import Array
from flexdyn.diagnose.shooting.sensing import sensors
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects.channels import lag, recovered
from flexdyn.model.flexible_joint_model import FlexibleJointModel


def torques_of_windows(model: FlexibleJointModel, windows: Windows, extra: Array | None) -> list[tuple[Array, Array]]:
    """Breaks from the window's start [s] and the torques held between them, of every window."""
    names, shifts = model.joint_names, torque_shifts(model)
    effects = [sensors(model, f"tau.{joint}") for joint in names]
    tables: list[Array] = []
    for recording in windows.recordings:
        columns = np.zeros((len(recording), len(names)))
        for j, (joint, each) in enumerate(zip(names, effects, strict=True)):
            if recording.has("tau", joint):
                columns[:, j] = recording[f"tau.{joint}"]
            columns[:, j] = recovered(each, columns[:, j], recording.t)
        tables.append(columns)
    found = []
    reach = math.ceil(np.abs(shifts).max() / windows.period) + 2
    for w, (k, row) in enumerate(windows.places):
        first = max(0, row - reach)
        near = slice(first, row + windows.rows + reach)
        tau = tables[k][near].copy()
        if extra is not None:
            tau[row - first : row - first + windows.rows] += extra[w]
        found.append(_held(windows.recordings[k].t[near], tau, shifts, row - first, windows.rows))
    return found


def torque_shifts(model: FlexibleJointModel) -> Array:
    """Delay between recorded and acting torques (n,) [s]."""
    lags = [lag(sensors(model, f"tau.{joint}")) for joint in model.joint_names]
    return np.asarray(command_delays(model) - np.array(lags))


def _held(t: Array, tau: Array, shifts: Array, row: int, rows: int) -> tuple[Array, Array]:
    """The torques that act within one window, which begins at a row; before the first one, its value is used."""
    if not shifts.any():
        return t[row : row + rows] - t[row], tau[row : row + rows]
    begin, end = t[row], t[row + rows - 1]
    late = np.concatenate([t + shift for shift in np.unique(shifts)])
    breaks = np.unique(np.concatenate([[begin, end], late[(late > begin + 1e-9) & (late < end - 1e-9)]]))
    breaks = breaks[np.concatenate([[True], np.diff(breaks) > 1e-9])]
    values = np.empty((len(breaks), len(shifts)))
    for j, shift in enumerate(shifts):
        values[:, j] = tau[np.maximum(np.searchsorted(t, breaks - shift + 1e-9, side="right") - 1, 0), j]
    return breaks - begin, values


def held_signal(breaks: Array, values: Array) -> _core.Signal:
    """Torques held between breaks, as a signal of the core."""
    coef = np.ascontiguousarray(values[:-1, None, :])
    return _core.signal(np.ascontiguousarray(breaks), coef, np.ascontiguousarray(values[-1]))
