"""What a model may hold and a diagnosis does not know: each is one line."""

from __future__ import annotations

from flexdyn.effects import JointCoupling, JointEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot.axes import joint_row


def check_diagnosable(model: FlexibleJointModel) -> None:
    """Refuse a model with a part that the equations of a diagnosis leave out: it would name something in its place.

    Args:
        model: as it was given.

    Raises:
        InputError: dry friction between two motors, a stop or spring on a joint of several axes.
    """
    for i, effect in enumerate(model.effects):
        if isinstance(effect, JointCoupling) and effect.level > 0.0:
            remedy = "leave it out, or use coulomb_friction of each motor"
            problem = "a diagnosis does not know dry friction between motors"
            raise InputError(problem, key=f"effects[{i}].level", value=effect.level, remedy=remedy)
        if isinstance(effect, JointEffect) and joint_row(model.robot, effect.joint) is not None:
            problem = "a diagnosis does not know effects on joints that several axes move"
            raise InputError(problem, key=f"effects[{i}].joint", value=effect.joint, remedy="leave it out")
