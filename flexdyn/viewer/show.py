"""Make the page from motions: which arm is solid, which is translucent, what is magnified, and the texts beside."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.plots.page import BLUE
from flexdyn.robot import frame_positions
from flexdyn.viewer.bodies import bodies_of
from flexdyn.viewer.layout import Extent, arm_size, extent
from flexdyn.viewer.motion import Frames, PlayedMotion, checked_factor, frames_of, magnification
from flexdyn.viewer.page import floats, viewer_page
from flexdyn.viewer.scene import ARM, GHOST, SILVER, VIOLET, ArmScene, NodeMove, commands_of
from flexdyn.viewer.solids import NEEDLE

COLUMNS = {"q": "q", "deflection": "\u03b8 \u2212 q", "difference": "\u0394q"}
"""Heads of the page's table by series."""
GHOSTLY = {
    "color": int(VIOLET[1:], 16),
    "opacity": 0.42,
    "transparent": True,
    # Where both arms coincide, the solid one is drawn in front, to avoid flicker.
    "polygonOffset": True,
    "polygonOffsetFactor": 4,
    "polygonOffsetUnits": 800,
}
"""The second arm's material, as three.js describes it."""
SHOWN_ANGLE = math.radians(25.0)
"""Approximate size of the largest magnified deflection of a revolute joint [rad]."""
SHOWN_SHARE = 0.1
"""The same for a prismatic joint, as a share of the arm's size [1]."""


def about_it(
    model: FlexibleJointModel, frames: Frames, size: float, box: Extent, tips: Sequence[Array]
) -> dict[str, Any]:
    """Time, table and view.

    Args:
        model: of the arm.
        frames: its motion.
        size: of the arm [m].
        box: that contains it at all times.
        tips: paths of the tip, of the second arm too if there is one.
    """
    times, series = frames.arm.t, _series(frames, tips)
    return {
        "size": size,
        "grid": _grid(size, box),
        "box": {"low": box.low.tolist(), "high": box.high.tolist()},
        "view": _view(box),
        "start": float(times[0]),
        "duration": float(times[-1] - times[0]),
        "rate": frames.rate,
        "ghost": None if frames.ghost is None else {"material": GHOSTLY},
        "joints": _rows(model),
        "columns": [name for name in COLUMNS if name in series],
        "heads": ["joint", *(_head(name, model) for name in COLUMNS if name in series)],
        "series": series,
    }


def legend_parts(frames: Frames, frame: str, factors: Mapping[str, float], dials: Sequence[str]) -> dict[str, Any]:
    """The parts of the picture, each with the nodes of the scene that its check box hides.

    Args:
        frames: motions of the arms.
        frame: name of the tip.
        factors: magnification by unit.
        dials: nodes of the dials.
    """
    entries: list[tuple[str, str, list[str]]] = [(SILVER, f"arm: {frames.arm.label}", [ARM])]
    second, traces = "", ["trace"]
    if frames.ghost is not None:
        entries.append((VIOLET, f"translucent: {frames.ghost.label}", [GHOST]))
        second, traces = ", in violet that of the translucent arm", ["trace", "ghost_trace"]
    if factors:
        entries.append((NEEDLE, f"rotor against the mark of its link; {_magnified(factors)}", list(dials)))
    if len(frames.arm.t) > 1:
        entries.append((BLUE, f"path of {frame}{second}", traces))
    shown = [{"color": color, "text": text, "paths": paths} for color, text, paths in entries]
    return {"legend": shown, "magnified": _magnified(factors)}


def _magnified(factors: Mapping[str, float]) -> str:
    """The text about magnification; empty if nothing is magnified."""
    several = len(factors) > 1
    each = [f"{factor:g}\u00d7{f' [{unit}]' if several else ''}" for unit, factor in factors.items()]
    return f"\u03b8 \u2212 q magnified {' and '.join(each)}" if each else ""


def _series(frames: Frames, tips: Sequence[Array]) -> dict[str, str]:
    """Numbers of the table, frame by frame, and the distance of the tips [m]."""
    found = {"q": floats(frames.arm.q)}
    if np.isfinite(frames.arm.deflection).any():
        found["deflection"] = floats(frames.arm.deflection)
    if frames.ghost is not None:
        found["difference"] = floats(frames.ghost.q - frames.arm.q)
        found["gap"] = floats(np.linalg.norm(tips[1] - tips[0], axis=1))
    return found


