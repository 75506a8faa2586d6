"""What the benchmarks share: races between contestants, Markdown tables, result files."""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LIBRARIES = ("flexdyn", "pin", "numpy", "scipy", "mujoco")


@dataclass(frozen=True)
class Contestant:
    """One who does the same work in every round.

    Attributes:
        name: in tables.
        run: does the work once.
        units: how many steps or calls the work is.
        setup: what `run` does besides the work (compiling a model, say); its time is subtracted.
    """

    name: str
    run: Callable[[], object]
    units: int = 1
    setup: Callable[[], object] | None = None


@dataclass(frozen=True)
class Bound:
    """A number that must not be above its bound."""

    name: str
    value: float
    bound: float

    @property
    def passed(self) -> bool:
        """Whether it holds."""
        return self.value <= self.bound

    def to_dict(self) -> dict[str, Any]:
        """As the result file writes it."""
        return {"name": self.name, "value": _short(self.value), "bound": self.bound, "passed": self.passed}

    def __str__(self) -> str:
        """One line for the terminal."""
        return f"{'PASS' if self.passed else 'FAIL'}  {self.name}: {self.value:.4g} (at most {self.bound:g})"


def race(contestants: Sequence[Contestant], rounds: int) -> dict[str, Array]:
    """Let all of them run in every round, so that a slow moment of the machine hits all alike.

    The order turns by one from round to round. Time is CPU time of this process: others on the machine take none of
    it. The first round only warms up.

    Args:
        contestants: each with a name of its own.
        rounds: how often each runs.

    Returns:
        name -> time per unit of work in every round (rounds,) [s].
    """
    times: dict[str, list[float]] = {each.name: [] for each in contestants}
    for turn in range(rounds + 1):
        first = turn % len(contestants)
        for each in (*contestants[first:], *contestants[:first]):
            seconds = _seconds(each.run) - (_seconds(each.setup) if each.setup else 0.0)
            if turn:
                times[each.name].append(seconds / each.units)
    return {name: np.array(column) for name, column in times.items()}


def _seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def ratio(times: Mapping[str, Array], name: str, over: str) -> float:
    """Median over the rounds of the ratio of two contestants' times in the same round."""
    return float(np.median(times[name] / times[over]))


def summary(times: Mapping[str, Array], name: str, over: str) -> dict[str, Any]:
    """A contestant's time and its ratio to another's, as the result file writes it; quartiles tell the noise."""
    ratios = times[name] / times[over]
    low, middle, high = np.percentile(ratios, [25, 50, 75])
    return {
        "microseconds": _short(float(np.median(times[name])) * 1e6),
        "ratio": _short(middle),
        "quartiles": [_short(low), _short(high)],
    }


def arguments(about: str | None) -> argparse.ArgumentParser:
    """A parser of a benchmark's command line, with the option for the file of its results.

    Args:
        about: the benchmark's docstring.
    """
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, help="write the results as JSON")
    return parser


def conclude(bounds: Sequence[Bound], output: Path | None, command: str, content: Mapping[str, Any]) -> int:
    """Print the bounds, write the results with them, and return the exit code: 0 if all bounds hold, else 1.

    Args:
        bounds: of the benchmark.
        output: the file of the results; None: it is not written.
        command: that makes them, without the output option.
        content: what was measured.
    """
    print(*bounds, sep="\n")
    if output is not None:
        write_results(output, command, {**content, "bounds": [bound.to_dict() for bound in bounds]})
    return 0 if all(bound.passed for bound in bounds) else 1


def write_results(path: Path, command: str, content: Mapping[str, Any]) -> None:
    """Write results as JSON, with the command that makes them, the date and the versions of what took part.

    Args:
        path: of the file; it is written beside and renamed.
        command: without the output option.
        content: what was measured.
    """
    head = {
        "command": f"{command} -o benchmarks/results/{path.name}",
        "date": datetime.now(UTC).date().isoformat(),
        "versions": {"python": platform.python_version(), **{name: _version(name) for name in LIBRARIES}},
        "processor": processor(),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".part")
    beside.write_text(json.dumps(head | dict(content), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    os.replace(beside, path)


def processor() -> str:
    """The processor's model, where the system tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return "not installed"


def _short(number: float) -> float:
    """Six figures: what is shown has fewer, and would be rounded twice if it were rounded to nearly as many here."""
    return float(f"{number:.6g}")
