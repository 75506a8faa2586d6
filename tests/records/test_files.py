"""Reading and writing in general: round trips, suffixes, and writes that happen whole or not at all."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from flexdyn.errors import InputError
from flexdyn.records import SUFFIXES, Recording, read_recording, write_recording
from flexdyn.records.channelmap.known_units import split_unit

REC = Recording([0.0, 0.1, 0.3], {"q.a": [1.0, 2.0, 3.0], "tau.a": [0.1, -0.0, 5e-324]}, meta={"a": {"b": [1, None]}})

DOUBLES = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([-0.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, 0.1, 1 / 3, 1e23, 2.0**53]),
)
NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("C", "Z"), include_characters=" "), min_size=1, max_size=12
).filter(
    lambda name: (
        name not in ("t", "__meta__")
        and name.isprintable()
        and "," not in name
        and name == name.strip()
        and name[-1] != "."
        and not split_unit(name)[1]  # a column "t[N]" is the time, in a wrong unit
    )
)


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    """Any recording: any doubles, any names."""
    t = np.array(sorted(draw(st.sets(DOUBLES, min_size=2, max_size=8))))
    names = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    return Recording(t, {name: draw(hnp.arrays(np.float64, len(t), elements=DOUBLES)) for name in names})


@pytest.mark.parametrize("suffix", [name for name in SUFFIXES if name not in (".bag", ".mcap", ".db3")])
@settings(max_examples=30, deadline=None)
@given(rec=recordings())
def test_every_double_and_name_comes_back_bit_for_bit(
    suffix: str, rec: Recording, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Subnormals, minus zero and extreme exponents survive in every format."""
    path = tmp_path_factory.mktemp("trip") / f"log{suffix}"
    write_recording(rec, path)
    back = read_recording(path)
    assert back == rec
    assert [values.tobytes() for values in back.channels.values()] == [v.tobytes() for v in rec.channels.values()]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_long_recordings_come_back(tmp_path: Path, suffix: str) -> None:
    """The blocks in which files are written and read leave no seam."""
    random = np.random.default_rng(3)
    rec = Recording(np.arange(30_000) * 1e-3, {f"q.j{k}": random.normal(size=30_000) for k in range(3)})
    write_recording(rec, tmp_path / f"log{suffix}")
    assert read_recording(tmp_path / f"log{suffix}") == rec


@pytest.mark.parametrize("suffix", [".npz", ".h5", ".hdf5"])
def test_meta_comes_back(tmp_path: Path, suffix: str) -> None:
    """NPZ and HDF5 keep meta, units of a prismatic joint included."""
    rec = Recording(REC.t, REC.channels, meta={"units": {"q.a": "m"}, "note": "\u00fc \ud83d\x00", "n": [1, 2.5, None]})
    write_recording(rec, tmp_path / f"log{suffix}")
    assert read_recording(tmp_path / f"log{suffix}") == rec


def test_arrays_read_from_files_are_locked(tmp_path: Path) -> None:
    """A recording from a file is as immutable as any."""
    for suffix in SUFFIXES:
        write_recording(REC, tmp_path / f"log{suffix}")
        back = read_recording(str(tmp_path / f"log{suffix}"))
        assert not any(values.flags.writeable for values in (back.t, *back.channels.values()))


def test_suffixes(tmp_path: Path) -> None:
    """Any case will do; an unknown suffix is answered with what is known."""
    write_recording(REC, tmp_path / "LOG.CSV")
    assert read_recording(tmp_path / "LOG.CSV").same_as(REC)
    for name in ("log.xyz", "log", "log.hdf"):
        for use in (read_recording, lambda path: write_recording(REC, path)):
            with pytest.raises(InputError, match=r"unknown suffix.*known: \.csv, \.npz, \.h5, \.hdf5"):
                use(tmp_path / name)
    with pytest.raises(InputError, match=r"did you mean '\.hdf5'"):
        read_recording("log.hdf")


def test_paths_that_are_no_files(tmp_path: Path) -> None:
    """Missing files, folders and pipes are said, never waited for."""
    (tmp_path / "dir.csv").mkdir()
    os.mkfifo(tmp_path / "pipe.csv")
    too_long = "no such file" if sys.version_info >= (3, 14) else "cannot be read"  # as Path.exists answers
    for name, words in {
        "none.csv": "no such file",
        "dir.csv": "not a regular file",
        "pipe.csv": "not a regular file",
        "a\0b.csv": "no such file",
        "x" * 300 + ".csv": too_long,
    }.items():
        with pytest.raises(InputError, match=words):
            read_recording(tmp_path / name)
    for name, words in {
        "none/log.csv": "no such folder",
        "dir.csv": "not a regular file",
        "pipe.csv": "not a regular file",
    }.items():
        with pytest.raises(InputError, match=words):
            write_recording(REC, tmp_path / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dir.csv", "pipe.csv"]


def break_writing(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Let every write fail after some of it is done."""

    def fail(*_: Any) -> None:
        raise error

    monkeypatch.setattr(os, "fsync", fail)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    ("error", "seen"),
    [(OSError(28, "No space left on device"), InputError), (KeyboardInterrupt(), KeyboardInterrupt)],
)
def test_a_failed_write_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, error: BaseException, seen: type[BaseException]
) -> None:
    """The old file stays to the last byte and nothing lies beside it."""
    path = tmp_path / f"log{suffix}"
    write_recording(REC, path)
    before = path.read_bytes()
    break_writing(monkeypatch, error)
    with pytest.raises(seen) as caught:
        write_recording(Recording([0.0, 1.0], {"q.b": [0.0, 1.0]}), path)
    if seen is InputError:
        assert "No space left" in str(caught.value)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_a_write_goes_through_links_and_keeps_the_usual_permissions(tmp_path: Path) -> None:
    """A link stays a link to the fresh file; the file is as readable as any that the user makes."""
    (tmp_path / "plain").touch()
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    write_recording(REC, tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert read_recording(tmp_path / "real.csv").same_as(REC)
    assert stat.S_IMODE((tmp_path / "real.csv").stat().st_mode) == stat.S_IMODE((tmp_path / "plain").stat().st_mode)
