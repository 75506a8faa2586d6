"""The file of a channel map: whatever is wrong in it is one line, and what is right comes back unchanged."""

from __future__ import annotations

import pickle
from copy import deepcopy
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.io.yaml import dump_yaml, parse_yaml
from flexdyn.records.channelmap import file as channelmap_file
from flexdyn.records.repairs import Repair
from tests.records.mapping import channel_map

FULL = """\
flexdyn_map: 1
source: {names_line: 3, first_line: 5, delimiter: ";", decimal: ",", topic: /joints, clock: bag}
time: {from: stamp, unit: ms, shift: 0.012, start: zero}
joints:
  elbow: {gear_ratio: 100, torque_constant: 0.05}
  slide: {prismatic: true}
channels:
  q.elbow: {from: pos_meas1, unit: deg, sign: -1, offset: 0.2}
  theta.elbow: {from: enc1, unit: counts, counts_per_turn: 131072, side: motor}
  omega.elbow: {from: n1, unit: rpm, side: motor}
  tau.elbow: {from: i1, unit: A, side: motor}
  temperature.elbow: {from: T1, unit: degF}
  q.slide: x
  tau.slide: {from: vir, unit: V, factor: 35.15}
  theta.wrist_pitch: {from: 7, delay: 0.002}
  theta.wrist_roll: 8
couplings:
  - {joints: [wrist_pitch, wrist_roll], position: [[0.5, 0.5], [0.5, -0.5]]}
others: drop
repair: [sort_time, {fill_nan: {longest: 0.5}}]
"""


def written(path: Path, text: str) -> Path:
    """A map file."""
    path.write_text(text, encoding="utf-8")
    return path


def test_everything_that_a_map_can_say(tmp_path: Path) -> None:
    """Numbers of a joint arrive at the channels that use them, and only there."""
    made = fd.read_map(written(tmp_path / "map.yaml", FULL))
    channels = {channel.name: channel for channel in made.channels}
    assert channels["q.elbow"].gear_ratio is None
    assert channels["theta.elbow"].gear_ratio == 100
    assert (channels["tau.elbow"].gear_ratio, channels["tau.elbow"].torque_constant) == (100, 0.05)
    assert channels["omega.elbow"].torque_constant is None
    assert channels["q.slide"].source == "x"
    assert channels["theta.wrist_roll"].source == 8
    assert made.time == type(made.time)("stamp", "ms", None, "zero", 0.012)
    assert made.couplings[0].torque == ((1.0, 1.0), (1.0, -1.0))
    assert made.repair == (Repair("sort_time"), Repair("fill_nan", 0.5))
    assert made.prismatic == ("slide",)
    assert made.request().columns == frozenset(["stamp", "pos_meas1", "enc1", "n1", "i1", "T1", "x", "vir", 7, 8])
    assert made.request().layout == made.layout
    assert (made.layout.topic, made.layout.delimiter, made.layout.clock) == ("/joints", ";", "bag")


def test_a_map_comes_back_from_yaml_and_pickle(tmp_path: Path) -> None:
    """What `to_dict` gives is a map file again, and a worker gets the same map."""
    made = fd.read_map(written(tmp_path / "map.yaml", FULL))
    assert fd.read_map(written(tmp_path / "again.yaml", dump_yaml(made.to_dict()))) == made
    assert pickle.loads(pickle.dumps(made)) == made  # noqa: S301
    assert hash(made) == hash(fd.ChannelMap.from_dict(made.to_dict()))
    with pytest.raises(AttributeError):
        made.keep_others = True  # type: ignore[misc]


def elbow(**entry: Any) -> dict[str, Any]:
    """A map of one channel."""
    return {"channels": {"q.elbow": {"from": "x", **entry}}}


def motor(**entry: Any) -> dict[str, Any]:
    """A map of one torque."""
    return {"channels": {"tau.elbow": {"from": "x", **entry}}}


