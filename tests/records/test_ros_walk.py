"""Layouts against the serialiser of rosbags: every number of a message is found, and replaced, where it was put."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexdyn.errors import InputError
from flexdyn.records.ros.walk import MessageLayout, lay_out
from tests.records.ros_bags import Maker

MIX = "lab_msgs/msg/Mix"
TEXTS = {
    "lab_msgs/msg/Part": "uint8 kind\nfloat64 size\nstring label\n",
    MIX: "string name\nuint8 small\nfloat64 large\nint16[] shorts\nstring[] words\nfloat32 single\nfloat64[<=9] list\n"
    "bool on\nlab_msgs/Part[] parts\nint64 long\nfloat64[2] pair\nduration lasting\nuint8[] blob\nuint32 last\n",
}
FIELDS = tuple(line.split()[1] for line in TEXTS[MIX].splitlines())
MAKERS = {
    ros1: Maker(
        ros1=ros1,
        texts=TEXTS if ros1 else {**TEXTS, MIX: TEXTS[MIX].replace("duration", "builtin_interfaces/Duration")},
    )
    for ros1 in (False, True)
}

words = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)
doubles = st.floats(allow_nan=False)
mixes = st.fixed_dictionaries(
    {
        "name": words,
        "small": st.integers(0, 255),
        "large": doubles,
        "shorts": st.lists(st.integers(-(2**15), 2**15 - 1), max_size=4),
        "words": st.lists(words, max_size=3),
        "single": st.floats(width=32, allow_nan=False),
        "list": st.lists(doubles, max_size=4),
        "on": st.booleans(),
        "parts": st.lists(st.tuples(st.integers(0, 255), doubles, words), max_size=3),
        "long": st.integers(-(2**63), 2**63 - 1),
        "pair": st.tuples(doubles, doubles),
        "lasting": st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**31 - 1)),
        "blob": st.binary(max_size=5),
        "last": st.integers(0, 2**32 - 1),
    }
)


def message(maker: Maker, mix: dict[str, Any]) -> Any:
    """A message of these values."""
    kinds = {"shorts": np.int16, "list": np.float64, "pair": np.float64}
    values = {name: np.array(value, kinds[name]) if name in kinds else value for name, value in mix.items()}
    values["parts"] = [maker.new("lab_msgs/msg/Part", *part) for part in mix["parts"]]
    values["lasting"] = maker.new("builtin_interfaces/msg/Duration", *mix["lasting"])
    values["blob"] = np.frombuffer(mix["blob"], np.uint8)
    return maker.new(MIX, *(values[name] for name in FIELDS))


def numbers(mix: dict[str, Any]) -> dict[tuple[str | int, ...], float]:
    """The numbers of a message by path, as written down here and not as any bytes say."""
    found: dict[tuple[str | int, ...], float] = {
        (name,): mix[name] for name in ("small", "large", "single", "on", "long", "last")
    }
    for name in ("shorts", "list", "pair"):
        found.update({(name, index): value for index, value in enumerate(mix[name])})
    for index, part in enumerate(mix["parts"]):
        found.update({("parts", index, "kind"): part[0], ("parts", index, "size"): part[1]})
    found.update({("lasting", "sec"): mix["lasting"][0], ("lasting", "nanosec"): mix["lasting"][1]})
    return found


def described(maker: Maker, raw: bytes) -> MessageLayout:
    """The layout by the fields that rosbags parsed."""
    return lay_out(raw, MIX, {name: parsed[1] for name, parsed in maker.store.fielddefs.items()}, cdr=not maker.ros1)


@pytest.mark.parametrize("coding", ["little", "big", "ros1"])
@settings(max_examples=120, deadline=None)
@given(mix=mixes, other=mixes)
def test_every_number_is_where_it_was_put(coding: str, mix: dict[str, Any], other: dict[str, Any]) -> None:
    """Packed or aligned, either byte order, whatever texts and lists stand before it."""
    maker = MAKERS[coding == "ros1"]
    raw = maker.raw(MIX, message(maker, mix), little=coding == "little")
    layout = described(maker, raw)
    block = np.frombuffer(raw, np.uint8)[None].copy()
    assert {number.path: number.of(block)[0] for number in layout.numbers} == numbers(mix)
    assert layout.texts["name",] == mix["name"]
    assert [layout.texts["words", index] for index in range(len(mix["words"]))] == mix["words"]
    changed = {**mix, "large": other["large"], "last": other["last"], "on": other["on"]}
    second = maker.raw(MIX, message(maker, changed), little=coding == "little")
    assert layout.matches(np.frombuffer(second, np.uint8)[None])[0]
    for number in layout.numbers:
        if number.path in {("large",), ("last",), ("on",)}:
            number.put(block, np.array([changed[str(number.path[0])]]))
    assert bytes(block[0]) == second
    third = maker.raw(MIX, message(maker, {**mix, "name": mix["name"] + "x"}), little=coding == "little")
    if len(third) == len(raw):
        assert not layout.matches(np.frombuffer(third, np.uint8)[None])[0]


@pytest.mark.parametrize("coding", ["little", "big", "ros1"])
@settings(max_examples=60, deadline=None)
@given(mix=mixes, share=st.floats(0, 0.99))
def test_a_message_that_is_cut(coding: str, mix: dict[str, Any], share: float) -> None:
    """No length but the right one is taken."""
    maker = MAKERS[coding == "ros1"]
    raw = maker.raw(MIX, message(maker, mix), little=coding == "little")
    with pytest.raises(InputError):
        described(maker, raw[: int(share * len(raw))])
    with pytest.raises(InputError, match="goes on for 4 bytes"):
        described(maker, raw + bytes(4))
