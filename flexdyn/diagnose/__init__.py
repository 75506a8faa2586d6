"""Diagnosis: where model and measurement disagree, which effect is missing, and what the model is with it."""

from flexdyn.diagnose.result import Diagnosis, Finding, Interrupted
from flexdyn.diagnose.run import diagnose

__all__ = ["Diagnosis", "Finding", "Interrupted", "diagnose"]
