"""flexdyn simulate: simulate a model under a command, and write the run."""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np

from flexdyn.cli import options
from flexdyn.cli.output import cell, note, progress, show, show_json, table
from flexdyn.cli.recordings import load
from flexdyn.cli.target import model_file
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording, write_recording
from flexdyn.records.files import SUFFIXES
from flexdyn.simulation.given_command import read_command_file
from flexdyn.simulation.limits import enforce_limits
from flexdyn.simulation.run import Run
from flexdyn.simulation.solvers import SOLVERS, Solver, make_solver

STARTS = "0.1,0.2 or elbow=1.57,wrist=0"
# Arguments of the Python interface -> what the user typed.
OPTION_OF_SETTING = {name: f"--{name}" for name in ("duration", "rate", "q0", "v0", "theta0", "omega0")}
OPTION_OF_SETTING |= {f"solver.{name}": f"--{name}" for name in ("step", "rtol", "atol", "smoothing")} | {
    "solver": "--solver"
}
SYMBOLS = {
    "q": "link position",
    "v": "link velocity",
    "theta": "motor position, reflected",
    "tau": "commanded motor torque",
    "tau_s": "torque in the spring",
    "| |": "the largest size",
}
"""Meanings of the symbols in a run's table."""
OutputOption = Annotated[Path | None, options.output_option("RUN", f"The run: {', '.join(SUFFIXES)} by its suffix.")]
CommandOption = Annotated[
    Path | None,
    options.option(
        "FILE",
        "A recording whose tau drives the arm, or a YAML file with pd: or torques:. Default: the model's own, "
        "else no torque.",
    ),
]


def simulate(
    model: options.ModelArgument,
    output: OutputOption = None,
    command: CommandOption = None,
    map: options.MapOption = None,
    duration: Annotated[str | None, options.option("S", "Duration in s. Default: the command's.")] = None,
    solver: Annotated[str, options.option("NAME", f"auto, {', '.join(SOLVERS)}.")] = "auto",
    step: Annotated[str | None, options.option("S", "Step of RungeKutta4 or TimeStepping, in s.")] = None,
    rtol: Annotated[str | None, options.option("R", "Relative tolerance of an adaptive solver.")] = None,
    atol: Annotated[
        str | None, options.option("A", "Absolute tolerance of an adaptive solver, in rad and rad/s.")
    ] = None,
    smoothing: Annotated[
        str | None, options.option("U", "Smooth dry friction below this velocity, in rad/s. Default: exact sticking.")
    ] = None,
    rate: Annotated[str, options.option("HZ", "Sample rate of the run, in Hz.")] = "1000",
    q0: Annotated[list[str] | None, options.option("VALUES", f"First link positions, {STARTS}; rad or m.")] = None,
    v0: Annotated[list[str] | None, options.option("VALUES", "First link velocities, likewise.")] = None,
    theta0: Annotated[
        list[str] | None,
        options.option("VALUES", "First rotor positions, likewise; or equilibrium: the springs then carry gravity."),
    ] = None,
    omega0: Annotated[list[str] | None, options.option("VALUES", "First rotor velocities, likewise.")] = None,
    limits: Annotated[
        bool,
        options.flag("--limits", "Keep to the limits in the URDF: end stops at the ends, saturated motors."),
    ] = False,
    as_json: options.JsonOption = False,
) -> None:
    """Simulate a model under a command and write the run.

    The first state comes from --q0, --v0, --theta0 and --omega0. Without them it comes from the first row of the
    recording in --command, or else from the model file. Rotors start at theta = q, omega = v by default.
    """
    from flexdyn.simulation.simulate import simulate as integrate

    path = options.output_file("--output", output, SUFFIXES, inputs=(Path(model), command, map))
    span = None if duration is None else options.decimal("--duration", duration)
    hertz = options.decimal("--rate", rate)
    settings = _settings(step=step, rtol=rtol, atol=atol, smoothing=smoothing)
    arm = enforce_limits(model_file(model)) if limits else model_file(model)
    with options.naming(OPTION_OF_SETTING, file=model, files={"samples": command, "pd": command, "command": command}):
        chosen = choose(solver, **settings)
        starts = _starts(arm, q0=q0, v0=v0, theta0=theta0, omega0=omega0)
        drive = _read_command(command, map)
        if command is None and arm.command is not None:
            drive = arm.command
            note("the command is the model file's own")
        _can_write(path)
        length = span or getattr(drive, "duration", None)
        end = f" of {length:g}" if length else ""
        with progress(f"{arm.name}: starting", lambda t: f"{arm.name}: t = {t:.3f}{end} s") as report:
            run = integrate(arm, drive, span, chosen, rate=hertz, progress=report, **starts)
    for text in run.notes:
        note(text)
    run.save(path)
    if as_json:
        show_json(summary(run, path))
    else:
        show(*_report(run, path))


