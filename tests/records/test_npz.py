"""NPZ: arrays by other hands are read; objects, lies about sizes and cut files are refused."""

from __future__ import annotations

import io
import json
import pickle
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording, read_recording, write_recording

T = np.array([0.0, 0.1, 0.2])


def npy(array: Any, **header: Any) -> bytes:
    """An array as .npy bytes; keywords replace what its header says."""
    stream = io.BytesIO()
    array = np.asarray(array)
    said = {"descr": array.dtype.str, "fortran_order": False, "shape": array.shape, **header}
    np.lib.format.write_array_header_1_0(stream, said)
    return stream.getvalue() + bytes(array.tobytes())


def zipped(path: Path, members: dict[str, bytes], method: int = zipfile.ZIP_STORED) -> Path:
    """A zip archive of these members."""
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_numpy_savez(tmp_path: Path, save: Any) -> None:
    """What savez writes is read, whatever its kind of real numbers."""
    save(tmp_path / "log.npz", **{"q.a": np.array([1, 2, 3], np.int16), "t": T, "tau.a": np.array([1, 2, 3], ">f4")})
    rec = read_recording(tmp_path / "log.npz")
    assert rec == Recording(T, {"q.a": [1, 2, 3], "tau.a": [1, 2, 3]})


def test_numpy_load_reads_what_is_written(tmp_path: Path) -> None:
    """Any NumPy user gets the arrays and meta without this package, even under names that savez refuses."""
    rec = Recording(T, {"q.a": T, "file": -T, "q.arm/one": 2 * T}, meta={"a": [1, {"b": "\u00fc"}]})
    write_recording(rec, tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz", allow_pickle=False) as arrays:
        assert arrays.files == ["t", "q.a", "file", "q.arm/one", "__meta__"]
        np.testing.assert_array_equal(arrays["q.arm/one"], 2 * T)
        assert json.loads(str(arrays["__meta__"])) == {"a": [1, {"b": "\u00fc"}]}
    assert read_recording(tmp_path / "log.npz") == rec


def test_the_same_recording_gives_the_same_bytes(tmp_path: Path) -> None:
    """No clock gets into the file."""
    rec = Recording(T, {"q.a": T}, meta={"a": 1})
    for name in ("one.npz", "two.npz"):
        write_recording(rec, tmp_path / name)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    with zipfile.ZipFile(tmp_path / "one.npz") as archive:
        assert {member.date_time for member in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


class Bomb:
    """Raises when unpickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Divide by zero on arrival."""
        return (divmod, (1, 0))


def test_objects_are_refused_without_unpickling(tmp_path: Path) -> None:
    """A pickle in the file is never executed."""
    array = np.array([Bomb(), 1, 2], dtype=object)
    columns: dict[str, Any] = {"t": T, "q.a": array}
    np.savez(tmp_path / "log.npz", **columns)
    with pytest.raises(InputError, match=r"q\.a: the column holds objects") as caught:
        read_recording(tmp_path / "log.npz")
    assert caught.value.channel == "q.a"
    zipped(tmp_path / "raw.npz", {"t.npy": npy(T), "q.a.npy": pickle.dumps(Bomb())})
    with pytest.raises(InputError, match=r"q\.a cannot be read"):
        read_recording(tmp_path / "raw.npz")


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"q.a.npy": npy(T)}, "no column t"),
        ({"time.npy": npy(T), "q.a.npy": npy(T)}, "did you mean 'time'"),
        ({"t.npy": npy(T), "q.a.npy": npy(T[:2])}, "q.a: 2 samples where t has 3"),
        ({"t.npy": npy(T), "q.a.npy": npy(T[:, None])}, r"q.a: the column has the shape \(3, 1\)"),
        ({"t.npy": npy(T), "q.a.npy": npy(1j * T)}, "q.a: the column holds the type complex128"),
        ({"t.npy": npy(T), "q.a.npy": npy(T, shape=(4,))}, "24 bytes where the shape"),
        ({"t.npy": npy(T), "q.a.npy": npy(T, shape=(2**60,))}, "24 bytes where the shape"),
        ({"t.npy": npy(T), "q.a.npy": npy(T, shape=(-3,))}, "24 bytes where the shape"),
        ({"t.npy": npy(T), "q.a.npy": npy([0, np.nan, 1])}, "q.a: row 1: not a finite number"),
        ({"t.npy": npy(T), "q.a.npy": npy(T)[:-8]}, "16 bytes where the shape"),
        ({"t.npy": npy(T), "q.a.npy": b""}, "q.a cannot be read"),
        ({"t.npy": npy(T), "q.a.npy": b"\x93NUMPY\x03\x00" + npy(T)[8:]}, "named fields"),
        ({"t.npy": npy(T), "q.a": npy(T)}, "more than NumPy's arrays, got 'q.a'"),
        ({"t.npy": npy(T), "q\n.npy": npy(T)}, "does not print"),
        ({"t.npy": npy(T), "q.a.npy": npy(T), "__meta__.npy": npy("[1]")}, "meta is not a JSON object"),
        ({"t.npy": npy(T), "q.a.npy": npy(T), "__meta__.npy": npy("{")}, "meta is not a JSON object"),
        ({"t.npy": npy(T), "q.a.npy": npy(T), "__meta__.npy": npy("[" * 200_000)}, "meta is not a JSON object"),
        ({"t.npy": npy(T), "q.a.npy": npy(T), "__meta__.npy": npy('{"a": NaN}')}, "meta cannot be written as JSON"),
        ({"t.npy": npy(T), "q.a.npy": npy(T), "__meta__.npy": npy(1.0)}, "meta is not one JSON text"),
        ({}, "no column t"),
    ],
)
def test_damage_is_named(tmp_path: Path, members: dict[str, bytes], words: str) -> None:
    """One line, the channel in it."""
    with pytest.raises(InputError, match=words) as caught:
        read_recording(zipped(tmp_path / "log.npz", members))
    assert str(caught.value).startswith(str(tmp_path / "log.npz"))
    assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_channel_twice_is_refused(tmp_path: Path) -> None:
    """An archive can hold one name twice; which one counts would be a guess."""
    with zipfile.ZipFile(tmp_path / "log.npz", "w") as archive:
        for name in ("t", "q.a", "q.a"):
            archive.writestr(f"{name}.npy", npy(T))
    with pytest.raises(InputError, match=r"q\.a: the channel is there twice"):
        read_recording(tmp_path / "log.npz")


