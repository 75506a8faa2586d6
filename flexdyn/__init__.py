"""flexdyn: simulate robot arms with elastic joints, compare them with measurements, and name missing effects."""

from importlib.metadata import version as _version

from flexdyn import effects
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
from flexdyn.batch.run_study import run_study
from flexdyn.comparison.compare import ChannelError, Comparison, compare
from flexdyn.control.commands import PD, Controller, FrameWrench, State
from flexdyn.control.firmware import Firmware
from flexdyn.control.samples import Samples
from flexdyn.control.servo import Servo
from flexdyn.diagnose import Diagnosis, ModelsCompared, compare_models, diagnose, prescribed_forces
from flexdyn.errors import FlexdynError, InputError, MissingExtra, SimulationError
from flexdyn.model.actuator import Actuator, DCMotor
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import Joint
from flexdyn.model.model_file import load_model, save_model, shipped_models
from flexdyn.plots import Picture, plot
from flexdyn.records.channelmap.description import ChannelMap
from flexdyn.records.channelmap.file import read_map
from flexdyn.records.files import read_recording, write_recording
from flexdyn.records.notices import RecordingWarning
from flexdyn.records.recording import Recording
from flexdyn.records.signals.derivatives import Derivatives, derivatives
from flexdyn.records.signals.noise import Noise, estimate_noise
from flexdyn.records.signals.smooth import Smoother
from flexdyn.robot import Robot, load_robot, robot_names
from flexdyn.simulation import solvers
from flexdyn.simulation.electrical import Electrical
from flexdyn.simulation.energy import Energy, EnergyWarning
from flexdyn.simulation.limits import Exceeded, LimitWarning, enforce_limits
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate, simulate_many
from flexdyn.viewer.playback import Playback, play

__version__ = _version("flexdyn")

__all__ = [
    "PD",
    "Actuator",
    "BaseParameters",
    "ChannelError",
    "ChannelMap",
    "Comparison",
    "Controller",
    "DCMotor",
    "Derivatives",
    "Diagnosis",
    "Electrical",
    "Energy",
    "EnergyWarning",
    "Equilibrium",
    "Exceeded",
    "Firmware",
    "FlexdynError",
    "FlexibleJointModel",
    "FrameWrench",
    "HoldingTorques",
    "InputError",
    "Joint",
    "LawTrial",
    "LimitWarning",
    "LinearModel",
    "LinkSide",
    "MissingExtra",
    "ModelsCompared",
    "Modes",
    "Noise",
    "PathFrequencies",
    "Picture",
    "Playback",
    "Recording",
    "RecordingWarning",
    "Robot",
    "Run",
    "Samples",
    "Servo",
    "SimulationError",
    "Smoother",
    "State",
    "SteadyFriction",
    "SteadyPoint",
    "base_parameters",
    "compare",
    "compare_models",
    "derivatives",
    "diagnose",
    "effects",
    "enforce_limits",
    "equilibrium",
    "estimate_noise",
    "frequencies_over_path",
    "frequency_response",
    "holding_torques",
    "linearize",
    "load_model",
    "load_robot",
    "modes",
    "play",
    "plot",
    "prescribed_forces",
    "read_map",
    "read_recording",
    "robot_names",
    "run_study",
    "save_model",
    "shipped_models",
    "simulate",
    "simulate_many",
    "solvers",
    "steady_friction",
    "steady_points",
    "write_recording",
]


def __dir__() -> list[str]:
    """Names that tab completion offers: those that users need."""
    return [*__all__, "__version__"]
