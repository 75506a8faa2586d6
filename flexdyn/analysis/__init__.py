"""Linear and static analysis: modes, linear models, frequency responses, equilibria, torques that friction holds."""

from flexdyn.analysis.eigenmodes import modes
from flexdyn.analysis.equilibrium import Equilibrium, equilibrium
from flexdyn.analysis.holding import HoldingTorques, holding_torques
from flexdyn.analysis.linear_model import LinearModel
from flexdyn.analysis.linearization import frequency_response, linearize
from flexdyn.analysis.modes_result import Modes
from flexdyn.analysis.path import PathFrequencies, frequencies_over_path

__all__ = [
    "Equilibrium",
    "HoldingTorques",
    "LinearModel",
    "Modes",
    "PathFrequencies",
    "equilibrium",
    "frequencies_over_path",
    "frequency_response",
    "holding_torques",
    "linearize",
    "modes",
]
