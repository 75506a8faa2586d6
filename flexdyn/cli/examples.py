"""Examples: simulated robots whose models lack an effect, with logs that have sensor noise."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexdyn.control.commands import PD
from flexdyn.control.samples import Samples
from flexdyn.effects import Backlash, CoulombFriction, Effect, StribeckFriction, ViscousFriction
from flexdyn.io.files import make_folder, write_text
from flexdyn.io.text import fill
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model, save_model
from flexdyn.records import Recording, write_recording
from flexdyn.simulation.simulate import simulate

RATE, SECONDS = 1000.0, 16.0
ENCODER, TORQUE = 2e-6, 0.02
"""Noise: standard deviations of positions [rad] and torques [N m]."""
DIGITS = 9
"""Decimals in the logs, well below the noise."""


@dataclass(frozen=True)
class ExampleCase:
    """An effect of a robot that its model lacks.

    Attributes:
        words: in plain words.
        hidden: the effect.
    """

    words: str
    hidden: Effect


EXAMPLES: Mapping[str, ExampleCase] = {
    case.hidden.name: case
    for case in (
        ExampleCase("dry friction in a motor", CoulombFriction("shoulder", side="motor", level=0.8)),
        ExampleCase(
            "friction that falls as a motor speeds up",
            StribeckFriction("elbow", side="motor", excess=0.6, velocity=0.05),
        ),
        ExampleCase(
            "friction that grows with a motor's speed", ViscousFriction("elbow", side="motor", coefficient=1.2)
        ),
        ExampleCase("backlash in a gear", Backlash("elbow", half_gap=2e-3)),
    )
}
"""By the name of the effect."""


def model_of_the_examples() -> FlexibleJointModel:
    """The model of the example: the paper's arm with stiff gears."""
    drives = {"*": {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5}}
    return load_model("scara_two_link").replace(joints=drives, effects=[], tolerance=0.03)


def write_example(name: str, folder: Path) -> tuple[Path, ...]:
    """Write model.yaml, monday.csv, tuesday.csv and README.txt.

    Args:
        name: of `EXAMPLES`.
        folder: created if it does not exist.

    Returns:
        The files.
    """
    model = model_of_the_examples()
    robot = model.replace(effects=[EXAMPLES[name].hidden])
    make_folder(folder)
    files = tuple(folder / file for file in ("model.yaml", "monday.csv", "tuesday.csv", "README.txt"))
    save_model(model, files[0])
    for day, file in enumerate(files[1:3]):
        write_recording(example_log(robot, day), file)
    readme = fill("cli/example_readme.txt", name=name, words=EXAMPLES[name].words, commands=commands(folder))
    write_text(files[3], readme + "\n")
    return files


def example_log(robot: FlexibleJointModel, day: int) -> Recording:
    """A log of the robot's encoders and motor currents; each day has another motion."""
    t = np.arange(round(RATE * SECONDS)) / RATE
    shoulder = 0.5 * np.sin((0.9 + 0.1 * day) * t) + 0.2 * np.sin((5.0 - 0.4 * day) * t)
    elbow = 1.5 + 0.4 * np.sin((0.7 + 0.1 * day) * t) + 0.2 * np.sin((4.0 + 0.3 * day) * t)
    reference = np.column_stack([shoulder, elbow])
    run = simulate(robot, PD(Samples(t, reference, "cubic"), kp=400.0, kd=20.0), q0=reference[0], rate=RATE)
    rng, rec = np.random.default_rng(day), run.to_recording()
    channels = {}
    for joint in robot.joint_names:
        for signal, noise in (("q", ENCODER), ("theta", ENCODER), ("tau", TORQUE)):
            seen = rec[f"{signal}.{joint}"]
            channels[f"{signal}.{joint}"] = np.round(seen + rng.normal(0.0, noise, seen.size), DIGITS)
    return Recording(np.round(rec.t, DIGITS), channels, name=f"day {day}")


def commands(folder: Path) -> tuple[str, ...]:
    """The commands to run, in order."""
    at = shlex.quote(folder.as_posix())
    return (
        f"flexdyn info {at}/model.yaml --modes",
        f"flexdyn simulate {at}/model.yaml --command {at}/tuesday.csv -o {at}/simulated.csv",
        f"flexdyn plot {at}/tuesday.csv {at}/simulated.csv -o {at}/gap.html",
        f"flexdyn diagnose {at}/model.yaml {at}/monday.csv --check {at}/tuesday.csv -o {at}/report",
        f"flexdyn simulate {at}/report/model.yaml --command {at}/tuesday.csv -o {at}/corrected.csv",
        f"flexdyn compare {at}/tuesday.csv {at}/corrected.csv",
    )