def _rows(model: FlexibleJointModel) -> list[str]:
    """Names of the joints, with the unit if the joints have different units."""
    names, kinds = model.joint_names, model.robot.kinds
    sliding = {"prismatic"} if len(set(kinds)) > 1 else set()
    return [f"{name} [m]" if kind in sliding else name for name, kind in zip(names, kinds, strict=True)]


def _head(name: str, model: FlexibleJointModel) -> str:
    units = dict.fromkeys(model.robot.angle_unit(j) for j in range(model.n))
    thousandth = "" if name == "q" else "m"
    return f"{COLUMNS[name]} [{', '.join(thousandth + unit for unit in units)}]"


def _grid(size: float, box: Extent) -> dict[str, float]:
    """A grid with cells of 1, 2, 5, ..., at most a quarter of the arm; on the ground, or below the lowest part."""
    power = 10.0 ** np.floor(np.log10(size / 4.0))
    cell = max(step * power for step in (1, 2, 5) if step * power <= size / 4.0)
    return {"cell": float(cell), "height": min(0.0, float(box.low[2]))}


def _view(box: Extent) -> list[float]:
    """The point of view; for a motion in a plane it is in front of that plane."""
    wide = box.high - box.low
    thin = int(np.argmin(wide))
    if wide[thin] > 0.3 * np.median(wide):
        return [1.0, -1.3, 0.9]
    return [[1.6, -0.6, 0.5], [0.5, -1.6, 0.5], [0.2, -0.9, 1.3]][thin]


def motion_page(
    model: FlexibleJointModel, motion: PlayedMotion, ghost: PlayedMotion | None = None, magnify: float | None = None
) -> str:
    """The page of a motion.

    Args:
        model: of the arm.
        motion: of the arm.
        ghost: motion of a translucent second arm.
        magnify: factor of theta - q; default: one that fits the largest deflection.

    Raises:
        InputError: two motions without a common time, or a factor that is not allowed.
    """
    robot, frames = model.robot, frames_of(motion, ghost)
    size = arm_size(robot, frames.everywhere)
    bodies, notes = bodies_of(robot, size)
    factors = _factors(model, motion, size, magnify)
    scene = ArmScene(robot, size)
    scene.add_bodies(bodies)
    frame = robot.last_frame
    tips = [frame_positions(robot, each.q, frame) for each in (frames.arm, frames.ghost) if each is not None]
    place = robot.frame(frame)
    scene.add_tip(place.joint, place.translation)
    for name, points, color in zip(("trace", "ghost_trace"), tips, (BLUE, VIOLET), strict=False):
        scene.add_trace(name, points, color)
    dialled = [j for j in range(model.n) if _known(motion, j)]
    scene.commands.extend(commands_of(_moves(model, frames, dialled, factors, scene), frames.rate))
    about = about_it(model, frames, size, extent(robot, frames.everywhere, bodies), tips)
    about |= legend_parts(frames, frame, factors, scene.dials)
    samples = len(motion.t)
    if len(frames.arm.t) < samples:
        notes += (f"{len(frames.arm.t)} of {samples} samples are in the page, {frames.rate:.4g} in a second",)
    about["notes"] = [*motion.notes, *(() if ghost is None else ghost.notes), *notes]
    return viewer_page(motion.label, about, scene.commands)


def _factors(model: FlexibleJointModel, motion: PlayedMotion, size: float, magnify: float | None) -> dict[str, float]:
    """Magnification by unit, for joints whose rotor is shown."""
    given = None if magnify is None else checked_factor(magnify)
    found = {}
    for unit, shown in (("rad", SHOWN_ANGLE), ("m", SHOWN_SHARE * size)):
        columns = [j for j in range(model.n) if model.robot.angle_unit(j) == unit and _known(motion, j)]
        if columns:
            found[unit] = given or magnification(motion.deflection[:, columns], shown)
    return found


def _known(motion: PlayedMotion, j: int) -> bool:
    return bool(np.isfinite(motion.deflection[:, j]).any())


def _moves(
    model: FlexibleJointModel, frames: Frames, dialled: list[int], factors: dict[str, float], scene: ArmScene
) -> list[NodeMove]:
    """The motions of all nodes; adds the dials."""
    robot = model.robot
    moves = scene.arm_moves(ARM, robot.expand(frames.arm.q))
    if frames.ghost is not None:
        moves += scene.arm_moves(GHOST, robot.expand(frames.ghost.q))
    names = list(robot.pin_model.names)[1:]
    for j in dialled:
        shown = factors[robot.angle_unit(j)] * frames.arm.deflection[:, j]
        moves.append(scene.add_dial(names.index(model.joint_names[j]), shown))
    return moves
