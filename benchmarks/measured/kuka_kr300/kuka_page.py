"""The KUKA's page: verdicts, tables and pictures."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from kuka_encoders import Account, Ripple
from kuka_pictures import draw

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from pages import fill_page
from result_tables import markdown_table

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
    axes = {
        joint: [*_terms(told, published), *_wave(wave), *_refused(told, published)]
        for joint, told, wave, published in zip(JOINTS, made.accounts, made.ripples, PUBLISHED, strict=True)
    }
    fill_page(__file__, made, held, folder, errors=_errors(made), verdicts=_verdicts(made), axes=axes)


def _errors(made: Study) -> str:
    """Torque errors of axis 2 in every record: least squares, the published model, what was found."""
    rows = [
        [law, *(f"{100 * by[name]:.1f}" for key in "ABC" for name in (key, f"{key} moving"))]
        for law, by in made.references.items()
    ]
    for what, along in (("published model", made.before), ("**found by `fd.diagnose`**", made.after)):
        errors = ((along[key].error(AXIS), along[key].error(AXIS, moving=True)) for key in "ABC")
        rows.append([what, *(f"{100 * each:.1f}" for pair in errors for each in pair)])
    header = ["torque error of axis 2 [%]", "A", "moving", "B", "moving", "C", "moving"]
    return markdown_table(header, rows, text=len(header))


def _verdicts(made: Study) -> str:
    """Which numbers of the model record A determines, by verdict."""
    words = {
        "told": "better than 3 % (or their own tolerance), all others unknown",
        "weak": "worse than that",
        "combined": "only in sums with others",
        "silent": "nothing",
    }
    rows = []
    for verdict, meaning in words.items():
        numbers = [each for each in made.told.numbers if each.verdict == verdict]
        found = [f"{each.of} {each.parameter.removeprefix('link_')}" for each in numbers]
        rows.append([verdict, meaning, f"{len(found)}", ", ".join(found) or "-"])
    return markdown_table(["verdict", "meaning", "numbers", "which"], rows, text=4)


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
