"""Puts the benchmark's modules on the path; without Numba there is nothing to test."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path += [str(BENCHMARKS / "discovery"), str(BENCHMARKS)]
collect_ignore_glob = [] if importlib.util.find_spec("numba") else ["test_*.py"]
