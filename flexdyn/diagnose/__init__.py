"""Diagnosis: where model and measurement disagree, which effect is missing, and what the model is with it."""

from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.report.result import Diagnosis, Experiment, Finding, Interrupted, Number, Suspect

__all__ = ["Diagnosis", "Experiment", "Finding", "Interrupted", "Number", "Suspect", "diagnose"]
