"""The KUKA's page: verdicts, tables and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from kuka_encoders import Account, Ripple
from kuka_pictures import draw

if TYPE_CHECKING:
    from kuka_result import Study
    from measure import Bound

AXIS = 1
JOINTS = ("axis 1", "axis 2", "axis 3")
PUBLISHED = (4.5778e6, 7.5189e6, 4.0999e6)
"""Stiffness that the authors use [N m/rad]."""


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its pictures, and the diagnosis' report into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    draw(made, folder)
    made.diagnosis.save(folder / "diagnosis")
    parts = [*_torque(made), *_told(made), *_encoders(made)]
    checks = "\n".join(f"- {each}" for each in held)
    head = (
        "# KUKA KR 300: what the model lacks\n"
        "\n"
        "Record A is fitted; B and C are not used in the fit (10 s each at 4 ms)."
    )
    (folder / "page.md").write_text("\n\n".join([head, checks, *parts]) + "\n", encoding="utf-8")


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _torque(made: Study) -> Iterator[str]:
    yield "## The torque of axis 2"
    named = [each for each in made.diagnosis.findings if each.suspect.joint == "axis2"]
    for each in named:
        numbers = ", ".join(f"{k} {n.value:.4g} +- {n.std:.2g} {n.unit}" for k, n in each.suspect.parameters.items())
        rivals = ", ".join(f"`{r.effect}` on {r.joint}" for r in each.rivals)
        or_ = f" Not told apart from it by these records: {rivals}." if rivals else ""
        yield f"**Missing: `{each.suspect.effect}` on axis 2, {each.suspect.side} side** ({numbers}).{or_}"
    rows = [
        [law, *(f"{100 * by[name]:.1f}" for key in "ABC" for name in (key, f"{key} moving"))]
        for law, by in made.references.items()
    ]
    for what, along in (("published model", made.before), ("**found by `fd.diagnose`**", made.after)):
        errors = ((along[key].error(AXIS), along[key].error(AXIS, moving=True)) for key in "ABC")
        rows.append([what, *(f"{100 * each:.1f}" for pair in errors for each in pair)])
    yield _table(["torque error of axis 2 [%]", "A", "moving", "B", "moving", "C", "moving"], rows)
    yield (
        "Root mean square of the residual over that of the torque, for all samples, and for those in which the "
        "axis moves faster than 5 mrad/s. The first five rows are plain least squares on A, an independent "
        "reference. With friction alone most of the residual remains. One law of position removes it on B and C "
        "too, although their range of the axis (-2.0 to -1.3 rad) differs from that of the fit (-1.6 to -1.1 rad). "
        "A law with four free numbers fits A better and fails on B: record A does not determine more than the "
        "first of them."
    )
    yield (
        "Physical interpretation: the torque pulls towards a position near -pi/2, where the arm is upright, and so "
        "carries a part of the weight: a gravity balancer. A spring and a cosine of the angle fit equally well: "
        "0.9 rad of motion does not determine the law of the balancer (that of a gas cylinder is neither). It is "
        "not a wrong mass: the weight's own slope near upright is about 5300 N m/rad by the table, less than the "
        "missing slope, and a mass would change the inertia too. A ripple of the motor's torque with one cycle per "
        "turn of the joint has the same column, but no motor has a ripple of thousands of N m. The available part "
        "of the authors' text does not name a balancer; their model has further terms that are not listed with the "
        "data."
    )
    yield "![torque](torque.png)"
    gap = made.diagnosis.gap_test
    if gap is not None:
        yield (
            f"The gap of simulated windows (0.5 s, B and C, in units of noise) is {gap.before:.3g} with the "
            f"published model, {gap.calibrated:.3g} calibrated, {gap.after:.3g} with the finding, {gap.floor:.2g} "
            f"for a perfect model: verdict `{made.diagnosis.verdict}`. The rest occurs mostly where axes rest or "
            "break away. With such fine encoders (1e-6 rad and less), any error of a model is many times the noise."
        )


def _told(made: Study) -> Iterator[str]:
    yield "## Which of the model's numbers record A determines"
    numbers = made.told.numbers
    words = {
        "told": "better than 3 % (or their own tolerance), all others unknown",
        "weak": "worse than that",
        "combined": "only in sums with others",
        "silent": "nothing",
    }
    rows = []
    for verdict, meaning in words.items():
        found = [f"{each.of} {each.parameter.removeprefix('link_')}" for each in numbers if each.verdict == verdict]
        rows.append([verdict, meaning, f"{len(found)}", ", ".join(found) or "-"])
    yield (
        f"`fd.base_parameters`: {made.told.rank} combinations of inertial numbers and friction, condition "
        f"{made.told.condition:.0f}; the noise is the residual of the corrected model, including its correlations."
    )
    yield _table(["verdict", "meaning", "numbers", "which"], rows)


def _encoders(made: Study) -> Iterator[str]:
    yield "## The parts of the difference between motor and link encoder"
    yield "![encoders](encoders.png)"
    for joint, told, wave, published in zip(JOINTS, made.accounts, made.ripples, PUBLISHED, strict=True):
        yield f"**{joint}.** " + " ".join([*_terms(told, published), *_wave(wave), *_refused(told, published)])
    yield (
        "The data do not determine: the cause of a zero offset (each record has its own; encoders count from the "
        "start pose); whether the lag comes from the encoder, its converter or the log; the damping of the gears, "
        "which a lag hides (a common lag of three axes of different size and load is the simpler cause); an "
        "eccentricity, which over less than 0.9 rad looks like a scale and a small spring; the springs of axes 4 "
        "to 6, which have one encoder."
    )


def _terms(told: Account, published: float) -> Iterator[str]:
    for k, term in enumerate(told.terms):
        drop = ", ".join(
            f"{name} {1e6 * told.left[k][name]:.0f} to {1e6 * told.left[k + 1][name]:.0f}" for name in "ABC"
        )
        values = np.array(list(told.estimates[term].values()))
        mean, std = float(values.mean()), float(values.std(ddof=1))
        meaning = {
            "lag": f"a lag of the link encoder's channel of {1e3 * mean:.2f} +- {1e3 * std:.2f} ms",
            "spring": f"a compliance of {mean:.2g} +- {std:.1g} rad/(N m) (the authors': {1 / published:.2g})",
            "scale": f"a scale (gear ratio, encoder, slow eccentricity) of {1e6 * mean:.0f} +- {1e6 * std:.0f} ppm",
            "hysteresis": f"a step with the direction of {2e6 * mean:.0f} +- {2e6 * std:.0f} urad",
            "inertial": f"a part in proportion to the acceleration, {mean:.2g} +- {std:.1g} s^2",
        }[term]
        yield f"{meaning[0].upper()}{meaning[1:]}, {drop} urad rms." + (" Mean and spread over the records." * (not k))


def _wave(wave: Ripple) -> Iterator[str]:
    if wave.size[-1] < 6.0 * wave.floor:
        yield "No sine over position stands out at all speeds."
        return
    sizes = ", ".join(f"{1e6 * each:.0f}" for each in wave.size)
    yield f"A ripple of {wave.harmonic:.1f} cycles per turn, {sizes} urad at 0.1, 0.2 and 0.35 rad/s:"
    if wave.own < 0.5 * wave.motor:
        yield (
            "counted by the link encoder's own angle its phase is the same at every speed and in both directions "
            f"(spread {wave.own:.2f} rad; by the motor's angle {wave.motor:.2f} rad), and it hardly shrinks beyond the "
            "arm's resonances: it is the link encoder's own error, not the gear's."
        )
    else:
        yield "gear or encoder: its phase does not decide."


def _refused(told: Account, published: float) -> Iterator[str]:
    if told.refused:
        yield "Not wanted by B and C: " + ", ".join(sorted(told.refused)) + "."
    if "spring" in told.refused:
        values = np.array(list(told.refused["spring"].values()))
        yield (
            f"As to the spring, its compliance would be {values.mean():.1g} +- {values.std(ddof=1):.1g} rad/(N m), "
            f"against the authors' {1 / published:.2g}: no weight loads this axis, so its torque is nearly in "
            "proportion to the acceleration, and these records do not tell it."
        )
    zeros = ", ".join(f"{name} {1e3 * each:.2f}" for name, each in told.zeros.items())
    yield f"Zeros: {zeros} mrad."
