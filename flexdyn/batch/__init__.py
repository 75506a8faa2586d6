"""Batch studies: thousands of runs over drawn numbers, stored chunk by chunk, on all cores or a cluster."""

from flexdyn.batch.run_study import run_study

__all__ = ["run_study"]
