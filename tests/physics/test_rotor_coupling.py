"""Rotors that ride on their parent links, against Lagrange's equations written out by hand."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import BENT, EXACT, slider, state
from tests.oracles.integrate import trajectory
from tests.oracles.riding_arms import RIGID, SKEW, planar, riding_model, skew, too_light
from tests.oracles.rotor_lagrangian import RidingRotors
from tests.oracles.two_link import TwoLink

STOPS = np.linspace(0.0, 3.0, 7)
SHORT = np.linspace(0.0, 0.6, 7)
START = [0.0, math.pi / 2, 0.0, math.pi / 2, 0.4, -0.3, 0.4, -0.3]
TAU = (1.0, -0.5)


def test_a_planar_arm_with_a_riding_rotor() -> None:
    """Rotor 2 turns with link 1, S = J2/N2 constant: the motion of the hand-derived equations, far from the reduced."""
    arm = planar()
    run = fd.simulate(arm.model(), TAU, 3.0, EXACT, times=STOPS, **BENT)
    expected = trajectory(lambda _, x: arm.derivative(list(x), TAU), START, STOPS)
    assert np.abs(state(run) - expected).max() < 1e-8
    reduced = fd.simulate(arm.model(coupling="reduced"), TAU, 3.0, EXACT, times=STOPS, **BENT)
    assert np.abs(reduced.q - run.q).max() > 1e-2


@pytest.mark.parametrize("stiffness", [(60.0, 40.0, 30.0), (RIGID, 40.0, RIGID), (60.0, RIGID, 30.0), (RIGID,) * 3])
def test_a_spatial_arm_with_skew_axes(tmp_path: Path, stiffness: tuple[float, float, float]) -> None:
    """S(q), gyroscopic torques and mixtures of rigid and elastic joints, as the kinetic energy has them."""
    arm = skew(stiffness)
    model, names = riding_model(arm, tmp_path), [f"j{i}" for i in arm.elastic]
    q, v, omega, tau = [0.3, -0.5, 0.8], [1.0, -2.0, 3.0], [5.0, -6.0, 8.0][: len(names)], [1.0, -2.0, 0.5]
    rotors: dict[str, Any] = {"omega0": dict(zip(names, omega, strict=True))} if names else {}
    run = fd.simulate(model, tau, 0.6, EXACT, times=SHORT, q0=q, v0=v, **rotors)
    expected = arm.motion(np.array([*q, *(q[i] for i in arm.elastic), *v, *omega]), tau, SHORT)
    assert np.abs(state(run) - expected).max() < 1e-7
    np.testing.assert_allclose(run.energy.mechanical, [arm.energy(x) for x in expected], atol=1e-7)
    reduced = fd.simulate(model.replace(rotor_coupling="reduced"), tau, 0.6, EXACT, times=SHORT, q0=q, v0=v, **rotors)
    assert np.abs(reduced.q - run.q).max() > 1e-2


@pytest.mark.parametrize("stiffness", [(60.0, 30.0), (RIGID, 30.0)])
def test_a_rotor_that_rides_on_a_mimic_joint(tmp_path: Path, stiffness: tuple[float, float]) -> None:
    """The second link follows the first, and the third joint's rotor turns with both."""
    arm = RidingRotors(SKEW, (4.0, 5.0), (0.2, 0.05), stiffness, mimic=(1, 0, -0.7))
    model = riding_model(arm, tmp_path)
    assert model.joint_names == ("j0", "j2")
    run = fd.simulate(model, [1.0, 0.5], 0.6, EXACT, times=SHORT, q0=[0.3, 0.8], v0=[1.0, 3.0])
    x0 = [0.3, 0.8, *([0.3, 0.8][i] for i in arm.elastic), 1.0, 3.0, *([1.0, 3.0][i] for i in arm.elastic)]
    assert np.abs(state(run) - arm.motion(np.array(x0), [1.0, 0.5], SHORT)).max() < 1e-7


