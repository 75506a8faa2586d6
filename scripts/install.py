"""Install flexdyn from this checkout into the environment that runs this script, unless it is there already.

A stamp in the environment holds a digest of the sources, one of the package as pip recorded it, and the extras.
It is removed before every installation and written after it, so an installation that was interrupted is done again,
and so is one after pip installed another state by hand. A wheel, where one is given, takes the place of the sources.

Libraries are installed by uv, which takes a fifth of pip's computing, and where uv does not work by pip.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

SOURCES = ("pyproject.toml", "flexdyn", "robots", "scripts/flexdyn_program")
"""What the package is built from; README and licence only go into its description."""
LEFT_OUT = {"__pycache__", ".so", ".pyc"}
"""What a build or an import leaves among the sources: names of folders, ends of files."""
BOTH_HOLD = {"all"}
"""The extras `test` and `docs` contain this one, so it is there after either."""
FOR_UV = {
    "index-url": "UV_DEFAULT_INDEX",
    "extra-index-url": "UV_INDEX",
    "find-links": "UV_FIND_LINKS",
    "constraint": "UV_CONSTRAINT",
    "cert": "SSL_CERT_FILE",
}
"""Settings of pip about where packages come from, and uv's names for them."""
PIP_ALONE = {"no-index", "proxy", "trusted-host", "client-cert", "only-binary", "no-binary", "require-virtualenv"}
"""Settings of pip that uv has no like of: who made one keeps pip."""


def source_digest(root: Path) -> str:
    """A digest of the names and bytes of all files that the package is built from."""
    digest = hashlib.sha256()
    for path in _files(root):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(root).as_posix()}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def wheel_digest(wheel: Path) -> str:
    """A digest of a wheel, which is never that of sources."""
    return hashlib.sha256(b"wheel\0" + wheel.read_bytes()).hexdigest()


def installed_digest(site: Path) -> str | None:
    """A digest of pip's list of the installed files, which holds theirs; None where flexdyn is not installed."""
    records = sorted(site.glob("flexdyn-*.dist-info/RECORD"))
    if not records or not (site / "flexdyn" / "__init__.py").is_file():
        return None
    return hashlib.sha256(b"".join(each.read_bytes() for each in records)).hexdigest()


def missing_extras(stamp: Path, sources: str, site: Path, wanted: set[str]) -> set[str] | None:
    """The wanted extras that are not installed; None where the package itself is not there or of another state."""
    try:
        noted = json.loads(stamp.read_text(encoding="utf-8"))
        same = noted["sources"] == sources and noted["installed"] == installed_digest(site)
        return wanted - set(noted["extras"]) if same else None
    except (OSError, ValueError, TypeError, KeyError):
        return None  # no stamp, or not one of ours


def write_stamp(stamp: Path, sources: str, site: Path, extras: set[str]) -> None:
    """Note what is installed now."""
    noted = {"sources": sources, "installed": installed_digest(site), "extras": sorted(extras)}
    stamp.write_text(json.dumps(noted), encoding="utf-8")


def main(
    root: Path,
    site: Path,
    stamp: Path,
    extras: str,
    pip: Sequence[str],
    wheel: Path | None = None,
    find_uv: Callable[[Sequence[str]], Sequence[str]] = lambda pip: (),
) -> int:
    """Install where it is needed; pip's exit code, 0 where nothing was to be done.

    Args:
        root: folder of the checkout.
        site: folder of installed packages.
        stamp: file that notes what is installed.
        extras: names of extras, with commas between.
        pip: the command that runs pip.
        wheel: installed in place of the checkout, so that nothing is compiled.
        find_uv: gives the command that runs uv, empty where there is none; asked only where something is installed.
    """
    wanted = set(extras.split(","))
    sources = source_digest(root) if wheel is None else wheel_digest(wheel)
    missing = missing_extras(stamp, sources, site, wanted)
    if missing is not None and not missing:
        print(f"flexdyn[{extras}] in .venv is up to date.")
        return 0
    # Extras of the same state stay noted: test.sh and docs.sh want different ones in turn.
    known = set() if missing is None else set(json.loads(stamp.read_text(encoding="utf-8"))["extras"])
    stamp.unlink(missing_ok=True)
    how = "the core is compiled: a minute or two" if wheel is None else f"from {wheel.name}"
    print(f"Installing flexdyn[{extras}] into .venv ({how}) ...", flush=True)
    libraries = requirements(root, wanted) if wheel is None else [f"{wheel}[{','.join(sorted(wanted))}]"]
    uv = find_uv(pip)
    tool = _by_uv(uv) if uv else _by_pip(pip)
    if uv and _run([*tool.install, *libraries], root):
        print("uv cannot install them, pip does ...", flush=True)
        tool = _by_pip(pip)
    elif uv:
        libraries = []
    code = _install(tool, libraries, root, wheel, missing is None)
    if code == 0:
        write_stamp(stamp, sources, site, known | wanted | BOTH_HOLD)
    return code


