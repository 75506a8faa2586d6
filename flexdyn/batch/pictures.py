"""The picture of a study: metrics over parameters, tornado of sensitivities, quantiles of trajectories."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np

from flexdyn.batch.metric_views import DOTS, MetricColumns, scatter, tornado
from flexdyn.batch.results import Results
from flexdyn.batch.trajectory_views import trajectories, trajectory_keys
from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.plots.arrange import Block, arrange
from flexdyn.plots.palette import hue
from flexdyn.plots.panel import Key, short
from flexdyn.plots.picture import Picture

VIEWS = ("metrics", "sensitivities", "trajectories")
MOST_METRICS, MOST_PARAMETERS = 6, 4
"""Default views."""


def draw_results(
    results: Results,
    *,
    views: Sequence[str] | str | None = None,
    metrics: Sequence[str] | None = None,
    parameters: Sequence[str] | None = None,
    channels: Sequence[str] | None = None,
) -> Picture:
    """A page with the results of a study; the arguments are those of `Results.plot`.

    Raises:
        InputError: there is nothing to draw, or no such view, metric, parameter or channel.
    """
    wanted = (views,) if isinstance(views, str) else tuple(VIEWS if views is None else views)
    _known("views", wanted, VIEWS)
    notes = [_counted(results)]
    blocks: list[Block] = []
    keys: tuple[Key, ...] = ()
    if "trajectories" in wanted and results.channels and len(results.complete):
        kept = results.channels if channels is None else tuple(channels)
        _known("channels", kept, results.channels)
        blocks += trajectories(results, kept, notes)
        keys = trajectory_keys()
    if {"metrics", "sensitivities"} & set(wanted):
        columns = _drawn_columns(results, metrics, parameters, notes, chosen=views is not None)
        if columns is not None:
            if "metrics" in wanted:
                blocks += scatter(_strongest(columns, parameters, notes))
                some = f"{DOTS} runs, evenly spaced among all, are drawn."
                notes.append(some if columns.runs > DOTS else "Every dot is a run.")
            if "sensitivities" in wanted and columns.sensitivities:
                blocks += tornado(columns)
                notes.append(
                    "Sensitivities: from the mean of a metric over the fifth of runs with the lowest value of a "
                    "parameter to that over the fifth with the highest, minus its mean over all runs; r is next to it."
                )
            if columns.sensitivities:
                chance = f"below {columns.chance:.2g} in 95 of 100 studies"
                notes.append(f"r is Spearman's rank correlation, by chance alone {chance}.")
    if not blocks:
        problem = f"there is nothing to draw of {', '.join(wanted)}"
        raise InputError(problem, file=results.path, key="views", remedy=" ".join(notes))
    return arrange(short(results.path.name), notes, keys, blocks)


def _drawn_columns(
    results: Results, metrics: Sequence[str] | None, parameters: Sequence[str] | None, notes: list[str], *, chosen: bool
) -> MetricColumns | None:
    """The metrics and parameters to be drawn; None if there are none."""
    measured, varied = results.metrics, results.parameters
    _known("metrics", metrics or (), measured)
    _known("parameters", parameters or (), varied)
    there = [name for name, values in measured.items() if np.isfinite(values).any()]
    if not there or not varied:
        if chosen:
            notes.append("No metrics are drawn: the study has none, or nothing varies, or no run is done.")
        return None
    names = list(metrics or there[:MOST_METRICS])
    units = {name: results.unit(name) for name in (*measured, *varied)}
    if len(names) < len(there):
        notes.append(f"{len(names)} of {len(there)} metrics are drawn.")
    colours = {path: hue(place) for place, path in enumerate(varied)}
    kept = {path: varied[path] for path in parameters or varied}
    return MetricColumns({name: measured[name] for name in names}, kept, units, colours)


def _strongest(columns: MetricColumns, chosen: Sequence[str] | None, notes: list[str]) -> MetricColumns:
    """The parameters that fit side by side, unless the user chose them."""
    if chosen is not None or len(columns.parameters) <= MOST_PARAMETERS:
        return columns
    some = f"{MOST_PARAMETERS} of {len(columns.parameters)} parameters"
    notes.append(f"Metrics over the {some} with the largest influence.")
    return columns.only(columns.strongest(MOST_PARAMETERS))


def _counted(results: Results) -> str:
    count, failed = len(results.status), len(results.failed)
    done = f"{count} run{'s' if count != 1 else ''}, {count - results.pending} done"
    return f"{done}, {failed} of them failed." if failed else f"{done}."


def _known(key: str, given: Iterable[str], known: Collection[str]) -> None:
    for name in given:
        check_known(name, known, f"no such {key.removesuffix('s')}", key=key, value=name)
