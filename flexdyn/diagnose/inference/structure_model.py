"""A structure with its coefficients as a model: what stays linear until the last fit, and what that needs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, bounded, least_factor
from flexdyn.diagnose.hypothesis.linear import tangent_scale
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.effects import Effect, JointEffect
from flexdyn.model.uncertain_parameters import FileNumber


def waits(space: Space, c: int) -> bool:
    """Whether a candidate makes a rigid joint elastic: all its equations change, so it stays linear until the end."""
    candidate, true = space.candidates[c], space.library.equations.true
    if candidate.law.takes_load:
        return not true.elastic[true.index(candidate.place["joint"])]
    return bool(candidate.law.makes_elastic)


def hypothesis_of(space: Space, structure: Structure, *, whole: bool = False, share: float = 1.0) -> Hypothesis:
    """A structure with its coefficients as a hypothesis; what makes joints elastic only in the whole one.

    What the linearisation is at, is returned as it is: a fit that starts there finds its own steps.

    Args:
        space: of the linearisation.
        structure: in it.
        whole: whether joints become elastic.
        share: of the step from the linearisation to the coefficients [1].
    """
    here = space.library.start
    if structure == standing(space) and not any(waits(space, c) for c, _ in structure):
        return here
    columns, mean = space.gram.with_base(space.gram.estimate(space.columns(structure)))
    value = dict(zip(columns.tolist(), (share * mean).tolist(), strict=True))
    names = list(here.factors)
    factors = {n: here.factors[n] + value[k] for k, n in enumerate(names)}
    freed: set[FileNumber] = set()
    effects: list[Effect] = []
    for c, p in sorted(structure):
        candidate = space.candidates[c]
        if candidate.number is not None:
            factors[candidate.number] += value[int(candidate.columns[p][0])]
            freed.add(candidate.number)
        elif candidate.stands is not None:
            steps = [value[int(k)] for k in candidate.columns[p][1:]]
            effects.append(_moved(candidate.stands, dict(zip(candidate.tangents, steps, strict=True))))
        elif whole or not waits(space, c):
            x = np.array([value[int(k)] for k in candidate.columns[p]])
            x = np.where(space.matrix.prior.positive[candidate.columns[p]], np.maximum(x, 0.0), x)
            effect = candidate.effect(p, x)
            if effect is not None and not effect.is_neutral:
                effects.append(effect)
    effects = _softened(space, structure, effects)
    factors = {n: max(f, least_factor(n)) for n, f in factors.items()}
    return dataclasses.replace(here, factors=factors, freed=frozenset(freed), effects=tuple(effects))


def effect_of(candidate: Candidate, here: Hypothesis) -> Effect | None:
    """A hypothesis' effect of a candidate's kind and place."""
    proposal = candidate.proposal
    return None if proposal is None else next((each for each in here.effects if proposal.is_of(each)), None)


def factor_of(space: Space, structure: Structure, number: FileNumber) -> tuple[float, float]:
    """Factor of a number of the file in a structure, by the linear equations, and its standard deviation [1].

    Small amounts of every law are beside it there, unlike in a fit of the structure alone.
    """
    estimate = space.gram.whole(space.columns(structure))
    own = [space.candidates[c].columns[p][0] for c, p in structure if space.candidates[c].number == number]
    parts = np.isin(estimate.columns, [list(space.library.start.factors).index(number), *own])
    variance = float(estimate.covariance[np.ix_(parts, parts)].sum())
    return space.library.start.factors[number] + float(estimate.mean[parts].sum()), float(np.sqrt(variance))


def standing(space: Space) -> Structure:
    """The structure that a linearisation is at: effects that stand and numbers that no tolerance holds."""
    each = enumerate(space.candidates)
    return frozenset((c, 0) for c, one in each if one.stands is not None or one.number in space.library.start.freed)


def _moved(effect: Effect, steps: Mapping[str, float]) -> Effect:
    """An effect with its parameters moved along their tangents."""
    return effect.replace(
        **{name: bounded(effect, name, step * tangent_scale(effect, name)) for name, step in steps.items()}
    )


def _softened(space: Space, structure: Structure, effects: list[Effect]) -> list[Effect]:
    """Effects with the elasticities that friction which takes the load needs: as stiff as the data allow.

    Where no compliance of the joint was compared, such friction is left out.
    """
    true = space.library.equations.true
    soft = {each.joint for each in effects if isinstance(each, JointEffect) and each.makes_elastic}
    rigid = {name for name, elastic in zip(true.joint_names, true.elastic, strict=True) if not elastic} - soft
    loaded = [each for each in effects if isinstance(each, JointEffect) and each.takes_load and each.joint in rigid]
    for joint in sorted({each.joint for each in loaded}):
        stiffest = _stiffest(space, structure, joint)
        if stiffest is None:
            effects = [each for each in effects if each not in loaded or getattr(each, "joint", None) != joint]
        else:
            effects = [*effects, stiffest]
    return effects


def _stiffest(space: Space, structure: Structure, joint: str) -> Effect | None:
    """The elasticity of a joint one standard deviation above the compliance that suits the data best."""
    of_joint = (c for c, other in enumerate(space.candidates) if other.place.get("joint") == joint)
    c = next((c for c in of_joint if space.candidates[c].law.makes_elastic), None)
    if c is None:
        return None
    estimate = space.gram.estimate(space.columns(structure | {(c, 0)}))
    k = int(np.flatnonzero(estimate.columns == space.candidates[c].columns[0][0])[0])
    compliance = max(float(estimate.mean[k]), 0.0) + float(np.sqrt(estimate.covariance[k, k]))
    return space.candidates[c].effect(0, np.array([compliance]))
