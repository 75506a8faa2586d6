"""Effects that the model holds already: priors of their parameters, and their columns."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from flexdyn.diagnose.constants import EFFECT_TORQUE_SHARE
from flexdyn.diagnose.hypothesis.linear import tangent, tangent_scale
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.inference.candidate import Column, natural
from flexdyn.diagnose.inference.column_maker import ColumnMaker, natural_spread
from flexdyn.diagnose.inference.priors import FITTED_SIZE_WIDTH, UNKNOWN_WIDTH
from flexdyn.diagnose.inference.sizes import Sizes
from flexdyn.effects import Effect, JointEffect

Belief = Callable[[Effect, str], tuple[float, float]]
"""Of an effect's parameter: how far its prior's centre is from its value, and its standard deviation, in its unit."""


def beliefs(maker: ColumnMaker, effects: tuple[Effect, ...]) -> Belief:
    """Priors of effects' parameters, those that need a column taken once: where the effects stand.

    Of other effects, such as one that a fit tries in the place of another one: where they are when first asked for.
    """
    at = maker.first or maker
    known: dict[tuple[object, ...], tuple[float, float]] = {}

    def known_belief(effect: Effect, name: str) -> tuple[float, float]:
        """The prior of a parameter: see `Belief`."""
        nothing = effect.neutral.get(name)
        if nothing is None or not np.isfinite(nothing):
            return belief(maker, effect, name)
        place = (name, *(getattr(effect, key, None) for key in ("name", "joint", "side", "other", "channel", "frame")))
        if place not in known:
            known[place] = (float(nothing), _spread(at, effect, name))
        return known[place][0] - getattr(effect, name), known[place][1]

    for effect in effects:
        for entry in effect.parameters():
            known_belief(effect, entry.name)
    return known_belief


def belief(maker: ColumnMaker, effect: Effect, name: str, sizes: Sizes | None = None) -> tuple[float, float]:
    """Prior of a parameter: how far its centre is from its value, and its standard deviation, in its unit.

    A parameter that makes the effect large is ``N(neutral, (share of the drive)^2)``; one that the grid is of is
    log-normal about the grid's middle, half its range wide; of others nothing is known.

    Args:
        maker: where the effect stands.
        effect: of which.
        name: of the parameter.
        sizes: what the equations are about without the effect: of two encoders of a rigid joint, one of which is late,
            they are about nothing once the lag is taken off; None: the maker's.
    """
    value, nothing = getattr(effect, name), effect.neutral.get(name)
    if nothing is not None and np.isfinite(nothing):
        raw = tangent(maker.equations, effect, name)
        largest = float((sizes or maker.sizes).largest(raw[None])[0])
        spread = natural_spread(effect.name, EFFECT_TORQUE_SHARE / largest) if 0.0 < largest < np.inf else np.inf
        return (float(nothing) - value, spread) if np.isfinite(spread) else (0.0, np.inf)
    proposal = next(p for p in maker.proposals if p.is_of(effect))
    if name not in proposal.axes or len(proposal.grid) < 2 or value <= 0.0:
        return 0.0, np.inf
    grid = [point[proposal.axes.index(name)] for point in proposal.grid]
    if min(grid) <= 0.0:
        return 0.0, np.inf
    low, high = float(np.log(min(grid))), float(np.log(max(grid)))
    return -value * (float(np.log(value)) - 0.5 * (low + high)), value * max(0.5 * (high - low), 0.1)


def _spread(maker: ColumnMaker, effect: Effect, name: str) -> float:
    """Prior standard deviation of a parameter that makes an effect large."""
    true = maker.equations.true
    if isinstance(effect, JointEffect) and effect.takes_load and not true.elastic[true.index(effect.joint)]:
        column = maker.columns(next(p for p in maker.proposals if p.is_of(effect)), ())
        return np.inf if column is None else float(column.std[0])
    return belief(maker.alone(effect), effect, name, maker.sizes)[1]


def standing_columns(
    maker: ColumnMaker, effect: Effect, proposal: Proposal, belief: Belief
) -> tuple[Column, list[str]]:
    """An effect of the start: its present torque, which may be absent, and the tangents of its parameters.

    A parameter that makes it large is ``N(neutral, (share of the drive)^2)``, so its tangent's coefficient has the
    mean ``neutral - value``. Of others, such as a phase, nothing is known but that the change is no larger than the
    effect may be: the prior of a sine and a cosine of equal width. A harmonic that is a whole number stays.

    Returns:
        the columns, and the names of the parameters that have tangents.
    """
    others = tuple(each for each in maker.start.effects if each is not effect)
    without = maker.equations.of(dataclasses.replace(maker.start, effects=others).model())
    change = maker.equations.residual - without.residual
    share, least = maker.sizes.of(effect, change)
    parts, size, mean, std, names = [change], [share], [1.0], [FITTED_SIZE_WIDTH], []
    for each, name in maker.start.unknowns():
        if each is not effect or (
            name == effect.cycles
            and getattr(effect, name) in natural(getattr(effect, name), maker.gear_ratio(proposal))
        ):
            continue
        scale = tangent_scale(effect, name)
        raw = scale * tangent(maker.equations, effect, name)
        largest = maker.sizes.largest(raw[None])[0]
        if not np.isfinite(largest) or largest == 0.0:
            continue
        off, spread = belief(effect, name)
        parts.append(raw)
        size.append(largest)
        std.append(spread / scale)
        mean.append(off / scale if np.isfinite(spread) else 0.0)
        names.append(name)
    most = max((d * s for d, s in zip(std[1:], size[1:], strict=True) if np.isfinite(d)), default=np.inf)
    std = [min(d, most / s if np.isinf(d) else d, UNKNOWN_WIDTH) for d, s in zip(std, size, strict=True)]
    white, cost = maker.work.whiten(np.stack(parts).T), maker.sizes.log_jacobian(effect)
    return Column.of(white, maker.many, np.array(std), np.array(mean), np.array(size), cost, least), names
