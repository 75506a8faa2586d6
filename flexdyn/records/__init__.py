"""Recordings: one table of samples per file, read and written without loss (CSV, NPZ, HDF5)."""

from __future__ import annotations

from flexdyn.records.files import SUFFIXES, read_recording, write_recording
from flexdyn.records.recording import Recording
from flexdyn.records.units import SIGNALS, unit_of

__all__ = ["SIGNALS", "SUFFIXES", "Recording", "read_recording", "unit_of", "write_recording"]
