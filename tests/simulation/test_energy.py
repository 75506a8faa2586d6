"""The energy ledger closes, and each of its entries is what an independent computation finds."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import Effect
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, RungeKutta4, Solver, TimeStepping
from tests.arms import coupled, repickled, slider
from tests.effects.arms import catalogue_examples, model_of
from tests.effects.reference import Arm

Array = NDArray[np.float64]
ARM = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.1), gravity=9.81)
LOSSLESS = Arm((300.0, 200.0), (0.0, 0.0), (0.1, 0.1), gravity=9.81)
HALF_RIGID = Arm((math.inf, 200.0), (0.0, 0.3), (0.1, 0.1), gravity=9.81)
START: dict[str, Any] = {"q0": [0.95, math.pi / 2], "v0": [1.0, -0.6]}
"""Just before the end stop of the catalogue's example, moving towards it, the springs at rest."""
TABLE = [[1.5, 0.4], [-2.0, 0.3], [0.5, -0.8], [0.2, 0.1]]
RAMPS = fd.Samples([0.0, 0.1, 0.17, 0.3], TABLE, "linear")
STEPS = fd.Samples([0.0, 0.1, 0.17, 0.3], TABLE)
SOLVERS: tuple[Solver, ...] = (
    DormandPrince(),
    DormandPrince(smoothing=0.05),
    Rosenbrock(),
    Rosenbrock(smoothing=0.05),
    RungeKutta4(step=1e-4, smoothing=0.05),
    TimeStepping(step=1e-4),
)
IN_PLANT = [e for e in catalogue_examples() if e.stage != "sensor"]
TOGETHER = [e for e in IN_PLANT if e.name != "joint_elasticity"]
LOSING = [e for e in IN_PLANT if e.stage in ("friction", "dry") and e.name != "joint_coupling"]
MEMORYLESS = [e for e in LOSING if e.name != "presliding_friction"]


def solver_name(solver: Solver) -> str:
    """A solver's name, and whether it smooths."""
    return type(solver).__name__ + ("_smooth" if getattr(solver, "smoothing", None) else "")


def arm_with(effects: list[Any]) -> fd.FlexibleJointModel:
    """The arm; its shoulder is rigid where the effects make it elastic themselves."""
    elasticity = any(effect.name == "joint_elasticity" for effect in effects)
    return model_of(HALF_RIGID if elasticity else ARM, effects)


