"""The columns of an effect that the model holds already: what it does now, and the tangents of its parameters."""

from __future__ import annotations

import dataclasses

import numpy as np

from flexdyn.diagnose.equations.columns import of_parameter
from flexdyn.diagnose.hypothesis.linear import tangent_scale
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.inference.candidate import Column, natural
from flexdyn.diagnose.inference.column_maker import ColumnMaker
from flexdyn.diagnose.inference.parameter_beliefs import Belief
from flexdyn.diagnose.inference.priors import FITTED_SIZE_WIDTH, UNKNOWN_WIDTH
from flexdyn.effects import Effect


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
    parts, size, mean, std, names = [maker.whiten(change)], [share], [1.0], [FITTED_SIZE_WIDTH], []
    for each, name in maker.start.unknowns():
        if each is not effect or (
            name == "harmonic" and getattr(effect, name) in natural(getattr(effect, name), maker.gear_ratio(proposal))
        ):
            continue
        scale = tangent_scale(effect, name)
        raw = scale * of_parameter(maker.equations, effect, name, 0.1 * scale)
        largest = maker.sizes.largest(raw[None])[0]
        if not np.isfinite(largest) or largest == 0.0:
            continue
        off, spread = belief(effect, name)
        parts.append(maker.whiten(raw))
        size.append(largest)
        std.append(spread / scale)
        mean.append(off / scale if np.isfinite(spread) else 0.0)
        names.append(name)
    most = max((d * s for d, s in zip(std[1:], size[1:], strict=True) if np.isfinite(d)), default=np.inf)
    std = [min(d, most / s if np.isinf(d) else d, UNKNOWN_WIDTH) for d, s in zip(std, size, strict=True)]
    white, cost = np.stack(parts, axis=1), maker.sizes.log_jacobian(effect)
    return Column.of(white, maker.many, np.array(std), np.array(mean), np.array(size), cost, least), names
