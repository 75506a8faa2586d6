"""plot: motions as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from flexdyn.checks import check_known
from flexdyn.errors import FlexdynError, InputError, listed
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model
from flexdyn.plots.arrange import Block, arrange
from flexdyn.plots.energy_view import energy_panels
from flexdyn.plots.panel import Panel, short
from flexdyn.plots.picture import Picture
from flexdyn.plots.scene import PlotScene, make_scene
from flexdyn.plots.thinning import MOST_CURVE_POINTS
from flexdyn.plots.views import RESIDUAL, VIEWS, View, grid, keys_of, panel_of, residual_of, shows

OVERVIEW = ("positions", "deflection", "torques", "energy")
"""Default views."""
VIEW_NAMES = (*VIEWS, "energy")
NO_ENERGY = "No energy"
MOST_VIEW_ROWS = 8
"""Largest number of joints on a page of several views."""
MOST_PANELS = 40
"""Largest number of joints on a page of one view."""


def plot(
    *runs: Any,
    path: str | Path | None = None,
    views: Sequence[str] | str | None = None,
    joints: Sequence[str] | str | None = None,
    start: float | None = None,
    end: float | None = None,
    model: FlexibleJointModel | str | Path | None = None,
) -> Picture:
    """Draw runs and recordings: a row of panels for each joint, the energy below.

    Several motions are drawn over one another, measured ones in grey below simulated ones. Under every panel over time
    are the differences from the first motion, with their RMS (computed as in `fd.compare`). Of a recording with more
    than 6000 samples, the first, last, smallest and largest of 1500 slices of time are drawn: no peak is lost.

    Args:
        runs: runs, recordings, or paths of recordings; it is best to give a measurement first.
        path: of a file to write, if given: .png, .pdf, .svg by Matplotlib, .html (interactive, offline) by Plotly.
        views: of ``positions``, ``velocities``, ``deflection``, ``torques``, ``energy``, ``phase`` (v over q, omega
            over theta), ``loops`` (tau_s over deflection), ``temperature``. Default: positions, deflection, torques,
            energy, if there are such signals.
        joints: to be drawn; default: all, but not more than 8 on a page of several views.
        start: of the window of time [s]; default: the beginning.
        end: of the window of time [s]; default: the end.
        model: that was simulated, or its file or name: for the energy of a saved run without its model (CSV).

    Returns:
        The picture: ``show()`` opens it in the browser, ``save(path)`` writes it; a notebook shows it by itself.

    Raises:
        InputError: nothing to draw, a joint or view that is not there, an empty window, an unknown suffix.
        MissingExtra: matplotlib or plotly is not installed.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> picture = fd.plot(run, path="run.html", views=["positions"], joints="elbow")
    """
    wanted = _checked_views(views)
    scene = make_scene(runs, [joints] if isinstance(joints, str) else joints, start, end)
    arm = model if model is None or isinstance(model, FlexibleJointModel) else load_model(model)
    notes = [_described(scene, place) for place in range(min(4, len(scene.sources)))]
    drawn, energy = _drawable(scene, wanted, arm, notes, chosen=views is not None)
    scene = _bounded(scene, drawn, notes, chosen=joints is not None)
    blocks = _joint_blocks(scene, drawn)
    panels = [panel for block in blocks for row in block.rows for panel in row]
    keys = keys_of(scene, drawn, panels) if blocks else ()
    _note_residuals(scene, panels, notes)
    blocks += energy
    if not blocks:
        problem = f"there is nothing to draw of {', '.join(wanted)}"
        why = next((note for note in notes if note.startswith(NO_ENERGY)), f"the channels are {_some_channels(scene)}")
        raise InputError(problem, key="views", remedy=why)
    _note_thinning(scene, notes)
    title = " and ".join(short(source.name) for source in scene.sources[:3])
    title += f" and {len(scene.sources) - 3} more" if len(scene.sources) > 3 else ""
    picture = arrange(title, notes, keys, blocks)
    if path is not None:
        picture.save(path)
    return picture


def _checked_views(views: Sequence[str] | str | None) -> tuple[str, ...]:
    names = OVERVIEW if views is None else (views,) if isinstance(views, str) else tuple(dict.fromkeys(views))
    for name in names:
        check_known(name, VIEW_NAMES, "no such view", key="views", value=name)
    if not names:
        raise InputError("no view is chosen", key="views", remedy=f"known: {', '.join(VIEW_NAMES)}")
    return names


def _drawable(
    scene: PlotScene, wanted: Sequence[str], model: FlexibleJointModel | None, notes: list[str], *, chosen: bool
) -> tuple[list[View], list[Block]]:
    """The views for which there are signals, and the energy; missing ones are noted."""
    drawn, missing, energy = [], [], []
    for name in wanted:
        if name in VIEWS and shows(scene, VIEWS[name]):
            drawn.append(VIEWS[name])
        elif name in VIEWS:
            missing.append(name)
        else:
            energy = _energy(scene, model, notes)
    if missing and chosen:
        notes.append(f"Not drawn, because there are no such signals: {', '.join(missing)}.")
    return drawn, energy


def _energy(scene: PlotScene, model: FlexibleJointModel | None, notes: list[str]) -> list[Block]:
    """Energies of every simulated motion; if one has none, a note says why."""
    rows: list[tuple[Panel | None, ...]] = []
    heights: list[float] = []
    for place, source in enumerate(scene.sources):
        if source.measured:
            continue
        try:
            panels = energy_panels(scene, place, model)
        except FlexdynError as error:
            notes.append(f"{NO_ENERGY} of {short(source.name)}: {str(error).rstrip('.')}.")
            continue
        rows += [(replace(panel, labelled=panel is panels[-1]),) for panel in panels]
        heights += (1.7, 1.7, 0.9)[: len(panels)]
    return [Block(tuple(rows), tuple(heights))] if rows else []


def _bounded(scene: PlotScene, drawn: Sequence[View], notes: list[str], *, chosen: bool) -> PlotScene:
    """The scene with at most as many joints as fit on a page, unless they were chosen by name."""
    most = MOST_PANELS if len(drawn) == 1 else MOST_VIEW_ROWS
    count = len(scene.joints)
    if chosen or count <= most:
        return scene
    notes.append(f"The first {most} of {count} joints; choose others by name, or one view for more on a page.")
    return replace(scene, joints=scene.joints[:most])


def _joint_blocks(scene: PlotScene, drawn: Sequence[View]) -> list[Block]:
    """Panels joint by joint: a grid of one view, or a row for each joint with a column for each view."""
    if not drawn:
        return []
    timed = any(not view.across for view in drawn)
    if len(drawn) == 1 and (len(scene.sources) == 1 or not timed):
        panels = [panel for joint in scene.joints if (panel := panel_of(scene, drawn[0], joint)) is not None]
        columns, width, height = _grid_shape(len(panels))
        return [grid(panels, columns, width, height if timed else max(height, 2.0))]
    width = {1: 6.3, 2: 4.6}.get(len(drawn), 3.5)
    height = 2.2 if len(scene.joints) <= 2 else 1.55
    rows: list[tuple[Panel | None, ...]] = []
    heights: list[float] = []
    for joint in scene.joints:
        above = [panel_of(scene, view, joint) for view in drawn]
        beneath = [None if view.across else residual_of(scene, view, joint) for view in drawn]
        rows.append(tuple(above))
        heights.append(height if timed else max(height, 2.0))
        if any(beneath):
            rows.append(tuple(beneath))
            heights.append(0.85)
    return [Block(_labelled(rows), tuple(heights), width)]


def _labelled(rows: Sequence[tuple[Panel | None, ...]]) -> tuple[tuple[Panel | None, ...], ...]:
    """Time labels only under the lowest panel of each column."""
    lowest = {column: i for i, row in enumerate(rows) for column, panel in enumerate(row) if panel is not None}
    return tuple(
        tuple(panel and replace(panel, labelled=not panel.timed or lowest[c] == i) for c, panel in enumerate(row))
        for i, row in enumerate(rows)
    )


def _grid_shape(count: int) -> tuple[int, float, float]:
    """Columns, and width and height of a panel [inch]."""
    if count <= 2:
        return 1, 6.3, 2.6
    if count <= 8:
        return 2, 4.6, 1.7
    return (3, 3.5, 1.5) if count <= 18 else (4, 2.8, 1.3)


def _note_residuals(scene: PlotScene, panels: Sequence[Panel | None], notes: list[str]) -> None:
    first = short(scene.sources[0].name)
    apart = [short(source.name) for source, rows in zip(scene.sources, scene.common, strict=True) if rows is None]
    if apart:
        notes.append(f"No residual, because there is no time in common with {first}: {', '.join(apart)}.")
    if any(panel is not None and panel.up.startswith(RESIDUAL) for panel in panels):
        notes.append(f"{RESIDUAL.capitalize()}: the others less {first}.")


def _described(scene: PlotScene, place: int) -> str:
    """The source of a motion and its length."""
    source, rows = scene.sources[place], scene.rows[place]
    t = source.recording.t[rows]
    name = f"{short(source.name)}: " if len(scene.sources) > 1 else ""
    kind = "recorded" if source.measured else "simulated"
    solver = f" by {type(source.run.solver).__name__}" if source.run is not None else ""
    return f"{name}{kind}{solver}, {len(t)} samples from {t[0]:.6g} to {t[-1]:.6g} s."


def _note_thinning(scene: PlotScene, notes: list[str]) -> None:
    longest = max(len(rows) for rows in scene.rows)
    if longest > MOST_CURVE_POINTS:
        notes.append(
            f"Of {longest} samples those are drawn that the outline needs, every peak among them; "
            "a narrower window of time shows more."
        )


def _some_channels(scene: PlotScene) -> str:
    return listed((name for source in scene.sources for name in source.recording.channels), 6)
