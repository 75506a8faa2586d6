"""What the user does: runs a command, reads what it says, corrects a file, tries again."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flexdyn.io.yaml import parse_yaml

Map = dict[str, Any]


@dataclass
class Step:
    """Something that the user wanted.

    Attributes:
        wanted: in words.
        commands: run until it was there.
        seconds: that they took.
        said: what those said that failed; one more try each.
    """

    wanted: str
    commands: int = 0
    seconds: float = 0.0
    said: list[str] = field(default_factory=list)


class StuckError(Exception):
    """The user does not know what to do next."""


@dataclass
class User:
    """A user in a folder.

    Attributes:
        folder: that the commands run in.
        steps: taken so far.
    """

    folder: Path
    steps: list[Step] = field(default_factory=list)

    def want(self, wanted: str) -> Step:
        """Begin a step."""
        self.steps.append(Step(wanted))
        return self.steps[-1]

    def run(self, *command: str) -> subprocess.CompletedProcess[str]:
        """``flexdyn`` with these words."""
        step, began = self.steps[-1], time.monotonic()
        done = subprocess.run(
            [sys.executable, "-m", "flexdyn", *command], cwd=self.folder, capture_output=True, text=True, check=False
        )
        step.commands += 1
        step.seconds += time.monotonic() - began
        if done.returncode:
            step.said.append(done.stderr.strip())
        return done

    def succeed(self, *command: str) -> str:
        """A command that the user expects to work.

        Returns:
            What it printed.

        Raises:
            StuckError: it does not.
        """
        done = self.run(*command)
        if done.returncode:
            raise StuckError(f"flexdyn {' '.join(command)}: {done.stderr.strip()}")
        return done.stdout

    def read_log(self, log: str, correct: Callable[[Map], Map]) -> str:
        """Look at a log until its picture is there: the map that the error suggests is copied and corrected.

        Args:
            log: file or folder.
            correct: what the user knows of the log and writes into the map.

        Returns:
            Name of the map.

        Raises:
            StuckError: the error suggests no map, or the corrected one does not do.
        """
        self.want(f"see {log}")
        picture, name = f"{Path(log).stem}.png", f"{Path(log).stem}_map.yaml"
        first = self.run("plot", log, "-o", picture)
        if first.returncode == 0:
            raise StuckError(f"{log} was read without a map, so its units were not asked for")
        corrected = correct(suggested(first.stderr))
        (self.folder / name).write_text(json.dumps(corrected), encoding="utf-8")  # JSON is YAML
        self.succeed("plot", log, "--map", name, "-o", picture)
        return name


def suggested(text: str) -> Map:
    """The map that an error suggests, from its first brace to the one that closes it.

    Raises:
        StuckError: it suggests none.
    """
    begin = text.find("{flexdyn_map")
    if begin < 0:
        raise StuckError(f"no map is suggested: {text.strip()}")
    depth = 0
    for place, letter in enumerate(text[begin:], begin):
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if depth == 0:
            return dict(parse_yaml(text[begin : place + 1]))
    raise StuckError(f"the map that is suggested does not end: {text.strip()}")
