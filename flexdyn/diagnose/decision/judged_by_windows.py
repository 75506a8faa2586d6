"""What simulated windows of the data of the fit say of a corrected model, where they contradict it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

from flexdyn.diagnose.decision.corrected import Corrected, Judges, corrected
from flexdyn.diagnose.decision.figures import OnFit, on_fit
from flexdyn.diagnose.decision.findings import reported_names
from flexdyn.diagnose.decision.last_fit import leaves_noise, to_equations
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.one_law import with_best
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.progress import tell
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.reweighting import Reweighed, reweighed, share_in_windows
from flexdyn.diagnose.simulated.rivals_in_windows import preferred_by_windows
from flexdyn.diagnose.simulated.structures import Simulated
from flexdyn.diagnose.simulated.window_fit import to_windows, unlike_noise
from flexdyn.effects import DeflectionEffect

Said = tuple[Posterior, Corrected, list[Name], OnFit]
"""The posterior, the corrected model, its names and its figures."""
RIVAL_ROUNDS = 3
"""Times at most that the laws that share a name are compared: others may share it when windows reject some."""
SHORTER = 4
"""Windows are shorter by this factor where links are not measured [1]: an impact in a gap hides where its link is."""


def judged_by_windows(
    plain: Workspace, made: Fit, compared: Posterior, found: Corrected, fitted: Sequence[DataPart]
) -> Said:
    """What is said of the data of the fit, after their windows have been simulated.

    Args:
        plain: equations of the model as given, with the sensors' weights.
        made: the fit of the file's numbers alone.
        compared: the posterior over structures.
        found: the corrected model.
        fitted: the data of the fit.
    """
    found, named, first = _on_fit(plain, made, found, fitted)
    for _ in range(RIVAL_ROUNDS):
        other = _with_preferred_rivals(plain, compared, found, _compared_windows(first, plain))
        if other is None:
            break
        compared, found = other
        found, named, first = _on_fit(plain, made, found, fitted)
    windows = _contradicting(first, plain)
    noise = leaves_noise(compared.fitted, plain)
    if windows is not None and (noise or first.farther):
        tell("comparing simulated windows", 0.75)
        if found.explained and {c for c, _ in compared.best} <= found.named:  # a pass may end far from its last fit
            compared = dataclasses.replace(compared, fitted=found.fitted)
        by_windows = _by_windows(plain, compared, found, windows) if noise else None
        judges: Judges = "both" if by_windows is None else "either" if by_windows.explained else "windows"
        compared = compared if by_windows is None else by_windows.found
        refit = to_equations if by_windows is None else functools.partial(to_windows, windows)
        share = functools.partial(share_in_windows, Simulated(compared, windows))
        again = corrected(compared, plain, share, judges=judges, refit=refit)
        found, named, first = _on_fit(plain, made, again, fitted, rejected=judges == "both")
    return compared, found, named, first


def _by_windows(plain: Workspace, compared: Posterior, found: Corrected, windows: Windows) -> Reweighed | None:
    """The posterior that simulated windows give too; None if the equations reject what they find most probable.

    Windows and equations are likelihoods of the same data. A structure that either of them rejects is wrong. Only where
    a link that nobody measures has play in its gear, its computed position is none: windows at noise are then enough.
    """
    all_named = {c for c, _ in compared.best} <= found.named
    other = reweighed(compared, windows, lambda made: leaves_noise(made, plain), all_named=all_named)
    if other is None or leaves_noise(other.found.fitted, plain):
        return other
    return other if other.explained and _has_hidden_play(other.found.fitted, plain) else None


def _has_hidden_play(made: Fit, plain: Workspace) -> bool:
    """Whether a model has a gap in the gear of a link that nobody measures."""
    true, hidden = plain.equations.true, plain.equations.unmeasured
    gaps = (each for each in made.hypothesis.effects if isinstance(each, DeflectionEffect) and each.gap)
    return any(hidden[true.index(each.joint)] for each in gaps)


def _on_fit(
    plain: Workspace, made: Fit, found: Corrected, fitted: Sequence[DataPart], *, rejected: bool = False
) -> tuple[Corrected, list[Name], OnFit]:
    """The corrected model, its names and its figures; without names the numbers of the file alone are corrected."""
    named, first = reported_names(found), on_fit(plain, made, found, fitted)
    if not found.converged and (first.worse or first.farther):
        named, first = [], dataclasses.replace(first, stalled=found.fitted)
    if rejected and first.farther:
        named = []
    # A gap without an established effect displaces numbers for no good reason.
    if not named and not (found.explained and found.hypothesis.tolerated().factors == found.hypothesis.factors):
        found, first = first.calibration_alone(found)
    return found, named, first


def _contradicting(first: OnFit, plain: Workspace) -> Windows | None:
    """Windows of the fit for comparisons, if they leave more than noise; None: they do not, or there are none."""
    if first.shots is None or not unlike_noise(first.shots.after, first.shots.gap.floor):
        return None
    windows = first.shots.after.windows.preceded()
    return windows.divided(SHORTER) if plain.equations.unmeasured.any() else windows


def _compared_windows(first: OnFit, plain: Workspace) -> Windows | None:
    """Windows of the fit for comparisons; None: there are none."""
    windows = _contradicting(first, plain)
    return first.shots.after.windows.preceded() if windows is None and first.shots is not None else windows


def _with_preferred_rivals(
    plain: Workspace, compared: Posterior, found: Corrected, windows: Windows | None
) -> tuple[Posterior, Corrected] | None:
    """The posterior and the corrected model with rivals that windows prefer, and without those that they reject.

    None where windows tell nothing, or if a name would be lost with that: a law with more numbers suits windows a
    little better in any case.
    """
    rivals = {each.candidate: each.rivals for each in found.names}
    if windows is None or not any(rivals.values()):
        return None
    preferred = preferred_by_windows(compared, rivals, windows)
    rejected = {**compared.rejected, **preferred.rejected}
    other = with_best(compared, preferred.best)
    if other is compared and rejected == compared.rejected:
        return None
    other = dataclasses.replace(other, rejected=rejected)
    again, there = corrected(other, plain), {c for c, _ in other.best}
    new, still = there - {c for c, _ in compared.best}, found.named & there
    return (other, again) if new | still <= again.named else None
