"""Recordings: one table of samples per file, read (through a channel map where it needs one) and written."""

from __future__ import annotations

from flexdyn.records.channelmap import ChannelMap
from flexdyn.records.channelmap_file import read_map
from flexdyn.records.derivatives import Derivatives, derivatives
from flexdyn.records.files import SUFFIXES, read_recording, write_recording
from flexdyn.records.noise import Noise, estimate_noise
from flexdyn.records.recording import Recording
from flexdyn.records.smooth import Smoother
from flexdyn.records.units import SIGNALS, unit_of

__all__ = [
    "SIGNALS",
    "SUFFIXES",
    "ChannelMap",
    "Derivatives",
    "Noise",
    "Recording",
    "Smoother",
    "derivatives",
    "estimate_noise",
    "read_map",
    "read_recording",
    "unit_of",
    "write_recording",
]
