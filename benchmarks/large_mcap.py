"""A log of hours: JointState messages in one MCAP file, read in bounded memory; beside rosbags' own deserialiser.

The file is written by rosbags alone. It is read in fresh processes, by `flexdyn.read_recording` and by the plain loop
that deserialises message after message (over the first part of the file only: its time grows with the messages).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from measure import Bound, conclude
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.enums import CompressionMode
from rosbags.rosbag2.writer import CompressionFormat
from rosbags.typesys import Stores, get_typestore

JOINTS = tuple(f"joint_{number}" for number in range(1, 7))
COLUMNS = 1 + 3 * len(JOINTS)
TYPE = "sensor_msgs/msg/JointState"

# VmHWM and not ru_maxrss: on Linux the latter starts from the parent's peak, even across exec, and hides the run.
READ = """
import json, sys, time
from pathlib import Path
import flexdyn as fd

def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))

small, large = sys.argv[1:3]
fd.read_recording(small)
before, shares, begin = peak(), [], time.process_time()
rec = fd.read_recording(large, progress=shares.append)
seconds = time.process_time() - begin
sums = [float(rec.t.sum()), float(rec["q.joint_1"].sum()), float(rec["tau.joint_6"][-1])]
held = rec.t.nbytes + sum(values.nbytes for values in rec.channels.values())
print(json.dumps([len(rec), peak() - before, held, seconds, len(shares), shares == sorted(shares), *sums]))
"""

LOOP = """
import json, sys, time
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_HUMBLE)
most, done, begin = int(sys.argv[2]), 0, time.process_time()
with Reader(sys.argv[1]) as reader:
    for connection, _, raw in reader.messages():
        store.deserialize_cdr(raw, connection.msgtype)
        done += 1
        if done == most:
            break
print(json.dumps([done, time.process_time() - begin]))
"""


def make(folder: Path, rows: int, *, packed: bool) -> tuple[Path, list[float]]:
    """Write a file of `rows` messages at 1 kHz with rosbags.

    Returns:
        its path, and the sums that a right reader finds.
    """
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    marks = np.arange(1.0, 1.0 + 3 * len(JOINTS)).reshape(3, -1)
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](7, 8), "base_link")
    first = bytes(store.serialize_cdr(types[TYPE](header, list(JOINTS), *marks), TYPE))
    places = [first.index(list_of.tobytes()) for list_of in marks]
    sums = [0.0, 0.0, 0.0]
    rng = np.random.default_rng(1)
    bag = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
    if packed:
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with bag as writer:
        link = writer.add_connection("/joint_states", TYPE, typestore=store)
        for begin in range(0, rows, 10_000):
            stamps = np.arange(begin, min(rows, begin + 10_000), dtype=np.int64) * 1_000_000 + 1_000_000
            block = np.tile(np.frombuffer(first, np.uint8), (len(stamps), 1))
            values = rng.standard_normal((3, len(stamps), len(JOINTS)))
            block[:, 4:8] = (stamps // 10**9).astype("<u4")[:, None].view(np.uint8)
            block[:, 8:12] = (stamps % 10**9).astype("<u4")[:, None].view(np.uint8)
            for place, numbers in zip(places, values, strict=True):
                block[:, place : place + 8 * len(JOINTS)] = np.ascontiguousarray(numbers).view(np.uint8)
            for row, stamp in enumerate(stamps.tolist()):
                writer.write(link, stamp, block[row].tobytes())
            sums = [sums[0] + float((stamps / 1e9).sum()), sums[1] + float(values[0, :, 0].sum()), values[2, -1, -1]]
    return folder / f"{folder.name}.mcap", sums


def _python(code: str, *arguments: str) -> list[float]:
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    numbers: list[float] = json.loads(done.stdout)
    return numbers


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the file, read it, print the table and check the bounds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=1_000_000, help="messages; 10_000_000 makes a file of 3.2 GB")
    parser.add_argument("--zstd", action="store_true", help="compress the chunks")
    parser.add_argument("-o", type=Path, help="JSON file of the results")
    options = parser.parse_args(arguments)
    with TemporaryDirectory() as folder:
        small, _ = make(Path(folder) / "small", 10_000, packed=options.zstd)
        begin = time.perf_counter()
        large, sums = make(Path(folder) / "large", options.rows, packed=options.zstd)
        print(f"written by rosbags in {time.perf_counter() - begin:.0f} s, {os.path.getsize(large) / 1e9:.2f} GB")
        count, growth, held, seconds, calls, ordered, *found = _python(READ, str(small), str(large))
        done, loop = _python(LOOP, str(large), str(min(options.rows, 300_000)))
        size = os.path.getsize(large)
    if count != options.rows or held != 8 * COLUMNS * options.rows or not ordered:
        raise RuntimeError(f"not the file that was meant: {count} messages, {held} bytes of columns")
    np.testing.assert_allclose(found, sums, rtol=1e-9, atol=1e-6)
    ratio = (loop / done) / (seconds / count)
    bounds = [
        Bound("peak memory above what was there, over the columns' size", growth / held, 3.0),
        Bound("time per message over that of rosbags' deserialising loop", 1.0 / ratio, 1.0),
    ]
    print("| reader | us per message | messages/s |\n|---|---|---|")
    print(f"| flexdyn.read_recording | {1e6 * seconds / count:.2f} | {count / seconds:,.0f} |")
    print(f"| rosbags, one deserialize_cdr per message | {1e6 * loop / done:.2f} | {done / loop:,.0f} |")
    print(f"memory grew by {growth / 1e9:.2f} GB for columns of {held / 1e9:.2f} GB; {calls:.0f} reports of progress")
    command = f"python benchmarks/large_mcap.py --rows {options.rows}{' --zstd' if options.zstd else ''}"
    content = {
        "rosbags": version("rosbags"),
        "messages": count,
        "joints": len(JOINTS),
        "file_bytes": size,
        "columns_bytes": held,
        "growth_bytes": growth,
        "seconds": round(seconds, 2),
        "microseconds_per_message": round(1e6 * seconds / count, 3),
        "rosbags_microseconds_per_message": round(1e6 * loop / done, 3),
        "times_faster": round(ratio, 2),
    }
    return conclude(bounds, options.o, command, content)


if __name__ == "__main__":
    sys.exit(main())
