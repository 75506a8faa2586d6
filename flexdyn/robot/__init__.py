"""Any URDF arm, a robot known by name, or a pin.Model, as one checked and immutable Robot."""

from flexdyn.robot.kinematics import frame_positions
from flexdyn.robot.load import load_robot
from flexdyn.robot.names import robot_names
from flexdyn.robot.robot import Robot
from flexdyn.robot.tree import Tree

__all__ = ["Robot", "Tree", "frame_positions", "load_robot", "robot_names"]
