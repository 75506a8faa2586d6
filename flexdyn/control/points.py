"""Commands in YAML, or as a mapping: ``pd:`` or ``torques:``, with points that are written in the text itself.

::

    pd:
      reference: {t: [0, 1, 2], shoulder: [0, 0.5, 0], interpolation: monotone}     # rad; or the path of a recording
      kp: 400            # N m/rad
      kd: 20             # N m s/rad; also rate, feedback, feedforward and interpolation, as `PD` takes them

    torques: {t: [0, 0.5, 1], elbow: [0, 2, 0], interpolation: linear}              # N m

Points give positions or torques of joints at times [s]. The default interpolation of a reference is ``monotone``: the
reference goes through the points, is at rest where it reverses, and never leaves their range. The arm starts at the
first point; a joint without points stays where it starts. By default torques are held from point to point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.checks import check_known
from flexdyn.control.commands import PD
from flexdyn.control.samples import Samples
from flexdyn.control.setting_checks import INTERPOLATIONS, Interpolation
from flexdyn.errors import InputError, retold
from flexdyn.io.yaml import check_keys

COMMAND_KEYS = ("pd", "torques")
PD_KEYS = ("reference", "kp", "kd", "rate", "feedback", "feedforward", "interpolation")


class CommandPoints(Samples):
    """Samples by joint; the arm starts at the first one."""

    def whole(self, joint_names: Sequence[str], rest: Mapping[str, float]) -> Samples:
        """Samples of every joint: one without points stays at `rest`, 0 if it is not named there.

        Raises:
            InputError: points of an unknown joint.
        """
        columns = self.columns(joint_names).copy()
        for j, joint in enumerate(joint_names):
            if joint not in (self.joints or ()):
                columns[:, j] = rest.get(joint, 0.0)
        return Samples(self.t, columns, self.interpolation)


def command_of(content: Mapping[str, Any], folder: Path | None = None) -> PD | Samples:
    """Make the command that a mapping describes.

    Args:
        content: with ``pd`` or ``torques``.
        folder: its relative paths start here; None: only points are allowed.

    Raises:
        InputError: an unknown key, or points that are not allowed.
    """
    check_keys(content, COMMAND_KEYS)
    if len(content) != 1:
        raise InputError("one of pd and torques is needed", key="command", value=list(content))
    if "torques" in content:
        return points_of(content["torques"], "torques", "hold")
    entry = content["pd"]
    check_keys(entry, PD_KEYS, required=("reference", "kp", "kd"), key="pd")
    settings = dict(entry)
    for key, between in (("reference", settings.get("interpolation") or "monotone"), ("feedforward", "hold")):
        if settings.get(key) is not None:
            settings[key] = _samples(settings[key], f"pd.{key}", between, folder)
    if isinstance(settings["reference"], Samples):
        settings.pop("interpolation", None)
    return PD(**settings)


def points_of(entry: Any, key: str, between: Any) -> CommandPoints:
    """Read points: ``t``, a list for each joint, and ``interpolation`` if it is not the default.

    Args:
        entry: of the text.
        key: its path in the file, for messages.
        between: default interpolation.

    Raises:
        InputError: no times, no joint, lists of different lengths, an entry that is no number.
    """
    if not isinstance(entry, Mapping) or "t" not in entry:
        raise InputError("points are needed", key=key, value=entry, remedy="write {t: [0, 1, 2], JOINT: [0, 0.5, 0]}")
    columns = {str(joint): values for joint, values in entry.items() if joint not in ("t", "interpolation")}
    if not columns:
        raise InputError("points of no joint", key=key, remedy="write {t: [0, 1, 2], JOINT: [0, 0.5, 0]}")
    interpolation: Interpolation = entry.get("interpolation", between)
    place = {"key": f"{key}.interpolation", "value": interpolation}
    check_known(interpolation, INTERPOLATIONS, "no such interpolation", **place)
    length = np.size(entry["t"])
    for joint, values in columns.items():
        if np.size(values) != length:
            problem = f"{np.size(values)} points where t has {length}"
            raise InputError(problem, key=f"{key}.{joint}", remedy="give one for each time")
    with retold(key=key):
        return CommandPoints(entry["t"], columns, interpolation)


def _samples(entry: Any, key: str, between: Any, folder: Path | None) -> Any:
    """A path, resolved, or points."""
    if isinstance(entry, Mapping):
        return points_of(entry, key, between)
    if not isinstance(entry, str):
        remedy = "or points: {t: [0, 1, 2], JOINT: [0, 0.5, 0]}"
        raise InputError("the path of a recording is needed", key=key, value=entry, remedy=remedy)
    if folder is None:
        remedy = "write points here, {t: [0, 1, 2], JOINT: [0, 0.5, 0]}, or a command file of its own"
        raise InputError("a path is not taken here", key=key, value=entry, remedy=remedy)
    return folder / entry
