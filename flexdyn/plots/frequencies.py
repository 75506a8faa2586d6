"""draw_frequencies: eigenfrequencies of an arm over a path as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.analysis.path import PathFrequencies
from flexdyn.errors import InputError
from flexdyn.plots.page import BLUE, GREY, checked_path, dress, line, new_figure, save_picture

LOGARITHMIC_SPAN = 12.0
"""A larger ratio of frequencies is drawn on a logarithmic axis [1]."""
DEEP = 200.0
"""Modes below the largest frequency by more than this factor are not shown: they are swings under gravity [1]."""
LABEL_DISTANCE = 0.04
"""Smallest distance of two names at the right end, as a share of the axis [1]."""


def draw_frequencies(found: PathFrequencies, path: str | Path) -> None:
    """Draw eigenfrequencies over the length of a path.

    Modes that are mostly below 1/200 of the greatest frequency are left out: rigid-body ones, swings under gravity.

    Args:
        found: by `frequencies_over_path`.
        path: of the picture; its suffix is one of `SUFFIXES`.

    Raises:
        InputError: there is no vibration, the suffix is not known, or the file cannot be written.
        MissingExtra: matplotlib is not installed.
    """
    file = checked_path(path)
    least = found.frequencies.max() / DEEP
    shown = np.where(found.frequencies > 0.0, found.frequencies, np.nan)
    modes = {k + 1: shown[:, k] for k, typical in enumerate(np.median(found.frequencies, axis=0)) if typical > least}
    if not modes:
        raise InputError("nothing vibrates along the path", file=file, remedy="give joints a stiffness")
    figure = new_figure()
    axes = figure.add_axes((0.13, 0.13, 0.78, 0.72))
    shades = {mode: _shade(place / max(1, len(modes) - 1)) for place, mode in enumerate(modes)}
    alone = {"marker": "o", "markersize": 5.0} if len(found.q) == 1 else {}
    for mode, column in modes.items():
        line(axes, found.distance, column, color=shades[mode], **alone)
    values = np.concatenate(list(modes.values()))
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if high > LOGARITHMIC_SPAN * low:
        axes.set_yscale("log")
        axes.set_ylim(low / 1.2, high * 1.3)
    else:
        axes.set_ylim(0.0, 1.08 * high)
    axes.margins(x=0.0)
    dress(axes, "length of the path in joint space [rad]", "eigenfrequency [Hz]")
    _name(axes, {mode: float(column[-1]) for mode, column in modes.items() if np.isfinite(column[-1])}, shades)
    figure.text(0.13, 0.93, "Eigenfrequencies over the path", fontsize=14, fontweight="bold")
    many = f"{len(found.q)} poses" if len(found.q) > 1 else "one pose"
    under = f"{many} of {', '.join(found.joint_names)}; rotors {found.rotors}"
    figure.text(0.13, 0.885, under, fontsize=min(8.5, 640 / len(under)), color=GREY)
    save_picture(figure, file)


def _name(axes: Any, ends: dict[int, float], shades: dict[int, Any]) -> None:
    """Write the number of every mode at its right end, moved up where two would overlap."""
    to_axes = axes.transData + axes.transAxes.inverted()
    last = -1.0
    for mode, frequency in ends.items():
        last = max(float(to_axes.transform((0.0, frequency))[1]), last + LABEL_DISTANCE)
        axes.text(1.012, last, f"{mode}", transform=axes.transAxes, va="center", color=shades[mode])


def _shade(share: float) -> tuple[float, ...]:
    """A blue from dark to pale."""
    darkest = (int(BLUE[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return tuple((1.0 - 0.65 * share) * c + 0.65 * share for c in darkest)