def choose(name: str, **settings: float) -> Solver | str:
    """The solver that the options describe.

    Args:
        name: as given; ``auto`` with tolerances or smoothing means the adaptive solver.
        settings: the given ones of step, rtol, atol, smoothing.

    Raises:
        InputError: no such solver, a setting that it does not have, or a missing one.
    """
    if name != "auto" or not settings:
        return make_solver(name, **settings) if name != "auto" else "auto"
    if "step" in settings:
        stepping = [kind for kind in SOLVERS if "step" in {field.name for field in fields(SOLVERS[kind])}]
        remedy = f"name one that takes a step: --solver {' or '.join(stepping)}"
        raise InputError("solver auto takes no step", key="solver.step", value=settings["step"], remedy=remedy)
    chosen = make_solver("DormandPrince", **settings)
    note(f"solver auto with {', '.join(f'--{key}' for key in settings)}: DormandPrince")
    return chosen


def summary(run: Run, path: Path) -> dict[str, Any]:
    """The output of `--json` for a run."""
    peak = {"deflection": run.deflection, "v": run.v, "tau": run.tau, "tau_s": run.tau_s}
    return {
        "output": str(path),
        "model": run.model.name,
        "duration": float(run.t[-1]),
        "samples": len(run.t),
        "solver": run.solver.to_dict(),
        "notes": list(run.notes),
        "exceeded": [asdict(each) for each in run.exceeded],
        "stats": dict(run.stats),
        "joints": {
            name: {
                "q_first": run.q[0, j],
                "q_last": run.q[-1, j],
                **{f"{key}_max": np.abs(signal[:, j]).max() for key, signal in peak.items()},
            }
            for j, name in enumerate(run.joint_names)
        },
    }


def _settings(**texts: str | None) -> dict[str, float]:
    """The given values, as numbers."""
    return {key: options.decimal(f"--{key}", text) for key, text in texts.items() if text is not None}


def _starts(model: FlexibleJointModel, **given: list[str] | None) -> dict[str, Any]:
    """First states by joint; of rotor positions also that the springs carry gravity."""
    starts: dict[str, Any] = {}
    for signal, texts in given.items():
        if texts == ["equilibrium"] and signal == "theta0":
            starts[signal] = "equilibrium"
        elif texts:
            starts[signal] = options.by_joint(f"--{signal}", texts, model.joint_names)
    return starts


def _read_command(path: Path | None, map: Path | None) -> Any:
    """The command; the name of a recording is its path, so that errors can name the file."""
    if path is not None and path.suffix.lower() not in (".yaml", ".yml"):
        return load(path, map=map, name=str(path))
    if map is not None:
        raise InputError("there is no recording to map", file=map, key="--map", remedy="give one as --command")
    return None if path is None else read_command_file(path)


def _can_write(path: Path) -> None:
    """Write an empty recording to another place: a missing library is reported before the work, not after it."""
    with TemporaryDirectory() as folder:
        write_recording(Recording([0.0, 1.0], {"q.none": [0.0, 0.0]}), Path(folder) / f"probe{path.suffix}")


def _report(run: Run, path: Path) -> list[Any]:
    """The table of a run."""
    stats, joints = run.stats, summary(run, path)["joints"]
    head = (
        f"{path}: {cell(float(run.t[-1]), 6)} s of {run.model.name}, {len(run.t)} samples; "
        f"{type(run.solver).__name__}, {stats['steps']} steps, {stats['rejected']} rejected, "
        f"{stats['evaluations']} evaluations, {stats['events']} events"
    )
    keys = ("q_first", "q_last", "v_max", "deflection_max", "tau_max", "tau_s_max")
    columns = ("q first", "q last", "|v|", "|theta - q|", "|tau|", "|tau_s|")
    rows = []
    for j, (name, entry) in enumerate(joints.items()):
        unit = f"{run.model.robot.angle_unit(j)}, {run.model.robot.torque_unit(j)}"
        rows.append((name, unit, *(cell(float(entry[key])) for key in keys)))
    return [
        head,
        table(
            "First and last position, largest values", ("joint", "unit", *columns), rows, right=columns, legend=SYMBOLS
        ),
    ]
