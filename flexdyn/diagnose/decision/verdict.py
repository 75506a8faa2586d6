"""The verdict: whether noise is left on the test data, and whether effects were named."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, LEFT_TORQUE_SHARE, NOISE_GAP, NOISE_LEVEL_ERROR
from flexdyn.diagnose.decision.gaps import Shots
from flexdyn.diagnose.decision.model_rows import ModelRows, rms
from flexdyn.diagnose.equations.layout import LINK, TRANSMISSION
from flexdyn.diagnose.report.measures import Gap, Left, ResidualPlace
from flexdyn.diagnose.report.result import Verdict

QUANTITY = re.compile(r"abs\((\w+(?: of \w+)?)\)|\b(q|v|omega|t)\b(?= [<>b])|(after a reversal)")


def is_noise(shots: Shots | None, left: Sequence[Left]) -> bool:
    """Whether what is left on the test data is noise.

    The gap of all windows but the tenth that is farthest off is that of a perfect model, and no joint's equations leave
    more than 1 % of its torque. Noise decides when a joint sticks, so a few windows of a right model may be far off; if
    there are more, something is missing, such as an end stop that is seldom touched. Simulations that noise moves
    farther than the given model is off tell nothing: see `simulations_tell`.

    Args:
        shots: windows; None: the data are too short for one, and the equations alone decide.
        left: what the equations of the corrected model leave, joints with 1 % of their torque or more.
    """
    if shots is None:
        return not left
    return not left and simulations_tell(shots.gap) and shots.after.is_mostly_noise(shots.gap.floor)


def simulations_tell(gap: Gap) -> bool:
    """Whether noise moves simulations with the corrected model less than the given model is off, or hardly at all.

    A spring as stiff as a rigid joint turns the rounding of a position into a large torque.

    Args:
        gap: of some data.
    """
    return gap.floor <= max(gap.before, NOISE_GAP)


def verdict(*, named: bool, noise: bool | None, converged: bool) -> Verdict:
    """What the report says.

    Args:
        named: whether there are findings; all of them are established.
        noise: whether what is left on the test data is noise; None: there are no test data.
        converged: whether the final fit has converged to a stationary point.
    """
    if not converged:
        return "not_converged"
    if noise is None:
        return "untested"
    if noise:
        return "explained" if named else "no_discrepancy"
    return "partly_explained" if named else "unexplained"


def left_by_joint(rows: ModelRows, depends_on: Mapping[str, tuple[str, ...]]) -> tuple[Left, ...]:
    """Of every joint that leaves more than noise and 1 % of its torque, the largest share first.

    The mean square of the rows in torque, less that of noise; of a joint with two equations that one which
    leaves more. It counts only where the white rows are beyond chance, and beyond what is unknown of the noise.

    Args:
        rows: as a rule over the test data.
        depends_on: by joint, quantities that it is known to change with.
    """
    at, seen, white = rows.after, rows.seen, rows.white(rows.after)
    residual, variance = at.residual.reshape(seen.shape), rows.variance
    found: dict[str, Left] = {}
    for k, (j, kind) in enumerate(at.kinds):
        clear, joint = seen[:, k], at.true.joint_names[j]
        if kind == TRANSMISSION or not clear.any():
            continue
        unit = at.softness[j] if kind == LINK else 1.0
        beyond = float((white[clear, k] ** 2 - 1.0).mean())
        power = float((residual[clear, k] ** 2 - variance[clear, k]).mean())
        if beyond <= max(CERTAIN_SIGMAS * np.sqrt(2.0 / clear.sum()), NOISE_LEVEL_ERROR) or power <= 0.0:
            continue
        share = float(unit * np.sqrt(power)) / max(rms(rows.torque(j)[1]), 1e-12)
        if share >= LEFT_TORQUE_SHARE and (joint not in found or share > found[joint].share_of_torque):
            time = _memory(white[:, k], clear) * at.filters.every * at.data[0].dt
            found[joint] = Left(joint, share, time, depends_on.get(joint, ()))
    return tuple(sorted(found.values(), key=lambda each: (-each.share_of_torque, each.joint)))


def _memory(white: Array, clear: Flags) -> int:
    """Rows over which what is left stays alike: until its autocorrelation has fallen to 1/e.

    Of white rows noise adds 1 to the power, and nothing to products of different rows.
    """
    power = float((white[clear] ** 2).mean()) - 1.0
    for lag in range(1, len(white) // 4):
        both = clear[lag:] & clear[:-lag]
        alike = float((white[lag:] * white[:-lag])[both].mean()) if both.any() else 0.0
        if alike < power / math.e:
            return lag
    return max(1, len(white) // 4)


def dependence(places: Sequence[ResidualPlace]) -> dict[str, tuple[str, ...]]:
    """Quantities that the residual of every joint depends on: those of the regimes in which it is largest.

    Args:
        places: where the residual of the corrected model is largest.
    """
    return {place.joint: tuple(dict.fromkeys(quantities(place.regime))) for place in reversed(places)}


def quantities(regime: str) -> list[str]:
    """Quantities that a regime in words is about: ``abs(omega) < 0.1 rad/s`` is about ``omega``."""
    return [plain or signed or "reversal" for plain, signed, _ in QUANTITY.findall(regime)]
