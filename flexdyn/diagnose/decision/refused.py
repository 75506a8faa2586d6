"""What a model may hold and a diagnosis does not know: each is one line."""

from __future__ import annotations

from flexdyn.effects import JointEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot.axes import joint_row


def check_diagnosable(model: FlexibleJointModel) -> None:
    """Refuse a model with a part that the equations of a diagnosis leave out: it would name something in its place.

    Args:
        model: as it was given.

    Raises:
        InputError: inductance of a motor, dry friction between two motors, a stop or spring on a joint of several axes.
    """
    for name, joint in model.joints.items():
        if joint.actuator is not None and joint.actuator.dc_motor.inductance > 0.0:
            motor = joint.actuator.dc_motor
            lag = 1e3 * motor.inductance / motor.resistance
            key, problem = f"joints.{name}.actuator.dc_motor.inductance", "a diagnosis does not know inductance"
            remedy = f"leave it out; the current then follows the voltage at once and not in L/R = {lag:.3g} ms"
            raise InputError(problem, key=key, value=motor.inductance, remedy=remedy)
    for i, effect in enumerate(model.effects):
        for name, (law, remedy) in effect.undiagnosed.items():
            if (value := getattr(effect, name)) > 0.0:
                problem = f"a diagnosis does not know {law}"
                raise InputError(problem, key=f"effects[{i}].{name}", value=value, remedy=remedy)
        if isinstance(effect, JointEffect) and joint_row(model.robot, effect.joint) is not None:
            problem = "a diagnosis does not know effects on joints that several axes move"
            raise InputError(problem, key=f"effects[{i}].joint", value=effect.joint, remedy="leave it out")
