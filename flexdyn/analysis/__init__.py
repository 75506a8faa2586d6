"""Modes, linear models, frequency responses, equilibria, holding torques, base parameters, steady friction."""

from flexdyn.analysis.base_parameters import BaseParameters, base_parameters
from flexdyn.analysis.eigenmodes import modes
from flexdyn.analysis.equilibrium import Equilibrium, equilibrium
from flexdyn.analysis.holding import HoldingTorques, holding_torques
from flexdyn.analysis.linear_model import LinearModel
from flexdyn.analysis.linearization import frequency_response, linearize
from flexdyn.analysis.modes_result import Modes
from flexdyn.analysis.path import PathFrequencies, frequencies_over_path
from flexdyn.analysis.steady_friction import LawTrial, SteadyFriction, steady_friction
from flexdyn.analysis.steady_points import SteadyPoint, steady_points

__all__ = [
    "BaseParameters",
    "Equilibrium",
    "HoldingTorques",
    "LawTrial",
    "LinearModel",
    "Modes",
    "PathFrequencies",
    "SteadyFriction",
    "SteadyPoint",
    "base_parameters",
    "equilibrium",
    "frequencies_over_path",
    "frequency_response",
    "holding_torques",
    "linearize",
    "modes",
    "steady_friction",
    "steady_points",
]
