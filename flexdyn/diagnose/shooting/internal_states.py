"""Internal states of effects with memory at the starts of windows, along the motion since a recording began."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.data.sensors import true_channels
from flexdyn.diagnose.equations.smoothed import smoothed
from flexdyn.diagnose.shooting.sensing import true_samples
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.effects import DeflectionEffect
from flexdyn.simulation.link_side import LinkSide

INTERNAL_STATE_WIDTH = 0.3
"""Standard deviation of an internal state at a window's start, relative to its reach or the joint's motion, if less."""


def internal_states(shooter: Shooter) -> tuple[Array, Array]:
    """Internal states at the starts and their standard deviations (windows, memories)."""
    windows = shooter.windows
    z = np.zeros((len(windows), len(shooter.memory)))
    std = np.zeros_like(z)
    for i, effect in enumerate(shooter.memory):
        std[:, i] = INTERNAL_STATE_WIDTH * effect.reach
        for k in range(len(windows.recordings)):
            mine = windows.places[:, 0] == k
            path = _path(shooter, effect, k)
            if path is None or not mine.any():
                continue
            rows = windows.places[mine, 1]
            z[mine, i] = effect.states_along(path[: rows.max() + 1])[rows]
            std[mine, i] = INTERNAL_STATE_WIDTH * min(effect.reach, float(np.ptp(path))) * np.where(rows == 0, 3.0, 1.0)
    return z, std


def _computed_deflection(shooter: Shooter, joint: str, k: int) -> Array | None:
    """Deflection of a joint with one encoder along a recording (samples,); None if the recording is too short."""
    model, recording = shooter.given.resolved(), shooter.windows.recordings[k]
    data = true_channels(measured(model, recording), shooter.given)
    first = Filters.of_rate(data.dt).first
    if len(data.t) <= 4 * first.half:
        return None
    along = smoothed(model, LinkSide(model), data, first)
    delta = along.delta[:, model.joint_names.index(joint)]
    return np.asarray(np.interp(recording.t - recording.t[0], along.t, delta))


def _path(shooter: Shooter, effect: object, k: int) -> Array | None:
    """The smoothed input of an effect with memory: position on its side, or deflection; None if it is unmeasured.

    With one encoder the deflection is that at which the transmission carries what the equations say.
    """
    model, recording = shooter.model, shooter.windows.recordings[k]
    joint = str(getattr(effect, "joint", ""))

    def position(signal: str) -> Array | None:
        """A joint's position by one encoder (samples,); None: it was not recorded."""
        name = f"{signal}.{joint}"
        if name not in recording:
            return None
        return np.interp(recording.t, *true_samples(model, recording, name))

    q, theta = position("q"), position("theta")
    path: Array | None
    if getattr(effect, "side", "") == "transmission":
        path = theta - q if q is not None and theta is not None else _computed_deflection(shooter, joint, k)
        rotor = theta if theta is not None else q
        if path is not None and rotor is not None:
            bent = [e for e in model.all_effects if isinstance(e, DeflectionEffect) and e.joint == joint]
            for each in bent:
                path = path if each.is_neutral else each.deflection(path, rotor)
    else:
        both = (q, theta) if getattr(effect, "side", "") == "link" else (theta, q)
        path = next((each for each in both if each is not None), None)  # on its own side, else on the other
    if path is None:  # neither was measured
        return None
    width = max(1, round(0.004 / shooter.windows.period)) * 2 + 1
    padded = np.pad(path, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), "valid")
