"""The effects a drive and its links can have; one class each, the laws in the compiled core."""

from flexdyn.effects.actuator import TorqueOffset, TorqueSpeedLimit
from flexdyn.effects.base import Effect, JointEffect, parameter, registered, unit_for
from flexdyn.effects.catalogue import catalogue, effect_from_dict
from flexdyn.effects.friction import CoulombFriction, StribeckFriction, ViscousFriction
from flexdyn.effects.link import Payload
from flexdyn.effects.transmission import TransmissionDamping

__all__ = [
    "CoulombFriction",
    "Effect",
    "JointEffect",
    "Payload",
    "StribeckFriction",
    "TorqueOffset",
    "TorqueSpeedLimit",
    "TransmissionDamping",
    "ViscousFriction",
    "catalogue",
    "effect_from_dict",
    "parameter",
    "registered",
    "unit_for",
]
