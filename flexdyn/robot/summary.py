"""A robot as a table of its joints and their limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexdyn.io.notebook import card, html_table

if TYPE_CHECKING:
    from flexdyn.robot.robot import Robot


def as_card(robot: Robot) -> str:
    """HTML for notebooks: joints and their limits."""
    mass = sum(inertia.mass for inertia in robot.pin_model.inertias[1:])
    facts = {"source": robot.source or "a pin.Model", "moving mass": f"{mass:.4g} kg"}
    rows = limit_rows(robot)
    return card(f"Robot {robot.name}", facts, html_table(("joint", "type", "range", "speed", "effort"), rows))


def limit_rows(robot: Robot) -> list[tuple[str, str, str, str, str]]:
    """Name, type, range, speed and effort of every joint, as texts with units."""
    return [
        (
            name,
            "continuous" if robot.continuous[j] else robot.kinds[j],
            f"{robot.lower[j]:.4g} to {robot.upper[j]:.4g} {robot.angle_unit(j)}",
            f"{robot.velocity_limit[j]:.4g} {robot.angle_unit(j)}/s",
            f"{robot.effort_limit[j]:.4g} {robot.torque_unit(j)}",
        )
        for j, name in enumerate(robot.joint_names)
    ]
