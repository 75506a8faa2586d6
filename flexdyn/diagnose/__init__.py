"""Diagnosis: where model and measurement disagree, which effect is missing, and what the model is with it."""

from flexdyn.diagnose.compared.models import ModelsCompared, compare_models
from flexdyn.diagnose.decision.forces import prescribed_forces
from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.report.result import Diagnosis, Experiment, Finding, Interrupted, Number, Suspect

__all__ = [
    "Diagnosis",
    "Experiment",
    "Finding",
    "Interrupted",
    "ModelsCompared",
    "Number",
    "Suspect",
    "compare_models",
    "diagnose",
    "prescribed_forces",
]
