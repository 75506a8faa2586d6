"""Bags that are damaged or made to hurt: one line, bounded memory, and nothing outside the bag is opened."""

from __future__ import annotations

import bz2
import sqlite3
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags import rosbag1
from rosbags.interfaces import Nodetype
from rosbags.rosbag2.storage_mcap import ChunkInfo

from flexdyn.errors import InputError
from flexdyn.records import read_recording
from flexdyn.records.ros.guard import Chunk, check_index
from flexdyn.records.ros.walk import lay_out
from tests.records.ros_bags import JOINT_STATE, Maker, Message, refused

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAGIC = b"\x89MCAP0\r\n"
ZEROS = bytes(2**25)


def few(maker: Maker, count: int = 4) -> list[Message]:
    """A few joint states of one joint."""
    return [("/joint_states", JOINT_STATE, row, maker.state(row, ["a"], [row])) for row in range(1, count + 1)]


def made(folder: Path, kind: str, count: int = 4) -> Path:
    """A good bag."""
    maker = Maker(ros1=kind.startswith("bag"))
    return maker.write(folder, kind, few(maker, count))


@pytest.mark.parametrize("kind", ["bag", "bag lz4", "bag bz2", "mcap", "mcap zstd", "db3"])
def test_cut_anywhere(tmp_path: Path, kind: str) -> None:
    """A copy that stopped is noticed at every length."""
    path = made(tmp_path, kind)
    data = path.read_bytes()
    for length in range(0, len(data), max(1, len(data) // 150)):
        path.write_bytes(data[:length])
        refused(path)


DAMAGED = ("bag bz2", "bag lz4", "mcap zstd", "db3")


@pytest.fixture(scope="module")
def wholes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A good bag of each kind, made once."""
    return {kind: made(tmp_path_factory.mktemp("whole"), kind) for kind in DAMAGED}


@pytest.mark.parametrize("kind", DAMAGED)
@settings(max_examples=40, deadline=None)
@given(changes=st.lists(st.tuples(st.integers(0, 2**16), st.integers(0, 255)), min_size=1, max_size=4))
def test_changed_bytes(wholes: dict[str, Path], kind: str, changes: list[tuple[int, int]]) -> None:
    """Damage anywhere in a bag that others wrote gives a recording or a line."""
    whole = wholes[kind]
    data = bytearray(whole.read_bytes())
    for position, value in changes:
        data[position % len(data)] = value
    path = whole.with_name(f"changed{whole.suffix}")
    path.write_bytes(data)
    line = ""
    try:
        read_recording(path)
    except InputError as error:
        line = str(error)
    assert not line or line.startswith(str(path))
    assert line.isprintable()


def record(kind: int, data: bytes) -> bytes:
    """A record of an MCAP file."""
    return struct.pack("<BQ", kind, len(data)) + data


def mcap(*records: bytes) -> bytes:
    """An MCAP file without summary."""
    head = record(1, struct.pack("<I4sI", 4, b"ros2", 0))
    return MAGIC + head + b"".join(records) + record(2, bytes(20)) + MAGIC


def chunk(data: bytes, compression: bytes, plain: int) -> bytes:
    """A chunk of an MCAP file, and the size that it says it has."""
    name = struct.pack("<I", len(compression)) + compression
    return record(6, struct.pack("<QQQI", 0, 9, plain, 0) + name + struct.pack("<Q", len(data)) + data)


def test_chunks_that_unpack_to_more_than_they_say(tmp_path: Path) -> None:
    """Kilobytes that unpack to gigabytes are stopped at the size declared, and that one is bounded by the file's."""
    path = tmp_path / "log.mcap"
    path.write_bytes(mcap(chunk(zstd.compress(ZEROS), b"zstd", 1000)))
    refused(path, "zstd data unpack to more than 1000 bytes")
    path.write_bytes(mcap(chunk(zstd.compress(ZEROS), b"zstd", len(ZEROS))))
    refused(path, f"a chunk announces {len(ZEROS)} bytes")
    path.write_bytes(mcap(chunk(zstd.compress(bytes(900)) * 3, b"zstd", 1000)))
    refused(path, "zstd data unpack to more than 1000 bytes")
    path.write_bytes(mcap(chunk(b"x" * 50, b"zstd", 2**63)))
    refused(path, "a chunk announces 9223372036854775808 bytes")


def test_chunks_of_a_bag_that_unpack_to_more_than_the_bag_can_hold(tmp_path: Path) -> None:
    """The same in ROS 1, whose chunks say nothing of their size that rosbags would check."""
    maker = Maker(ros1=True)
    path = tmp_path / "log.bag"
    writer = rosbag1.Writer(path)
    writer.compression_format, writer.compressor = "bz2", lambda data: bz2.compress(data + ZEROS)
    with writer:
        link = writer.add_connection("/joint_states", JOINT_STATE, typestore=maker.store)
        for _, kind, time, message in few(maker):
            writer.write(link, time, maker.raw(kind, message))
    refused(path, "bz2 data unpack to more than")


def test_messages_and_files_that_unpack_to_more(tmp_path: Path) -> None:
    """Compression around a message or around a whole file is bounded too."""
    maker = Maker()
    bag = maker.write(tmp_path, "folder db3", [("/joint_states", JOINT_STATE, 1, zstd.compress(ZEROS))])
    meta = bag / "metadata.yaml"
    text = meta.read_text()
    packed = text.replace("compression_format: ''", "compression_format: zstd")
    meta.write_text(packed.replace("compression_mode: ''", "compression_mode: message"))
    refused(bag, "zstd data unpack to more than 16777216 bytes")
    (bag / "log.db3").write_bytes(zstd.compress(ZEROS))
    meta.write_text(packed.replace("compression_mode: ''", "compression_mode: file"))
    refused(bag, "the file unpacks to more than 1100 times its size")
    meta.write_text(text.replace("compression_mode: ''", "compression_mode: rar"))
    refused(bag, "this compression is not supported, got 'rar none'")


def test_an_index_that_lies(tmp_path: Path) -> None:
    """Chunks named twice, chunks that are not there, and too many unpacked at one time."""

    def info(offset: int, begin: int, end: int, plain: int) -> ChunkInfo:
        return ChunkInfo(begin, end, offset, plain, {}, 0, "", plain, plain, {})

    chunks = {offset: Chunk(offset, "", 2**29, 2**29) for offset in range(8)}
    check_index([info(offset, offset, offset, 2**29) for offset in range(8)], chunks)
    check_index([info(offset, 0, 9, 2**29) for offset in range(4)], chunks)
    for index, words in (
        ([info(0, 0, 9, 2**29)] * 2, "the index disagrees"),
        ([info(9, 0, 9, 2**29)], "the index disagrees"),
        ([info(0, 0, 9, 2**30)], "the index disagrees"),
        ([info(offset, 0, offset, 2**29) for offset in range(8)], "overlap in time"),
    ):
        with pytest.raises(InputError, match=words):
            check_index(index, chunks)


def test_a_count_that_lies(tmp_path: Path) -> None:
    """Messages that the statistics do not count, or that are not there."""
    path = made(tmp_path, "mcap")
    data = path.read_bytes()
    count = struct.pack("<HQ", 1, 4)
    assert data.count(count) == 1
    for other, words in ((3, "more messages than the 3"), (5, "4 messages where the index announces 5")):
        path.write_bytes(data.replace(count, struct.pack("<HQ", 1, other)))
        refused(path, words)
    path.write_bytes(data.replace(count, struct.pack("<HQ", 1, 2**50)))
    refused(path, "declares [0-9]+ bytes of arrays")


def changed(old: str, new: str) -> Callable[[str], str]:
    """An edit of metadata.yaml."""
    return lambda text: text.replace(old, new)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (
            changed("- log.mcap", "- ../../../../etc/passwd"),
            "a file of the bag is missing, got '../../../../etc/passwd'",
        ),
        (changed("- log.mcap", "- .."), "a file of the bag is missing, got '..'"),
        (changed("- log.mcap", "- ''"), "a file of the bag is missing, got ''"),
        (changed("- log.mcap", "- {a: b}"), "a file of the bag is missing"),
        (changed("- log.mcap", "- metadata.yaml"), "this storage is not supported, got 'metadata.yaml'"),
        (changed("- log.mcap", "- outside.mcap"), "a link out of its folder, got 'outside.mcap'"),
        (lambda _: "rosbag2_bagfile_information: 5", "it lists no files of a ROS 2 bag"),
        (lambda _: "rosbag2_bagfile_information: {relative_file_paths: []}", "it lists no files of a ROS 2 bag"),
        (lambda _: "- 1", "a mapping of keys is needed"),
        (lambda _: "a: &a [1]\nb: &b [" + "*a," * 5000 + "]\nc: [" + "*b," * 5000 + "]", "aliases unfold"),
        (lambda _: "a: !!python/object/apply:os.system ['true']", "not valid YAML"),
        (lambda _: "\0", "metadata.yaml"),
    ],
)
def test_metadata_that_lie(tmp_path: Path, edit: Callable[[str], str], words: str) -> None:
    """metadata.yaml names files of its own folder, and nothing else is opened."""
    bag = made(tmp_path, "folder mcap")
    (bag / "log.mcap").rename(tmp_path / "elsewhere.mcap")
    (bag / "outside.mcap").symlink_to(tmp_path / "elsewhere.mcap")
    meta = bag / "metadata.yaml"
    meta.write_text(edit(meta.read_text()))
    refused(bag, words)


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("DROP TABLE messages", "not a bag, truncated, or damaged"),
        ("UPDATE messages SET data = 'text'", "a message is not bytes"),
        ("UPDATE messages SET data = zeroblob(20000000)", "."),
        ("UPDATE messages SET data = x'00'", "not in CDR"),
        ("UPDATE messages SET data = zeroblob(21)", "is cut or of another type"),
        ("UPDATE topics SET type = 'std_msgs/msg/Float64'", "no topic of joint states"),
        ("UPDATE message_definitions SET encoded_message_definition = 'float64 \"'", "the definition of"),
        ("UPDATE message_definitions SET encoded_message_definition = 'Foo bar'", "is not defined in the bag"),
        ("UPDATE message_definitions SET encoded_message_definition = 'sensor_msgs/JointState a'", "nests too deep"),
        ("UPDATE message_definitions SET encoded_message_definition = 'float64[4000000000] a'", "is cut"),
        ("DELETE FROM messages", "no topic of joint states"),
    ],
)
def test_databases_of_another_kind(tmp_path: Path, script: str, words: str) -> None:
    """Tables that are not there, numbers of another type, definitions that do not fit or never end."""
    path = made(tmp_path, "db3")
    with sqlite3.connect(path) as base:
        base.executescript(script)
    base.close()
    refused(path, words)


