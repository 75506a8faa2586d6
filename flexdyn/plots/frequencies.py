"""draw_frequencies: eigenfrequencies of an arm over a path as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.analysis import PathFrequencies
from flexdyn.plots.page import BLUE, GREY, WIDE, checked_path, dress, new_figure, save

FAR = 12.0
"""A span of frequencies wider than this factor is drawn on a logarithmic axis."""


def draw_frequencies(found: PathFrequencies, path: str | Path) -> None:
    """Draw eigenfrequencies over the length of a path; rigid-body and falling modes, at 0 Hz, are left out.

    Args:
        found: by `frequencies_over_path`.
        path: of the picture; its suffix is one of `SUFFIXES`.

    Raises:
        InputError: the suffix is not known, or the file cannot be written.
        MissingExtra: matplotlib is not installed.
    """
    file = checked_path(path)
    figure = new_figure()
    axes = figure.add_axes((0.13, 0.13, 0.76, 0.72))
    vibrating = np.where(found.frequencies > 0.0, found.frequencies, np.nan)
    kept = [column for column in vibrating.T if np.isfinite(column).any()]
    for k, column in enumerate(kept):
        share = k / max(1, len(kept) - 1)
        _curve(axes, found.distance, column, f"{k + 1}", share)
    values = np.concatenate(kept) if kept else np.ones(1)
    if np.nanmax(values) > FAR * np.nanmin(values):
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.0, 1.08 * np.nanmax(values))
    axes.margins(x=0.0)
    dress(axes, "length of the path in joint space [rad]", "eigenfrequency [Hz]")
    figure.text(0.13, 0.93, "Eigenfrequencies over the path", fontsize=14, fontweight="bold")
    ends = f"{len(found.q)} poses of {', '.join(found.joint_names)}; rotors {found.rotors}"
    figure.text(0.13, 0.885, ends, fontsize=min(8.5, 640 / len(ends)), color=GREY)
    save(figure, file)


def _curve(axes: Any, distance: Any, column: Any, name: str, share: float) -> None:
    """One mode, named at its right end."""
    shade = tuple((1.0 - 0.65 * share) * c + 0.65 * share for c in _rgb(BLUE))
    alone = {"marker": "o", "markersize": 5.0} if len(distance) == 1 else {}
    axes.plot(distance, column, color=shade, linewidth=WIDE, **alone)
    last = int(np.flatnonzero(np.isfinite(column))[-1])
    axes.annotate(name, (distance[last], column[last]), (6, 0), textcoords="offset points", va="center", color=shade)


def _rgb(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
