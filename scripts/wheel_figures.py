"""Build a wheel for each of some Pythons, try it where no compiler is, and time the way to the paper's study.

    python scripts/wheel_figures.py python3.11 python3.13 -o benchmarks/results/wheels.json

scripts/release.sh builds each wheel in a copy of what is committed. Every trial begins with nothing: no environment, no
cache, and no program on the path but those of the environment that it makes. It installs the wheel with all extras from
wheels alone, and makes the paper's study; these are timed. Then scripts/wheel_check.py tests the installation. The
wheel of the first Python is tried by uv too, and with the oldest libraries that it accepts. The results are written
after each Python. Exit code 1: one trial failed.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))

from install import FOR_UV, pip_settings  # noqa: E402
from measure import Bound, conclude  # noqa: E402
from wheels_table import wheels_table  # noqa: E402

LIBRARIES = ("pin", "numpy", "scipy")
"""What the wheel must work with in every version that it accepts."""
ELSEWHERE = ("Linux aarch64", "macOS arm64", "macOS x86_64", "conda", "pixi")
"""What a Linux machine with x86_64 and PyPI alone cannot try."""
VERSIONS = (
    "import json, platform; from importlib.metadata import version;"
    f"print(json.dumps([platform.python_version(), {{name: version(name) for name in {LIBRARIES}}}]))"
)
TAG = "import sys; print(f'cp{sys.version_info[0]}{sys.version_info[1]}')"


class Failed(Exception):
    """A program of a trial ended with an error; its last line."""


def done(words: Sequence[str | Path], where: Path, environ: Mapping[str, str]) -> str:
    """What a program prints.

    Raises:
        Failed: it ended with an error.
    """
    ended = subprocess.run(words, cwd=where, env=environ, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise Failed(((ended.stderr or ended.stdout).strip().splitlines() or ["it said nothing"])[-1])
    return ended.stdout


def built(python: str, checkout: Path, folder: Path) -> tuple[Path, Path]:
    """The wheel for a Python and the source archive that it was built from, in a folder; made if not there."""
    tag = subprocess.run([python, "-c", TAG], capture_output=True, text=True, check=True).stdout.strip()
    if not list(folder.glob(f"*-{tag}-*.whl")):
        if not checkout.is_dir():
            clone: list[str | Path] = ["git", "clone", "--quiet", ROOT, checkout]
            subprocess.run(clone, check=True)
        words = ["bash", "scripts/release.sh"]
        subprocess.run(words, cwd=checkout, env=os.environ | {"PYTHON": python}, check=True)
        shutil.copytree(checkout / "dist", folder, dirs_exist_ok=True)
    (wheel,), (archive,) = folder.glob(f"*-{tag}-*.whl"), folder.glob("*.tar.gz")
    return wheel, archive


def oldest(project: Mapping[str, Any]) -> list[str]:
    """The first release of every library of `LIBRARIES` that the package accepts, as pip takes it."""
    lowest = (re.match(r"([\w-]+)>=([\d.]+)", entry) for entry in project["project"]["dependencies"])
    return [f"{found[1]}=={found[2]}" for found in lowest if found and found[1] in LIBRARIES]


def tried(python: str, wheel: Path, asked: Sequence[str], uv: Path | None) -> dict[str, Any]:
    """One trial, as the result file writes it.

    Args:
        python: the program that makes the environment.
        wheel: to install.
        asked: further requirements.
        uv: installs it; None: venv and pip do.
    """
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        own = place / "env" / "bin"
        bare = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        bare |= {"PATH": str(own), "HOME": folder, **({} if uv is None else as_pip_is_set())}
        wanted: list[str | Path] = ["--only-binary", ":all:", f"{wheel}[all]", *asked]
        if uv is None:
            make: list[str | Path] = [python, "-m", "venv", "env"]
            install: list[str | Path] = [own / "pip", "install", "--quiet", "--no-cache-dir", *wanted]
        else:
            make = [uv, "venv", "--quiet", "--python", python, "env"]
            install = [uv, "pip", "install", "--quiet", "--no-cache", "--python", own / "python", *wanted]
        study: list[str | Path] = [own / "flexdyn", "paper", "-o", "paper"]
        row: dict[str, Any] = {"by": "pip" if uv is None else "uv", "oldest": bool(asked), "problem": None}
        try:
            before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
            for words in (make, install, study):
                done(words, place, bare)
            after, row["seconds"] = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic() - begin
            row["computing"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            row["megabytes"] = size(place / "env")
            done([own / "python", ROOT / "scripts" / "wheel_check.py"], place, bare)
        except Failed as failed:
            row["problem"] = str(failed)
        version, libraries = json.loads(done([own / "python", "-c", VERSIONS], place, bare))
        return {"python": version, "libraries": libraries} | row


def as_pip_is_set() -> dict[str, str]:
    """Where pip is told to look for packages, as uv is told it."""
    listed = subprocess.run([sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True, check=True)
    settings = {FOR_UV[name]: value for name, value in pip_settings(listed.stdout).items() if name in FOR_UV}
    return {"UV_SYSTEM_CERTS": "1", "UV_INDEX_STRATEGY": "unsafe-best-match", "UV_LINK_MODE": "copy", **settings}


def size(place: Path) -> float:
    """Bytes of a file, or of all files in a folder [MB]."""
    files = [place] if place.is_file() else [path for path in place.rglob("*") if path.is_file()]
    return sum(path.lstat().st_size for path in files) / 1e6


def figures(pythons: Sequence[str], folder: Path) -> Iterator[dict[str, Any]]:
    """Build and try; what the result file writes, so far, after each Python.

    Args:
        pythons: programs.
        folder: with the wheels that are built already; the others are put there.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    promised = ["3." + name.removeprefix("cp3").removesuffix("-*") for name in project["tool"]["cibuildwheel"]["build"]]
    files: dict[str, float] = {}
    trials: list[dict[str, Any]] = []
    uv = shutil.which("uv", path=str(Path(sys.executable).parent)) or shutil.which("uv")
    with tempfile.TemporaryDirectory() as place:
        for number, python in enumerate(pythons):
            wheel, archive = built(python, Path(place) / "checkout", folder)
            files |= {archive.name: size(archive), wheel.name: size(wheel)}
            ways: list[tuple[Sequence[str], Path | None]] = [((), None)]
            if number == 0:
                ways += [((), Path(uv))] if uv else []
                ways.append((oldest(project), None))
            for asked, by in ways:
                trials.append(tried(python, wheel, asked, by))
                print(trials[-1], file=sys.stderr, flush=True)
            seen = {row["python"].rpartition(".")[0] for row in trials}
            not_tried = [f"Python {version}" for version in promised if version not in seen]
            yield {"files": files, "trials": trials, "not_tried": [*not_tried, *ELSEWHERE]}


def main() -> int:
    """Build, try, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pythons", nargs="+", help="programs, the first one is tried with the oldest libraries too")
    parser.add_argument("--built", type=Path, help="a folder with source archive and wheels, for those that are there")
    parser.add_argument("-o", "--output", type=Path, help="a file for the results")
    given = parser.parse_args()
    pythons = [shutil.which(python) or python for python in given.pythons]
    code = 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) if given.built is None else given.built.resolve()
        for number, content in enumerate(figures(pythons, folder), start=1):
            print(wheels_table(content))
            failed = sum(row["problem"] is not None for row in content["trials"])
            names = " ".join(Path(python).name for python in pythons[:number])
            command = f"python scripts/wheel_figures.py {names}"
            code = conclude([Bound("trials that failed", failed, 0)], given.output, command, content)
    return code


if __name__ == "__main__":
    sys.exit(main())
