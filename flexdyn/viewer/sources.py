"""The arm and the motion that the user wants to see."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import NAME_IT, load_model, model_in
from flexdyn.records import Recording, read_recording
from flexdyn.records.given import as_recording
from flexdyn.simulation.run import Run
from flexdyn.viewer.motion import PlayedMotion, at_rest, of_recording, of_run
from flexdyn.viewer.rigid import RIGID, without_elasticity

Model = FlexibleJointModel | str | Path
Source = Run | Recording | Model


@dataclass(frozen=True)
class Shown:
    """An arm and its motion.

    Attributes:
        model: of the arm.
        motion: of the arm.
        source: of the motion.
    """

    model: FlexibleJointModel
    motion: PlayedMotion
    source: Run | Recording | FlexibleJointModel


def first(source: Source, model: Model | None) -> Shown:
    """The arm and motion to be shown.

    Args:
        source: a run, a recording or its path, or a model.
        model: of a recording, instead of the one that it contains.

    Raises:
        InputError: no model, or no positions of its joints.
    """
    given, file = _read(source, "run")
    with _naming(file):
        arm = _arm(given, model)
        if arm is None:
            raise InputError("the recording does not say which arm it is of", key="model", remedy=NAME_IT)
        return Shown(arm, _motion(given, arm, at_rest(arm)), given)


def second(source: Source, model: Model | None, shown: Shown, command: Any = None) -> PlayedMotion:
    """The second arm and its motion.

    Args:
        source: as for `first`; or ``"rigid"``: the shown arm without elasticity, under the same command.
        model: likewise; a recording without a model is taken to belong to the shown arm.
        shown: the first arm and its motion.
        command: that drives the arm without elasticity instead.

    Raises:
        InputError: as for `first`; a motion of another arm; or no torques for a rigid arm.
        SimulationError: the rigid arm could not be simulated.
    """
    if isinstance(source, str) and source == RIGID:
        return without_elasticity(shown.source, shown.model, shown.motion, command)
    if command is not None:
        remedy = f"leave it out, or compare with {RIGID!r}"
        raise InputError("a command is for the arm without elasticity alone", key="command", remedy=remedy)
    given, file = _read(source, "compare")
    with _naming(file, "compare"):
        other = _arm(given, model) or shown.model
        if not same_arm(shown.model, other):
            problem = f"it is of another arm, {other.robot.name}, and not of {shown.model.robot.name}"
            raise InputError(problem, remedy="joints and the frames between them must be the same")
        return _motion(given, other, shown.motion)


def same_arm(one: FlexibleJointModel, other: FlexibleJointModel) -> bool:
    """Whether two models have the same joints at the same places; masses, springs and effects may differ."""
    mine, its = one.robot.tree, other.robot.tree
    names = ("parent", "prismatic", "axis", "rotation", "translation", "gain", "offset")
    pairs = ((getattr(mine, name), getattr(its, name)) for name in names)
    alike = all(a.shape == b.shape and np.allclose(a, b, atol=1e-9) for a, b in pairs)
    return one.joint_names == other.joint_names and alike


def _read(source: Source, key: str) -> tuple[Run | Recording | FlexibleJointModel, Path | None]:
    if isinstance(source, (str, Path)):
        return read_recording(source), Path(source)
    if isinstance(source, (Run, FlexibleJointModel)):
        return source, None
    return as_recording(source, key), None


def _arm(given: Run | Recording | FlexibleJointModel, model: Model | None) -> FlexibleJointModel | None:
    if isinstance(given, Run):
        return given.model
    if isinstance(given, FlexibleJointModel):
        return given
    if model is not None:
        return model if isinstance(model, FlexibleJointModel) else load_model(model)
    return model_in(given)


def _motion(given: Run | Recording | FlexibleJointModel, arm: FlexibleJointModel, held: PlayedMotion) -> PlayedMotion:
    if isinstance(given, Run):
        return of_run(given)
    return of_recording(given, arm, held) if isinstance(given, Recording) else at_rest(given)


@contextmanager
def _naming(file: Path | None, key: str | None = None) -> Iterator[None]:
    """Add to an error the name of its file, or the argument before its key."""
    try:
        yield
    except InputError as error:
        if error.file:
            raise
        raise (error.at(key=key) if file is None else error.at(file=file)) from None
