"""What the user wants to see: which arm it is, and what that arm did."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model
from flexdyn.model.recorded_model import NAME_IT, model_in
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
        motion: what it did.
        source: where that comes from.
    """

    model: FlexibleJointModel
    motion: PlayedMotion
    source: Run | Recording | FlexibleJointModel


def first(source: Source, model: Model | None) -> Shown:
    """What is shown.

    Args:
        source: a run, a recording or its path, or a model.
        model: of a recording, in place of the one that it holds.

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
    """What it is compared with.

    Args:
        source: as of `first`; or ``"rigid"``: the arm shown without elasticity, under the same command.
        model: likewise; a recording without a model is taken to be of the arm shown.
        shown: what it is compared with.
        command: that drives the arm without elasticity instead.

    Raises:
        InputError: likewise, it is of another arm, or what is shown has no torques for a rigid one.
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
    """Whether two models have the same joints in the same places, whatever their masses, springs and effects."""
    mine, its = one.robot.tree, other.robot.tree
    names = ("parent", "prismatic", "axis", "rotation", "translation", "gain", "offset")
    return one.joint_names == other.joint_names and all(
        getattr(mine, name).shape == getattr(its, name).shape
        and np.allclose(getattr(mine, name), getattr(its, name), atol=1e-9)
        for name in names
    )


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
    """Errors of a file with its name; of an argument, with that before their key."""
    try:
        yield
    except InputError as error:
        if error.file:
            raise
        raise (error.at(key=key) if file is None else error.at(file=file)) from None
