"""The effects that a drive and its links can have: one class for each; the laws are in the compiled core."""

from flexdyn.effects.actuator import (
    CommandDelay,
    TorqueConstantError,
    TorqueOffset,
    TorqueRipple,
    TorqueSaturation,
    TorqueSpeedLimit,
)
from flexdyn.effects.base import Effect, registered
from flexdyn.effects.catalogue import catalogue, effect_from_dict
from flexdyn.effects.channels import measure, recovered
from flexdyn.effects.coupling import CouplingEffect, JointCoupling
from flexdyn.effects.friction import (
    AsymmetricFriction,
    AsymmetricViscousFriction,
    CoulombFriction,
    QuadraticDrag,
    StribeckFriction,
    ViscousFriction,
)
from flexdyn.effects.friction_of_load import DirectionalGearLoss, LoadDependentFriction, StribeckGearLoss
from flexdyn.effects.friction_of_state import PositionDependentFriction, PreslidingFriction, WarmUpFriction
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.link import EndStop, InertiaEffect, ParallelSpring, Payload, PositionTorque
from flexdyn.effects.memory import MemoryEffect
from flexdyn.effects.model_error import ParameterError
from flexdyn.effects.parameters import parameter
from flexdyn.effects.sensor import (
    ChannelLag,
    EncoderEccentricity,
    SensorEffect,
    SensorGain,
    SensorOffset,
)
from flexdyn.effects.transmission import (
    Backlash,
    DeflectionEffect,
    HardeningSpring,
    JointElasticity,
    KinematicError,
    SpringHysteresis,
    TransmissionDamping,
)
from flexdyn.records.units import unit_for

__all__ = [
    "AsymmetricFriction",
    "AsymmetricViscousFriction",
    "Backlash",
    "ChannelLag",
    "CommandDelay",
    "CoulombFriction",
    "CouplingEffect",
    "DeflectionEffect",
    "DirectionalGearLoss",
    "Effect",
    "EncoderEccentricity",
    "EndStop",
    "HardeningSpring",
    "InertiaEffect",
    "JointCoupling",
    "JointEffect",
    "JointElasticity",
    "KinematicError",
    "LoadDependentFriction",
    "MemoryEffect",
    "ParallelSpring",
    "ParameterError",
    "Payload",
    "PositionDependentFriction",
    "PositionTorque",
    "PreslidingFriction",
    "QuadraticDrag",
    "SensorEffect",
    "SensorGain",
    "SensorOffset",
    "SpringHysteresis",
    "StribeckFriction",
    "StribeckGearLoss",
    "TorqueConstantError",
    "TorqueOffset",
    "TorqueRipple",
    "TorqueSaturation",
    "TorqueSpeedLimit",
    "TransmissionDamping",
    "ViscousFriction",
    "WarmUpFriction",
    "catalogue",
    "effect_from_dict",
    "measure",
    "parameter",
    "recovered",
    "registered",
    "unit_for",
]


def __dir__() -> list[str]:
    """What tab completion offers: the names that users need."""
    return list(__all__)
