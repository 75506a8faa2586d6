"""The table of motors under voltage that `flexdyn info` shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flexdyn.cli.output import cell, table
from flexdyn.model.actuator import MOTOR_UNITS


def motors(joints: Sequence[Mapping[str, Any]]) -> Any:
    """Numbers of every DC motor and its firmware; None where no joint has one.

    Args:
        joints: of the document of `flexdyn info`.
    """
    driven = [(joint["name"], joint["actuator"]) for joint in joints if joint["actuator"] is not None]
    columns = ("joint", *(name.replace("_", " ") for name in MOTOR_UNITS), "firmware")
    rows = [
        (
            name,
            *(
                f"{cell(drive['dc_motor'][key])} {unit}" if key in drive["dc_motor"] else "-"
                for key, unit in MOTOR_UNITS.items()
            ),
            _firmware(drive.get("firmware")),
        )
        for name, drive in driven
    ]
    return table("Motors under voltage, on the motor's side", columns, rows) if rows else None


def _firmware(settings: Mapping[str, Any] | None) -> str:
    if settings is None:
        return "-"
    return ", ".join(f"{key} {cell(settings[key])}" for key in ("kp", "ki", "kd", "rate"))
