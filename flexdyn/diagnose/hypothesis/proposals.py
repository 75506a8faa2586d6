"""The catalogue as hypotheses: every effect at every place where the model can have it and the data can show it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence

from flexdyn.diagnose.equations.computed_positions import acting_on
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.proposal import Proposal, declared, extent_of
from flexdyn.effects import Effect, JointEffect, SensorEffect, catalogue
from flexdyn.effects.extent import MotionExtent
from flexdyn.model.flexible_joint_model import FlexibleJointModel


def proposals(equations: Equations) -> list[Proposal]:
    """Every effect of the catalogue at every place.

    Of two structures that are equally likely the one that is proposed first counts, so the order matters: per joint
    first laws that are linear in their own numbers, then others; those of a drive before those of a link.
    """
    kinds = [
        k
        for k in catalogue().values()
        if k.__module__.startswith("flexdyn.") and (k.linear or k.linear_bounds or k.axes)
    ]
    laws = [k for k in kinds if issubclass(k, JointEffect) and not _has(k, "other")]
    own = [k for k in laws if k.stage != "link" and (k.linear or k.grids)]
    shaped = [k for k in laws if k.stage != "link" and k not in own]
    links = sorted((k for k in laws if k.stage == "link"), key=lambda k: not k.axes and not k.linear_bounds)
    sensors = sorted((k for k in kinds if issubclass(k, SensorEffect) and not k.late_by), key=lambda k: k.name)
    lags = [k for k in kinds if issubclass(k, SensorEffect) and k.late_by]
    found: list[Proposal] = []
    true = equations.true
    for j, joint in enumerate(true.joint_names):
        extent, elastic = extent_of(equations, j), bool(true.elastic[j])
        for side in ("motor", "link") if elastic else ("motor",):
            found += _on_side(joint, side, own, extent, true)
            found += _on_side(joint, side, [k for k in shaped if len(k.sides) > 1], extent, true)
        if elastic or true.rotor_inertia[j] > 0.0:
            found += _on_side(joint, "transmission", [*own, *shaped], extent, true)
        found += _on_side(joint, "motor", [k for k in shaped if len(k.sides) == 1], extent, true)
        found += _on_side(joint, "link", links, extent, true)
        for kind in (k for k in kinds if _has(k, "other")):
            place = {"joint": joint, "side": kind.sides[0]}
            for k, other in enumerate(true.joint_names):
                if other != joint:  # drives touch where one joint carries the other
                    far = j not in (k, true.robot.tree.carrier(k)) and k != true.robot.tree.carrier(j)
                    found.append(dataclasses.replace(declared(kind, {**place, "other": other}, extent), seldom=far))
        found += _sensors(equations, j, extent, sensors)
    tip = {"frame": true.robot.tip}
    found += [declared(k, tip, extent) for k in kinds if _has(k, "frame")]
    found += _lags(equations, lags)
    return [each for each in found if each.grid and _may_be(equations, each)]


def _has(kind: type[Effect], field: str) -> bool:
    return any(each.name == field for each in dataclasses.fields(kind))  # type: ignore[arg-type]


def _may_be(equations: Equations, proposal: Proposal) -> bool:
    """Whether an effect can be where a test rig prescribes the motion.

    A motor does nothing there. A sensor measures the force; it may have an offset, but no actuator's effect.
    """
    true, kind = equations.true, catalogue()[proposal.place["effect"]]
    if proposal.joint not in true.joint_names or not equations.data[0].forced[true.index(proposal.joint)]:
        return True
    return kind.stage != "actuator" or kind.is_constant


def _on_side(
    joint: str, side: str, kinds: Iterable[type[Effect]], extent: MotionExtent, true: FlexibleJointModel
) -> Iterator[Proposal]:
    """Proposals for one side of a joint; a rigid joint has no transmission, but may be elastic after all."""
    elastic = bool(true.elastic[true.index(joint)])
    beside = {each.name for each in acting_on(true, true.index(joint)) if each.side == side}
    for kind in kinds:
        possible = elastic != bool(kind.makes_elastic) if side == "transmission" else elastic or not kind.takes_load
        if side in kind.sides and possible:
            yield declared(kind, {"joint": joint, "side": side}, extent, beside)


def _sensors(
    equations: Equations, j: int, extent: MotionExtent, kinds: Iterable[type[SensorEffect]]
) -> Iterator[Proposal]:
    """Errors of the measured channels that can show them.

    With one encoder only gravity shows a gain or an offset: otherwise the inertias could explain it.
    """
    model, data = equations.true, equations.data[0]
    told = bool(data.both[j]) or any(model.gravity)
    for signal in ("q", "theta", "tau_s"):
        if getattr(data, f"has_{signal}")[j]:
            channel, seen = f"{signal}.{model.joint_names[j]}", dataclasses.replace(extent, signal=signal)
            for kind in kinds:
                if (not kind.signals or signal in kind.signals) and (told or kind.cycles or signal == "tau_s"):
                    yield declared(kind, {"channel": channel}, seen)


def _lags(equations: Equations, kinds: Sequence[type[SensorEffect]]) -> Iterator[Proposal]:
    """Lags of the encoders, and of the recorded torque.

    A lag is no small change where a spring is stiff, so it is on a grid.
    """
    true = equations.true
    torques = (f"tau.{name}" for name in true.joint_names)
    for channel in (*equations.data[0].encoders(true.joint_names), *torques):
        signal, _, joint = channel.partition(".")
        extent = dataclasses.replace(extent_of(equations, true.index(joint)), signal=signal)
        yield from (declared(kind, {"channel": channel}, extent) for kind in kinds)
