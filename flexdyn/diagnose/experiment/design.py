"""An experiment that would separate effects that the data cannot: designed for this arm and tested by simulation."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from flexdyn.arrays import Array
from flexdyn.diagnose.experiment.bench import RehearsalBench
from flexdyn.diagnose.experiment.joint_paths import two_digits
from flexdyn.diagnose.experiment.moves import VARIED_MOTIONS, PlannedMotion, moves
from flexdyn.diagnose.experiment.plan import planned
from flexdyn.diagnose.experiment.reach import load_mass
from flexdyn.diagnose.experiment.rehearsal import CLEAR_DELTA_BIC, LONGEST_MOTION, Rehearsal
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.parallel import in_parallel
from flexdyn.diagnose.report.suspects import Experiment, Finding
from flexdyn.diagnose.report.words import effect_name, is_number, suspect_phrase
from flexdyn.errors import FlexdynError
from flexdyn.model.flexible_joint_model import FlexibleJointModel

AMPLE_DELTA_BIC = 4.0 * CLEAR_DELTA_BIC
"""With at least this expected delta BIC, the remaining motions are not tried [1]."""
SAME_LAW_DELTA_BIC = 4.0
"""If the expected delta BIC in the longest time is below this, the laws count as the same [1]."""
MOTIONS_TRIED = 12
"""Largest number of motions that are tried: each is simulated, and the rivals are fitted to it."""
JOINTS_TRIED = 3
"""Number of joints that are tried if no candidate determines the joint."""
HELD_JOINTS_NAMED = 2
"""Largest number of other joints whose positions are given in the text."""
POSES = ("in the middle of their ranges", "where gravity asks most of them", "where gravity asks least of them")
LITTLE_MORE = 1.5
"""A motion with a larger difference may take this multiple of the shortest duration [1]."""
FAILURES = (FlexdynError, ArithmeticError, ValueError)
"""Errors of a motion that cannot be simulated or evaluated."""


def with_experiment(found: Finding, named: Fit, rivals: Sequence[Fit]) -> Finding:
    """Add to a finding with rivals the experiment that would separate them, if there is one.

    Every motion is simulated with the named hypothesis. Then the rivals are fitted to this simulated recording, with
    the previous information about their numbers.

    Args:
        found: with rivals.
        named: fit with the finding.
        rivals: fits with each rival instead of the finding.
    """
    model = named.space.equations.true
    try:
        rehearsed = _tried(RehearsalBench.of([named, *rivals]), _joints(model, found))
    except FAILURES:
        return found
    if not rehearsed:
        return found
    names = _names_of_finding(model, found)
    chosen = _chosen(rehearsed)
    if chosen is None:
        return replace(found, experiment=_no_motion_helps(names, rehearsed))
    plan = planned(*chosen, names)
    return replace(found, experiment=_sentence(plan, names), plan=plan)


def _tried(bench: RehearsalBench, joints: Sequence[int]) -> list[Rehearsal]:
    """Try possible motions in groups until one separates the rivals: by the equations, else by windows."""
    moves_left = itertools.islice(_moves(bench, joints), MOTIONS_TRIED)
    found: list[Rehearsal] = []
    while some := list(itertools.islice(moves_left, VARIED_MOTIONS)):
        new = _rehearsed(bench, some)
        if new and not any(made.passes for made in new):
            turning = max(range(len(new)), key=lambda k: new[k].reversals)
            with contextlib.suppress(*FAILURES):
                new[turning] = new[turning].with_windows().from_all_sides()
        found += new
        if any(made.passes for made in new):
            break
    return found


def _rehearsed(bench: RehearsalBench, some: Sequence[PlannedMotion]) -> list[Rehearsal]:
    """Try possible motions in parallel, up to the first with a sufficient difference."""
    ample: list[int] = []

    def rehearse(k: int) -> Rehearsal | None:
        """A motion, unless one before it has already separated enough or it fails."""
        if any(first < k for first in ample):
            return None
        with contextlib.suppress(*FAILURES):
            made = Rehearsal.of(bench, some[k]).from_all_sides()
            if made.apart() >= AMPLE_DELTA_BIC:
                ample.append(k)
            return made
        return None

    made = in_parallel(rehearse, range(len(some)))
    wanted = min(ample) + 1 if ample else len(some)
    return [each for each in made[:wanted] if each is not None]


def _moves(bench: RehearsalBench, joints: Sequence[int]) -> Iterator[PlannedMotion]:
    """Motions at the middle pose; then the best ones with a payload, and at poses with largest and smallest gravity."""
    reach, true = bench.reach, bench.space.equations.true

    def at(k: int) -> list[list[PlannedMotion]]:
        """The motions of each joint at a pose."""
        words = [_other_joints(true, reach.poses[k], j, POSES[k]) for j in joints]
        return [moves(reach, j, true, reach.poses[k], where) for j, where in zip(joints, words, strict=True)]

    middle = at(0)
    yield from _by_turns(middle)
    mass = load_mass(bench.space.equations, reach)
    if mass > 0.0:
        yield from (move.loaded(mass) for move in _by_turns([each[:VARIED_MOTIONS] for each in middle]))
    for k in (1, 2) if true.n > 1 else ():
        yield from _by_turns([each[:VARIED_MOTIONS] for each in at(k)])


def _by_turns(joints: list[list[PlannedMotion]]) -> Iterator[PlannedMotion]:
    return (move for turn in itertools.zip_longest(*joints) for move in turn if move is not None)


def _other_joints(model: FlexibleJointModel, pose: Array, j: int, words: str) -> str:
    """The positions of the other joints, in words."""
    others = [k for k in range(model.n) if k != j]
    if len(others) > HELD_JOINTS_NAMED:
        return f", the other joints held {words}"
    names = (f"{model.joint_names[k]} held at {two_digits(pose[k])} {model.robot.angle_unit(k)}" for k in others)
    return "".join(f", {name}" for name in names)


def _joints(model: FlexibleJointModel, finding: Finding) -> list[int]:
    """The joints of a finding and its rivals; some of all joints if they have none."""
    found = []
    for each in finding.names:
        joint = each.joint or each.place.get("channel", "").partition(".")[2]
        found += [model.index(joint)] if joint in model.joint_names else list(range(model.n))
    return list(dict.fromkeys(found))[:JOINTS_TRIED]


def _chosen(rehearsed: Sequence[Rehearsal]) -> tuple[Rehearsal, int] | None:
    """Of the motions that need hardly more time than the shortest one, the one with the largest difference."""
    telling = [(made, passes) for made in rehearsed if (passes := made.passes) is not None]
    if not telling:
        return None
    least = min(made.seconds * passes for made, passes in telling)
    near = [each for each in telling if each[0].seconds * each[1] <= LITTLE_MORE * least]
    return max(near, key=lambda each: each[0].apart(each[1]))


def _names_of_finding(model: FlexibleJointModel, finding: Finding) -> list[str]:
    """Names of the finding and its rivals, with their places if the same effect occurs twice."""
    suspects = finding.names
    plain = [suspect_phrase(model, each) if is_number(each) else effect_name(each.effect) for each in suspects]
    return plain if len(set(plain)) == len(plain) else [suspect_phrase(model, each) for each in suspects]


def _sentence(plan: Experiment, names: Sequence[str]) -> str:
    """What to do, for how long, and the result of the simulation."""
    often = f", {plan.passes} times" if plan.passes > 1 else ""
    told = f"{names[0]} and {' or '.join(names[1:])} then differ by {plan.apart:.0f} times the noise"
    sure = f"(expected delta BIC {plan.delta_bic:.0f})"
    return f"{plan.motion}{often}, {plan.seconds:.0f} s in all: in simulation, {told} {sure}"


def _no_motion_helps(names: Sequence[str], rehearsed: Sequence[Rehearsal]) -> str:
    """A sentence that no motion helps, with the largest difference that was found."""
    left, best = max(((made.apart(made.most), made) for made in rehearsed), key=lambda each: each[0])
    told = f"no motion within the range of the recordings separates {names[0]} from {' or '.join(names[1:])}"
    tried = f"{len(rehearsed)} motions simulated, for up to {LONGEST_MOTION:.0f} s each"
    apart = f"{math.sqrt(left):.1f} times the noise apart"
    if left < SAME_LAW_DELTA_BIC:
        return f"{told}: they are the same law here ({tried}; at best they are {apart})"
    return f"{told} clearly ({tried}; with the best one, {best.move.words}, they are {apart})"
