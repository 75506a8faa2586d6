"""A bag as a table: topics chosen, columns collected, times merged."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.records.meta import from_json
from flexdyn.records.request import CLOCKS, Request
from flexdyn.records.ros.bag import Bag, Topic, opened
from flexdyn.records.ros.clock import YEAR, seconds
from flexdyn.records.ros.columns import CONVENTIONAL, is_own
from flexdyn.records.ros.merging import merged
from flexdyn.records.ros.series import Conventional, Series, Wanted
from flexdyn.records.ros.words import nearest_name, shortened_list
from flexdyn.records.table import Rows, Table

META_TOPIC = "/flexdyn/meta"
"""Topic for data without a place in ROS: order of channels, zero of time, meta; one text."""

TEXT_MESSAGE = "std_msgs/msg/String"


def read_bag(path: Path, request: Request) -> Table:
    """Read the requested topics; see the package's docstring.

    Args:
        path: of the bag.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: as in the package's docstring.
    """
    check_known(request.layout.clock, CLOCKS, "no such clock", key="source.clock", value=request.layout.clock)
    with opened(path) as bag:
        own = _own(bag, request)
        every = [Series(bag, topic, pick, request.layout.clock) for topic, pick in _choice(bag, request, own)]
        _collect(bag, every, request)
    table = Table(rows=Rows("message"))
    one = merged(every, request)
    if own and one.said:
        raise InputError("the bag's own topics have different times", remedy="copy the whole bag", channel="t")
    table.said += one.said
    first = int(one.stamps[0]) if len(one.stamps) else 0
    zero = own["zero_ns"] if own else (first if first >= YEAR else 0)  # a time of day
    columns = dict(one.columns)
    exact = columns.pop("t", None)
    table.add("t", seconds(one.stamps, zero) if exact is None else exact)
    for name in own["channels"] if own else columns:
        if name not in columns:
            raise InputError("the channel is announced and not there", key=name, remedy="copy the whole bag")
        if not own or request.wants(name):
            table.add(name, columns[name])
    if own:
        table.meta = own["meta"]
    elif zero:
        table.meta["start_ns"] = zero
    if not own and request.columns is None and (notes := _notes(table, every[0])):
        table.meta["notes"] = notes
    return table


def _own(bag: Bag, request: Request) -> dict[str, Any] | None:
    """The text of flexdyn about its own bag; None for other bags, or if raw columns are requested."""
    topic = bag.topics.get(META_TOPIC)
    raw = request.layout.topic or any(str(name).startswith("/") for name in request.columns or ())
    if topic is None or topic.msgtype != TEXT_MESSAGE or raw:
        return None
    texts = [text for _, _, raw in bag.messages([topic]) for text in bag.layout(topic, raw).texts.values()]
    own = from_json(texts[0]) if len(texts) == 1 else {}
    zero, channels, meta = own.get("zero_ns"), own.get("channels"), own.get("meta")
    known = isinstance(zero, int) and abs(zero) < 2**62 and isinstance(channels, list) and isinstance(meta, dict)
    if not known or not all(isinstance(name, str) for name in own["channels"]):
        raise InputError("what flexdyn wrote about the bag is damaged", key=META_TOPIC, remedy="write the bag again")
    return own


def _choice(bag: Bag, request: Request, own: dict[str, Any] | None) -> list[tuple[Topic, Conventional | Wanted]]:
    """The topics to read, and the columns of each."""
    if own or request.columns is None:
        names = [name for name in bag.topics if is_own(name)] if own else [_topic(bag, request)]
        if not names:
            remedy = "copy the whole bag"
            raise InputError("no topic with the channels that flexdyn wrote", key=META_TOPIC, remedy=remedy)
        topics = [bag.topics[name] for name in names]
        if bad := [topic for topic in topics if topic.msgtype not in CONVENTIONAL]:
            problem = f"messages of {bad[0].msgtype} make no recording by themselves"
            raise InputError(problem, key=bad[0].name, remedy="name columns in a channel map")
        return [(topic, Conventional(topic.name, topic.msgtype, own=bool(own))) for topic in topics]
    wanted: dict[str, dict[str, str]] = {}
    for column in sorted(str(column) for column in request.columns if column != "t"):
        topic, _, name = column.partition(".") if column.startswith("/") else ("", "", column)
        wanted.setdefault(_known(bag, topic) if topic else _topic(bag, request), {})[name] = column
    if not wanted:
        raise InputError("no column of the bag is asked for", remedy="name columns in the channel map")
    return [(bag.topics[topic], Wanted(topic, names)) for topic, names in wanted.items()]


def _topic(bag: Bag, request: Request) -> str:
    """The named topic, or the only possible one."""
    if request.layout.topic is not None:
        return _known(bag, request.layout.topic)
    filled = [topic for topic in bag.topics.values() if topic.count != 0]
    able = [topic.name for topic in filled if topic.msgtype in CONVENTIONAL]
    if not able and request.columns is not None:
        able = [topic.name for topic in filled]
    if len(able) == 1:
        return able[0]
    types = shortened_list(f"{topic.name} ({topic.msgtype})" for topic in bag.topics.values()) or "none"
    if able:
        states = [topic.name for topic in filled if topic.msgtype.endswith("/JointState") and topic.name in able]
        together = f", or name the fields of several, such as {_together(*states[:2])}" if len(states) > 1 else ""
        problem = "several topics could be read"
        remedy = f"choose one in a channel map, source: {{topic: ...}}, others: keep{together}; there are "
    else:
        problem, remedy = "no topic of joint states", "name topic and columns in a channel map; there are "
    raise InputError(problem, remedy=remedy + (shortened_list(able) if able else types))


def _together(first: str, second: str) -> str:
    """A map of two topics of joint states, the second one for motors (ROS has no message of currents)."""
    if re.search("cur|mot|eff|torq|tau", first) and not re.search("cur|mot|eff|torq|tau", second):
        first, second = second, first
    channels = f"{{q.JOINT: {first}.position.JOINT, tau.JOINT: {second}.effort.JOINT}}"
    return f"{{flexdyn_map: 1, channels: {channels}}}"


def _known(bag: Bag, name: str) -> str:
    if name not in bag.topics:
        raise InputError("the bag has no such topic", key=name, remedy=nearest_name(name, bag.topics))
    if bag.topics[name].count == 0:
        raise InputError("the topic has no messages", key=name, remedy="choose another topic")
    return name


def _collect(bag: Bag, every: Sequence[Series], request: Request) -> None:
    """Read the messages of all topics; refuses a bag with more or fewer than its index announces."""
    by_topic: Mapping[str, Series] = {series.topic: series for series in every}
    total = sum(series.count for series in every)
    for topic, time, raw in bag.messages([bag.topics[name] for name in by_topic]):
        if topic not in by_topic:
            raise InputError("two topics have one number", key=topic, remedy="the bag is damaged; reindex it")
        if by_topic[topic].add(time, raw):
            request.report(sum(series.seen for series in every) / total)
    for series in every:
        series.finish()
        announced = bag.topics[series.topic].count
        if announced is not None and series.seen != announced:
            problem = f"{series.seen} messages where the index announces {announced}"
            raise InputError(problem, key=series.topic, remedy="the bag is truncated or damaged; reindex or recover it")


def _notes(table: Table, series: Series) -> list[str]:
    """Leave out columns that were never measured, and note the assumptions."""
    notes = []
    for name in [name for name, values in table.columns.items() if np.isnan(values).all() and len(values)]:
        del table.columns[name]
        notes.append(f"{name} of {series.topic} is NaN in every message and was left out")
    if any(name.startswith("tau.") for name in table.columns):
        taken = f"effort of {series.topic} was taken as tau, the commanded torque"
        notes.append(f"{taken}; map it to tau_s if it is measured")
    return notes