def closed(run: fd.Run) -> fd.Energy:
    """The ledger of a run that must close without a warning, turn over energy, and start at zero."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        energy = run.energy
    assert energy.closes
    assert np.abs(energy.residual).max() <= energy.tolerance
    assert 0.0 < energy.tolerance < 0.1 * np.ptp(energy.kinetic)
    for sums in (energy.supplied, energy.external, *energy.dissipated.values()):
        assert not sums[0].any()
    return energy


@pytest.mark.parametrize("solver", SOLVERS, ids=solver_name)
@pytest.mark.parametrize("effect", IN_PLANT, ids=lambda effect: effect.name)
def test_it_closes_with_every_effect(effect: Effect, solver: Solver) -> None:
    """Energy gained is energy supplied less energy dissipated, whatever the effect does."""
    if effect.name == "end_stop" and isinstance(solver, RungeKutta4):
        solver = RungeKutta4(step=1e-4)  # its damper sets in with a jump; with smoothing nothing locates it: see below
    closed(fd.simulate(arm_with([effect]), STEPS, 0.3, solver, rate=200, **START))


@pytest.mark.parametrize("solver", SOLVERS, ids=solver_name)
def test_it_closes_with_all_effects_together(solver: Solver) -> None:
    """The whole catalogue on one joint, and every loss has an entry of its own."""
    start: dict[str, Any] = {"q0": [0.98, math.pi / 2], "v0": [2.0, -0.6]}
    run = fd.simulate(arm_with(TOGETHER), STEPS, 0.3, solver, rate=200, **start)
    if isinstance(solver, RungeKutta4):
        with pytest.warns(fd.EnergyWarning):  # nothing locates the end stop's jump
            energy = run.energy
    else:
        energy = closed(run)
    assert np.abs(energy.residual).max() < 1e-4 * np.ptp(energy.kinetic) or isinstance(solver, TimeStepping)
    expected = {f"{e.name}.{e.joint}.{e.side}" for e in [*LOSING, *(e for e in TOGETHER if e.name == "joint_coupling")]}
    expected |= {"damping.shoulder", "damping.elbow", "transmission_damping.shoulder.transmission"}
    expected |= {"spring_hysteresis.shoulder.transmission", "end_stop.shoulder.link"}
    assert set(energy.dissipated) == expected
    assert all(energy.dissipated[label].any() for label in expected)


@pytest.mark.parametrize("solver", SOLVERS, ids=solver_name)
@pytest.mark.parametrize("kind", ["pd", "controller", "wrench", "delayed_pd", "coupled_rotors"])
def test_it_closes_under_every_drive(kind: str, solver: Solver) -> None:
    """Tracking, a law in Python, a wrench at the tip, delayed feedback, and the full rotor coupling."""
    reference = fd.Samples([0.0, 0.15, 0.3], [[0.9, 1.5], [0.7, 1.7], [0.9, 1.6]], "cubic")
    pd = fd.PD(reference, 30.0, 1.0, rate=500)
    command: Any = {"pd": pd, "delayed_pd": pd}.get(kind, STEPS)
    if kind == "controller":
        command = fd.Controller(lambda t, x: 20.0 * (1.0 - x.theta) - 0.5 * x.omega, rate=500)
    effects = [fd.effects.CommandDelay("elbow", delay=0.0031)] if kind == "delayed_pd" else []
    wrench = fd.FrameWrench("tool", [3.0, -5.0, 0.0, 0.0, 0.0, 0.4]) if kind == "wrench" else None
    settings = {"rotor_coupling": "full"} if kind == "coupled_rotors" else {}
    model = model_of(ARM, [*effects, fd.effects.CoulombFriction("shoulder", side="motor", level=0.3)], **settings)
    energy = closed(fd.simulate(model, command, 0.3, solver, rate=200, external=wrench, **START))
    assert energy.external.any() == (kind == "wrench")
    assert np.abs(energy.supplied).max() > 0.01


@pytest.mark.parametrize("solver", SOLVERS, ids=solver_name)
@pytest.mark.parametrize("kind", ["mixed", "rigid", "mimic", "prismatic"])
def test_it_closes_on_every_kind_of_joint(kind: str, solver: Solver, tmp_path: Path) -> None:
    """Rigid joints with rotors, one of each, a joint that mimics, a mass that is lifted."""
    start: dict[str, Any]
    joint = {"rotor_inertia": 0.2, "stiffness": 300.0, "damping": 0.5}
    if kind in ("mixed", "rigid"):
        arm = HALF_RIGID if kind == "mixed" else Arm((math.inf, math.inf), (0.0, 0.0), (0.1, 0.1), gravity=9.81)
        model, start = model_of(arm, [fd.effects.CoulombFriction("shoulder", side="link", level=0.3)]), START
    elif kind == "mimic":
        model = fd.FlexibleJointModel(coupled(tmp_path, -1.5, 0.4), {"lead": joint}, gravity=[0.0, -9.81, 0.0])
        start = {"q0": [0.3], "v0": [1.0]}
    else:
        model, start = fd.FlexibleJointModel(slider(tmp_path), {"lift": joint}), {"v0": [2.0]}
    torque = np.full(model.n, 1.5)
    energy = closed(fd.simulate(model, torque, 0.3, solver, rate=200, **start))
    assert np.ptp(energy.gravity) > 0.05


@pytest.mark.parametrize("solver", SOLVERS, ids=solver_name)
@pytest.mark.parametrize(("effect", "side"), [(e, s) for e in MEMORYLESS for s in type(e).sides], ids=str)
def test_memoryless_friction_only_takes(effect: Any, side: Any, solver: Solver) -> None:
    """Its entry never falls, on either side, to and fro; and it takes something."""
    there = type(effect)(effect.joint, side=side, **{f.name: getattr(effect, f.name) for f in effect.parameters()})
    run = fd.simulate(arm_with([there]), STEPS, 0.3, solver, rate=1000, **START)
    lost = closed(run).dissipated[f"{effect.name}.shoulder.{side}"]
    assert (np.diff(lost) >= 0.0).all()
    assert lost[-1] > 1e-4


@pytest.mark.parametrize("name", ["presliding_friction", "spring_hysteresis"])
def test_memory_takes_no_less_than_it_stores(name: str) -> None:
    """With what bristles and loops hold in the ledger, their entries never fall."""
    (effect,) = [e for e in IN_PLANT if e.name == name]
    energy = closed(fd.simulate(arm_with([effect]), STEPS, 0.3, DormandPrince(), **START))
    assert (np.diff(energy.dissipated[f"{name}.{effect.joint}.{effect.side}"]) >= -1e-12).all()


def test_mechanical_energy_stays_where_nothing_takes_it() -> None:
    """Springs and gravity pass energy to and fro; the sum is constant although each part changes."""
    run = fd.simulate(model_of(LOSSLESS), None, 0.5, DormandPrince(rtol=1e-12, atol=1e-13), **START)
    energy = closed(run)
    assert np.ptp(energy.mechanical) < 1e-10
    assert min(np.ptp(part) for part in (energy.kinetic, energy.spring, energy.gravity)) > 1e-3
    assert dict(energy.dissipated) == {}


def test_samples_need_not_begin_at_the_start() -> None:
    """The ledger counts from the start of the run, whatever the samples: their entries are those of the whole grid."""
    whole = closed(fd.simulate(model_of(ARM), STEPS, 0.3, rate=100, **START))
    late = fd.simulate(model_of(ARM), STEPS, 0.3, times=[0.1, 0.25], **START).energy
    assert late.closes
    assert late.initial == whole.initial == pytest.approx(whole.mechanical[0], rel=1e-14)
    np.testing.assert_allclose(late.supplied, whole.supplied[[10, 25]], atol=1e-7)
    np.testing.assert_allclose(late.residual, whole.residual[[10, 25]], atol=1e-7)


@pytest.mark.parametrize(
    ("solver", "friction"),
    [(solver, level) for solver in SOLVERS for level in (0.0, 50.0) if not (level and getattr(solver, "smoothing", 0))],
    ids=lambda value: solver_name(value) if isinstance(value, Solver) else str(value),
)
def test_it_closes_at_rest(solver: Solver, friction: float) -> None:
    """An arm that is held still turns over no energy: rounding and absolute tolerance are no failure."""
    model = model_of(ARM, [fd.effects.CoulombFriction("elbow", side="motor", level=friction)])
    weight = fd.LinkSide(model).bias([0.3, 0.5], [0.0, 0.0])
    run = fd.simulate(model, weight, 1.0, solver, q0=[0.3, 0.5], theta0="equilibrium")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert 0.0 < run.energy.tolerance < 1e-6
    assert run.energy.closes


def test_a_coarse_step_is_said() -> None:
    """RungeKutta4 at a radian of the fastest vibration damps it: the ledger does not close, at the caller's line."""
    run = fd.simulate(model_of(LOSSLESS), None, 0.5, RungeKutta4(step=1e-2), **START)
    with pytest.warns(fd.EnergyWarning, match="RungeKutta4 does not resolve the motion") as caught:
        energy = run.energy
    assert not energy.closes
    assert [warning.filename for warning in caught] == [__file__]


