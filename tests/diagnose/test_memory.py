"""Recordings that are too long for the machine's memory are refused by one line, before they fill it."""

from __future__ import annotations

import importlib
import re

import pytest

import flexdyn as fd
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_recording


def test_too_long_recordings_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line names how long they are, what they need and what there is; as much as it says then fits."""
    memory = importlib.import_module("flexdyn.diagnose.inference.memory")
    monkeypatch.setattr(memory, "installed", lambda: 2e7)
    rec = two_link_recording(Levels(), 4)
    with pytest.raises(fd.InputError, match=r"s of recordings need [\d.]+ GB of memory, 0.0 GB may be used") as told:
        fd.diagnose(two_link(ARM, tolerance=0.03), [rec])
    assert str(told.value).isprintable()
    less = re.search(r"give ([\d.]+) s of them", str(told.value))
    assert less is not None
    assert 0.0 < float(less[1]) < rec.duration


def test_memory_grows_with_rows() -> None:
    """In proportion; the columns are those of every point of every grid."""
    memory = importlib.import_module("flexdyn.diagnose.inference.memory")
    proposal = importlib.import_module("flexdyn.diagnose.hypothesis.proposal").Proposal
    load = fd.effects.Payload(mass=1.0)
    one = proposal({"effect": "x"}, lambda point, values: load, ((1.0,), (2.0,)), sizes=(1.0, 1.0))
    assert memory.memory_needed([one] * 3, 1000) == memory.COLUMN_COPIES * 8 * 12 * 1000
    memory.check_memory([one], 1000, 1.0)