def wrist(**entry: Any) -> dict[str, Any]:
    """A map of a coupled pair of joints, and a third."""
    pair = {"joints": ["a", "b"], "position": [[1, 1], [1, -1]], **entry}
    return {"channels": {"theta.a": "x", "theta.b": "y", "theta.c": "z"}, "couplings": [pair]}


MISTAKES = [
    ({}, "channels: no channels; name one as q.elbow: COLUMN, or give others: keep"),
    ({"chanels": {}}, "chanels: no such key; did you mean 'channels'?"),
    ({"channels": ["q"]}, "channels: a mapping of keys is needed, got ['q']"),
    ({"channels": {3: "x"}}, "channels: the channel has no name, got 3"),
    ({"channels": {"t": "x"}}, "channels: the name is reserved, got 't'"),
    ({"channels": {"Tau.elbow": "x"}}, "channels.Tau.elbow: no such signal, got 'Tau'; did you mean 'tau'?"),
    ({"channels": {"q.elbow": None}}, "channels.q.elbow.from: the name of a column, or its number from 1, is needed"),
    (
        {"channels": {"q.elbow": 0}},
        "channels.q.elbow.from: the name of a column, or its number from 1, is needed, got 0",
    ),
    ({"channels": {"q.elbow": {"unit": "deg"}}}, "channels.q.elbow.from: the key is missing"),
    (elbow(units="deg"), "channels.q.elbow.units: no such key; did you mean 'unit'?"),
    (elbow(unit=3), "channels.q.elbow.unit: a text is needed, got 3"),
    (elbow(unit="degs"), "channels.q.elbow.unit: no such unit, got 'degs'; did you mean 'deg'? or give factor"),
    (elbow(unit="N m"), "channels.q.elbow.unit: a unit of torque does not fit q.elbow, got 'N m'; known: rad, "),
    (elbow(unit="degC"), "channels.q.elbow.unit: a unit of temperature does not fit q.elbow, got 'degC'"),
    (motor(unit="V"), "channels.tau.elbow.unit: a unit of voltage does not fit tau.elbow, got 'V'; "),
    (
        motor(unit="A"),
        "channels.tau.elbow.torque_constant: unit: A needs torque_constant; give it here or as joints.el",
    ),
    (motor(side="motor"), "channels.tau.elbow.gear_ratio: side: motor needs gear_ratio; give it here or as joints.elb"),
    (motor(side="motr"), "channels.tau.elbow.side: no such choice, got 'motr'; did you mean 'motor'?"),
    (motor(gear_ratio=3), "channels.tau.elbow.gear_ratio: the number is not used; it goes with side: motor"),
    (motor(side="motor", gear_ratio=-3), "channels.tau.elbow.gear_ratio: a number above zero is needed, got -3; a rev"),
    (motor(side="motor", gear_ratio="x"), "channels.tau.elbow.gear_ratio: a finite number is needed, got 'x'"),
    (motor(unit="N m", factor=2), "channels.tau.elbow.factor: factor and unit both give the scale, got 'N m'"),
    (motor(unit="N m", torque_constant=2), "channels.tau.elbow.torque_constant: the number is not used; it goes w"),
    (motor(factor=0), "channels.tau.elbow.factor: a number other than zero is needed, got 0"),
    (motor(factor=float("nan")), "channels.tau.elbow.factor: a finite number is needed, got nan"),
    (elbow(unit="counts"), "channels.q.elbow.counts_per_turn: unit: counts needs counts_per_turn"),
    (elbow(unit="deg", counts_per_turn=4), "channels.q.elbow.counts_per_turn: the number is not used; it goes wit"),
    (elbow(sign=-2), "channels.q.elbow.sign: 1 or -1 is needed, got -2; scale with factor"),
    (elbow(sign=True), "channels.q.elbow.sign: 1 or -1 is needed, got True"),
    (elbow(delay="2 ms"), "channels.q.elbow.delay: a finite number is needed, got '2 ms'"),
    ({"channels": {"x": {"from": "x", "side": "motor", "gear_ratio": 2}}}, "channels.x.side: a gear does not change"),
    ({"channels": {"power": "x"}, "joints": {"elbow": {}}}, "joints.elbow: no such key"),
    (elbow() | {"joints": {"elbo": {}}}, "joints.elbo: no such key; did you mean 'elbow'?"),
    (elbow() | {"joints": {"elbow": {"ratio": 3}}}, "joints.elbow.ratio: no such key; did you mean 'gear_ratio'?"),
    (elbow() | {"joints": {"elbow": {"prismatic": 1}}}, "joints.elbow.prismatic: true or false is needed, got 1"),
    (elbow(unit="deg") | {"joints": {"elbow": {"prismatic": True}}}, "channels.q.elbow.unit: the joint slides by join"),
    (elbow() | {"time": {"form": "x"}}, "time.form: no such key; did you mean 'from'?"),
    (elbow() | {"time": {"unit": "deg"}}, "time.unit: no unit of time, got 'deg'; known: s, ms, us, ns, min, h"),
    (elbow() | {"time": {"from": "x", "rate": 100}}, "time.rate: rows are counted and read from a column; give rate w"),
    (elbow() | {"time": {"rate": 0}}, "time.rate: a number above zero is needed, got 0"),
    (elbow() | {"time": {"start": "first"}}, "time.start: no such choice, got 'first'; known: keep, zero"),
    (elbow() | {"time": {"shift": "1"}}, "time.shift: a finite number is needed, got '1'"),
    (elbow() | {"source": {"names": 1}}, "source.names: no such key; did you mean 'names_line'?"),
    (elbow() | {"source": {"names_line": 0}}, "source.names_line: a line number from 1 is needed, got 0"),
    (elbow() | {"source": {"delimiter": "tab"}}, "source.delimiter: one character is needed, got 'tab'; such as"),
    (elbow() | {"source": {"decimal": ";"}}, "source.decimal: no such choice, got ';'; known: ., ,"),
    (elbow() | {"source": {"clock": "header"}}, "source.clock: no such choice, got 'header'; known: message, bag"),
    (elbow() | {"source": {"topic": 3}}, "source.topic: a text is needed, got 3"),
    (elbow() | {"others": "yes"}, "others: no such choice, got 'yes'; known: drop, keep"),
    ({"channels": {"q.a": 2}, "others": "keep"}, "channels.q.a.from: a column by number does not go with others: keep"),
    (elbow() | {"repair": "sort"}, "repair: no such repair, got 'sort'; did you mean 'sort_time'?"),
    (elbow() | {"repair": 3}, "repair: a list of repairs is needed, got 3; known: sort_time"),
    (elbow() | {"repair": [{"sort_time": 1}]}, "repair.sort_time: the repair takes no such number, got 1"),
    (
        elbow() | {"repair": [{"fill_nan": {"longest": 0}}]},
        "repair.fill_nan.longest: a time above zero is needed, in s",
    ),
    (elbow() | {"couplings": {}}, "couplings: a list of couplings is needed, got {}"),
    (wrist(join=[]), "couplings[0].join: no such key; did you mean 'joints'?"),
    (wrist(joints=["a", "d"]), "couplings[0].joints: no such name, got 'd'; known: a, b, c"),
    (wrist(joints=["a", "a"]), "couplings[0].joints: a list without repetition is needed, got ['a', 'a']"),
    (wrist(joints=["a"], position=[[1]]), "couplings[0].joints: two joints or more are needed, got ['a']"),
    (wrist(position=[[1, 1]]), "couplings[0].position: a matrix of 2 rows of 2 numbers is needed, got [[1, 1]]"),
    (wrist(position=[[1, 1], [1, "a"]]), "couplings[0].position: finite numbers are needed, got"),
    (wrist(position=[[1, 1], [2, 2]]), "couplings[0].position: the matrix is singular, got [[1, 1], [2, 2]]; correct"),
    (wrist(torque=[1, 1]), "couplings[0].torque: a matrix of 2 rows of 2 numbers is needed, got [1, 1]"),
    (wrist(signals=["tau"]), "couplings[0].signals: no such name, got 'tau'; known: q, v, theta, omega"),
    (
        wrist(signals=["q", "v"]),
        "couplings[0]: no channel of the coupled joints is mapped; map one of q, v, tau, tau_applied",
    ),
]


