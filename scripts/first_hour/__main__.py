"""``PYTHONPATH=scripts python -m first_hour [FOLDER]``: play it, and print what it took."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from first_hour.play import play, prepare
from first_hour.user import StuckError, User


def main(folder: Path) -> int:
    """Play in a folder; the last line is all of it as JSON."""
    prepare(folder)
    user, began = User(folder), time.monotonic()
    try:
        read = play(user)
    except StuckError as stuck:
        print(f"{user.steps[-1].wanted}: {stuck}", file=sys.stderr)
        return 1
    seconds = time.monotonic() - began
    for step in user.steps:
        print(f"{step.wanted:<40} {step.commands} commands, {len(step.said)} of them failed  {step.seconds:5.1f} s")
        for said in step.said:
            print(f"    {said}")
    print(f"The report says: {read}")
    steps = [vars(step) for step in user.steps]
    print(json.dumps({"report": read, "seconds": seconds, "steps": steps}))
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").split(": ")[-1])
    parser.add_argument("folder", nargs="?", type=Path, help="keeps the logs and the report; default: a temporary one")
    if (chosen := parser.parse_args().folder) is not None:
        chosen.mkdir(parents=True, exist_ok=True)
        sys.exit(main(chosen))
    with TemporaryDirectory() as given:
        sys.exit(main(Path(given)))
