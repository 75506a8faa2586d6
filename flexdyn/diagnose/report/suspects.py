"""Effects that a diagnosis names or compares, with their numbers and probabilities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from flexdyn.arrays import Array
from flexdyn.control.commands import PD
from flexdyn.diagnose.constants import ESTABLISHED
from flexdyn.effects import ParameterError
from flexdyn.io.locked import Locked

CONFIDENCE = 1.96
"""Standard deviations on either side that hold 95 % of a normal distribution [1]."""
Key = tuple[str, str | None, str | None, tuple[tuple[str, str], ...]]


@dataclass(frozen=True, eq=False)
class Experiment(Locked):
    """A motion that separates a finding from its rivals in simulation.

    Attributes:
        motion: what to do, in words.
        seconds: its duration with repetitions [s].
        passes: number of repetitions.
        payload: known mass to be added at the tip [kg].
        delta_bic: expected delta BIC of the right name to the nearest other one, for any of them being right.
        command: of the simulation: joint control along one pass of the motion.
        names: of the finding and of its nearest rival.
        t: times (points,) [s].
        position: of the moving joint (points,) [rad or m].
        left: residual of the rival with fitted numbers, if the finding is right, in units of noise (points,).
        labels: of position and residual, with their units.
    """

    motion: str
    seconds: float
    passes: int
    payload: float
    delta_bic: float
    command: PD
    names: tuple[str, str]
    t: Array
    position: Array
    left: Array
    labels: tuple[str, str]

    @property
    def apart(self) -> float:
        """Difference between the names in units of the noise: the root of the expected delta BIC."""
        return math.sqrt(self.delta_bic)


@dataclass(frozen=True)
class Number:
    """An estimated number.

    Attributes:
        value: in `unit`.
        std: its standard deviation in `unit`; NaN: unknown; 0: it was chosen among a few values, not measured.
        unit: as the effect's parameter has it on this kind of joint.
    """

    value: float
    std: float
    unit: str

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval in `unit`."""
        return self.value - CONFIDENCE * self.std, self.value + CONFIDENCE * self.std


@dataclass(frozen=True)
class Suspect:
    """An effect where it acts.

    Attributes:
        effect: its name in the catalogue.
        joint: None where it has none (payload, a link's number).
        side: link, motor, transmission or sensor; None where it has none.
        parameters: its numbers by name; empty where they were not estimated.
        place: what else says where it acts: ``channel`` of a sensor effect, ``of`` and ``parameter`` of a parameter
            error, ``other`` of a coupling, ``frame`` of a payload.
        probability: posterior probability of this effect by itself [1]; NaN where it was not computed.
    """

    effect: str
    joint: str | None
    side: str | None
    parameters: Mapping[str, Number] = field(default_factory=dict)
    place: Mapping[str, str] = field(default_factory=dict)
    probability: float = math.nan

    @classmethod
    def of_number(cls, of: str, parameter: str, joint: str | None, side: str | None = None, **more: Any) -> Suspect:
        """A number of the model that may be wrong.

        Args:
            of: joint, link or ``effects[i]`` that it belongs to.
            parameter: its name.
            joint: that it belongs to, if any.
            side: likewise.
            more: `parameters` and `probability`.
        """
        return cls(ParameterError.name, joint, side, place={"of": of, "parameter": parameter}, **more)

    @property
    def key(self) -> Key:
        """The effect and its place, without its numbers: equal for the same effect at the same place."""
        return self.effect, self.joint, self.side, tuple(sorted(self.place.items()))


@dataclass(frozen=True)
class Finding:
    """A named effect and the evidence for it.

    Attributes:
        suspect: the effect with its numbers; its own `probability` is its share where there are rivals.
        probability: posterior probability that this effect, or one of its rivals, is there [1].
        log_bayes_factor: natural logarithm of the evidence of the best structure with it over the best without it.
        test_gain: share of the improvement on the test data that is lost where it alone is left out, at most 1;
            negative: the improvement is larger without it.
        rivals: effects from which the data cannot separate it: then the answer is "this or one of those".
        experiment: the motion that would separate them; empty if there is no rival.
        plan: that motion, where one was found; None else.
    """

    suspect: Suspect
    probability: float
    log_bayes_factor: float
    test_gain: float
    rivals: tuple[Suspect, ...] = ()
    experiment: str = ""
    plan: Experiment | None = None

    @property
    def names(self) -> tuple[Suspect, ...]:
        """The suspect and its rivals: every name that this finding may have."""
        return (self.suspect, *self.rivals)

    @property
    def established(self) -> bool:
        """Whether its probability, together with that of its rivals, is 0.95 or more."""
        return self.probability >= ESTABLISHED


@dataclass(frozen=True)
class Considered:
    """A candidate that the search compared, named or not.

    Attributes:
        suspect: the effect and where it acts.
        probability: marginal posterior probability: the sum over all structures that hold it [1].
        log_bayes_factor: natural logarithm of the evidence of the best structure with it over the best without it.
        note: a further reason, as a sentence; empty if there is none.
    """

    suspect: Suspect
    probability: float
    log_bayes_factor: float
    note: str = ""


@dataclass(frozen=True)
class Structure:
    """A set of effects that was compared with other sets.

    Attributes:
        effects: it adds to the model; none for the calibrated model alone.
        probability: posterior, among all structures that were compared [1].
        log_evidence: natural logarithm of its marginal likelihood, up to a constant that all structures share.
    """

    effects: tuple[Suspect, ...]
    probability: float
    log_evidence: float
