"""Diagnosis: where model and measurement disagree, which effects are missing, and the corrected model."""

from flexdyn.diagnose.compared.models import compare_models
from flexdyn.diagnose.compared.over_models import ModelsCompared
from flexdyn.diagnose.decision.forces import prescribed_forces
from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.report.result import Diagnosis, Interrupted
from flexdyn.diagnose.report.suspects import Experiment, Finding, Number, Suspect

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
