"""Refuse a recording if the correction of one mistake explains its torques, and the given recording does not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.match import Match, liveliest, match
from flexdyn.diagnose.equations.mistakes import EXPLAINED_SHARE, Mistake, far, fits, mistakes, wanted_share
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.link_side import LinkSide

POOR_VARIANCE_SHARE = 0.7
"""Mistakes are searched if a model explains less of a torque's variance [1]."""
LIVELIEST_LENGTH = 12.0
"""Length of the part of a recording with the most motion, in which mistakes are searched [s]."""
BETTER_BY_SHARE = 0.2
"""The correction of a mistake of several joints must explain this additional share of each torque, or all of it [1]."""
NOTED_VARIANCE_SHARE = 0.5
"""If less than this share of a torque's variance is explained, there is a note [1]."""
SIZE_WEIGHT = 0.1
"""Penalty in explained share for torques of the wrong size, for a factor of e [1]."""
BELIEVED_RATIO = 5.0
"""A mistake is accepted only if its correction reduces the unexplained share by this factor [1]."""


def check_equations(model: FlexibleJointModel, links: LinkSide, data: Measured) -> Iterator[str]:
    """Refuse the recording if the correction of one mistake explains the torques far better."""
    seen = match(model, links, data)
    poor = seen.says & (seen.plain < POOR_VARIANCE_SHARE)
    if poor.any():
        _check_mistakes(model, links, liveliest(data, LIVELIEST_LENGTH))
    for j in np.flatnonzero(poor):
        joint, gain, share = model.joint_names[j], float(seen.gain[j]), float(seen.share[j])
        if share > EXPLAINED_SHARE and far(gain):
            remedy = f"check the unit of tau.{joint} and the masses of the model"
            problem = "the torque has the right shape and the wrong size"
            value = f"{gain:.3g} times what the model needs"
            raise InputError(problem, file=data.name, key=f"tau.{joint}", value=value, remedy=remedy)
        if (share > NOTED_VARIANCE_SHARE and 0.5 < gain < 2.0) or data.forced[j]:  # a rig tests what models lack
            continue
        yield (
            f"In {data.name or 'the recording'} the torque of {joint} follows what the model needs only loosely: at "
            f"{gain:.2g} times it, with {100.0 * share:.0f} % of its variance."
        )


def _check_mistakes(model: FlexibleJointModel, links: LinkSide, data: Measured) -> None:
    seen = match(model, links, data)
    poor = seen.says & (seen.plain < POOR_VARIANCE_SHARE)
    best: tuple[float, Mistake, Match] | None = None
    for mistake in mistakes(model, seen) if poor.any() else ():
        undone = match(model, links, mistake.undone(data))
        merit = _merit(seen, undone, mistake, poor)
        if merit is not None and mistake.of_units and not _beyond_springs(model, links, data, mistake):
            continue
        if merit is not None and (best is None or merit > best[0] + 0.02):
            best = (merit, mistake, undone)
    if best is not None:
        raise _refused(data, model.joint_names, seen, *best[1:])


def _beyond_springs(model: FlexibleJointModel, links: LinkSide, data: Measured, mistake: Mistake) -> bool:
    """Whether another unit of the positions explains more than a missing spring would."""
    sprung, undone = (match(model, links, each, springs=True) for each in (data, mistake.undone(data)))
    return all(undone.says[j] and undone.share[j] > sprung.plain[j] + BETTER_BY_SHARE for j in mistake.joints)


def _merit(seen: Match, undone: Match, mistake: Mistake, poor: Flags) -> float | None:
    """Mean explained share after correcting a mistake, minus the penalty for the size; None if it is too small."""
    known = seen.says | undone.says
    now = np.where(fits(mistake, undone), undone.share, 0.0)
    before = _share_as_given(seen, mistake)
    wanted = wanted_share(mistake, seen.gain)
    poor = poor & (before < POOR_VARIANCE_SHARE)
    healed = poor & (now >= wanted) & ((1.0 - now < (1.0 - before) / BELIEVED_RATIO) | (wanted < EXPLAINED_SHARE))
    named = [j for j in mistake.joints if known[j]]
    better = (now >= wanted) | (now > before + BETTER_BY_SHARE)
    if not named or not healed[known].any() or not better[named].all() or (now < before - 0.1)[known].any():
        return None
    off = np.abs(np.log(np.maximum(np.abs(undone.gain[named]), 1e-9))).mean()
    return float(now[known].mean() - SIZE_WEIGHT * off)


def _share_as_given(seen: Match, mistake: Mistake) -> Array:
    """Explained shares without the correction (n,): a gain that is right within the same factor counts for both."""
    return np.where(fits(mistake, seen), seen.share, np.clip(seen.plain, 0.0, 1.0))


def _refused(data: Measured, joints: Sequence[str], seen: Match, mistake: Mistake, undone: Match) -> InputError:
    """The error for an accepted mistake; it names the joint for which the correction explains most."""
    gained = undone.share - _share_as_given(seen, mistake)
    j = max(mistake.joints, key=lambda i: float(gained[i]))
    if mistake.of_torques:
        j, value = mistake.joints[0], f"{seen.gain[mistake.joints[0]]:.3g} times what the model needs"
    else:
        before, after = 100.0 * float(_share_as_given(seen, mistake)[j]), 100.0 * float(undone.share[j])
        value = f"{before:.0f} % of the torque explained as given, {after:.0f} % without the mistake"
    signal = "tau" if not mistake.of_positions else "q" if data.has_q[j] else "theta"
    return InputError(mistake.problem, file=data.name, key=f"{signal}.{joints[j]}", value=value, remedy=mistake.remedy)
