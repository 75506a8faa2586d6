"""The catalogue as hypotheses: every effect at every place where the model can have it and the data can show it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.play import half_gaps
from flexdyn.diagnose.hypothesis.proposal import MotionExtent, Point, Proposal, at, declared, given, linear, wave
from flexdyn.effects import Effect, JointEffect, JointElasticity, TorqueOffset, catalogue
from flexdyn.model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
SLOW_HARMONICS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Cycles per turn of the joint; those per turn of the motor are added."""


def proposals(equations: Equations) -> list[Proposal]:
    """Every effect of the catalogue at every place."""
    found: list[Proposal] = []
    names = equations.true.joint_names
    for j, joint in enumerate(names):
        extent = MotionExtent.of(equations, j)
        elastic = bool(equations.true.elastic[j])
        for side in ("motor", "link") if elastic else ("motor",):
            found += _declared({"joint": joint, "side": side}, extent, equations.true)
            found += _friction({"joint": joint, "side": side}, extent)
        if elastic:
            found += _declared({"joint": joint, "side": "transmission"}, extent, equations.true)
            found += _transmission(joint, extent, half_gaps(equations, j, extent.deflection))
        elif equations.true.rotor_inertia[j] > 0.0:
            found.append(_elasticity(joint))
        found += _actuator(joint, extent)
        found += _link(joint, extent)
        found += _couplings(joint, names)
        found += _sensors(equations, j, extent)
    tip = {"effect": "payload", "frame": equations.true.robot.tip}
    return [each for each in (*found, linear(tip, "mass", unit=1e-3)) if each.grid and _may_be(equations, each)]


def _may_be(equations: Equations, proposal: Proposal) -> bool:
    """Whether an effect can be where a test rig prescribes the motion.

    Nothing is asked of a motor there: the force is what a sensor says, which may have an offset, and no actuator stands
    between the two.
    """
    true, kind = equations.true, catalogue()[proposal.place["effect"]]
    if proposal.joint not in true.joint_names or not equations.data[0].forced[true.index(proposal.joint)]:
        return True
    return kind.stage != "actuator" or kind is TorqueOffset


def _declared(place: Mapping[str, str], extent: MotionExtent, true: FlexibleJointModel) -> Iterator[Proposal]:
    """Proposals for one side of a joint: every effect whose class declares linear parameters or grids."""
    elastic = bool(true.elastic[true.index(place["joint"])])
    there = [each for each in true.all_effects if isinstance(each, JointEffect) and each.joint == place["joint"]]
    beside = {each.name for each in there if each.side == place["side"]}
    for kind in catalogue().values():
        own = kind.__module__.startswith("flexdyn.") and issubclass(kind, JointEffect)
        possible = place["side"] in kind.sides and (elastic or not kind.takes_load)
        if own and possible and (kind.linear or kind.grids):
            yield declared(kind, place, extent, beside)


def _friction(place: Mapping[str, str], extent: MotionExtent) -> Iterator[Proposal]:
    yield _swinging({"effect": "position_dependent_friction", **place}, extent)
    yield _presliding({"effect": "presliding_friction", **place}, extent)


def _swinging(place: Mapping[str, str], extent: MotionExtent) -> Proposal:
    """``amplitude (1 + sin(harmonic x + phase)) Sgn(u)``: a level, a sine and a cosine part."""

    def build(point: Point, amplitude: float, phase: float) -> Effect:
        return at(place, amplitude=amplitude, harmonic=point[0], phase=phase)

    def make(point: Point, x: Array) -> Effect:
        # The weights are those of 1 + sin, 1 + cos and 1 - sin.
        return build(point, float(np.hypot(x[0] - x[2], x[1])), math.atan2(x[1], x[0] - x[2]))

    return Proposal(
        place,
        make=make,
        units=lambda point: [(build(point, 1.0, phase), 1.0) for phase in (0.0, math.pi / 2, math.pi)],
        grid=tuple((h,) for h in _seen(SLOW_HARMONICS if extent.turns else (extent.ratio, 2.0 * extent.ratio), extent)),
        axes=("harmonic",),
    )


def _seen(harmonics: Sequence[float], extent: MotionExtent) -> tuple[float, ...]:
    """Harmonics that a joint which slides can show.

    Of a wave that it follows for less than a radian it sees a constant and a slope, which are other laws.
    """
    return tuple(h for h in harmonics if extent.turns or h * extent.span >= 1.0)


def _presliding(place: Mapping[str, str], extent: MotionExtent) -> Proposal:
    """Linear in its level at a given reach = level/stiffness."""

    def build(point: Point, level: float) -> Effect | None:
        return at(place, level=level, stiffness=level / point[0]) if level > 0.0 else None

    return Proposal(
        place,
        make=lambda point, x: build(point, float(x[0])),
        units=lambda point: [(at(place, level=1.0, stiffness=1.0 / point[0]), 1.0)],
        grid=tuple((float(r),) for r in extent.span * np.geomspace(1e-5, 0.05, 10)),
        positive=(True,),
    )


