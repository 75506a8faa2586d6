"""Keys of a study that a study file and the metadata of a store both have, checked as untrusted input."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flexdyn.batch.distributions import Distribution, Grid, distribution
from flexdyn.checks import check_known, number, whole
from flexdyn.control.points import PD_KEYS
from flexdyn.errors import InputError, placed
from flexdyn.io.yaml import check_keys
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.solvers import make_solver

MAX_RUNS = 100_000_000
"""Largest number of runs of a study."""
RECORDINGS_OF_PD = ("reference", "feedforward")
"""Settings of a controller that are paths of recordings."""


def check_number_of_runs(runs: int, points: int) -> None:
    """Refuse more runs than a store can count.

    Args:
        runs: at each point of the grid.
        points: of the grid.

    Raises:
        InputError: more than `MAX_RUNS` of them.
    """
    if runs * points > MAX_RUNS:
        raise InputError(f"more than {MAX_RUNS} runs", key="runs", value=runs * points)


def checked_seed(given: Any) -> int:
    """Check the seed of the draws.

    Raises:
        InputError: it is no whole number of at least 0.
    """
    return whole("seed", given, 0)


def checked_duration(given: Any) -> float:
    """Check the duration of every run [s].

    Raises:
        InputError: it is no number above 0.
    """
    return number("duration", given, "a time above 0 s is needed", above=0.0)


def checked_pd(entry: Any, key: str) -> dict[str, Any]:
    """Check which settings a controller has, and that its recordings are paths.

    Args:
        entry: ``{"pd": settings}``.
        key: of the settings, for messages.

    Returns:
        The settings.

    Raises:
        InputError: an unknown or missing setting, or a path that is no text.
    """
    check_keys(entry, ("pd",), required=("pd",), key=key.rpartition(".")[0])
    given = entry["pd"]
    check_keys(given, PD_KEYS, required=("reference", "kp", "kd"), key=key)
    for name in RECORDINGS_OF_PD:
        path = given.get(name)
        if path is not None and (not isinstance(path, str) or not path):
            raise InputError("the path of a recording is needed", key=f"{key}.{name}", value=path)
    return dict(given)


def checked_solver(entry: Any) -> dict[str, Any]:
    """Check a solver's name and settings.

    Args:
        entry: a name, or a mapping of ``name`` and settings; None: ``auto``.

    Returns:
        Name and settings; all of them unless the solver is ``auto``.

    Raises:
        InputError: no such solver, or a setting that it does not have.
    """
    if entry is None or entry == "auto" or entry == {"name": "auto"}:
        return {"name": "auto"}
    settings = {"name": entry} if isinstance(entry, str) else entry
    if not isinstance(settings, Mapping) or not isinstance(settings.get("name"), str):
        remedy = "write {name: TimeStepping, step: 1.0e-3}"
        raise InputError("a solver's name is needed", key="solver", value=entry, remedy=remedy)
    numbers: dict[str, Any] = {str(key): value for key, value in settings.items() if key != "name"}
    if settings["name"] == "auto":
        raise InputError("solver auto takes no settings", key=f"solver.{next(iter(numbers))}", remedy="name a solver")
    return make_solver(settings["name"], **numbers).to_dict()


def checked_distributions(entries: Any) -> dict[str, Distribution | Grid]:
    """Check how each number varies, by its path.

    Raises:
        InputError: nothing varies, or not by a known distribution.
    """
    if not isinstance(entries, Mapping) or not entries:
        remedy = "write {joints.JOINT.stiffness: {uniform: [2000, 6000]}}"
        raise InputError("a mapping of what varies is needed", key="vary", value=entries, remedy=remedy)
    kinds = {}
    for path, entry in entries.items():
        with placed(key=f"vary.{path}"):
            kinds[str(path)] = distribution(entry)
    return kinds


def checked_channels(entry: Any) -> tuple[str, ...]:
    """Check the channels that are kept; None: no channel.

    Raises:
        InputError: no list of names, or no such channel.
    """
    names = checked_names("keep", entry)
    for i, name in enumerate(names):
        check_known(name, SIGNALS, "no such channel", key=f"keep[{i}]", value=name)
    return names


def checked_names(key: str, entry: Any) -> tuple[str, ...]:
    """Check a list of names, none of them twice; None: no name.

    Args:
        key: of the list, for the message.
        entry: as given.

    Raises:
        InputError: it is no such list.
    """
    if entry is None:
        return ()
    if not isinstance(entry, Sequence) or isinstance(entry, str):
        raise InputError("a list of names is needed", key=key, value=entry)
    for i, name in enumerate(entry):
        if not isinstance(name, str):
            raise InputError("a name is needed", key=f"{key}[{i}]", value=name)
        if name in entry[:i]:
            raise InputError("the name is there twice", key=f"{key}[{i}]", value=name)
    return tuple(entry)
