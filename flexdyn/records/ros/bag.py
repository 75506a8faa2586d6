"""An open bag: its topics, and their messages as bytes in the order of recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from flexdyn.errors import InputError
from flexdyn.io.yaml import read_yaml
from flexdyn.records.ros.definitions import stored
from flexdyn.records.ros.guard import (
    MOST_MESSAGE,
    BoundedReader,
    check_database,
    check_index,
    check_mcap,
    unpack_file,
    unpacked,
)
from flexdyn.records.ros.walk import Fields, MessageLayout, lay_out
from flexdyn.records.ros.words import check_word, shortened_list
from flexdyn.records.table import damage_named

_SQLITE_LIMIT_LENGTH = 0


@dataclass
class Topic:
    """One topic of a bag.

    Attributes:
        name: such as ``/joint_states``.
        msgtype: such as ``sensor_msgs/msg/JointState``.
        connections: rosbags' connections, by the number of their storage.
        count: number of messages in the index; None if it is not there.
    """

    name: str
    msgtype: str
    connections: dict[int, list[Any]] = field(default_factory=dict)
    count: int | None = 0


@dataclass
class Bag:
    """An open bag.

    Attributes:
        topics: by name.
        cdr: whether messages are encoded as in ROS 2.
        size: bytes on disk.
        total: number of messages in the whole bag.
    """

    storages: Sequence[Any]
    unpack: Callable[[bytes], bytes] | None
    cdr: bool
    size: int
    topics: dict[str, Topic] = field(default_factory=dict)
    total: int = 0
    _fields: dict[str, list[Fields]] = field(default_factory=dict)

    def messages(self, topics: Sequence[Topic]) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and bytes of every message of some topics.

        Raises:
            InputError: a message is not bytes, or too long; or the bag is damaged.
        """
        for number, storage in enumerate(self.storages):
            wanted = [connection for topic in topics for connection in topic.connections.get(number, ())]
            with _errors_of_rosbags():
                for connection, time, raw in storage.messages(wanted) if wanted else ():
                    if not isinstance(raw, bytes) or len(raw) > MOST_MESSAGE:
                        problem = f"a message is not bytes, or more than {MOST_MESSAGE} of them"
                        raise InputError(problem, key=connection.topic, remedy="choose another topic")
                    yield connection.topic, time, raw if self.unpack is None else self.unpack(raw)

    def layout(self, topic: Topic, raw: bytes) -> MessageLayout:
        """The layout of a message; if the bag does not define its type, that of the first type that fits.

        Args:
            topic: of the message.
            raw: its bytes.
        """
        if topic.name not in self._fields:
            connection = next(iter(topic.connections.values()))[0]
            self._fields[topic.name] = list(stored(connection.msgdef, topic.msgtype, cdr=self.cdr))
        known = self._fields[topic.name]
        while len(known) > 1:
            try:
                return lay_out(raw, topic.msgtype, known[0], cdr=self.cdr)
            except InputError:
                del known[0]
        return lay_out(raw, topic.msgtype, known[0], cdr=self.cdr)


@contextmanager
def opened(path: Path) -> Iterator[Bag]:
    """Open a bag: a file by its suffix, or the folder of a ROS 2 bag.

    Raises:
        InputError: it is no bag, or damaged.
    """
    with ExitStack() as stack:
        files, unpack = _files(path, stack) if path.is_dir() else ([path], None)
        storages = [_storage(file, stack) for file in files]
        size = sum(file.stat().st_size for file in files)
        bag = Bag(storages, unpack, not isinstance(storages[0], BoundedReader), size)
        with _errors_of_rosbags():
            for number, storage in enumerate(storages):
                _add_topics(bag, number, storage)
        yield bag


@contextmanager
def _errors_of_rosbags() -> Iterator[None]:
    """Any error of rosbags as one line."""
    try:
        with damage_named("not a bag, truncated, or damaged"):
            yield
    except MemoryError:
        problem = "truncated or damaged: a part of it declares more than fits into memory"
        raise InputError(problem, remedy="copy the file again") from None


