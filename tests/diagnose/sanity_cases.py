"""Recordings of the oracle's arm with changed channels, as the check before a diagnosis sees them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.sanity import check_recordings
from tests.diagnose.truths import ARM, Levels, two_link_recording

Array = NDArray[np.float64]
Channels = dict[str, Array]
Change = Callable[[Channels], Channels]
RATIO = 100.0
LEVELS = Levels(position=5e-6, torque=0.01)


@cache
def geared_arm() -> fd.FlexibleJointModel:
    """The oracle's arm with its rotors behind gears of 100."""
    joints = {
        name: {
            "gear_ratio": RATIO,
            "rotor_inertia": ARM.rotor[j] / RATIO**2,
            "stiffness": ARM.stiffness[j],
            "damping": ARM.damping[j],
        }
        for j, name in enumerate(("shoulder", "elbow"))
    }
    return fd.FlexibleJointModel(fd.load_robot("scara_two_link"), joints, gravity=[0.0, -ARM.gravity, 0.0])


def checked(
    model: fd.FlexibleJointModel, change: Change, t: Array | None = None, keep: int | None = None
) -> tuple[str, ...]:
    """The notes on the oracle's motion, its channels changed first."""
    rec = two_link_recording(LEVELS, seed=3)
    channels = change({name: np.array(values) for name, values in rec.channels.items()})
    rows = slice(0, keep)
    changed = fd.Recording((rec.t if t is None else t)[rows], {k: x[rows] for k, x in channels.items()}, name="log.csv")
    return check_recordings(model, (measured(model, changed),))


def same(channels: Channels) -> Channels:
    """As it was recorded."""
    return channels


def scaled(factor: float, *names: str) -> Change:
    """Channels times a factor."""
    return lambda channels: {name: x * factor if name in names else x for name, x in channels.items()}


def exchanged(*signals: str) -> Change:
    """Signals of the shoulder and the elbow swapped."""
    other = {"shoulder": "elbow", "elbow": "shoulder"}

    def change(channels: Channels) -> Channels:
        return {
            name: channels[f"{name.partition('.')[0]}.{other[name.partition('.')[2]]}"]
            if name.partition(".")[0] in signals
            else x
            for name, x in channels.items()
        }

    return change


def without(*names: str) -> Change:
    """Channels left out."""
    return lambda channels: {name: x for name, x in channels.items() if name not in names}


def both(one: Change, two: Change) -> Change:
    """One change after the other."""
    return lambda channels: two(one(channels))
