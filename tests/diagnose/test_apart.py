"""What a motion that was not made yet would show of a hypothesis."""

from __future__ import annotations

import dataclasses

import numpy as np

import flexdyn as fd
from flexdyn.diagnose.data.measured import Measured, measured
from flexdyn.diagnose.experiment.apart import Known, refitted, space_along
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.effects import SensorOffset
from tests.diagnose.test_estimate import problem


def test_encoders_keep_the_offsets_that_a_hypothesis_needs() -> None:
    """A law that stands only with an encoder a few counts off has it off in the next motion too, and says so."""
    space, start = problem()
    made = fit(start, space)
    off = tuple(
        SensorOffset(each.channel, offset=each.offset + (3e-5 if each.channel == "theta.elbow" else 0.0))
        for each in made.hypothesis.counts
    )
    hypothesis = dataclasses.replace(made.hypothesis, counts=off)
    known = dataclasses.replace(Known.of(made), fitted=dataclasses.replace(made, hypothesis=hypothesis))
    usual = Known.of(made)

    def along(each: Known) -> Workspace:
        return space_along(space, hypothesis.factors, pushed(each.fitted.hypothesis))

    own, other, plain = (
        refitted(each, motion).chi2()
        for each, motion in ((known, along(known)), (usual, along(known)), (usual, along(usual)))
    )
    assert abs(own - plain) < 1.0
    assert other > plain + 20.0


def pushed(hypothesis: Hypothesis) -> Measured:
    """What the encoders of a hypothesis would report of its arm, pushed for two seconds."""
    t = np.arange(2000) * 1e-3
    tau = np.stack([2.0 * np.sin(4.0 * t), np.sin(7.0 * t)], axis=1)
    run = fd.simulate(hypothesis.seen(), fd.Samples(t, tau), q0=[-1.4, 0.3], theta0="equilibrium", rate=1000.0)
    whole = run.to_recording()
    kept = {name: x for name, x in whole.channels.items() if name.partition(".")[0] in ("q", "theta", "tau")}
    return measured(hypothesis.given, fd.Recording(run.t, kept))