def _transmission(joint: str, extent: MotionExtent, gaps: Sequence[float]) -> Iterator[Proposal]:
    across = {"joint": joint, "side": "transmission"}
    yield given({"effect": "backlash", **across}, ("half_gap",), [(gap,) for gap in gaps])
    turns = _seen((1.0, 2.0, 3.0, 4.0, extent.ratio, 2.0 * extent.ratio, 4.0 * extent.ratio), extent)
    yield wave({"effect": "kinematic_error", **across}, turns, 1e-6)


def _elasticity(joint: str) -> Proposal:
    """Elasticity of a joint that the model takes for rigid: linear in its compliance."""
    return Proposal(
        {"effect": "joint_elasticity", "joint": joint, "side": "transmission"},
        make=lambda point, x: JointElasticity(joint, stiffness=1.0 / float(x[0])) if x[0] > 0.0 else None,
        units=lambda point: [(JointElasticity(joint, stiffness=1.0), 1.0)],
        positive=(True,),
    )


def _actuator(joint: str, extent: MotionExtent) -> Iterator[Proposal]:
    motor = {"joint": joint, "side": "motor"}
    slow = SLOW_HARMONICS if extent.turns else ()
    turns = _seen((*slow, *(k * extent.ratio for k in (1.0, 2.0, 3.0, 6.0))), extent)
    yield wave({"effect": "torque_ripple", **motor}, turns, extent.torque)


def _link(joint: str, extent: MotionExtent) -> Iterator[Proposal]:
    link = {"joint": joint, "side": "link"}
    rests = np.linspace(extent.low - extent.span, extent.high + extent.span, 13)
    yield linear({"effect": "parallel_spring", **link}, "stiffness", [{"rest": float(r)} for r in rests])
    yield _end_stop({"effect": "end_stop", **link}, extent)
    if not extent.turns:
        return
    cables, names = {"effect": "position_torque", **link}, ("cos_1", "sin_1", "cos_2", "sin_2")
    yield Proposal(
        cables,
        make=lambda point, x: at(cables, **dict(zip(names, map(float, x), strict=True))),
        units=lambda point: [(at(cables, **dict(zip(names, row, strict=True))), 1.0) for row in np.eye(4).tolist()],
    )


def _end_stop(place: Mapping[str, str], extent: MotionExtent) -> Proposal:
    """A one-sided spring beyond a limit within the range of the motion; linear in its stiffness."""

    def build(point: Point, stiffness: float) -> Effect:
        lower, upper = (point[0], math.inf) if point[1] < 0 else (-math.inf, point[0])
        return at(place, lower=lower, upper=upper, stiffness=stiffness, damping=0.0)

    depths = (extent.span * np.geomspace(0.003, 0.15, 7)).tolist()
    return Proposal(
        place,
        make=lambda point, x: build(point, float(x[0])) if x[0] > 0.0 else None,
        units=lambda point: [(build(point, 1.0), 1.0)],
        grid=(*((extent.low + d, -1.0) for d in depths), *((extent.high - d, 1.0) for d in depths)),
        positive=(True,),
    )


def _couplings(joint: str, names: tuple[str, ...]) -> Iterator[Proposal]:
    for other in names:
        if other != joint:
            place = {"effect": "joint_coupling", "joint": joint, "side": "motor", "other": other}
            yield linear(place, "coefficient")


def _sensors(equations: Equations, j: int, extent: MotionExtent) -> Iterator[Proposal]:
    """Lags, eccentricities, gains and offsets of the measured channels that can show them."""
    model, data = equations.true, equations.data[0]
    joint = model.joint_names[j]
    both = bool(data.both[j])
    for signal, there in (("q", data.has_q[j]), ("theta", data.has_theta[j])):
        if not there:
            continue
        place = {"channel": f"{signal}.{joint}"}
        yield linear({"effect": "channel_lag", **place}, "delay", unit=1e-4)
        turns = (1.0, 2.0) if signal == "q" else (1.0, 2.0, extent.ratio, 2.0 * extent.ratio)
        yield wave({"effect": "encoder_eccentricity", **place}, _seen(turns, extent), 1e-6)
        if both or any(model.gravity):  # one encoder alone: gravity's shape tells, inertias would hide a gain
            yield linear({"effect": "sensor_gain", **place}, "gain", unit=1e-4)
            yield linear({"effect": "sensor_offset", **place}, "offset", unit=1e-5)
    if data.has_tau_s[j]:
        for name, number in (("sensor_offset", "offset"), ("sensor_gain", "gain")):
            yield linear({"effect": name, "channel": f"tau_s.{joint}"}, number, unit=1e-4)