@pytest.mark.parametrize(("entries", "line"), MISTAKES, ids=[line[:50] for _, line in MISTAKES])
def test_mistakes(tmp_path: Path, entries: dict[str, Any], line: str) -> None:
    """One line: the file, the key, what stood there, what would be right."""
    path = written(tmp_path / "map.yaml", dump_yaml({"flexdyn_map": 1, **entries}))
    with pytest.raises(InputError) as caught:
        fd.read_map(path)
    assert str(caught.value).startswith(f"{path}: {line}")
    assert "\n" not in str(caught.value)


def test_a_coupling_needs_all_of_its_joints() -> None:
    """A motor that is not mapped is missed by name; a joint takes part once."""
    with pytest.raises(InputError, match=r"couplings\[0\].joints: a coupled channel is missing, got 'omega.b'"):
        channel_map(**wrist() | {"channels": {"theta.a": "x", "theta.b": "y", "omega.a": "z"}})
    twice = wrist()
    twice["couplings"].append({"joints": ["b", "c"], "position": [[1, 0], [0, 1]]})
    with pytest.raises(InputError, match=r"couplings\[1\].joints: the joint is in two couplings, got 'b'"):
        channel_map(**twice)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("flexdyn: 1\n", "flexdyn: no such key; did you mean 'flexdyn_map'?"),
        ("channels: {q.a: x}\n", "flexdyn_map: the key is missing"),
        ("flexdyn_map: 2\n", "flexdyn_map: no such format, got 2; this version reads format 1"),
        ("flexdyn_map: true\n", "flexdyn_map: no such format, got True"),
        ("flexdyn_map: 1\nchannels: {q.a: x, q.a: y}\n", "not valid YAML"),
        ("- 1\n", "a mapping of keys is needed, got [1]"),
    ],
)
def test_files_that_are_no_maps(tmp_path: Path, text: str, line: str) -> None:
    """Other YAML files are told apart by their first key."""
    path = written(tmp_path / "map.yaml", text)
    with pytest.raises(InputError) as caught:
        fd.read_map(path)
    assert str(caught.value).startswith(f"{path}: {line}")


