"""The experiment that is proposed where data allow several names: carried out elsewhere, it keeps what it promised."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.experiment import bench as simulating
from flexdyn.diagnose.experiment.bench import RehearsalBench
from flexdyn.diagnose.experiment.design import AMPLE_DELTA_BIC, _rehearsed, with_experiment
from flexdyn.diagnose.experiment.moves import moves
from flexdyn.diagnose.experiment.reach import Reach
from flexdyn.diagnose.experiment.rehearsal import CLEAR_DELTA_BIC, Rehearsal
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.report.suspects import Experiment, Finding, Suspect
from flexdyn.errors import SimulationError
from tests.arms import repickled
from tests.diagnose.truths import Levels, slider_model, slider_recording
from tests.diagnose.workspaces import workspace

Array = NDArray[np.float64]
RATE, MASS, LEVEL, SPEED = 250.0, 2.5, 3.0, 0.2
NOISY = Levels(position=1e-5, torque=3.0)
COULOMB = fd.effects.CoulombFriction("lift", side="link", level=LEVEL)
VISCOUS = fd.effects.ViscousFriction("lift", side="link", coefficient=LEVEL / SPEED)


def stepped(x: float, v: float, force: float, dt: float, mass: float, law: fd.effects.Effect) -> tuple[float, float]:
    """Position and velocity after a held force: parabolas and rests under Coulomb's law, exponentials under a drag."""
    if isinstance(law, fd.effects.ViscousFriction):
        rate, final = law.coefficient / mass, force / law.coefficient
        fade = np.exp(-rate * dt)
        return x + final * dt + (v - final) * (1.0 - fade) / rate, final + (v - final) * fade
    assert isinstance(law, fd.effects.CoulombFriction)
    left = dt
    while left > 0.0:
        way = np.sign(v) if v else np.sign(force)
        if v == 0.0 and abs(force) <= law.level:
            break
        a = (force - way * law.level) / mass
        step = -v / a if v * a < 0.0 and -v / a < left else left
        x, v = x + v * step + 0.5 * a * step * step, 0.0 if step < left else v + a * step
        left -= step
    return x, v


def controlled(
    path: Array, ahead: Array, gains: tuple[float, float], mass: float, law: fd.effects.Effect
) -> tuple[Array, Array]:
    """Positions and forces of a mass that a joint controller moves along a path, in closed form between its ticks."""
    x, v, xs, forces = float(path[0]), 0.0, [], []
    wanted = np.gradient(path, 1.0 / RATE)
    for k in range(len(path)):
        force = float(ahead[k] + gains[0] * (path[k] - x) + gains[1] * (wanted[k] - v))
        xs.append(x)
        forces.append(force)
        x, v = stepped(x, v, force, 1.0 / RATE, mass, law)
    return np.array(xs), np.array(forces)


def at_one_speed(law: fd.effects.Effect, mass: float = MASS) -> fd.Recording:
    """There and back at one speed: friction by the sign of the velocity, or in proportion to it."""
    t = np.arange(0.0, 12.0, 1.0 / RATE)
    path = np.interp(t, np.arange(9) * 1.5, 0.3 * (np.arange(9) % 2))
    width = round(0.1 * RATE)
    for _ in range(2):
        path = np.convolve(np.pad(path, width, "edge"), np.full(width, 1.0 / width), "same")[width:-width]
    x, force = controlled(path, 0.0 * path, (400.0, 60.0), mass, law)
    return slider_recording(x, force, RATE, NOISY, seed=1)


class Question:
    """A recording, and laws that were fitted to it."""

    def __init__(self, folder: Path, recordings: list[fd.Recording]) -> None:
        self.model = slider_model(folder)
        data = tuple(measured(self.model, each) for each in recordings)
        self.space, self.start, self.noise = workspace(self.model, data)

    def explained(self, *effects: fd.effects.Effect) -> Fit:
        """The recordings explained by effects."""
        return fit(dataclasses.replace(self.start, effects=effects), self.space)

    def heavier(self, *effects: fd.effects.Effect) -> Fit:
        """The recordings explained by a wrong mass and effects."""
        number = next(each for each in self.start.factors if each.parameter == "link_mass")
        return fit(dataclasses.replace(self.start, effects=effects, freed=frozenset({number})), self.space)

    def answered(self, names: tuple[str, str], named: Fit, rival: Fit) -> Finding:
        """With the experiment for it."""
        one, other = (Suspect(name, "lift", "link") for name in names)
        found = Finding(one, 0.99, 50.0, 0.5, (other,), "something general")
        return with_experiment(found, named, [rival])

    def apart(self, one: fd.effects.Effect, other: fd.effects.Effect) -> float:
        """Chi^2 of the one law less that of the other."""
        return self.explained(one).chi2 - self.explained(other).chi2


def carried_out(plan: Experiment, law: fd.effects.Effect) -> list[tuple[Array, Array]]:
    """Positions and forces of every pass."""
    path, ahead = plan.command.reference.values[:, 0], plan.command.feedforward.values[:, 0]
    kp, kd = (np.array(gain, dtype=float) for gain in (plan.command.kp, plan.command.kd))
    gains = (float(kp[0]), float(kd[0]))
    return [controlled(path, ahead, gains, MASS + plan.payload, law)] * plan.passes