class Tool(NamedTuple):
    """Commands of a program that installs; what they are about follows.

    Attributes:
        install: libraries, and wheels with their extras.
        again: a wheel alone, in place of the same version.
        build: a wheel of the checkout, into a folder.
    """

    install: Sequence[str]
    again: Sequence[str]
    build: Sequence[str]


def _by_pip(pip: Sequence[str]) -> Tool:
    quiet = ["--quiet", "--disable-pip-version-check"]
    # To compile all libraries to bytecode is half of pip's work; Python does it for those that are imported.
    install = [*pip, "install", "--no-compile", *quiet]
    again = [*install, "--force-reinstall", "--no-deps"]
    return Tool(install, again, [*pip, "wheel", *quiet, "--no-deps", ".", "--wheel-dir"])


def _by_uv(uv: Sequence[str]) -> Tool:
    install = [*uv, "pip", "install", "--quiet", "--python", sys.executable]
    build = [*uv, "build", "--quiet", "--wheel", "--python", sys.executable, ".", "--out-dir"]
    return Tool(install, [*install, "--reinstall", "--no-deps"], build)


def _install(tool: Tool, libraries: Sequence[str], root: Path, wheel: Path | None, anew: bool) -> int:
    """Install what is left to be: libraries, and the package where it is not there or of another state."""
    commands = [[*tool.install, *libraries]] if libraries else []
    if anew and wheel is None:
        return _build_and_install(tool, commands, root)
    if anew:
        # An installed state of the same version would be kept; what the wheel asks for comes with its extras.
        commands.insert(0, [*tool.again, str(wheel)])
    return next((code for command in commands if (code := _run(command, root))), 0)


def _run(command: Sequence[str], root: Path) -> int:
    return subprocess.run(command, cwd=root, check=False).returncode


def _build_and_install(tool: Tool, commands: Sequence[Sequence[str]], root: Path) -> int:
    """Compile the core while the libraries are installed, for which one processor is enough; then install both."""
    with tempfile.TemporaryDirectory() as folder:
        building = subprocess.Popen([*tool.build, folder], cwd=root)
        code = next((code for command in commands if (code := _run(command, root))), 0)
        if code:
            building.terminate()
        built = building.wait()
        if code or built:
            return code or built
        (wheel,) = Path(folder).glob("*.whl")
        return _run([*tool.again, str(wheel)], root)


def ready_uv(pip: Sequence[str]) -> Sequence[str]:
    """The command that runs uv: the user's own, or one that pip installs beside itself; empty where that fails.

    The user's own has its own settings. The other one is told those of pip.
    """
    own = shutil.which("uv")
    if own:
        return [own]
    quiet = ["--quiet", "--disable-pip-version-check"]
    listed = subprocess.run([*pip, "config", "list"], capture_output=True, text=True, check=False)
    settings = pip_settings(listed.stdout)
    if listed.returncode or settings.keys() & PIP_ALONE:
        return ()
    if subprocess.run([*pip, "install", *quiet, "--no-compile", "uv"], check=False).returncode:
        return ()
    os.environ.update({"UV_SYSTEM_CERTS": "1", "UV_INDEX_STRATEGY": "unsafe-best-match"})
    for name, value in settings.items():
        if name in FOR_UV:
            os.environ.setdefault(FOR_UV[name], ("," if name == "find-links" else " ").join(value.split()))
    return [str(Path(sys.executable).with_name("uv"))]


def pip_settings(listed: str) -> dict[str, str]:
    """What `pip config list` says of installing, later files and the environment before earlier ones."""
    found = re.findall(r"^(?:global|install|:env:)\.([\w-]+)=(.+)$", listed, flags=re.MULTILINE)
    return {name: str(ast.literal_eval(value)) for name, value in found}


def requirements(root: Path, extras: Iterable[str]) -> list[str]:
    """What the package and some of its extras ask for, as its pyproject.toml says it; extras of extras are followed."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    own, found, seen, left = f"{project['name']}[", list(project["dependencies"]), set[str](), list(extras)
    while left:
        extra = left.pop()
        if extra in seen:
            continue
        seen.add(extra)
        for each in project["optional-dependencies"][extra]:
            if each.startswith(own):
                left += each.removeprefix(own).rstrip("]").split(",")
            else:
                found.append(each)
    return sorted(set(found))


def _files(root: Path) -> Iterator[Path]:
    """The files of `SOURCES`, sorted; links to elsewhere are not followed."""
    for name in SOURCES:
        start = root / name
        for path in [start] if start.is_file() else sorted(start.rglob("*")):
            left_out = path.suffix in LEFT_OUT or LEFT_OUT & set(path.relative_to(root).parts)
            if path.is_file() and not path.is_symlink() and not left_out:
                yield path


if __name__ == "__main__":
    SITE, STAMP = Path(sysconfig.get_path("platlib")), Path(sys.prefix) / "flexdyn-installed.json"
    WHEEL = Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else None
    sys.exit(main(Path(__file__).parents[1], SITE, STAMP, sys.argv[1], [sys.executable, "-m", "pip"], WHEEL, ready_uv))
