"""Recordings: one table of samples per file, read (through a channel map where it needs one) and written."""

from flexdyn.records.files import SUFFIXES, read_recording, write_recording
from flexdyn.records.notices import RecordingWarning
from flexdyn.records.recording import Recording

__all__ = ["SUFFIXES", "Recording", "RecordingWarning", "read_recording", "write_recording"]
