"""load_robot: from a path, a name or a pin.Model to a Robot."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.errors import InputError
from flexdyn.robot.joints import MOVING
from flexdyn.robot.meshes import resolve_meshes
from flexdyn.robot.mimic import check_lock, resolve_mimics
from flexdyn.robot.names import find_robot
from flexdyn.robot.normalise import Normalised, normalise, write_limits
from flexdyn.robot.robot import Robot
from flexdyn.robot.text import urdf_text
from flexdyn.robot.tree import tree_of
from flexdyn.robot.urdf import Urdf, read_urdf


def load_robot(
    source: str | Path | pin.Model,
    *,
    package_dirs: str | Path | Iterable[str | Path] = (),
    lock: Mapping[str, float] | None = None,
    name: str | None = None,
) -> Robot:
    """Load an arm: any URDF file, a robot known by name, or a Pinocchio model.

    Revolute, continuous (one unwrapped angle), prismatic, fixed and mimic joints and branched trees are supported.
    Meshes are located but not read; missing ones are left out with one MeshWarning.

    Args:
        source: path of a URDF, a name of robot_names(), or a pin.Model, which is copied.
        package_dirs: folders in which ``package://`` meshes are looked up.
        lock: joints to remove, held at these positions [rad or m].
        name: the robot's name; by default the known name or the one that the URDF gives.

    Returns:
        The robot.

    Raises:
        InputError: a fault in the file, the name or the arguments, in one line.

    Example:
        >>> fd.load_robot("panda", lock={"panda_joint7": 0.0}).n
        7
    """
    folders = _folders(package_dirs)
    if isinstance(source, pin.Model):
        return _assemble(normalise(source), (), lock, name=name or source.name or "robot", source=None, dirs=folders)
    if not isinstance(source, (str, Path)):
        remedy = "give the path of a URDF, the name of a robot or a pin.Model"
        raise InputError("not a robot", key="robot", value=source, remedy=remedy)
    path, known = find_robot(source)
    if path.suffix.lower() in (".yaml", ".yml") and path.is_file():
        remedy = "a model file is read by fd.load_model, and its robot is then model.robot"
        raise InputError("a YAML file is no robot", file=path, remedy=remedy)
    urdf = read_urdf(path)
    try:
        fixed = [joint.name for joint in urdf.joints if joint.kind == "fixed"]
        title = name or known or urdf.name
        robot = _assemble(_model_of(urdf), fixed, lock, name=title, source=known or path, dirs=folders)
    except InputError as error:
        of_the_file = error.key is None or not error.key.startswith("lock")
        raise (error.at(file=path) if of_the_file else error) from None
    return replace(robot, _links=resolve_meshes(urdf.links, path, folders), _joints=urdf.joints)


def _folders(package_dirs: str | Path | Iterable[str | Path]) -> tuple[Path, ...]:
    """The given folders of packages as absolute paths; refuses one that is not there."""
    given = [package_dirs] if isinstance(package_dirs, (str, Path)) else list(package_dirs)
    folders = tuple(Path(os.path.abspath(Path(folder).expanduser())) for folder in given)
    for folder in folders:
        if not folder.is_dir():
            raise InputError("no such folder", key="package_dirs", value=str(folder), remedy="give existing folders")
    return folders


def _model_of(urdf: Urdf) -> Normalised:
    """Let Pinocchio read the links and joints; limits, damping and friction are set from the checked values."""
    text = urdf_text([replace(link, visuals=()) for link in urdf.links], urdf.joints)
    try:
        model = pin.buildModelFromXML(text)
    except (ValueError, RuntimeError) as error:
        fault, remedy = _complaint(text) or _last_line(error), "check the links and joints that it names"
        raise InputError(f"Pinocchio cannot read it: {fault}", remedy=remedy) from None
    made = normalise(model)
    moving = {joint.name: joint for joint in urdf.joints if joint.kind in MOVING}
    ordered = [moving[joint] for joint in list(made.model.names)[1:]]

    def column(attribute: str) -> np.ndarray:
        """One number of every joint that moves."""
        return np.array([getattr(joint, attribute) for joint in ordered], dtype=float)

    write_limits(made.model, column("lower"), column("upper"), column("velocity"), column("effort"), column("friction"))
    made.model.damping = column("damping")
    made.model.name = urdf.name
    return replace(made, mimics={joint.name: joint.mimic for joint in ordered if joint.mimic is not None})


def _complaint(text: str) -> str | None:
    """The fault that yourdfpy finds in a URDF that Pinocchio refuses without a reason."""
    import io

    import yourdfpy

    try:
        urdf = yourdfpy.URDF.load(io.BytesIO(text.encode()), build_scene_graph=False, load_meshes=False)
        return None if urdf.validate() else str(urdf.errors[0])
    except Exception as error:  # the user should see any fault that it finds
        return _last_line(error)


def _last_line(error: Exception) -> str:
    """The last line of an error, which says what is wrong; of one without text its type."""
    return (str(error).strip() or type(error).__name__).splitlines()[-1]


def _assemble(
    made: Normalised, fixed: Iterable[str], lock: Any, *, name: str, source: str | Path | None, dirs: tuple[Path, ...]
) -> Robot:
    """A robot from its Pinocchio model: held joints made fixed, followers tied to their leaders."""
    names = list(made.model.names)[1:]
    given = check_lock(lock, names, made.mimics, list(fixed))
    held = {**dict.fromkeys(fixed, 0.0), **given}
    followers, still = resolve_mimics(made.mimics, held, [joint for joint in names if joint not in given])
    model = _reduced(made.model, {**given, **still})
    rows = {joint: row for row, joint in enumerate(list(model.names)[1:])}
    leaders = tuple(joint for joint in rows if joint not in followers)
    if not leaders:
        remedy = "lock fewer joints" if given else "make a joint revolute, continuous or prismatic"
        raise InputError("the robot has no joint that moves", key="lock" if given else "joint", remedy=remedy)
    tree = tree_of(model, leaders, followers)
    take = [rows[joint] for joint in leaders]
    return Robot(
        name=name,
        source=source,
        package_dirs=dirs,
        lock=given,
        joint_names=leaders,
        kinds=tuple("prismatic" if tree.prismatic[row] else "revolute" for row in take),
        continuous=tuple(joint in made.continuous for joint in leaders),
        lower=model.lowerPositionLimit[take],
        upper=model.upperPositionLimit[take],
        velocity_limit=model.velocityLimit[take],
        effort_limit=model.effortLimit[take],
        # A follower's torque reaches its leader times G, and its speed is the leader's times G.
        damping=(tree.gain**2).T @ model.damping,
        friction=np.abs(tree.gain).T @ model.friction,
        followers=followers,
        tree=tree,
        _model=model,
    )


def _reduced(model: pin.Model, held: Mapping[str, float]) -> pin.Model:
    """The model with these joints made fixed at these positions."""
    if not held:
        return model
    position = np.zeros(model.nq)
    indices = [model.getJointId(joint) for joint in held]
    for index, value in zip(indices, held.values(), strict=True):
        position[model.idx_qs[index]] = value
    return pin.buildReducedModel(model, indices, position)