def test_a_map_that_is_not_there(tmp_path: Path) -> None:
    """The line names the map, not the recording."""
    with pytest.raises(InputError, match=r"nothing\.yaml: there is no such file"):
        fd.read_recording(tmp_path / "log.csv", map=tmp_path / "nothing.yaml")


def places(content: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in a map, by keys and indices."""
    inner = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    return [path, *(place for key, value in inner for place in places(value, (*path, key)))]


JUNK = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5), st.just(10**400)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=5), inner, max_size=3)),
    max_leaves=4,
)


WHOLE = dict(parse_yaml(FULL))


@given(st.sampled_from(places(WHOLE)[1:]), JUNK)
def test_junk_anywhere_is_refused_in_one_line(place: tuple[Any, ...], junk: Any) -> None:
    """Whatever stands at any place of a map: it is read and comes back, or one line says what is wrong."""
    content: Any = deepcopy(WHOLE)
    entry = content
    for key in place[:-1]:
        entry = entry[key]
    entry[place[-1]] = junk
    line, made = "", None
    try:
        made = fd.ChannelMap.from_dict(content)
    except InputError as error:
        line = str(error)
    assert (made is None) == bool(line)
    assert "\n" not in line
    assert made is None or fd.ChannelMap.from_dict(made.to_dict()) == made


def test_the_documented_example_is_a_map() -> None:
    """What the module shows is read as it stands."""
    text = str(channelmap_file.__doc__).partition("::\n")[2]
    made = fd.ChannelMap.from_dict(parse_yaml(dedent(text)))
    assert made.couplings[0].torque == ((1.0, 1.0), (1.0, -1.0))
    assert [channel.source for channel in made.channels if channel.joint == "slide"] == [4, "vir"]
