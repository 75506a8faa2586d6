"""Folders of generated pages."""

from __future__ import annotations

import shutil
from pathlib import Path


def fresh(folder: Path) -> None:
    """Make a folder, empty even where it was there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
