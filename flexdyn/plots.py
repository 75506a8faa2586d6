"""Pictures: the laws of effects. Matplotlib is the extra ``plot`` and is imported when a picture is drawn."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.effects import Effect, JointEffect
from flexdyn.errors import InputError, MissingExtra
from flexdyn.files import replacing

Array = NDArray[np.float64]
SUFFIXES = (".png", ".pdf", ".svg")
"""Formats of pictures."""

EXAMPLES: Mapping[str, Mapping[str, float]] = {
    "viscous_friction": {"coefficient": 0.5},
    "coulomb_friction": {"level": 1.0},
    "stribeck_friction": {"excess": 0.5, "velocity": 0.1},
    "transmission_damping": {"coefficient": 2.0},
    "torque_offset": {"offset": 0.3},
    "torque_speed_limit": {"stall_torque": 1.0, "no_load_speed": 3.0},
    "payload": {"mass": 1.0},
}
"""Parameters that show what an effect does."""

_USUAL = {"N m": 1.0, "N m s/rad": 0.5, "N m/rad": 100.0, "rad": 0.01, "rad/s": 0.5, "s": 0.01}
ASKED = (-1.2, -0.6, 0.0, 0.6, 1.2)
"""Torques asked for in the pictures of actuator effects [N m]."""
_BLUE, _RED, _GREY = "#1f4e9c", "#c23b22", "#6b7280"


def example_values(kind: type[Effect]) -> dict[str, float]:
    """Parameters with which an effect shows what it does: those that have no default."""
    known = EXAMPLES.get(kind.name, {})
    return {
        field.name: known.get(field.name, _USUAL.get(field.metadata["unit"], 1.0))
        for field in kind.parameters()
        if field.default is dataclasses.MISSING or field.name in known
    }


def example_entry(kind: type[Effect], joint: str) -> dict[str, Any]:
    """An entry of a model file, to be copied.

    Args:
        kind: the effect's class.
        joint: the name of the joint it is to act on.
    """
    place: dict[str, Any] = {"effect": kind.name}
    if issubclass(kind, JointEffect):
        place |= {"joint": joint, "side": kind.sides[-1]}
    return place | example_values(kind)


def draw_law(kind: type[Effect], path: str | Path) -> None:
    """Draw the law of an effect, with example parameters.

    Dry laws are drawn set-valued, laws of the actuator as tau_applied over omega for several tau.

    Args:
        kind: the effect's class, flexdyn's own or a user's.
        path: of the picture; its suffix is one of `SUFFIXES`.

    Raises:
        InputError: the effect has no law over position or velocity, the suffix is not known, or the file cannot be
            written.
        MissingExtra: matplotlib is not installed.
    """
    file = Path(path)
    if file.suffix.lower() not in SUFFIXES:
        remedy = f"known: {', '.join(SUFFIXES)}"
        raise InputError("unknown suffix of a picture", file=file, value=file.suffix, remedy=remedy)
    if kind.stage not in _DRAWN or not issubclass(kind, JointEffect):
        remedy = "it changes M(q) and h(q, v) instead"
        raise InputError("the effect has no law to draw", key="effect", value=kind.name, remedy=remedy)
    effect = kind("joint", side=kind.sides[0], **example_values(kind))
    figure = _figure()
    axes = figure.add_axes((0.13, 0.13, 0.83, 0.68))
    _DRAWN[effect.stage](axes, effect)
    _dress(figure, axes, effect)
    with replacing(file) as fresh:
        figure.savefig(fresh, format=file.suffix.lower()[1:], dpi=200)


def _figure() -> Any:
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtra("matplotlib", "plot") from None
    return Figure(figsize=(6.4, 4.4))


def _span(effect: Effect) -> float:
    """How far the velocity axis goes: some times the speed that the law itself names."""
    speeds = [getattr(effect, field.name) for field in effect.parameters() if field.metadata["unit"] == "rad/s"]
    factor = 1.3 if effect.stage == "actuator" else 6.0
    return factor * max(speeds) if speeds else 1.0


def _draw_smooth(axes: Any, effect: JointEffect) -> None:
    u = np.linspace(-_span(effect), _span(effect), 801)
    axes.plot(u, effect.torque(0.0, u), color=_BLUE, linewidth=2.2)


def _draw_dry(axes: Any, effect: JointEffect) -> None:
    """Two branches and, at rest, every torque between them."""
    span = _span(effect)
    right = np.linspace(0.0, span, 801)[1:]
    right = np.concatenate([[span * 1e-9], right])
    upper, lower = effect.torque(0.0, right), effect.torque(0.0, -right)
    axes.plot(right, upper, color=_BLUE, linewidth=2.2)
    axes.plot(-right, lower, color=_BLUE, linewidth=2.2)
    axes.plot([0.0, 0.0], [lower[0], upper[0]], color=_RED, linewidth=2.6, solid_capstyle="butt", zorder=3)
    axes.annotate(
        "at rest: any torque\nbetween the two ends",
        (0.0, 0.45 * lower[0]),
        (0.16 * span, 0.6 * lower[0]),
        color=_RED,
        va="center",
        arrowprops={"arrowstyle": "-", "color": _RED, "linewidth": 0.8, "shrinkB": 2.0},
    )


def _draw_actuator(axes: Any, effect: JointEffect) -> None:
    """tau_applied over omega, one curve for each torque asked for."""
    omega = np.linspace(-_span(effect), _span(effect), 801)
    shades = ("#7f1d1d", "#d97757", _GREY, "#6ea0dc", _BLUE)
    for tau, shade in zip(ASKED, shades, strict=True):
        axes.axhline(tau, color=shade, linewidth=0.8, linestyle=(0, (3, 3)))
        axes.plot(omega, effect.torque(0.0, omega, tau=tau), color=shade, linewidth=2.2, label=f"{tau:g} N m")
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(
        handles[::-1], labels[::-1], title="asked (dashed)", frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5)
    )
    axes.set_position((0.13, 0.13, 0.64, 0.68))


_DRAWN: Mapping[str, Callable[[Any, Any], None]] = {
    "friction": _draw_smooth,
    "spring": _draw_smooth,
    "dry": _draw_dry,
    "actuator": _draw_actuator,
}


def _labels(effect: JointEffect) -> tuple[str, str]:
    if effect.stage == "actuator":
        return r"rotor velocity $\omega$ [rad/s]", r"$\tau_\mathrm{applied}$ [N m]"
    if effect.stage == "spring":
        return r"$\omega - v$ [rad/s]", r"torque in the transmission [N m]"
    return "velocity $u$ of the link or rotor [rad/s]", "friction torque [N m]"


def _dress(figure: Any, axes: Any, effect: JointEffect) -> None:
    """Title, law, parameters, units, and no more ink than that."""
    across, up = _labels(effect)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.axhline(0.0, color="#111827", linewidth=0.7, zorder=0)
    axes.axvline(0.0, color="#111827", linewidth=0.7, zorder=0)
    axes.grid(color="#e5e7eb", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.locator_params(axis="x", nbins=7)
    axes.margins(x=0.0, y=0.12)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    values = ", ".join(f"{f.name} {getattr(effect, f.name):g} {_shown_unit(f)}".strip() for f in effect.parameters())
    figure.text(0.13, 0.93, effect.name.replace("_", " ").capitalize(), fontsize=14, fontweight="bold")
    figure.text(0.13, 0.885, effect.law, fontsize=min(8.5, 640 / len(effect.law)), family="monospace", color="#374151")
    figure.text(0.13, 0.845, values, fontsize=8.5, color=_GREY)


def _shown_unit(field: dataclasses.Field[Any]) -> str:
    unit = str(field.metadata["unit"])
    return "" if unit == "1" else unit
