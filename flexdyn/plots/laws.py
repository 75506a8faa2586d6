"""draw_law: the law of an effect as a picture, with the parameters of its example; and its entry in a model file."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flexdyn.effects import DeflectionEffect, Effect, JointEffect, MemoryEffect, SensorEffect
from flexdyn.errors import InputError
from flexdyn.plots import arm_curves, drive_curves, friction_curves
from flexdyn.plots.page import GREY, checked_path, dress, new_figure, save_picture

Labels = tuple[str, str]
Drawing = Callable[[Any, Any], Labels]

_BY_KIND: tuple[tuple[type[Effect], Drawing], ...] = (
    (MemoryEffect, friction_curves.loop),
    (DeflectionEffect, drive_curves.deflection),
    (SensorEffect, drive_curves.sensor_curve),
)
_BY_STAGE: dict[str, Drawing] = {
    "friction": friction_curves.smooth,
    "dry": friction_curves.dry,
    "spring": drive_curves.spring,
    "link": drive_curves.link,
    "actuator": drive_curves.actuator,
}
_OF_THE_ARM: dict[str, Drawing] = {"inertia": arm_curves.needed_torque, "model": arm_curves.needed_torque}
"""Stages that change the arm itself: the drawing shows the torque that a joint needs."""


def draw_law(kind: type[Effect], path: str | Path) -> None:
    """Draw the law of an effect, with the parameters of its example.

    Dry laws are drawn set-valued, laws with memory as loops, laws of the motor over the commanded torque, its speed or
    angle, laws of sensors as the measured over the true value. Of what changes masses or other numbers of the arm, the
    torque is drawn that a joint needs.

    Args:
        kind: the effect's class, flexdyn's own or a user's.
        path: of the picture; its suffix is one of `SUFFIXES`.

    Raises:
        InputError: the effect has no law to draw, the suffix is not known, or the file cannot be written.
        MissingExtra: matplotlib is not installed.
    """
    file = checked_path(path)
    effect = kind.example()
    figure = law_figure(effect)
    _write_head(figure, effect)
    save_picture(figure, file)


def law_figure(effect: Effect) -> Any:
    """Matplotlib's figure of the law of an effect with its own parameters, without a title.

    Args:
        effect: to be drawn.

    Raises:
        InputError: the effect has no law to draw.
        MissingExtra: matplotlib is not installed.
    """
    draw = _drawing(type(effect))
    figure = new_figure()
    axes = figure.add_axes((0.13, 0.13, 0.83, 0.68))
    axes.margins(x=0.0, y=0.12)
    dress(axes, *draw(axes, effect))
    return figure


def _drawing(kind: type[Effect]) -> Drawing:
    if kind.stage == "actuator" and kind.late_by:
        return drive_curves.delayed_command
    if kind.stage in _OF_THE_ARM:
        return _OF_THE_ARM[kind.stage]
    for base, drawing in _BY_KIND:
        if issubclass(kind, base):
            return drawing
    if kind.no_torque or kind.stage not in _BY_STAGE or not issubclass(kind, JointEffect):
        remedy = kind.no_torque or None
        raise InputError("the effect has no law to draw", key="effect", value=kind.name, remedy=remedy)
    return _BY_STAGE[kind.stage]


def _write_head(figure: Any, effect: Effect) -> None:
    """Name, law and parameters."""
    values = ", ".join(f"{f.name} {getattr(effect, f.name):g} {_shown_unit(f)}".strip() for f in effect.parameters())
    figure.text(0.13, 0.93, effect.name.replace("_", " ").capitalize(), fontsize=14, fontweight="bold")
    size = min(8.5, 640 / max(1, len(effect.law)))
    figure.text(0.13, 0.885, effect.law, fontsize=size, family="monospace", color="#374151")
    figure.text(0.13, 0.845, values, fontsize=8.5, color=GREY)


def _shown_unit(field: dataclasses.Field[Any]) -> str:
    unit = str(field.metadata["unit"])
    # The examples of sensors measure a position.
    return {"1": "", "unit of the channel": "rad"}.get(unit, unit)


def example_entry(kind: type[Effect], joint: str, other: str = "OTHER_JOINT") -> dict[str, Any]:
    """An entry of a model file, to be copied.

    Args:
        kind: the effect's class.
        joint: name of the joint that it acts on.
        other: name of a second joint, if it needs one.
    """
    effect = kind.example(joint, other)
    if isinstance(effect, JointEffect):
        effect = dataclasses.replace(effect, side=kind.sides[-1])  # the motor's rather than the link's
    return effect.to_dict()
