"""Chapter of `flexdyn paper --diagnose`: the model lacks the arm's dry friction, and the diagnosis finds it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.diagnose import Diagnosis, Number, Suspect, diagnose
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.report.digits import estimate_text, times
from flexdyn.diagnose.report.sentences import verdict_sentence
from flexdyn.diagnose.report.words import effect_name, place_phrase
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import Effect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.paper.bench import LINK_STEP, MOTOR_STEP, TORQUE_NOISE, Bench
from flexdyn.paper.cases import PaperCases
from flexdyn.paper.chapter import Chapter, Check, figure, prose, stated
from flexdyn.paper.hidden_friction_figure import Step, draw_hidden_friction
from flexdyn.records import Recording

CHAPTER_TITLE = "Friction hidden, and found"
FOLDER = "diagnosis"
HIDDEN = ("coulomb_friction", "stribeck_friction")
"""The dry part of eq. 1, at both joints: the paper gives v = 0.01 and no levels."""
MISTAKES = {
    "shoulder": {"stiffness": 1.015, "rotor_inertia": 0.98},
    "elbow": {"stiffness": 0.985, "rotor_inertia": 1.02},
}
"""Factors of the model file's numbers: Table I is printed with two digits."""
CHECKED = ("check_fig4", "check")
Progress = Callable[[str, float], None]


def hidden_friction(cases: PaperCases, folder: Path, progress: Progress | None = None) -> Chapter:
    """Record the true arm, diagnose a model without its dry friction, and compare what was hidden with what is found.

    Args:
        cases: with the arm.
        folder: for the report of the diagnosis; it must exist.
        progress: as for `diagnose`.
    """
    bench = Bench(cases)
    data = bench.recordings
    given = without_dry_friction(cases.model)
    answer = diagnose(given, [data["fit"]], [data[name] for name in CHECKED], progress=progress)
    answer.save(folder)
    steps = gap_steps(given, answer, [data[name] for name in CHECKED])
    truth = hidden(cases.model)
    picture = figure(
        "hidden_friction", lambda canvas: draw_hidden_friction(canvas, data["check_fig4"], given, answer.model, steps)
    )
    return Chapter(
        CHAPTER_TITLE,
        _hidden_friction_text(truth, answer, steps),
        checks(truth, answer),
        _numbers(truth, answer, steps),
        (picture,),
        {f"diagnosis_{name}": run for name, run in bench.runs.items()},
        tuple(sorted(path for path in folder.iterdir() if path.is_file())),
    )


def without_dry_friction(model: FlexibleJointModel) -> FlexibleJointModel:
    """The model that a reader of the paper would make: no dry friction, K and J with two digits."""
    joints = {
        name: {key: getattr(joint, key) * MISTAKES[name][key] for key in MISTAKES[name]}
        for name, joint in model.joints.items()
    }
    return model.replace(joints=joints, effects=[effect for effect in model.effects if effect.name not in HIDDEN])


def hidden(model: FlexibleJointModel) -> tuple[Effect, ...]:
    """The effects that this model lacks."""
    return tuple(effect for effect in model.effects if effect.name in HIDDEN)


def gap_steps(given: FlexibleJointModel, answer: Diagnosis, check: Sequence[Recording]) -> tuple[Step, ...]:
    """The gap of the given and the calibrated model, then with one more finding at a time, the most effective first.

    All steps use the numbers of the final answer. The diagnosis itself gives the first two gaps, the last one and that
    of noise alone.
    """
    if answer.gap_test is None:
        return ()
    windows = Windows.of(given, list(check), sensors_noise(check))
    steps = [Step("as given", answer.gap_test.before), Step("calibrated", answer.gap_test.calibrated)]
    missing = [finding.suspect for finding in answer.findings]
    while missing:
        sizes = [answer.gap_test.after]
        if len(missing) > 1:
            sizes = [
                shoot(_without(answer.model, [s for s in missing if s is not each]), windows).gap for each in missing
            ]
        best = missing.pop(int(np.argmin(sizes)))
        steps.append(Step(f"+ {effect_name(best.effect)}, {best.joint}", min(sizes)))
    return (*steps, Step("noise alone", answer.gap_test.floor))


