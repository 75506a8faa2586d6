"""Puts the studies' modules on the path."""

from __future__ import annotations

import sys
from pathlib import Path

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path += [str(BENCHMARKS), str(BENCHMARKS / "measured")]
sys.path += [str(folder) for folder in sorted((BENCHMARKS / "measured").iterdir()) if folder.is_dir()]