def _storage(path: Path, stack: ExitStack) -> Any:
    """A file of a bag, opened by its reader after its sizes were checked."""
    suffix = path.suffix.lower()
    with _errors_of_rosbags():
        if suffix == ".mcap":
            chunks = check_mcap(path)
            storage = McapReader(path)
        elif suffix == ".db3":
            check_database(path)
            storage = Sqlite3Reader(Path(quote(str(path))))  # rosbags makes a URI of it
        else:
            storage = BoundedReader(path)
        storage.open()
        stack.callback(storage.close)
        if suffix == ".mcap":
            check_index(storage.chunks, chunks)
        elif suffix == ".db3":
            storage.dbconn.limit(_SQLITE_LIMIT_LENGTH, MOST_MESSAGE)
    return storage


def _add_topics(bag: Bag, number: int, storage: Any) -> None:
    """Add the topics of a storage."""
    total = storage.message_count if isinstance(storage, BoundedReader) else storage.metadata.message_count
    bag.total += total
    for connection in storage.connections:
        check_word(connection.topic, "topic")
        check_word(connection.msgtype, "message type")
        topic = bag.topics.setdefault(connection.topic, Topic(connection.topic, connection.msgtype))
        if topic.msgtype != connection.msgtype:
            problem = f"the topic has messages of {shortened_list((topic.msgtype, connection.msgtype))}"
            raise InputError(problem, key=topic.name, remedy="split the bag")
        topic.connections.setdefault(number, []).append(connection)
        if topic.count is not None:
            topic.count += connection.msgcount
    if total and not any(connection.msgcount for connection in storage.connections):
        for topic in bag.topics.values():
            topic.count = None


def _files(path: Path, stack: ExitStack) -> tuple[list[Path], Callable[[bytes], bytes] | None]:
    """The files of a ROS 2 bag's folder, in order, and the unpacking of its messages."""
    info = read_yaml(path / "metadata.yaml").get("rosbag2_bagfile_information")
    names = info.get("relative_file_paths") if isinstance(info, dict) else None
    if not isinstance(info, dict) or not isinstance(names, list) or not names:
        remedy = "copy the whole folder, or read the .mcap or .db3 file in it"
        raise InputError("it lists no files of a ROS 2 bag", file=path / "metadata.yaml", remedy=remedy)
    mode = str(info.get("compression_mode") or "none").lower()
    kind = str(info.get("compression_format") or "none").lower()
    if mode not in ("none", "file", "message") or (mode != "none" and kind != "zstd"):
        problem = "this compression is not supported"
        remedy = "convert it with ros2 bag"
        raise InputError(problem, file=path / "metadata.yaml", value=f"{mode} {kind}", remedy=remedy)
    files = [_inside(path, name) for name in names]
    if mode == "file":
        folder = Path(stack.enter_context(TemporaryDirectory()))
        for index, packed in enumerate(files):
            plain = folder / f"{index}{PurePath(packed.stem).suffix}"
            with damage_named(f"{packed.name} cannot be unpacked"):
                unpack_file(packed, plain)
            files[index] = plain
    if bad := [file.name for file in files if file.suffix.lower() not in (".mcap", ".db3")]:
        raise InputError("this storage is not supported", value=bad[0], remedy="known: .mcap, .db3")
    return files, (lambda raw: unpacked(raw, "zstd", MOST_MESSAGE)) if mode == "message" else None


def _inside(folder: Path, name: object) -> Path:
    """A file in the metadata; a folder in its name (as in older bags) is ignored."""
    file = folder / PurePath(str(name)).name
    if not file.is_file():
        remedy = "copy the whole folder"
        raise InputError("a file of the bag is missing", file=folder / "metadata.yaml", value=name, remedy=remedy)
    if file.resolve().parent != folder.resolve():
        remedy = "give the path of that file instead"
        raise InputError("a file of the bag is a link out of its folder", value=name, remedy=remedy)
    return file
