"""model.yaml <-> FlexibleJointModel, validated: every mistake is one line that names file, key and remedy.

A saved run has the text of such a file in its meta data.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexdyn.errors import InputError, did_you_mean, placed, printable
from flexdyn.io.files import exists, is_file, relative, write_text
from flexdyn.io.locked import thawed
from flexdyn.io.yaml import check_format, check_keys, dump_yaml, parse_yaml, read_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.given_number import UNKNOWN, links_entry
from flexdyn.model.setting_checks import check_tolerance_paths
from flexdyn.model.stated_tolerances import known_tolerances, unknown_masses, unknown_of_motors, unknown_parameters
from flexdyn.records import Recording
from flexdyn.robot import Robot, load_robot, robot_names
from flexdyn.robot.axes import plain_axes
from flexdyn.robot.names import shipped_dir

MODEL_FORMAT = 1
ROBOT_SUFFIXES = (".urdf", ".xml", ".xacro")
TOP_KEYS = ("robot", "joints", "links", "initial", "tolerance", "effects", "command")
ROBOT_KEYS = ("urdf", "package_dirs", "gravity", "lock", "axes", "urdf_dynamics", "rotor_coupling")
NAME_IT = "name it: model=..., on the command line --model MODEL"
"""The remedy if a recording does not say which arm it belongs to."""


def shipped_models() -> tuple[str, ...]:
    """Names of the models that come with flexdyn.

    Example:
        >>> fd.shipped_models()
        ('panda', 'scara', 'scara_two_link', 'ur5')
    """
    return tuple(sorted(path.parent.name for path in shipped_dir().glob("*/model.yaml")))


def load_model(path: str | Path) -> FlexibleJointModel:
    """Read a model file.

    Args:
        path: of a model.yaml, or the name of a shipped model (``scara_two_link``, ``scara``, ``panda``, ``ur5``).

    Raises:
        InputError: no such file, or an entry in it that does not fit.

    Example:
        >>> model = fd.load_model("scara_two_link")
        >>> model.joint_names
        ('shoulder', 'elbow')
    """
    file = _find(path)
    name = file.parent.name if file.name == "model.yaml" else file.stem
    with placed(file=file):
        return model_from_dict(read_yaml(file), file.parent, name=name)


def model_from_dict(content: Mapping[str, Any], folder: Path, *, name: str = "") -> FlexibleJointModel:
    """Make the model that a file's mapping describes.

    Args:
        content: keys of the model file.
        folder: its relative paths start here.
        name: of the model; default: the robot's.

    Raises:
        InputError: a key, joint, effect or number that does not fit.
    """
    check_format(content, "flexdyn", MODEL_FORMAT, TOP_KEYS, required=("robot",))
    entry = content["robot"]
    check_keys(entry, ROBOT_KEYS, required=("urdf",), key="robot")
    for key, kind in (("package_dirs", list), ("lock", Mapping)):
        if entry.get(key) is not None and not isinstance(entry[key], kind):
            shape = "a list of folders" if kind is list else "a mapping JOINT: position"
            raise InputError(f"{shape} is needed", key=f"robot.{key}", value=entry[key])
    effects = [] if content.get("effects") is None else content["effects"]
    if not isinstance(effects, list):
        raise InputError("a list of effects is needed", key="effects", value=effects)
    settings = {key: entry[key] for key in ("gravity", "urdf_dynamics", "rotor_coupling") if entry.get(key) is not None}
    others = ("links", "initial", "tolerance", "command")
    settings |= {key: content[key] for key in others if content.get(key) is not None}
    model = FlexibleJointModel(_robot(entry, folder), content.get("joints"), effects, name=name, **settings)
    check_tolerance_paths(content.get("tolerance"), model.joint_names, model.robot.frame_names, model.effects)
    return model


def save_model(model: FlexibleJointModel, path: str | Path) -> None:
    """Write a model file that can be read back without loss; it is written completely or not at all.

    Args:
        model: to be written; effects that come from its URDF stay in the URDF.
        path: of the file; it names the URDF relative to its folder.

    Raises:
        InputError: the robot came from a pin.Model and has no URDF, or the file cannot be written.

    Example:
        >>> fd.save_model(fd.load_model("ur5").replace(tolerance=0.1), "mine.yaml")
        >>> fd.load_model("mine.yaml").n
        6
    """
    file = Path(path)
    title = printable(model.name)
    head = f"# {title}: a flexdyn model. SI units; rotor_inertia on the motor side, everything else reflected.\n"
    write_text(file, head + dump_yaml(model_to_dict(model, file.parent)))


def model_to_dict(model: FlexibleJointModel, folder: Path | None = None) -> dict[str, Any]:
    """The mapping of a model file.

    Args:
        model: to be described.
        folder: paths are written relative to it; None: absolute paths.

    Raises:
        InputError: the robot has no URDF.
    """
    robot: dict[str, Any] = {"urdf": _source(model.robot, folder)}
    if model.robot.package_dirs:
        robot["package_dirs"] = [_path(Path(directory), folder) for directory in model.robot.package_dirs]
    robot["gravity"] = list(model.gravity)
    if model.robot.lock:
        robot["lock"] = dict(model.robot.lock)
    if model.robot.axes:
        robot["axes"] = plain_axes(model.robot.axes)
    robot |= {"urdf_dynamics": model.urdf_dynamics, "rotor_coupling": model.rotor_coupling}
    effects, links = [effect.to_dict() for effect in model.effects], links_entry(model.links)
    joints = {name: joint.to_dict() for name, joint in model.joints.items()}
    for name, number in unknown_of_motors(model.tolerance, model.joints):
        joints[name]["actuator"]["dc_motor"][number] = UNKNOWN
    for i, name in unknown_parameters(model.tolerance, model.effects):
        effects[i][name] = UNKNOWN
    for link in unknown_masses(model.tolerance, model.robot.frame_names):
        links[link] = {**links.get(link, {}), "mass": UNKNOWN}
    content = {
        "flexdyn": MODEL_FORMAT,
        "robot": robot,
        "joints": joints,
        "initial": {signal: dict(values) for signal, values in model.initial.items()},
        "tolerance": known_tolerances(model.tolerance),
        "effects": effects,
    }
    if links:
        content["links"] = links
    return content if model.command is None else content | {"command": thawed(model.command)}


def _find(path: Any) -> Path:
    """The file that a path or a shipped model's name means; else an error that says what to do instead."""
    if not isinstance(path, str | os.PathLike):
        remedy = "a robot becomes one by FlexibleJointModel(robot)" if isinstance(path, Robot) else None
        raise InputError("the path of a model.yaml is needed", key="model", value=path, remedy=remedy)
    file = Path(path)
    if file.suffix.lower() in ROBOT_SUFFIXES or (not is_file(file) and is_robot(str(path))):
        raise InputError("a robot is no model yet", file=str(path), remedy=_becomes_model(str(path)))
    if is_file(file):
        return file
    shipped = shipped_dir() / str(path) / "model.yaml"
    if len(file.parts) == 1 and exists(shipped):
        return shipped
    if exists(file):
        raise InputError("it is not a file", file=str(path), remedy="give the path of a model.yaml")
    if file.suffix.lower() in (".yaml", ".yml") or len(file.parts) > 1:
        raise InputError("there is no such file", file=str(path))
    remedy = did_you_mean(str(path), shipped_models())
    raise InputError("no such model file or shipped model", key=str(path), remedy=remedy)


