"""A model as tables for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexdyn.io.notebook import card, html_table

if TYPE_CHECKING:
    from flexdyn.model.flexible_joint_model import FlexibleJointModel


def as_card(model: FlexibleJointModel) -> str:
    """HTML: drives and effects."""
    numbers = ("gear_ratio", "reflected_inertia", "stiffness", "damping")
    drives = (
        (name, "elastic" if each.elastic else "rigid", *(getattr(each, key) for key in numbers))
        for name, each in model.joints.items()
    )
    effects = (
        (
            each.name,
            getattr(each, "joint", "") or "",
            getattr(each, "side", "") or "",
            ", ".join(f"{field.name} {getattr(each, field.name):.4g}" for field in each.parameters()),
        )
        for each in model.all_effects
    )
    heads = ("joint", "drive", "gear", "J reflected [kg m^2]", "K [N m/rad]", "D [N m s/rad]")
    facts = {"robot": model.robot.name, "gravity [m/s^2]": list(model.gravity), "tolerance": model.tolerance}
    second = html_table(("effect", "joint", "side", "numbers"), effects)
    return card(f"FlexibleJointModel {model.name}", facts, html_table(heads, drives), second)
