"""Candidates of the search in the words of the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Space
from flexdyn.diagnose.report.suspects import Considered, Number, Structure, Suspect
from flexdyn.effects import Effect
from flexdyn.effects.model_error import effect_place
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.resolved_parameters import OF_MOTOR, units_of

PLACES = ("channel", "other", "frame", "of", "parameter")
SIDE_OF_NUMBER = dict.fromkeys(("rotor_inertia", *OF_MOTOR), "motor") | dict.fromkeys(
    ("stiffness", "damping"), "transmission"
)
"""Where a number of a joint acts; one of an effect acts on the effect's own side."""
RANKED = 20
"""Largest number of structures in the report."""
FAR = "It was compared only as an addition to the most probable structure, and was far too improbable there."


def suspect_of(
    model: FlexibleJointModel,
    candidate: Candidate,
    probability: float = math.nan,
    numbers: Mapping[str, Number] | None = None,
) -> Suspect:
    """A candidate where it acts.

    Args:
        model: as given.
        candidate: of the search.
        probability: its own.
        numbers: its parameters; None: they were not estimated.
    """
    if candidate.number is not None:
        number, at = candidate.number, effect_place(candidate.number.of)
        side = SIDE_OF_NUMBER.get(number.parameter) if at is None else getattr(model.effects[at], "side", None)
        more = {"parameters": numbers or {}, "probability": probability}
        return Suspect.of_number(number.of, number.parameter, number.joint, side, **more)
    kind = candidate.kind
    place = {key: value for key, value in candidate.place.items() if key in PLACES}
    effect = candidate.stands
    if effect is None and candidate.proposal is not None:
        units = candidate.proposal.units(candidate.points[0])
        effect = units[0][0] if units else None
    joint, side = (getattr(effect, key, candidate.place.get(key)) for key in ("joint", "side"))
    return Suspect(kind, joint, side, numbers or {}, place, probability)


def numbers_of(
    model: FlexibleJointModel, effect: Effect, std: Mapping[tuple[Effect, str], float] | None
) -> dict[str, Number]:
    """An effect's parameters with their units.

    Args:
        model: that says whether its joint turns or slides.
        effect: whose.
        std: standard deviations of those that were estimated, others were chosen; None: they are not known.
    """
    units = units_of(model.robot, effect)
    spread = {name: math.nan if std is None else std.get((effect, name), 0.0) for name in units}
    return {name: Number(float(getattr(effect, name)), spread[name], unit) for name, unit in units.items()}


def considered(model: FlexibleJointModel, space: Space, masses: Masses) -> tuple[Considered, ...]:
    """Every candidate that was compared, the most probable first.

    Those that no set within Occam's window holds were compared as additions to the most probable one.

    Args:
        model: as given.
        space: that compared them.
        masses: of the sets.
    """
    found = [(c, masses.of_any([c]), masses.log_bayes_factor(c), "") for c in masses.candidates]
    best = float(masses.probability[0])
    for gain, (c, _) in Scan(space).additions(masses.structures[0]):
        if c not in masses.candidates:
            found.append((c, best * math.exp(min(gain, 0.0)), gain, FAR))
    found.sort(key=lambda each: (-each[1], -each[2]))
    return tuple(Considered(suspect_of(model, space.candidates[c], p), p, factor, note) for c, p, factor, note in found)


def structures(model: FlexibleJointModel, candidates: Sequence[Candidate], masses: Masses) -> tuple[Structure, ...]:
    """The most probable sets that were compared at the last linearisation."""
    return tuple(
        Structure(tuple(suspect_of(model, candidates[c]) for c in sorted(mine)), float(probability), float(log))
        for mine, probability, log in list(zip(masses.sets, masses.probability, masses.log, strict=True))[:RANKED]
        if math.isfinite(log)
    )
