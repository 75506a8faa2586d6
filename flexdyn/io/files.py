"""Files: written into temporary ones, which are then renamed, so that nothing is incomplete; texts of bounded size."""

from __future__ import annotations

import os
import secrets
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from flexdyn.checks import check_known
from flexdyn.errors import InputError, did_you_mean


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Open a temporary file next to `path`; on success it replaces `path`, on failure it is removed.

    Raises:
        InputError: the folder does not exist, or the target is not a regular file.
    """
    target = Path(os.path.realpath(path))
    if not target.parent.is_dir():
        raise InputError("no such folder", file=path, value=str(path.parent), remedy="make it first")
    if target.exists() and not target.is_file():
        raise InputError("not a regular file", file=path, remedy="give the path of a file")
    fresh = target.with_name(f".{secrets.token_hex(8)}.tmp")
    try:
        yield fresh
        with open(fresh, "rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(fresh, target)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror or error})", file=path) from None
    finally:
        with suppress(OSError):  # it has replaced the path, or the disk is read-only
            fresh.unlink()


def exists(path: str | Path) -> bool:
    """Whether the path exists; False for a name that no file can have, or in a folder that cannot be read."""
    try:
        return Path(path).exists()
    except (OSError, ValueError):
        return False


def is_file(path: str | Path) -> bool:
    """Whether the path exists and is a file; like `exists` otherwise."""
    return exists(path) and Path(path).is_file()


def check_suffix(path: Path, suffixes: Collection[str], what: str, **where: Any) -> None:
    """Refuse a path with another suffix; the remedy names the most similar one and all.

    Args:
        path: of a file.
        suffixes: that are known.
        what: the file is, for the message.
        where: further arguments of `InputError`.

    Raises:
        InputError: the suffix is none of these.
    """
    suffix, known = path.suffix.lower(), f"known: {', '.join(suffixes)}"
    near = did_you_mean(suffix, suffixes)
    remedy = near if near == known else f"{near} {known}"
    check_known(suffix, suffixes, f"unknown suffix of {what}", file=path, value=path.suffix, remedy=remedy, **where)


def make_folder(path: Path) -> None:
    """Make a folder and those above it, unless they are there.

    Raises:
        InputError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = f"the folder cannot be made ({error.strerror})"
        raise InputError(problem, file=path, remedy="give the path of another folder") from None


def relative(path: Path, folder: Path) -> str:
    """A path as seen from a folder, with slashes; an absolute one on another drive."""
    try:
        return Path(os.path.relpath(path, folder.resolve())).as_posix()
    except ValueError:
        return path.as_posix()


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8, completely or not at all."""
    with replacing(path) as fresh:
        fresh.write_text(text, encoding="utf-8")


def bounded_text(path: Path, most: int, *, encoding: str, remedy: str) -> str:
    """The text of a file from an unknown source.

    Args:
        path: of the file.
        most: largest size that is read [bytes].
        encoding: UTF-8, with or without a mark at its begin.
        remedy: what to do if the file is too large.

    Raises:
        InputError: no such file, one that cannot be read, one that is too large, or no text in UTF-8.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(most + 1)
    except FileNotFoundError:
        raise InputError("there is no such file", file=path) from None
    except OSError as error:
        raise InputError(f"it cannot be read ({error.strerror})", file=path) from None
    if len(data) > most:
        raise InputError(f"the file is larger than {most} bytes", file=path, remedy=remedy)
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        raise InputError("it is not a text file in UTF-8", file=path) from None
