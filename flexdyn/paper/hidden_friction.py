"""Chapter of `flexdyn paper --diagnose`: the arm's dry friction hidden from its model, and found by the diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.diagnose import Diagnosis, Number, Suspect, diagnose
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.report.digits import estimate_text, times
from flexdyn.diagnose.report.verdicts import verdict_sentence
from flexdyn.diagnose.report.words import effect_name, place_phrase
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import Effect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.paper.bench import LINK_STEP, MOTOR_STEP, TORQUE_NOISE, Bench
from flexdyn.paper.cases import PaperCases
from flexdyn.paper.chapter import Chapter, Check, Figure, check
from flexdyn.paper.hidden_friction_figure import Step, draw
from flexdyn.records import Recording

TITLE = "Friction hidden, and found"
FOLDER = "diagnosis"
HIDDEN = ("coulomb_friction", "stribeck_friction")
"""The dry part of eq. 1, at both joints: the paper prints v = 0.01 and leaves its levels out."""
MISTAKES = {
    "shoulder": {"stiffness": 1.015, "rotor_inertia": 0.98},
    "elbow": {"stiffness": 0.985, "rotor_inertia": 1.02},
}
"""Factors of the model file's numbers: Table I is printed with two digits."""
CHECKED = ("check_fig4", "check")
Progress = Callable[[str, float], None]


def hidden_friction(cases: PaperCases, folder: Path, progress: Progress | None = None) -> Chapter:
    """Record the true arm, diagnose a model without its friction, compare what is found with what was hidden.

    Args:
        cases: with the arm.
        folder: for the report of the diagnosis; it must exist.
        progress: as for `diagnose`.
    """
    bench = Bench(cases)
    data = bench.recordings
    given = forgetful(cases.model)
    answer = diagnose(given, [data["fit"]], [data[name] for name in CHECKED], progress=progress)
    answer.save(folder)
    steps = gap_steps(given, answer, [data[name] for name in CHECKED])
    truth = hidden(cases.model)
    figure = Figure(
        "hidden_friction",
        "The torque of Fig. 4 on the arm (12 s that took no part in the fit): measured, and simulated from the first "
        "state on by the model without dry friction and by what the diagnosis made of it (a, b); the gap on all data "
        "of the check as one effect after the other is added (c).",
        lambda canvas: draw(canvas, data["check_fig4"], given, answer.model, steps),
        (7.16, 3.6),
    )
    return Chapter(
        TITLE,
        _text(truth, answer, steps),
        checks(truth, answer),
        _numbers(truth, answer, steps),
        (figure,),
        {f"diagnosis_{name}": run for name, run in bench.runs.items()},
        tuple(sorted(path for path in folder.iterdir() if path.is_file())),
    )


def forgetful(model: FlexibleJointModel) -> FlexibleJointModel:
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
    """The gap as the model is given, calibrated, then with one finding more at a time, the one that brings most first.

    On the way the numbers are those of the final answer. The first two, the last and that of noise alone are the
    diagnosis' own.
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
    """What the sensors of the bench make: encoder steps evenly spread, step / sqrt(12), and the torque's noise.

    Args:
        recordings: of both joints; the torque's noise is a share of its peak, their mean.
    """
    joints = ("shoulder", "elbow")
    peak = [np.mean([np.abs(each[f"tau.{joint}"]).max() for each in recordings]) for joint in joints]
    link, motor = (np.full(2, step / np.sqrt(12.0)) for step in (LINK_STEP, MOTOR_STEP))
    return SampleNoise(link, motor, TORQUE_NOISE * np.array(peak), np.zeros(2))


def _place(entry: Effect | Suspect) -> tuple[Any, ...]:
    name = entry.effect if isinstance(entry, Suspect) else entry.name
    return (name, getattr(entry, "joint", None), getattr(entry, "side", None))


def checks(truth: Sequence[Effect], answer: Diagnosis) -> tuple[Check, ...]:
    """Whether a diagnosis names all that was hidden and nothing else, with the true numbers, down to noise."""
    named = {_place(finding.suspect) for finding in answer.findings if not finding.rivals}
    wrong = named ^ {_place(effect) for effect in truth}
    unsure = sum(bool(finding.rivals) for finding in answer.findings)
    errors = [abs(found.value / true - 1.0) for _, _, true, found in _compared(truth, answer) if found is not None]
    gap = answer.gap_test
    return (
        check(
            "Every effect that was hidden is named, at its joint and side, and nothing else is",
            len(wrong) + unsure,
            0.0,
            f"effects missing, false or in doubt, of {len(truth)} hidden",
        ),
        check(
            "The numbers found are the true ones",
            max(errors, default=np.nan),
            0.1,
            "greatest relative error of a level, coefficient or velocity",
        ),
        check(
            "With what was found, the model is as good as noise allows on data not used in the fit",
            np.nan if gap is None else gap.after / gap.floor,
            1.3,
            "gap after over the gap of a perfect model",
        ),
    )


def _compared(truth: Sequence[Effect], answer: Diagnosis) -> list[tuple[Effect, str, float, Number | None]]:
    """Every number that was hidden: whose it is, its name, its true value, what was found."""
    found = {_place(finding.suspect): finding.suspect.parameters for finding in answer.findings}
    return [
        (effect, entry.name, float(getattr(effect, entry.name)), found.get(_place(effect), {}).get(entry.name))
        for effect in truth
        for entry in effect.parameters()
    ]


def _numbers(truth: Sequence[Effect], answer: Diagnosis, steps: Sequence[Step]) -> Mapping[str, Any]:
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


def _text(truth: Sequence[Effect], answer: Diagnosis, steps: Sequence[Step]) -> str:
    rows = [
        f"| {effect_name(effect.name)} {place_phrase(str(getattr(effect, 'joint', '')), getattr(effect, 'side', None))}"
        f" | {name} | {true:g} | {'not found' if found is None else estimate_text(found)} |"
        for effect, name, true, found in _compared(truth, answer)
    ]
    return "\n".join(
        [
            "The arm has all of eq. 1 on both links. The model given to `fd.diagnose` knows what the paper prints, the "
            "viscous friction of Fig. 5, and no dry friction, whose levels the paper leaves out; its stiffnesses and "
            "rotor inertias are wrong by 1.5 and 2 %. The arm is moved for 40 s under joint control (fast moves, slow "
            "sweeps, dwells); 12 s of another such motion and 12 s under the torque of Fig. 4 are kept for the check. "
            "Encoders have 20 bit on the links and 17 bit on the motors, torques have noise of "
            f"{100 * TORQUE_NOISE:g} % of their peak, and control sees nothing but the motors' encoders.",
            "",
            "The arm is simulated with flexdyn's own event-driven integrator (`DormandPrince`, every stick and slip an "
            "event): what is found here was made by the same laws. The benchmark of the diagnosis, "
            "`benchmarks/discovery`, and a test of this very study use simulators that share nothing with flexdyn.",
            "",
            f"{verdict_sentence(answer)} The whole answer: [{FOLDER}/report.html]({FOLDER}/report.html).",
            "",
            "| hidden | number | true | found |",
            "|---|---|---|---|",
            *rows,
            "",
            "| gap on data not used in the fit | in units of noise |",
            "|---|---|",
            *(f"| {step.name} | {times(step.gap)} |" for step in steps),
        ]
    )
