"""Study: the description of a batch of runs, as plain data from which any worker can make the runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Self

from flexdyn.batch.distributions import Distribution, Grid, distribution
from flexdyn.errors import shown, visible
from flexdyn.io.notebook import Public, card, html_table
from flexdyn.io.yaml import dump_yaml, parse_yaml

_OF_COMMAND = ("command", "command.pd.reference", "command.pd.feedforward")
PLACES = ("name", "folder", "model.robot.urdf", "model.robot.package_dirs", *_OF_COMMAND)
"""Entries that are paths (an unnamed model has the name of its folder): a study that was moved is the same study if the
content of its files is the same, which is compared under ``files``."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Study(Public):
    """A batch study, checked and completed by `flexdyn.batch.studyfile`.

    Attributes:
        name: of the model.
        model: mapping of the model file; the paths in it are absolute.
        command: absolute path of a recording, a mapping ``{"pd": {...}}`` with absolute paths, or None: no torque.
        duration: of every run [s].
        rate: of the stored samples [Hz].
        solver: ``{"name": ..., settings}``.
        runs: number of random draws; with a grid, draws at each of its points.
        points: number of points of the grid; 1 without a grid.
        seed: run k depends on (seed, k) alone.
        vary: path of a number -> ``{distribution: numbers}``.
        keep: channels.
        metrics: their names.
        chunk: number of runs that are made and written together.
        folder: absolute, of the study file: users' own metrics are searched there.
        files: SHA-256 of the files that the study reads, by their path in it.
    """

    name: str
    model: Mapping[str, Any]
    command: Any
    duration: float
    rate: float
    solver: Mapping[str, Any]
    runs: int
    points: int
    seed: int
    vary: Mapping[str, Mapping[str, Any]]
    keep: tuple[str, ...]
    metrics: tuple[str, ...]
    chunk: int
    folder: str
    files: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """What it makes, in a line."""
        runs = f"{self.count} runs of {self.duration:g} s"
        return visible(f"<Study of {self.name}: {runs}, {len(self.vary)} numbers vary>")

    def _repr_html_(self) -> str:
        """HTML for notebooks: how many runs, and how each number varies."""
        facts = {
            "runs": f"{self.count} of {self.duration:g} s, seed {self.seed}",
            "solver": self.solver["name"],
            "kept": f"{', '.join(self.keep)} at {self.rate:g} Hz",
            "metrics": ", ".join(self.metrics),
        }
        rows = ((path, *(f"{kind} {numbers}" for kind, numbers in entry.items())) for path, entry in self.vary.items())
        return card(f"Study of {self.name}", facts, html_table(("number", "varies as"), rows))

    @cached_property
    def kinds(self) -> Mapping[str, Distribution | Grid]:
        """How each number varies, by its path."""
        return {path: distribution(entry) for path, entry in self.vary.items()}

    @property
    def count(self) -> int:
        """Number of all runs."""
        return self.points * self.runs

    @property
    def chunks(self) -> int:
        """Number of chunks of runs."""
        return math.ceil(self.count / self.chunk)

    def bounds(self, chunk: int) -> range:
        """The runs of a chunk."""
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, self.count))

    def to_dict(self) -> dict[str, Any]:
        """Plain data: mappings, lists, text and numbers (infinite ones too)."""
        content = asdict(self)
        return content | {key: list(content[key]) for key in ("keep", "metrics")}

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """Make a study from `to_dict`, without new checks."""
        return cls(**{**content, "keep": tuple(content["keep"]), "metrics": tuple(content["metrics"])})

    def to_text(self) -> str:
        """As YAML, which can contain infinite numbers and can be read back bit for bit."""
        return self._text

    @cached_property
    def _text(self) -> str:
        return dump_yaml(self.to_dict())

    @classmethod
    @lru_cache(maxsize=4)
    def from_text(cls, text: str) -> Self:
        """Make a study from `to_text`, without new checks."""
        return cls.from_dict(parse_yaml(text))

    def difference(self, other: Study) -> str | None:
        """The first difference because of which another study gives other numbers; None if there is none.

        Args:
            other: an earlier study, from a store.

        Returns:
            for example ``seed is 8 here and 7 there``.
        """
        mine, its = (dict(_entries(study.to_dict())) for study in (self, other))
        for key in [*mine, *(key for key in its if key not in mine)]:
            if mine.get(key) == its.get(key) or key in PLACES:
                continue
            if key.startswith("files."):
                return f"what the file of {key.removeprefix('files.')} holds has changed"
            here, there = (shown(side[key]) if key in side else "not given" for side in (mine, its))
            return f"{key} is {here} here and {there} there"
        return None


def _entries(content: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Every leaf of plain data, with its dotted path; lists stay whole."""
    if not isinstance(content, Mapping) or not content:
        yield key, content
        return
    for name, entry in content.items():
        yield from _entries(entry, f"{key}.{name}" if key else str(name))
