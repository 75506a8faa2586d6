"""Recordings: one table of samples per file, read (through a channel map where it needs one) and written."""

from __future__ import annotations

from flexdyn.records.channelmap.description import ChannelMap
from flexdyn.records.channelmap.file import read_map
from flexdyn.records.files import SUFFIXES, read_recording, write_recording
from flexdyn.records.notices import RecordingWarning
from flexdyn.records.recording import Recording
from flexdyn.records.signals.derivatives import Derivatives, derivatives
from flexdyn.records.signals.noise import Noise, estimate_noise
from flexdyn.records.signals.smooth import Smoother
from flexdyn.records.units import SIGNALS, unit_of

__all__ = [
    "SIGNALS",
    "SUFFIXES",
    "ChannelMap",
    "Derivatives",
    "Noise",
    "Recording",
    "RecordingWarning",
    "Smoother",
    "derivatives",
    "estimate_noise",
    "read_map",
    "read_recording",
    "unit_of",
    "write_recording",
]
