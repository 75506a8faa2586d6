"""Notes about numbers that the data do not determine, and fits that have not converged."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.findings import lags_within_a_sample
from flexdyn.diagnose.decision.one_law import completing
from flexdyn.diagnose.decision.suspects import suspect_of
from flexdyn.diagnose.decision.verdict import simulations_tell
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.own_effects import own_effects
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.report.calibrated import estimate
from flexdyn.diagnose.report.digits import estimate_text
from flexdyn.diagnose.report.measures import Calibration, Gap, Statistics
from flexdyn.diagnose.report.words import capital, effect_name, joined, number_phrase, suspect_phrase

UNINFORMED_SHARE = 0.5
"""The data do not determine a number whose posterior is wider than this share of its prior [1]."""
FARTHEST_NUMBERS_TOLD = 3
"""Number of estimates that are reported where a fit has not converged: those that its next step would change most, in
their standard deviations."""
CORRELATION_TOLD, MOST_CORRELATIONS = 0.1, 40
"""Correlations that are reported: not below the first number [1], and at most the second one."""
UNSETTLED = "The search did not settle: its last linearisation still changed the most probable structure."
NOISE_RULES = (
    "Noise moves simulations with the corrected model farther than the given model is off: a joint has a spring that "
    "is nearly rigid. The gap says nothing; torque errors do."
)
METHOD = "Gauss-Newton, weighted by noise and model error, with the stated tolerances as priors"


def notes(compared: Posterior, found: Corrected, gap: Gap | None) -> tuple[str, ...]:
    """One sentence for each thing that the data do not determine, that the prior decided, or that has not converged.

    Args:
        compared: the posterior over structures.
        found: the corrected model.
        gap: on the data of the fit; None: they are too short for a window.
    """
    failed = own_effects(compared.space.library.equations)[1]
    return (
        *_of_channels(compared),
        *failed,
        *_late_torques(found),
        *_of_sums(found),
        *_of_unknown(found),
        *_of_priors(found),
        *([] if compared.settled else [UNSETTLED]),
        *([] if gap is None or simulations_tell(gap) else [NOISE_RULES]),
    )


def _of_unknown(found: Corrected) -> Iterator[str]:
    """Numbers that were not known, with their intervals."""
    model, std = found.hypothesis.given, found.fitted.factor_std()
    for number, factor in found.hypothesis.factors.items():
        if number.is_open:
            name = number_phrase(model, number.of, number.parameter)
            entry = Calibration(number.of, number.parameter, factor, std[number], number.tolerance)
            if std[number] > UNINFORMED_SHARE * number.tolerance:
                yield f"The {name} was not known, and these data do not determine it."
            else:
                yield f"The {name} was not known: it is estimated as {estimate_text(estimate(model, entry))} (95 %)."


def _of_priors(found: Corrected) -> Iterator[str]:
    """Names that stand first because of the prior, and not because of these data."""
    model = found.hypothesis.given
    for name in found.names:
        if name.held_down:
            first = suspect_phrase(model, suspect_of(model, found.candidates[name.candidate]))
            others = [suspect_phrase(model, suspect_of(model, found.candidates[c])) for c in name.held_down]
            yield (
                f"{capital(' or '.join(others))} would fit these data about as well as {first}. Their probabilities"
                " differ by the prior alone: what is expected of drives. The experiment of this finding separates them."
            )


def _of_sums(found: Corrected) -> Iterator[str]:
    """Names that are several other laws together: both models are the same."""
    for candidate in (found.candidates[each.candidate] for each in found.names):
        if parts := [effect_name(kind) for kind in candidate.law.sum_of]:
            yield (
                f"On {candidate.spot[0]}, {effect_name(candidate.kind)} is the same as {joined(parts)} together:"
                " no motion tells them apart."
            )
    beside = completing(found.space, found.masses, found.names, {c for c in found.genuine if found.effect(c)})
    for candidate in (found.candidates[c] for c in sorted(beside)):
        yield (
            f"The corrected model has {effect_name(candidate.kind)} on {candidate.spot[0]} as well. A rival of a"
            " finding includes it. That it acts is certain; only its cause is open."
        )


def _late_torques(found: Corrected) -> Iterator[str]:
    for each in lags_within_a_sample(found):
        yield (
            f"{each.channel} lags by {1e3 * each.lateness:.3g} ms, less than one sample. This is not a finding: the"
            " torque was sampled rather than held, or read late within its sample."
        )


def _of_channels(compared: Posterior) -> Iterator[str]:
    data, model = compared.space.library.equations.data[0], compared.fitted.hypothesis.given
    for j, joint in enumerate(model.joint_names):
        if model.elastic[j] and not data.has_q[j]:
            yield f"{joint} has no link encoder: only its spring separates friction on link and motor."
        if model.elastic[j] and not data.has_theta[j]:
            yield f"{joint} has no motor encoder: the motion of its rotor is seen through the spring alone."


def number_words(here: Hypothesis) -> list[str]:
    """Every number of a fit: ``damping of elbow``, ``level of Coulomb friction of elbow``."""
    words = [number_phrase(here.given, number.of, number.parameter) for number in here.factors]
    for effect, name in here.unknowns():
        place = getattr(effect, "joint", None) or getattr(effect, "channel", None)
        words.append(f"{name.replace('_', ' ')} of {effect_name(effect.name)}{f' of {place}' if place else ''}")
    return words


def unsettled_numbers(made: Fit) -> tuple[str, ...]:
    """Numbers that the next step of a fit would move farthest, such as ``damping of elbow``."""
    words = number_words(made.hypothesis)
    spread = [
        *made.factor_std().values(),
        *(s / scale for s, scale in zip(made.std().values(), made.scales, strict=True)),
    ]
    far = np.abs(made.step[: len(words)]) / np.maximum(spread, 1e-300)
    return tuple(words[k] for k in np.argsort(-far, kind="stable")[:FARTHEST_NUMBERS_TOLD])


def statistics(made: Fit) -> Statistics:
    """Statistics of the corrected model's fit.

    Args:
        made: the fit; its correlations are those of the last linear problem.
    """
    problem = made.free or made.regression
    points, variables = problem.rows, problem.X.shape[1]
    chi_square = problem.data_chi2
    log = points * math.log(max(chi_square, 1e-300) / points)
    names = number_words(made.hypothesis)
    covariance = problem.covariance[: len(names), : len(names)]
    spread = np.sqrt(np.diag(covariance))
    alike = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    first, second = np.triu_indices(len(names), 1)
    pairs = [
        (names[i], names[j], float(alike[i, j]))
        for i, j in zip(first.tolist(), second.tolist(), strict=True)
        if abs(alike[i, j]) >= CORRELATION_TOLD
    ]
    pairs.sort(key=lambda pair: -abs(pair[2]))
    return Statistics(
        METHOD,
        points,
        variables,
        chi_square,
        chi_square / max(1, points - variables),
        log + 2.0 * variables,
        log + math.log(points) * variables,
        tuple(pairs[:MOST_CORRELATIONS]),
    )
