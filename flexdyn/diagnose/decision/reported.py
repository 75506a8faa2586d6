"""Which structure is reported: the best, or one with plainer laws or without likely imitations if more has a name."""

from __future__ import annotations

import functools

from flexdyn.diagnose.constants import ESTABLISHED, LIKELY_IMITATION
from flexdyn.diagnose.decision.corrected import Corrected, corrected
from flexdyn.diagnose.decision.needed_in_fits import needed_in_fits
from flexdyn.diagnose.decision.one_law import by_plainer_laws, in_one_law, with_best
from flexdyn.diagnose.decision.refitted import share_in_forces
from flexdyn.diagnose.decision.rivals_in_fits import rivals_in_fits
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.passes import Posterior


def reported(compared: Posterior, plain: Workspace) -> tuple[Posterior, Corrected]:
    """The posterior whose best structure is reported, and its corrected model.

    Args:
        compared: the posterior over structures.
        plain: the equations of the model as given, with the sensors' weights.
    """
    compared = rivals_in_fits(needed_in_fits(compared))
    shares = functools.partial(share_in_forces, compared) if plain.equations.replayed.any() else None
    found = corrected(compared, plain, shares)
    # A law that gets no name, however genuine: the product with its probability may be too small for one.
    genuine = {c: p if c in found.named else 0.0 for c, p in found.genuine.items()}
    other = in_one_law(by_plainer_laws(compared, genuine), found.named)
    again = found if other is compared else corrected(other, plain, shares)
    new = {c for c, _ in other.best} - {c for c, _ in compared.best}
    # Only if what was put in place has a name, and nothing else loses its own.
    still = found.named & {c for c, _ in other.best}
    if not new or (new & again.named and still <= again.named):
        compared, found = other, again
    other = _without_imitations(compared, found)
    if other is not compared:
        again = corrected(other, plain, shares)
        if again.named > found.named:
            return other, again
    return compared, found


def _without_imitations(compared: Posterior, found: Corrected) -> Posterior:
    """The posterior whose best structure has no uncertain law that is more likely an imitation.

    Such a law gets no name, but it may leave nothing for another one that has its torque in other structures: quadratic
    drag in the place of the viscous friction that every motor has. A law that is in all structures stays: whatever it
    imitates is there, and would be left over for others to imitate.
    """
    doubtful = {c for c, genuine in found.genuine.items() if genuine < LIKELY_IMITATION} - found.named
    uncertain = {c for c in doubtful if found.masses.of_any([c]) < ESTABLISHED}
    laws = {c for c in uncertain if compared.space.candidates[c].number is None}
    return with_best(compared, frozenset(each for each in compared.best if each[0] not in laws))