def test_sizes_that_the_file_cannot_hold_are_refused(tmp_path: Path) -> None:
    """A directory that announces gigabytes in a small file is refused before anything is unpacked."""
    path = zipped(tmp_path / "log.npz", {"t.npy": npy(T), "q.a.npy": npy(T)})
    data = bytearray(path.read_bytes())
    entry = data.rindex(b"PK\x01\x02")
    struct.pack_into("<I", data, entry + 24, 2**31)
    path.write_bytes(data)
    with pytest.raises(InputError, match="declares 2147"):
        read_recording(path)


def test_samples_that_are_not_there_are_not_made_up(tmp_path: Path) -> None:
    """Header and directory agree on four samples, three are stored: the fourth would be whatever memory held."""
    path = zipped(tmp_path / "log.npz", {"t.npy": npy(T), "q.a.npy": npy(T, shape=(4,))})
    data = bytearray(path.read_bytes())
    entry = data.rindex(b"PK\x01\x02")
    (size,) = struct.unpack_from("<I", data, entry + 24)
    struct.pack_into("<I", data, entry + 24, size + 8)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"q\.a: cut after 24 of 32 bytes"):
        read_recording(path)


def test_long_names_do_not_flood_the_line(tmp_path: Path) -> None:
    """An error stays a line that can be read."""
    with pytest.raises(InputError, match="longer than 255 characters") as caught:
        read_recording(zipped(tmp_path / "log.npz", {"t.npy": npy(T), "q" * 60_000 + ".npy": npy(1j * T)}))
    assert len(str(caught.value)) < 400 + len(str(tmp_path))


def test_a_constant_channel_compresses_as_far_as_deflate_goes(tmp_path: Path) -> None:
    """An honest file, however well it compresses, is below the limit on expansion."""
    path = tmp_path / "log.npz"
    n = 1_000_000
    flat = {f"tau.j{k}.npy": npy(np.zeros(n)) for k in range(3)}
    zipped(path, {"t.npy": npy(np.arange(n, dtype=np.uint8))} | flat, zipfile.ZIP_DEFLATED)
    with pytest.raises(InputError, match="time runs backwards"):
        read_recording(path)


def test_other_compressions_are_refused(tmp_path: Path) -> None:
    """NumPy writes stored and deflated members; others have no limit on expansion."""
    members = {"t.npy": npy(T), "q.a.npy": npy(T)}
    with pytest.raises(InputError, match="more than NumPy's arrays"):
        read_recording(zipped(tmp_path / "log.npz", members, zipfile.ZIP_LZMA))


def test_a_flipped_bit_is_noticed(tmp_path: Path) -> None:
    """The archive's checksum guards every sample."""
    path = zipped(tmp_path / "log.npz", {"t.npy": npy(T), "q.a.npy": npy(T)})
    data = bytearray(path.read_bytes())
    data[data.index(T.tobytes()) + 9] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"the array t cannot be read .*CRC"):
        read_recording(path)