def is_robot(name: str) -> bool:
    """Whether a robot has this name and no model does."""
    return name in robot_names() and name not in shipped_models()


def _becomes_model(robot: str) -> str:
    """How to make a model from a robot, in Python and as a file."""
    stem = Path(robot).stem
    python = f"fd.FlexibleJointModel(fd.load_robot({robot!r}), joints={{...}})"
    return f"make one of it: {python}, or flexdyn new {robot} -o {stem}.yaml and load that"


def _robot(entry: Mapping[str, Any], folder: Path) -> Robot:
    """The robot of a model file, its paths relative to the folder; errors name the key in the file."""
    urdf = entry["urdf"]
    if not isinstance(urdf, str) or not urdf:
        raise InputError("the path or name of a URDF is needed", key="robot.urdf", value=urdf)
    file = folder / urdf
    if not is_file(file) and ("/" in urdf or urdf.lower().endswith(ROBOT_SUFFIXES)):
        raise InputError("there is no such file", key="robot.urdf", value=urdf, remedy=f"it is looked for in {folder}")
    source = file.resolve() if is_file(file) else urdf  # one name for each file, so that models of it compare equal
    package_dirs = [folder / str(directory) for directory in entry.get("package_dirs") or []]
    for i, directory in enumerate(package_dirs):
        if not exists(directory):
            raise InputError("no such folder", key=f"robot.package_dirs[{i}]", value=str(directory))
    try:
        robot = load_robot(source, package_dirs=package_dirs, lock=entry.get("lock"))
        ignored = entry.get("urdf_dynamics") == "ignore"
        return robot if entry.get("axes") is None else robot.with_axes(entry["axes"], ignore_dynamics=ignored)
    except InputError as error:
        if error.file or str(error.key).startswith("robot.axes"):
            raise
        if error.key == "robot":
            raise InputError(error.problem, **error.data | {"key": "robot.urdf"}) from None
        raise error.at(key="robot") from None


def _source(robot: Robot, folder: Path | None) -> str:
    """How a model file names its URDF: a known name, else a path."""
    if robot.source is None:
        remedy = "write the URDF and load the robot from it"
        raise InputError("the robot came from a pin.Model and has no URDF to name", key="robot.urdf", remedy=remedy)
    return robot.source if isinstance(robot.source, str) else _path(robot.source, folder)


def _path(path: Path, folder: Path | None) -> str:
    return path.resolve().as_posix() if folder is None else relative(path.resolve(), folder)


def model_in(recording: Recording) -> FlexibleJointModel | None:
    """The model in the meta data of a run's recording; None if there is none.

    Raises:
        InputError: the text is no model, or its URDF does not exist any more.
    """
    text = recording.meta.get("model")
    if text is None:
        return None
    try:
        if not isinstance(text, str):
            raise InputError("the text of a model file is needed", value=text)
        return model_from_dict(parse_yaml(text), Path.cwd(), name=recording.name)
    except InputError as error:
        problem = f"the model that the recording holds cannot be read: {error.problem}"
        raise InputError(problem, **{**error.data, "remedy": NAME_IT}) from None
