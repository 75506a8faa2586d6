"""Whether a law behind a prescribed motion is what its name says: by fits with it and without it.

Links behind a spring whose motor is moved are simulated. Their equations bend with every number that acts there, so the
linear ones say too much of what the file's numbers could do in a law's place.
"""

from __future__ import annotations

import dataclasses

from flexdyn.diagnose.decision.model_effects import without_effect
from flexdyn.diagnose.equations.columns import moves_links
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.inference.apart import beyond_noise
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.structure_model import effect_of
from flexdyn.diagnose.inference.whitening import Tempered

STEPS_WITHOUT = 6
"""Of a fit without the law."""


def share_in_forces(found: Posterior, candidate: int) -> float:
    """What a candidate of the best structure takes off the equations, over what is left of them beyond noise [1].

    Without it all numbers are fitted again, from where they stand and from the file's values; the better fit counts,
    and what the file's tolerances say of its numbers with it.

    Args:
        found: the posterior.
        candidate: of the best structure.

    Returns:
        0 where the candidate does not act on links that are simulated.
    """
    made = found.fitted
    here, whiten = made.hypothesis, made.space.whiten
    effect = effect_of(found.space.candidates[candidate], here)
    if effect is None or not moves_links(made.equations, effect) or not isinstance(whiten, Tempered):
        return 0.0
    rest = without_effect(here, effect)
    given = dataclasses.replace(rest, factors=dict.fromkeys(rest.factors, 1.0))
    without = min(
        (fit(start, made.space, steps=STEPS_WITHOUT) for start in (rest, given)), key=lambda made: made.reached
    )
    error = whiten.error
    squares = (made.regression.left[: len(made.regression.y)] ** 2).reshape(-1, len(error.scale)).sum(axis=0)
    left = float(error.weights @ beyond_noise(error, squares / error.weights))
    return max(without.reached - made.reached, 0.0) / max(left, 1e-9)
