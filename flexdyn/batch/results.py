"""Results: the stored results of a study, in numbers and pictures, and the extraction of its runs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Indices
from flexdyn.batch.extract import Extracted, extract
from flexdyn.batch.layout import DONE, NOT_DONE
from flexdyn.batch.store import open_store
from flexdyn.batch.stored_study import check_arrays
from flexdyn.batch.study import Study
from flexdyn.batch.summary import Summary, metric_summary, parameter_summary, reasons_of
from flexdyn.errors import InputError, needed, visible
from flexdyn.io.notebook import Public, card, html_table

if TYPE_CHECKING:
    from flexdyn.plots.picture import Picture

METRIC = "metric "
"""Beginning of the status of a run that has its channels but lacks a metric."""


def open_results(path: str | Path) -> Results:
    """The results of a study, finished or not.

    Args:
        path: of the store.

    Raises:
        InputError: there is none.
        MissingExtra: zarr or xarray is not installed.
    """
    return Results(Path(path), open_store(path).study)


@dataclass(frozen=True, eq=False)
class Results(Public):
    """The stored results of a study.

    Attributes:
        path: of the store.
        study: that made it.
    """

    path: Path
    study: Study

    def __repr__(self) -> str:
        """The path, the number of runs, and how many failed or are not done, in one line."""
        waiting = f", {self.pending} not done" if self.pending else ""
        runs = f"{len(self.status)} runs, {len(self.failed)} failed{waiting}"
        return visible(f"<Results of {self.study.name} in {self.path}: {runs}>")

    def _repr_html_(self) -> str:
        """HTML for notebooks: how many runs, what varies, every metric."""
        done = self.status != NOT_DONE
        rows = []
        for kind, columns in (("varies", self.parameters), ("metric", self.metrics)):
            for name, values in columns.items():
                there = values[done & np.isfinite(values)]
                spread = [float(f(there)) if there.size else math.nan for f in (np.min, np.median, np.max)]
                rows.append((name, kind, self.unit(name) or "-", *spread))
        facts = {
            "store": self.path,
            "runs": f"{len(self.status)}, {len(self.failed)} failed, {self.pending} not done",
            "kept": ", ".join(self.channels),
        }
        heads = ("number", "", "unit", "least", "median", "greatest")
        return card(f"Study of {self.study.name}", facts, html_table(heads, rows))

    def dataset(self) -> Any:
        """All results as an xarray.Dataset over dask arrays, which are read when needed.

        Channels are over ``(run, time, joint)``; parameters (named by their path), metrics and ``status`` over ``run``.
        The attribute ``kind`` of each says what it is.
        """
        return self._opened({})

    @cached_property
    def failed(self) -> Mapping[int, str]:
        """Runs without channels, and the reasons; a run that only lacks a metric is not included."""
        status = self.status
        bad = [k for k in np.flatnonzero((status != DONE) & (status != NOT_DONE)) if not status[k].startswith(METRIC)]
        return {int(k): str(status[k]) for k in bad}

    @cached_property
    def status(self) -> NDArray[Any]:
        """Status of every run: ``ok``, ``not done``, ``metric NAME: reason`` or why it failed (runs,)."""
        return np.asarray(self._read(self._arrays["status"]), dtype=object)

    @property
    def pending(self) -> int:
        """Runs that are not done yet."""
        return int((self.status == NOT_DONE).sum())

    @cached_property
    def complete(self) -> Indices:
        """Runs that have their channels."""
        there = self.status != NOT_DONE
        there[list(self.failed)] = False
        return np.flatnonzero(there)

    @property
    def metrics(self) -> Mapping[str, Array]:
        """Every metric by run (runs,); NaN if a run has none."""
        return self._columns(self.study.metrics)

    @property
    def parameters(self) -> Mapping[str, Array]:
        """Every varying number by path and run (runs,); NaN if a run is not done."""
        return self._columns(self.study.vary)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the stored channels."""
        return self.study.keep

    def unit(self, name: str) -> str:
        """Unit of an array."""
        return str(self._arrays[name].attrs.get("units", ""))

    def summary(self) -> Summary:
        """A summary: failures with reasons, every metric, and the influence of each parameter on it."""
        status, metrics = self.status, self.metrics
        done = status != NOT_DONE
        said = ((int(k), str(status[k])) for k in np.flatnonzero(done & (status != DONE)))
        return Summary(
            path=str(self.path),
            runs=len(status),
            done=int(done.sum()),
            failed=len(self.failed),
            reasons=reasons_of(said),
            metrics=tuple(metric_summary(name, self.unit(name), values) for name, values in metrics.items()),
            parameters=tuple(
                parameter_summary(name, self.unit(name), np.where(done, values, np.nan), metrics)
                for name, values in self.parameters.items()
            ),
        )

    def plot(self, path: str | Path | None = None, **choice: Any) -> Picture:
        """Draw it: metrics over parameters, influences of parameters on metrics, and trajectories of all runs.

        Args:
            path: of a file to write, if given: .png, .pdf, .svg, or .html, which is interactive.
            choice: what is drawn, as keywords:

                views: of ``metrics`` (each over each parameter), ``sensitivities`` (tornado), ``trajectories``
                (quantiles over runs); default: all for which there are data.

                metrics: default: the first 6.

                parameters: default: the 4 with the largest influence.

                channels: drawn as trajectories; default: all that were stored.

        Returns:
            The picture: ``show()`` opens it in the browser, ``save(path)`` writes it.

        Raises:
            InputError: there is nothing to draw, or no such view, metric, parameter or channel.
            MissingExtra: matplotlib or plotly is not installed.
        """
        from flexdyn.batch.pictures import draw_results

        picture = draw_results(self, **choice)
        if path is not None:
            picture.save(path)
        return picture

    def extract(self, k: int, folder: str | Path) -> Extracted:
        """Extract one run as model file, command file and the line of ``flexdyn simulate`` that repeats this run.

        Args:
            k: its number, from 0.
            folder: to write them to; it is created if it does not exist.

        Raises:
            InputError: there is no such run, or the folder cannot be written.
        """
        return extract(self.study, k, Path(folder))

    def blocks(self, channel: str, instants: Indices) -> Iterator[Array]:
        """A channel of all runs that have it, in blocks of runs.

        Args:
            channel: its name.
            instants: indices of the samples.

        Yields:
            Blocks (some runs, instants, joints), in the order of runs.
        """
        array, size = self._arrays[channel], self.study.chunk
        for first in range(0, array.sizes["run"], size):
            block = self._read(array.isel(run=slice(first, first + size)))[:, instants]
            yield block[np.isfinite(block).all(axis=(1, 2))]

    @property
    def times(self) -> Array:
        """Times of the samples [s]."""
        return np.asarray(self._arrays["time"].values, dtype=float)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints in the order of the channels' columns."""
        return tuple(str(name) for name in self._arrays["joint"].values)

    def _columns(self, names: Iterable[str]) -> dict[str, Array]:
        return {name: np.asarray(self._read(self._arrays[name]), dtype=float) for name in names}

    @cached_property
    def _arrays(self) -> Any:
        return self._opened(None)

    def _opened(self, chunks: Any) -> Any:
        with needed("xarray", "batch"):
            import xarray
        try:
            found = xarray.open_zarr(self.path, chunks=chunks, consolidated=True, zarr_format=3, decode_times=False)
            check_arrays(found, self.study)
            told = {stored: each.attrs.get("name") for stored, each in found.data_vars.items()}
            return found.rename({stored: name for stored, name in told.items() if name is not None})
        except Exception as error:  # zarr and xarray raise various exceptions for unusual metadata
            raise self._damaged("the metadata", error) from None

    def _read(self, array: Any) -> NDArray[Any]:
        """Numbers of an array.

        Raises:
            InputError: the stored data are damaged.
        """
        try:
            return np.asarray(array.values)
        except Exception as error:  # of its codecs, likewise; memory, where a piece says that it unpacks to terabytes
            raise self._damaged(str(array.name), error) from None

    def _damaged(self, what: str, error: Exception) -> InputError:
        problem = f"{what} cannot be read ({' '.join(str(error).split())[:120]})"
        remedy = "run the study again with --resume: it redoes what is damaged"
        return InputError(problem, file=self.path, remedy=remedy)