def _without(model: FlexibleJointModel, missing: Sequence[Suspect]) -> FlexibleJointModel:
    places = {_place(suspect) for suspect in missing}
    return model.replace(effects=[effect for effect in model.effects if _place(effect) not in places])


def sensors_noise(recordings: Sequence[Recording]) -> SampleNoise:
    """Noise of the sensors on the bench: quantisation of the encoders, step / sqrt(12), and noise of the torque.

    Args:
        recordings: of both joints; the noise of the torque is a share of its largest value, averaged over them.
    """
    joints = ("shoulder", "elbow")
    peak = [np.mean([np.abs(each[f"tau.{joint}"]).max() for each in recordings]) for joint in joints]
    link, motor = (np.full(2, step / np.sqrt(12.0)) for step in (LINK_STEP, MOTOR_STEP))
    return SampleNoise(link, motor, TORQUE_NOISE * np.array(peak), np.zeros(2))


def _place(entry: Effect | Suspect) -> tuple[Any, ...]:
    name = entry.effect if isinstance(entry, Suspect) else entry.name
    return (name, getattr(entry, "joint", None), getattr(entry, "side", None))


def checks(truth: Sequence[Effect], answer: Diagnosis) -> tuple[Check, ...]:
    """Whether a diagnosis names every hidden effect and no other, with the true numbers, and explains the data."""
    named = {_place(finding.suspect) for finding in answer.findings if not finding.rivals}
    wrong = named ^ {_place(effect) for effect in truth}
    unsure = sum(bool(finding.rivals) for finding in answer.findings)
    errors = [abs(found.value / true - 1.0) for _, _, true, found in _compared(truth, answer) if found is not None]
    gap = answer.gap_test
    return (
        stated("hidden_effects", len(wrong) + unsure, hidden=len(truth)),
        stated("hidden_numbers", max(errors, default=np.nan)),
        stated("hidden_gap", np.nan if gap is None else gap.after / gap.floor),
    )


def _compared(truth: Sequence[Effect], answer: Diagnosis) -> list[tuple[Effect, str, float, Number | None]]:
    """Every hidden number: its effect, its name, its true value, the value found."""
    found = {_place(finding.suspect): finding.suspect.parameters for finding in answer.findings}
    return [
        (effect, entry.name, float(getattr(effect, entry.name)), found.get(_place(effect), {}).get(entry.name))
        for effect in truth
        for entry in effect.parameters()
    ]


def _numbers(truth: Sequence[Effect], answer: Diagnosis, steps: Sequence[Step]) -> Mapping[str, Any]:
    """The hidden effects with what was found of each, and the gap after each step."""
    rows = []
    for effect, name, true, found in _compared(truth, answer):
        row = {"effect": effect.name, "joint": getattr(effect, "joint", None), "side": getattr(effect, "side", None)}
        numbers = {"found": None, "std": None} if found is None else {"found": found.value, "std": found.std}
        unit = str(next(each.metadata["unit"] for each in effect.parameters() if each.name == name))
        rows.append({**row, "parameter": name, "unit": unit, "true": true, **numbers})
    return {
        "verdict": answer.verdict,
        "hidden": rows,
        "named": [list(_place(finding.suspect)) for finding in answer.findings],
        "gap": [vars(step) for step in steps],
    }


def _hidden_friction_text(truth: Sequence[Effect], answer: Diagnosis, steps: Sequence[Step]) -> str:
    """The prose of the chapter."""
    return prose(
        "hidden_friction.md",
        torque_noise=TORQUE_NOISE,
        verdict=verdict_sentence(answer),
        folder=FOLDER,
        rows=_compared(truth, answer),
        steps=steps,
        effect_name=effect_name,
        place_phrase=place_phrase,
        estimate_text=estimate_text,
        times=times,
    )