@pytest.mark.parametrize("law", [COULOMB, VISCOUS], ids=["coulomb", "viscous"])
def test_carried_out_elsewhere_it_tells_the_laws_apart_as_promised(law: fd.effects.Effect, tmp_path: Path) -> None:
    """After one speed alone, other speeds tell dry from viscous friction; the promise is of the less telling case."""
    first = at_one_speed(law)
    question = Question(tmp_path, [first])
    other = VISCOUS if law is COULOMB else COULOMB
    answer = question.answered((law.name, other.name), question.explained(law), question.explained(other))
    plan = answer.plan
    assert plan is not None
    assert plan.delta_bic >= CLEAR_DELTA_BIC
    assert answer.experiment.startswith(plan.motion)
    assert f"(expected delta BIC {plan.delta_bic:.0f})" in answer.experiment
    runs = carried_out(plan, law)
    more = [slider_recording(x, force, RATE, NOISY, seed=2 + k) for k, (x, force) in enumerate(runs)]
    gained = Question(tmp_path, [first, *more]).apart(other, law) - question.apart(other, law)
    assert 0.5 * plan.delta_bic < gained < 2.0 * plan.delta_bic
    for x, force in runs:
        assert first["q.lift"].min() <= x.min()
        assert x.max() <= first["q.lift"].max()
        assert np.abs(force).max() <= np.abs(first["tau.lift"]).max()


def test_one_law_under_two_names_is_said_to_be_one(tmp_path: Path) -> None:
    """A mass that slides without weight: whether its link is heavier or carries something, no motion can tell."""
    question = Question(tmp_path, [at_one_speed(COULOMB, mass=1.4 * MASS)])
    payload = question.explained(fd.effects.Payload(mass=0.4 * MASS, frame="mass"), COULOMB)
    answer = question.answered(("payload", "parameter_error"), payload, question.heavier(COULOMB))
    assert answer.plan is None
    assert answer.experiment.startswith("no motion within the range of the recordings separates payload from")
    assert "the same law here" in answer.experiment


def test_a_motion_that_cannot_be_simulated_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where none can, the general advice stays; a diagnosis never fails for it."""

    def stopped(*_: object, **__: object) -> None:
        raise SimulationError("stopped", reason="stopped", t=0.0)

    monkeypatch.setattr(simulating, "simulate", stopped)
    question = Question(tmp_path, [at_one_speed(COULOMB)])
    answer = question.answered(("a", "b"), question.explained(COULOMB), question.explained(VISCOUS))
    assert (answer.experiment, answer.plan) == ("something general", None)


def test_motions_stay_within_what_was_seen(tmp_path: Path) -> None:
    """Range, speed and, but for a little where a sine begins, acceleration of every motion that is proposed."""
    equations = Question(tmp_path, [at_one_speed(COULOMB)]).space.equations
    reach = Reach.of(equations, equations.true)
    made = moves(reach, 0, equations.true, reach.poses[0])
    assert len({each.words for each in made}) == len(made) == 10
    for each in made:
        v = np.gradient(each.path[:, 0], reach.dt)
        assert reach.ends[0] <= each.path.min(), each.words
        assert each.path.max() <= reach.ends[1], each.words
        assert np.abs(v).max() <= reach.fastest[0], each.words
        assert np.abs(np.gradient(v, reach.dt)).max() <= 1.5 * reach.acceleration[0], each.words
        assert v[0] == v[-1] == 0.0, each.words
        assert 5.0 < len(each.path) * reach.dt < 15.0, each.words


def plan() -> Experiment:
    """One by hand."""
    t = np.linspace(0.0, 8.0, 200)
    reference = fd.Samples(t, np.sin(t)[:, None], "cubic")
    left = np.where(np.abs(np.cos(t)) < 0.1, np.nan, np.sign(np.cos(t)))
    names = ("Coulomb friction", "viscous friction <b>")
    labels = ("elbow [rad]", "motor equation of elbow, in units of noise")
    told = ("swing elbow", 16.0, 2, 0.0, 400.0, fd.PD(reference, 1.0, 1.0), names)
    return Experiment(*told, t, np.sin(t), left, labels)


def test_an_experiment_is_locked_and_survives_a_trip_to_another_process() -> None:
    """Its columns cannot be written to; it says how many times the noise the names are apart."""
    for each in (plan(), repickled(plan())):
        assert each.apart == 20.0
        with pytest.raises(ValueError, match="read-only"):
            each.left[0] = 1.0


def test_motions_after_one_that_is_ample_are_left_out(tmp_path: Path) -> None:
    """They run side by side, and the same ones are kept as one after the other; one that stops is passed over."""
    question = Question(tmp_path, [at_one_speed(COULOMB)])
    bench = RehearsalBench.of([question.explained(law) for law in (COULOMB, VISCOUS)])
    reach = bench.reach
    made = moves(reach, 0, question.space.equations.true, reach.poses[0])
    slow = [move for move in made if Rehearsal.of(bench, move).apart() < AMPLE_DELTA_BIC]
    telling = [move for move in made if Rehearsal.of(bench, move).apart() > 2.0 * AMPLE_DELTA_BIC]
    assert len(slow) > 1
    assert len(telling) > 1
    thrown = dataclasses.replace(slow[0], push=np.full_like(slow[0].push, 1e300))
    with pytest.raises(SimulationError, match="not finite"):
        Rehearsal.of(bench, thrown)
    kept = _rehearsed(bench, [thrown, slow[0], telling[0], slow[1], telling[1]])
    assert [each.move.words for each in kept] == [slow[0].words, telling[0].words]