@pytest.mark.parametrize("solver", [EXACT, fd.solvers.RungeKutta4(step=2e-4)])
def test_energy_is_kept(tmp_path: Path, solver: fd.solvers.Solver) -> None:
    """Nothing drives or brakes: the gyroscopic torques take nothing, and the ledger holds S in the kinetic energy."""
    arm = skew()
    spinning: dict[str, Any] = {"q0": [0.3, -0.5, 0.8], "v0": [1.0, -2.0, 3.0], "omega0": [5.0, -6.0, 8.0]}
    run = fd.simulate(riding_model(arm, tmp_path), None, 2.0, solver, rate=100, **spinning)
    assert np.ptp(run.energy.kinetic) > 1.0
    assert np.abs(run.energy.mechanical - run.energy.mechanical[0]).max() < 1e-8 * np.ptp(run.energy.kinetic)
    np.testing.assert_allclose(run.energy.mechanical, [arm.energy(x) for x in state(run)], atol=1e-9)


def test_reduction_errs_by_the_inverse_of_the_gear_ratio() -> None:
    """At the same reflected J the coupling is J/N: the reduced motion differs as 1/N."""
    errors = []
    for ratio in (100.0, 1000.0, 10000.0):
        arm = planar(ratio)
        full, reduced = (
            fd.simulate(arm.model(coupling=coupling), TAU, 1.0, EXACT, rate=50, **BENT).q
            for coupling in ("full", "reduced")
        )
        errors.append(np.abs(full - reduced).max())
    assert errors[0] > 1e-5
    slopes = [math.log10(coarse / fine) for coarse, fine in itertools.pairwise(errors)]
    np.testing.assert_allclose(slopes, 1.0, atol=0.02)


def test_a_rotor_on_the_base_couples_to_nothing(tmp_path: Path) -> None:
    """The first rotor of an arm rides on nothing that moves: full and reduced are one motion."""
    drive = {"lift": {"gear_ratio": 200.0, "rotor_inertia": 5e-5, "stiffness": 800.0}}
    runs = [
        fd.simulate(fd.FlexibleJointModel(slider(tmp_path), drive, rotor_coupling=coupling), [18.0], 1.0, EXACT)
        for coupling in ("full", "reduced")
    ]
    np.testing.assert_allclose(runs[0].q, runs[1].q, atol=1e-10)


def test_what_the_gear_of_a_rigid_joint_carries() -> None:
    """tau_s of a rigid elbow is d12 a1 + d22 a2 + h2, all that moves link 2, its riding rotor's reaction taken off."""
    arm = planar(stiffness=(30.0, RIGID))
    links = arm.links
    run = fd.simulate(arm.model(), TAU, 1.0, EXACT, times=[0.0, 0.3, 0.7, 1.0], **BENT)
    for q, theta, v, found in zip(run.q, run.theta, run.v, run.tau_s, strict=True):
        d11, d22, d12, _ = links.inertias(q[1])
        h1, h2 = links.bias(q, v)
        H = np.array([[d11, d12 + arm.spin], [d12 + arm.spin, d22 + links.rotor[1]]])
        a = np.linalg.solve(H, [30.0 * (theta[0] - q[0]) - h1, TAU[1] - h2])
        assert found[1] == pytest.approx(d12 * a[0] + d22 * a[1] + h2, abs=1e-9)


@pytest.mark.parametrize("solver", [EXACT, fd.solvers.TimeStepping(step=1e-3)])
def test_a_link_that_sticks_while_a_rotor_spins_on_it(solver: fd.solvers.Solver) -> None:
    """The reaction of rotor 2 on link 1 is below its dry level: link 1 has exactly no velocity."""
    arm = planar(gravity=0.0)
    dry = [{"effect": "coulomb_friction", "joint": "shoulder", "side": "link", "level": 5.0}]
    run = fd.simulate(arm.model(dry), [0.0, 0.5], 1.0, solver, q0=[0.0, 0.4])
    assert np.ptp(run.q[:, 0]) == 0.0
    assert not run.v[:, 0].any()
    assert np.ptp(run.q[:, 1]) > 0.1


