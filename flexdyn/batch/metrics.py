"""The metrics of a study: found by name or import path, checked against the study before it runs, and measured."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.machinery import PathFinder
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.batch.aim import Aim
from flexdyn.batch.catalogue import METRICS, Metric, RunMetric
from flexdyn.batch.motion import RunsMotion
from flexdyn.errors import InputError, did_you_mean, placed, retold
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.units import unit_for

_importing = Lock()


def metric(name: str, folder: Path | None = None) -> Metric:
    """A metric by name.

    Args:
        name: of the catalogue; metrics of joints also for one joint (``overshoot.elbow``); or
            ``package.module:function``: a function of a `Run` that returns a number. Its attribute ``unit``, if it has
            one, is the unit of the number; the first line of its docstring is the description.
        folder: where the function is searched first, before Python's own paths.

    Raises:
        InputError: there is no such metric or function.
    """
    if not isinstance(name, str):
        raise InputError("the name of a metric is needed", value=name, remedy=f"known: {', '.join(METRICS)}")
    if name in METRICS:
        return METRICS[name]
    whole, _, joint = name.partition(".")
    if joint and whole in METRICS and "alike" in METRICS[whole].needs:
        return replace(METRICS[whole], name=name, joint=joint)
    if ":" in name:
        function = own_function(name, folder)
        about = (function.__doc__ or "").strip().splitlines() or [""]
        unit = str(getattr(function, "unit", ""))
        return RunMetric(name, unit, about[0], "", function)
    remedy = f"{did_you_mean(name, METRICS)}; your own function is package.module:function"
    raise InputError("no such metric", value=name, remedy=remedy)


def metrics_of(
    names: Sequence[str], model: FlexibleJointModel, aim: Aim, folder: Path | None = None
) -> tuple[Metric, ...]:
    """The metrics of a study, each checked against what the study has, with the units of its arm.

    Args:
        names: as the study file writes them.
        model: the arm.
        aim: of the command.
        folder: of the study file.

    Raises:
        InputError: an unknown metric, or one that this arm or command does not have; key ``metrics[i]``.
    """
    found = []
    for i, name in enumerate(names):
        with placed(key=f"metrics[{i}]"):
            each = metric(name, folder)
            _check_needs(each, model, aim)
        found.append(replace(each, unit=unit_for(each.unit, prismatic=_joints_slide(model, each))))
    return tuple(found)


def metrics_of_runs(metrics: Sequence[Metric], motion: RunsMotion) -> tuple[Array, list[list[str]]]:
    """All metrics of some runs; a missing one is NaN, with a reason.

    Args:
        metrics: of the study.
        motion: of successful runs.

    Returns:
        The numbers (metrics, runs), and for each run a line ``metric NAME: reason`` for each missing metric.
    """
    values = np.empty((len(metrics), motion.count))
    reasons: list[list[str]] = [[] for _ in range(motion.count)]
    for row, each in zip(values, metrics, strict=True):
        row[:], lines = each.measured(motion)
        for known, line in zip(reasons, lines, strict=True):
            if line:
                known.append(line)
    return values, reasons


def _check_needs(each: Metric, model: FlexibleJointModel, aim: Aim) -> None:
    """Refuse a metric that the model or the command has no meaning for."""
    if "reference" in each.needs and aim.reference is None:
        remedy = "it needs a command with pd:, whose reference is tracked"
        raise InputError("there is no reference to track", value=each.name, remedy=remedy)
    if "rest" in each.needs and (aim.rest is None):
        remedy = "give a duration beyond the command's end"
        raise InputError("the command does not come to rest before the run ends", value=each.name, remedy=remedy)
    if "tip" in each.needs:
        with retold(key=None, value=each.name, remedy="write a metric of your own: package.module:function"):
            _ = model.robot.tip
    if each.joint:
        model.index(each.joint)
    elif "alike" in each.needs and len(set(model.robot.kinds)) > 1:
        remedy = f"name one of them: {each.name}.{model.joint_names[0]}"
        raise InputError("the arm has joints that turn and joints that slide", value=each.name, remedy=remedy)


def _joints_slide(model: FlexibleJointModel, each: Metric) -> bool:
    """Whether the joints of a metric are prismatic."""
    kinds = model.robot.kinds
    return "alike" in each.needs and (kinds[model.index(each.joint)] if each.joint else kinds[0]) == "prismatic"


def own_function(name: str, folder: Path | None = None) -> Callable[[Any], Any]:
    """The function that an import path names.

    Args:
        name: ``package.module:function``.
        folder: where it is searched first; None: only in Python's own paths.

    Raises:
        InputError: it cannot be imported or is not callable; the message says why.
    """
    module, _, attribute = name.partition(":")
    if not attribute.isidentifier() or not all(part.isidentifier() for part in module.split(".")):
        raise InputError("no such metric", value=name, remedy="your own function is package.module:function")
    with _importing, _first_in_path(module, folder):
        try:
            found = importlib.import_module(module)
        except Exception as error:  # a user's module may raise anything
            reason = f"{type(error).__name__}: {error}" if not isinstance(error, ModuleNotFoundError) else str(error)
            where = f"; it is looked for in {folder} first" if folder is not None else ""
            raise InputError(f"the metric cannot be imported ({reason}){where}", value=name) from None
    function = getattr(found, attribute, None)
    if function is None:
        raise InputError(f"module {module} has no {attribute}", value=name)
    if not callable(function):
        raise InputError("the metric is not callable", value=name, remedy="it is a function of a Run")
    return function  # type: ignore[no-any-return]


@contextmanager
def _first_in_path(module: str, folder: Path | None) -> Iterator[None]:
    """Let Python search a folder first; a module of the same name from another place is refused.

    Raises:
        InputError: such a module is loaded already.
    """
    if folder is None:
        yield
        return
    top = module.partition(".")[0]
    place = str(folder.resolve())
    importlib.invalidate_caches()
    spec = PathFinder.find_spec(top, [place])
    loaded = getattr(sys.modules.get(top), "__file__", None)
    if spec and spec.origin and loaded and Path(spec.origin).resolve() != Path(loaded).resolve():
        remedy = "rename the file, or start Python anew"
        raise InputError(f"another module {top} is loaded already, from {loaded}", value=module, remedy=remedy)
    sys.path.insert(0, place)
    try:
        yield
    finally:
        sys.path.remove(place)