def test_a_jump_within_a_fixed_step_is_said() -> None:
    """At an end stop's damper RungeKutta4 falls to order 1 with smoothing, and says so; without, it meets the jump."""
    (stop,) = [e for e in IN_PLANT if e.name == "end_stop"]
    run = fd.simulate(arm_with([stop]), STEPS, 0.3, RungeKutta4(step=2e-4, smoothing=0.05), **START)
    with pytest.warns(fd.EnergyWarning, match="RungeKutta4 does not resolve the motion"):
        left = np.abs(run.energy.residual).max()
    located = fd.simulate(arm_with([stop]), STEPS, 0.3, RungeKutta4(step=2e-4), **START)
    assert np.abs(closed(located).residual).max() < 1e-3 * left


def test_it_is_locked_and_pickles() -> None:
    """Nothing in a ledger can be written, also after a trip to another process."""
    energy = fd.simulate(model_of(ARM), STEPS, 0.1, **START).energy
    for each in (energy, repickled(energy)):
        for array in (each.kinetic, each.spring, each.gravity, each.supplied, each.external, *each.dissipated.values()):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0
        with pytest.raises(TypeError):
            each.dissipated["damping.elbow"] = energy.kinetic  # type: ignore[index]
        np.testing.assert_array_equal(each.residual, energy.residual)


def test_a_controller_is_not_asked_again() -> None:
    """The ledger goes by the torques that were asked for, and a run from another process still has it."""
    over: list[bool] = []

    def law(t: float, x: fd.State) -> Array:
        assert not over, "it is asked for a torque after its run"
        return 20.0 * (1.0 - x.theta) - 0.5 * x.omega

    run = fd.simulate(model_of(ARM), fd.Controller(law, rate=200), 0.3, **START)
    over.append(True)
    energy = closed(run)
    assert np.abs(energy.supplied).max() > 0.01  # it did drive the arm
    again = closed(repickled(run))
    np.testing.assert_array_equal(again.residual, energy.residual)
    assert set(again.dissipated) == set(energy.dissipated)