@pytest.mark.parametrize(("factor", "holds"), [(1.0 + 1e-4, True), (1.0 - 1e-4, False)])
def test_the_level_at_which_a_riding_rotor_breaks_away(factor: float, holds: bool) -> None:
    """Link 1 starts under rotor 2, which its friction holds up to (J2/N2) a1."""
    arm = planar(gravity=0.0, stiffness=(RIGID, 1e-3))
    d11, d22, d12, _ = arm.links.inertias(0.5 * math.pi)
    a1 = np.linalg.solve([[d11 + arm.links.rotor[0], d12], [d12, d22]], [1.0, 0.0])[0]
    dry = [{"effect": "coulomb_friction", "joint": "elbow", "side": "motor", "level": factor * arm.spin * a1}]
    run = fd.simulate(arm.model(dry), [1.0, 0.0], 1e-3, EXACT, rate=1e5, q0=[0.0, 0.5 * math.pi])
    assert (not run.omega[:, 1].any()) == holds
    assert run.v[-1, 0] == pytest.approx(a1 * 1e-3, rel=1e-4)


def test_solvers_agree(tmp_path: Path) -> None:
    """Rosenbrock to its tolerance, TimeStepping with an error that falls like its step."""
    model = riding_model(skew(), tmp_path)
    start: dict[str, Any] = {"q0": [0.3, -0.5, 0.8], "v0": [0.5, -1.0, 1.0]}
    exact = fd.simulate(model, [1.0, -2.0, 0.5], 0.5, EXACT, rate=20, **start)
    stiff = fd.simulate(model, [1.0, -2.0, 0.5], 0.5, fd.solvers.Rosenbrock(rtol=1e-8, atol=1e-9), rate=20, **start)
    assert np.abs(stiff.q - exact.q).max() < 1e-6
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        run = fd.simulate(model, [1.0, -2.0, 0.5], 0.5, fd.solvers.TimeStepping(step=step), rate=20, **start)
        errors.append(np.abs(run.q - exact.q).max())
    assert errors[-1] < 1e-2
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.15)


def test_a_model_file_keeps_the_choice(tmp_path: Path) -> None:
    """What was saved as full is loaded as full, and is the same model."""
    model = fd.load_model("ur5").replace(rotor_coupling="full")
    fd.save_model(model, tmp_path / "model.yaml")
    again = fd.load_model(tmp_path / "model.yaml")
    assert again.rotor_coupling == "full"
    assert again.joints == model.joints
    assert again != model.replace(rotor_coupling="reduced")
    assert "rotor_coupling: full" in (tmp_path / "model.yaml").read_text(encoding="utf-8")


def test_links_lighter_than_their_rotors_are_refused() -> None:
    """J2/N2^2 above what link 1 has of its own leaves no positive kinetic energy: one line says so."""
    arm = planar(0.2)
    with pytest.raises(
        fd.InputError, match=r"^robot\.rotor_coupling: the inertia of the links is smaller than .*; the URDF"
    ) as caught:
        fd.simulate(arm.model(), None, 0.1)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("solver", [fd.solvers.DormandPrince(), fd.solvers.TimeStepping(step=1e-3)])
def test_a_motion_without_kinetic_energy_stops(tmp_path: Path, solver: fd.solvers.Solver) -> None:
    """Where the rotors outweigh the links at another pose than the model's own, no motion is made up."""
    model = riding_model(too_light(), tmp_path)
    with pytest.raises((fd.InputError, fd.SimulationError)):
        fd.simulate(model, [0.0, 0.05, 0.1], 0.01, solver, q0=[0.0, 1.5, 0.0])


@pytest.mark.parametrize("value", ["half", "", None, True, 1, ["full"]])
def test_other_choices_are_refused(value: Any) -> None:
    """Reduced or full, and nothing else."""
    with pytest.raises(fd.InputError, match=r"^robot\.rotor_coupling: no such choice.*it is reduced or full$"):
        fd.FlexibleJointModel(fd.load_robot("scara_two_link"), rotor_coupling=value)


def test_the_oracles_agree_with_each_other() -> None:
    """Without spin the hand-derived planar arm is the paper's own."""
    links = TwoLink(stiffness=(30.0, 20.0), rotor=(0.2, 0.1), gravity=9.81)
    expected = links.derivative(START, TAU)
    found = planar(1e12).derivative(START, TAU)
    np.testing.assert_allclose(found, expected, atol=1e-9)
