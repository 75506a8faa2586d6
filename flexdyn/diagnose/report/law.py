"""The law of a finding, drawn with its estimated numbers."""

from __future__ import annotations

import dataclasses
import io
import re
from typing import Any

from flexdyn.diagnose.report.suspects import Suspect
from flexdyn.effects import Effect, catalogue
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.plots.laws import law_figure

FONTS = ["DejaVu Sans", "Arial"]
LAW_PICTURE_SIZE = (5.0, 3.6)
"""Width and height of a law's picture [inch]: the letters are as large as those beside it."""


def effect_of(suspect: Suspect) -> Effect | None:
    """The effect with its estimated numbers; None where some were not estimated, or make no sense."""
    kind = catalogue().get(suspect.effect)
    if kind is None:
        return None
    given: dict[str, Any] = {"joint": suspect.joint, "side": suspect.side, **suspect.place}
    given |= {name: number.value for name, number in suspect.parameters.items()}
    known = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    try:
        effect = kind.from_dict({key: value for key, value in given.items() if key in known and value is not None})
    except InputError:
        return None
    return None if effect.is_neutral else effect


def law_picture(suspect: Suspect, model: FlexibleJointModel) -> str | None:
    """The law with its fitted numbers, as an SVG picture.

    None where the effect has no law to draw.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    effect = effect_of(suspect)
    joint = suspect.joint
    slides = joint in model.joint_names and model.robot.angle_unit(str(joint)) == "m"
    try:
        figure = None if effect is None else law_figure(effect, prismatic=slides)
    except InputError:
        return None
    if figure is None:
        return None
    import matplotlib

    figure.set_size_inches(LAW_PICTURE_SIZE)
    stream = io.BytesIO()
    # Letters as outlines would take four fifths of the room.
    with matplotlib.rc_context({"svg.hashsalt": "flexdyn", "svg.fonttype": "none", "font.sans-serif": FONTS}):
        figure.savefig(stream, format="svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.05)
    return _short(stream.getvalue().decode())


def _short(svg: str) -> str:
    """The same picture in a third of the letters: no metadata, no indents, places to a hundredth of a point."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"\s*\n\s*", " ", svg).replace("> <", "><")
    return re.sub(r"\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}", svg)
