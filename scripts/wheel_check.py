"""Test the flexdyn that is installed in this environment as a user meets it: no compiler, no checkout, no extras.

    cd /an/empty/folder && python /path/to/scripts/wheel_check.py [VERSION]

Run by scripts/release.sh and by cibuildwheel on every wheel. Exit code 1: something failed, and one line says what.
"""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from importlib import metadata
from pathlib import Path

COMPILERS = ("c++", "g++", "clang++", "cc", "gcc", "clang", "cl")
ALONE = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("_core", sys.argv[1])
core = importlib.util.module_from_spec(spec)
spec.loader.exec_module(core)
assert core.Plant
"""
"""Loads the compiled core in a Python that sees no installed package, so that no library of one can help it."""
COMMANDS = (
    ("doctor",),
    ("simulate", "scara_two_link", "--duration", "1", "--q0", "0,1", "--v0", "1,-2", "-o", "run.csv"),
    ("compare", "run.csv", "run.csv"),
)


def problem(folder: Path, version: str | None) -> str | None:
    """What is wrong with the installed package; None if nothing is.

    Args:
        folder: an empty one to work in.
        version: that it must have; None: any.
    """
    installed = metadata.version("flexdyn")
    if version is not None and installed != version:
        return f"version {installed} is installed, {version} is wanted"
    site = Path(sysconfig.get_path("platlib"))
    cores = sorted((site / "flexdyn").glob("_core.*"))
    binaries = [path for path in cores if path.suffix != ".pyi"]
    if len(binaries) != 1:
        return f"{site / 'flexdyn'}: {len(binaries)} compiled cores, one is needed"
    # Only the environment's own programs are in reach.
    bare = {"PATH": sysconfig.get_path("scripts"), "HOME": str(folder), "PYTHONSAFEPATH": "1"}
    found = [name for name in COMPILERS if shutil.which(name, path=bare["PATH"])]
    if found:
        return f"{bare['PATH']}: a compiler is in reach ({found[0]}), so the test would show nothing"
    alone = [sys.executable, "-I", "-S", "-c", ALONE, str(binaries[0])]
    flexdyn = str(Path(bare["PATH"]) / "flexdyn")
    says_version = [sys.executable, "-c", "import flexdyn; print(flexdyn.__version__)"]
    for words in (alone, says_version, *([flexdyn, *command] for command in COMMANDS)):
        done = subprocess.run(words, cwd=folder, env=bare, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return f"{' '.join(words[:3])} ended with {done.returncode}: {(done.stderr or done.stdout)[-600:]}"
        if words is says_version and done.stdout.strip() != installed:
            return f"flexdyn.__version__ is {done.stdout.strip()}, and the package's metadata say {installed}"
    return None


def main(version: str | None) -> int:
    """Test and say so."""
    with tempfile.TemporaryDirectory() as folder:
        wrong = problem(Path(folder), version)
    names = ("flexdyn", "pin", "numpy", "scipy")
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in names)
    print(f"Python {platform.python_version()} on {platform.machine()}, {versions}: {wrong or 'works'}")
    return int(wrong is not None)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else None))
