"""What is told about a recording while it is read, and does not stop it."""

from __future__ import annotations


class RecordingWarning(UserWarning):
    """Something about a file was guessed, or is worth knowing: its letters, its decimal sign, gaps in time."""
