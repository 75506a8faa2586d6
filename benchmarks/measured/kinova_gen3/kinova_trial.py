"""A finding of a sweep, left out or with a rival in its place, fitted to the sweep and held against the trajectory."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from kinova_data import Array
from kinova_result import Trial

import flexdyn as fd
from flexdyn.diagnose import Suspect

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from along import along

Effect = fd.effects.Effect
SIZES = ("coefficient", "level", "offset", "mass", "gain", "amplitude")
"""Parameters in which the laws are linear."""
ROTOR = 1e-5
"""Rotor inertia by which its column is taken [kg m^2]."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """What a joint's laws are fitted to.

    Attributes:
        joint: that moves.
        bare: its model without friction and without its rotor.
        recording: its sweep.
    """

    joint: int
    bare: fd.FlexibleJointModel
    recording: fd.Recording

    def fitted(self, effects: Sequence[Effect]) -> tuple[float, list[Effect]]:
        """Rotor inertia [kg m^2] and laws whose sizes are least squares on the sweep; no prior, no other number."""
        left = self._missing(self.bare)
        rotor = self.bare.replace(joints={f"joint_{self.joint}": {"rotor_inertia": ROTOR}})
        others = (self.bare.replace(effects=[each]) for each in effects)
        X = np.stack([left - self._missing(model) for model in (rotor, *others)], axis=1)
        sizes = np.linalg.lstsq(X, left, rcond=None)[0].tolist()
        made = [scaled(each, size) for each, size in zip(effects, sizes[1:], strict=True)]
        return max(ROTOR * sizes[0], 0.0), made

    def _missing(self, model: fd.FlexibleJointModel) -> Array:
        return along(model, self.recording).missing[:, 0]


def scaled(effect: Effect, size: float) -> Effect:
    """An effect that does so many times as much; friction that would drive the joint is none."""
    if isinstance(effect, fd.effects.ParameterError):
        return effect.replace(factor=max(1.0 + size * (effect.factor - 1.0), 0.05))
    name = next(each.name for each in effect.parameters() if each.name in SIZES)
    value = size * float(getattr(effect, name))
    return effect.replace(**{name: value if name in ("offset", "gain") else max(value, 0.0)})


def trial(sweep: Sweep, arm: fd.FlexibleJointModel, trajectory: fd.Recording, found: fd.Diagnosis, k: int) -> Trial:
    """One finding of a diagnosis.

    Args:
        sweep: that was diagnosed.
        arm: the whole arm with what the other sweeps found.
        trajectory: that no decision read.
        found: the diagnosis of the sweep.
        k: place of the finding in it.
    """

    def error(effects: Sequence[Effect]) -> float:
        inertia, laws = sweep.fitted(effects)
        whole = arm.replace(joints={f"joint_{sweep.joint}": {"rotor_inertia": inertia}}, effects=[*arm.effects, *laws])
        return along(whole, trajectory).error(sweep.joint - 1)

    finding = found.findings[k]
    rest = [each for other in found.findings if other is not finding for each in made(other.suspect)]
    rivals = {}
    for rival in finding.rivals:
        words = [rival.effect] if "of" not in rival.place else [rival.place["of"], rival.place["parameter"]]
        there = made(rival)
        rivals[" ".join(words)] = error([*rest, *there]) if there else math.nan
    names = tuple(each.effect for each in finding.names)
    return Trial(sweep.joint, names, error([*rest, *made(finding.suspect)]), error(rest), rivals)


def made(suspect: Suspect) -> list[Effect]:
    """The effect of a suspect with its own numbers; none where they were not estimated."""
    numbers: dict[str, Any] = {key: each.value for key, each in suspect.parameters.items()}
    if not numbers:
        return []
    where: dict[str, Any] = {key: x for key, x in suspect.place.items() if key in ("frame", "of", "parameter")}
    if suspect.effect == "parameter_error":
        return [fd.effects.ParameterError(**where, **numbers)]
    where |= {} if suspect.joint is None else {"joint": suspect.joint}
    where |= {} if suspect.side is None else {"side": suspect.side}
    return [fd.effects.catalogue()[suspect.effect](**where, **numbers)]
