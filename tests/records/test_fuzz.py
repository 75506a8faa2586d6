"""Readers under fire: whatever the bytes, a recording or one clear line. The long run is `scripts/fuzz.py`."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from flexdyn.errors import InputError
from flexdyn.records import SUFFIXES, Recording, read_recording, write_recording
from flexdyn.records.files import FORMATS
from flexdyn.records.matlab import file as mat_file
from flexdyn.records.request import Request

REC = Recording([0.0, 0.1, 0.3], {"q.a": [1.0, 2.0, 3.0], "tau.a/b": [0.1, 0.2, 0.3]}, meta={"a": 1})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all files of this module."""
    return tmp_path_factory.mktemp("fuzz")


def whole(folder: Path, suffix: str) -> bytes:
    """A valid file of this format."""
    path = folder / f"whole{suffix}"
    if not path.exists():
        write_recording(REC, path)
    return path.read_bytes()


def survives(folder: Path, suffix: str, data: bytes) -> bool:
    """Whether the bytes read as a recording; any answer but that and one line fails the test."""
    path = folder / f"bad{suffix}"
    path.write_bytes(data)
    try:
        read_recording(path)
    except InputError as error:
        line = str(error)
        assert line.startswith(str(path))
        assert line.isprintable()
        assert len(line) < 700 + len(str(path))
        return False
    return True


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=30, deadline=None)
@given(data=st.binary(max_size=400))
@example(data=b"t,q.a\n0,\x00\n1,2\n")
@example(data=b"\xff\xfet\x00,\x00q\x00\n\x00")
@example(data=b"t,q\n0,1\x1c2\n1,\x0b2\n2,\x0c")
def test_random_bytes(folder: Path, suffix: str, data: bytes) -> None:
    """Noise is answered with a line."""
    survives(folder, suffix, data)


@settings(max_examples=80, deadline=None)
@given(text=st.text(st.sampled_from('tq.,;\t\n\r #0123456789eE+-_naif\ufeff\u2028\x85\x1c\x00"'), max_size=60))
def test_random_tables(folder: Path, text: str) -> None:
    """Text made of what tables are made of reaches further into the reader than noise does."""
    survives(folder, ".csv", b"t,q\n" + text.encode())
    survives(folder, ".csv", text.encode())


@pytest.mark.parametrize("suffix", [".npz", ".h5", ".parquet", ".mat"])
def test_every_truncation_is_refused(folder: Path, suffix: str) -> None:
    """A copy that stopped anywhere is noticed."""
    data = whole(folder, suffix)
    for length in range(0, len(data), 23):
        assert not survives(folder, suffix, data[:length])


def test_truncated_tables_keep_to_a_line(folder: Path) -> None:
    """A cut table may still be a table; it never raises anything else."""
    data = whole(folder, ".csv")
    assert sum(survives(folder, ".csv", data[:length]) for length in range(len(data))) < len(data) / 2


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=40, deadline=None)
@given(changes=st.lists(st.tuples(st.integers(0, 2**16), st.integers(0, 255)), min_size=1, max_size=6))
def test_changed_bytes(folder: Path, suffix: str, changes: list[tuple[int, int]]) -> None:
    """Damage anywhere in a valid file gives a recording or a line."""
    data = bytearray(whole(folder, suffix))
    for position, value in changes:
        data[position % len(data)] = value
    survives(folder, suffix, bytes(data))


@pytest.fixture(scope="module")
def mat73(folder: Path) -> bytes:
    """A valid MAT-file of version 7.3, which is written where a variable is too large for version 5."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mat_file, "LARGEST_V5", 0)
        write_recording(REC, folder / "large.mat")
    return (folder / "large.mat").read_bytes()


def test_every_truncation_of_version_73_is_refused(folder: Path, mat73: bytes) -> None:
    """A copy that stopped anywhere is noticed."""
    for length in range(0, len(mat73), 61):
        assert not survives(folder, ".mat", mat73[:length])


@settings(max_examples=40, deadline=None)
@given(changes=st.lists(st.tuples(st.integers(0, 2**16), st.integers(0, 255)), min_size=1, max_size=6))
def test_changed_bytes_of_version_73(folder: Path, mat73: bytes, changes: list[tuple[int, int]]) -> None:
    """Damage anywhere gives a recording or a line."""
    data = bytearray(mat73)
    for position, value in changes:
        data[position % len(data)] = value
    survives(folder, ".mat", bytes(data))


@pytest.mark.parametrize("columns", [frozenset({"t", "q.a"}), frozenset({"q.a(:,1)", 2}), None])
@settings(max_examples=20, deadline=None)
@given(changes=st.lists(st.tuples(st.integers(0, 2**16), st.integers(0, 255)), max_size=6))
def test_changed_bytes_read_with_a_map(
    folder: Path, columns: frozenset[str | int] | None, changes: list[tuple[int, int]]
) -> None:
    """The raw columns that a channel map asks for: a table, or a line."""
    for suffix in (".csv", ".mat", ".parquet"):
        data = bytearray(whole(folder, suffix))
        for position, value in changes:
            data[position % len(data)] = value
        (folder / f"raw{suffix}").write_bytes(data)
        with contextlib.suppress(InputError):
            FORMATS[suffix].read(folder / f"raw{suffix}", Request(columns=columns, mapped=True))