def test_a_path_that_is_no_uri(tmp_path: Path) -> None:
    """SQLite is given the path as it is, whatever signs of a URI stand in it."""
    path = tmp_path / "a?mode=rw%20#b.db3"
    made(tmp_path, "db3").rename(path)
    assert read_recording(path)["q.a"].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_nothing_of_a_definition_is_executed() -> None:
    """Layouts come from parsed fields alone; zero-sized messages by the billion end in a line."""
    nested = {
        "a/msg/A": [("list", (Nodetype.SEQUENCE, ((Nodetype.NAME, "a/msg/B"), 0)))],
        "a/msg/B": [("list", (Nodetype.ARRAY, ((Nodetype.NAME, "a/msg/E"), 3000)))],
        "a/msg/E": [],
    }
    raw = struct.pack("<I", 3000) + bytes(4000)
    with pytest.raises(InputError, match="more than 100000 fields"):
        lay_out(raw, "a/msg/A", nested, cdr=False)
    with pytest.raises(InputError, match="cut or of another type"):
        lay_out(struct.pack("<I", 2**32 - 1) + bytes(40), "a/msg/A", nested, cdr=False)


def test_many_layouts_in_one_block(tmp_path: Path) -> None:
    """Texts that change with every message cost time, not correctness."""
    maker = Maker()
    messages: list[Message] = [
        ("/s", JOINT_STATE, row, maker.state(row, ["a"], [row], frame=f"{row:04d}")) for row in range(1, 400)
    ]
    rec = read_recording(maker.write(tmp_path, "mcap", messages))
    np.testing.assert_array_equal(rec["q.a"], np.arange(1.0, 400.0))


def test_a_database_without_its_last_bytes(tmp_path: Path) -> None:
    """Some versions of SQLite read on, as long as the end is not needed."""
    path = made(tmp_path, "db3")
    data = path.read_bytes()
    path.write_bytes(data[:-1])
    refused(path, f"truncated: {len(data)} bytes are announced, got '{len(data) - 1} bytes'")
    path.write_bytes(data + bytes(4096))
    assert read_recording(path).t.size == 4


def test_messages_that_are_left_in_a_journal(tmp_path: Path) -> None:
    """A recorder that was killed leaves messages beside the database: none is lost in silence."""
    path = made(tmp_path, "db3")
    base = sqlite3.connect(path)
    base.execute("PRAGMA journal_mode = WAL")
    base.execute("DELETE FROM messages WHERE id = 4")
    base.commit()
    refused(path, "messages are left in the journal, got 'log.db3-wal'")
    base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    base.close()
    assert read_recording(path)["q.a"].tolist() == [1.0, 2.0, 3.0]
