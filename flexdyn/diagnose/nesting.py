"""An effect that contains another is named only where its extra numbers are away from the limit."""

from __future__ import annotations

from flexdyn.diagnose.refine import Refined
from flexdyn.effects import AsymmetricFriction, CoulombFriction, Effect

APART = 4.0
"""Standard deviations by which the two levels of an asymmetric friction must differ to be two."""
LEAST = 0.02
"""Share of their mean by which they must differ, whatever the statistics say."""


def simplified(last: Refined) -> Refined:
    """The same fit with effects replaced by the simpler ones that they amount to."""
    std = last.effect_std()
    effects = tuple(_simpler(effect, std) for effect in last.hypothesis.effects)
    return last.renamed(dict(zip(last.hypothesis.effects, effects, strict=True)))


CONTAINS = {
    "asymmetric_friction": ("coulomb_friction", "torque_offset"),
    "presliding_friction": ("coulomb_friction", "viscous_friction"),
    "stribeck_friction": ("coulomb_friction",),
    "warm_up_friction": ("viscous_friction",),
    "position_dependent_friction": ("coulomb_friction",),
}
"""Effects that become others in a limit: these fit nearly as well, which says nothing against either."""


def is_simpler(one: str, other: str) -> bool:
    """Whether `one` is what `other` becomes in a limit."""
    return one in CONTAINS.get(other, ())


def is_nested(one: str, other: str) -> bool:
    """Whether one of two effects contains the other."""
    return other in CONTAINS.get(one, ()) or one in CONTAINS.get(other, ())


def _simpler(effect: Effect, std: dict[tuple[Effect, str], float]) -> Effect:
    if isinstance(effect, AsymmetricFriction):
        up, down = effect.level_positive, effect.level_negative
        spread = sum(std.get((effect, name), 0.0) ** 2 for name in ("level_positive", "level_negative")) ** 0.5
        if abs(up - down) < max(APART * spread, LEAST * 0.5 * (up + down)):
            return CoulombFriction(effect.joint, side=effect.side, level=0.5 * (up + down))
    return effect
