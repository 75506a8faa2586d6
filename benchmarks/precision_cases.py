"""The four arms of work_precision.py, and everybody who moves them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin
from arms import Arm, Array, two_link
from hybrid_truth import TwoLinkWithCorners
from measure import Contestant
from mujoco import set_mju_user_warning
from mujoco_arm import MujocoArm
from mujoco_friction import harden
from pinocchio_arm import PinocchioArm
from same_problem import flexdyn_positions

import flexdyn as fd

SAMPLES = 50
BUDGET = 100_000  # evaluations in Python after which a peer gives up: 1 to 2 s
TOLERANCES: Array = np.logspace(-2.0, -12.0, 11)


@dataclass(frozen=True, eq=False)
class Case:
    """An arm, how long it moves, and the play in its gears.

    Attributes:
        title: of the figure.
        arm: with its laws.
        duration: [s].
        steps: of the fixed-step methods [s].
    """

    title: str
    arm: Arm
    duration: float
    steps: Array

    @property
    def grid(self) -> Array:
        """Times at which positions are compared [s]."""
        return np.linspace(0.0, self.duration, SAMPLES + 1)

    @property
    def half_gap(self) -> Array:
        """Of every gear [rad]."""
        return self.arm.coefficients("backlash", "transmission")

    @property
    def dry(self) -> bool:
        """Whether there is dry friction."""
        return bool(self.arm.coefficients("coulomb_friction", "link").any())

    def truth(self, max_step: float = 5e-3) -> tuple[Array, int]:
        """Positions on the grid from the equations written out by hand, and how many corners were passed."""
        model, arm = self.arm.model, self.arm
        equations = TwoLinkWithCorners(
            stiffness=np.array(model.stiffness),
            damping=np.array(model.damping),
            rotor=np.array(model.rotor_inertia),
            viscous=arm.coefficients("viscous_friction", "link"),
            level=arm.coefficients("coulomb_friction", "link"),
            half_gap=self.half_gap,
            tau=arm.tau,
        )
        return equations.positions(np.concatenate([arm.q0, arm.theta0, np.zeros(4)]), self.grid, max_step)


def cases() -> dict[str, Case]:
    """By the name of the figure's file."""
    smooth = two_link()
    names = smooth.model.joint_names
    springs = {"*": {"stiffness": 40.0, "damping": 0.1}}
    dry: list[fd.effects.Effect] = [
        fd.effects.CoulombFriction(name, side="link", level=level)
        for name, level in zip(names, (0.5, 0.15), strict=True)
    ]
    gaps: list[fd.effects.Effect] = [fd.effects.Backlash(name, half_gap=0.02) for name in names]
    bent: dict[str, Any] = {"tau": np.array([0.6, -0.2]), "q0": np.array([0.0, 1.0]), "theta0": np.array([0.3, 1.3])}
    stiff = smooth.model.replace(joints={"*": {"stiffness": 1e7, "damping": 70.0}})
    wound = bent | {"theta0": bent["q0"] + bent["tau"] / 1e7}
    halves: Array = np.logspace(0.0, -13.0, 14, base=2.0)
    return {
        "smooth": Case("smooth arm, K = 5.5 N m/rad, 5 s", smooth, 5.0, 0.05 * halves),
        "stick_slip": Case(
            "stick-slip arm, K = 40 N m/rad, 2 s", _with(smooth, springs, dry, bent), 2.0, 0.02 * halves
        ),
        "backlash": Case("backlash arm, K = 40 N m/rad, 2 s", _with(smooth, springs, gaps, bent), 2.0, 0.02 * halves),
        "stiff": Case(
            "stiff arm, K = 1e7 N m/rad, 1 s",
            replace(smooth, model=stiff, **wound),
            1.0,
            0.02 * halves,
        ),
    }


def _with(
    arm: Arm, joints: dict[str, dict[str, float]], effects: list[fd.effects.Effect], start: dict[str, Any]
) -> Arm:
    return replace(arm, model=arm.model.replace(joints=joints, effects=[*arm.model.effects, *effects]), **start)


class CorneredArm(PinocchioArm):
    """The arm as a SciPy user writes it: a dead zone by np.clip, dry friction by tanh, a limit on the evaluations.

    Args:
        case: the arm.
        eps: width of tanh(v/eps) [rad/s].
    """

    def __init__(self, case: Case, eps: float) -> None:
        super().__init__(case.arm)
        self.gap, self.level, self.eps = case.half_gap, case.arm.coefficients("coulomb_friction", "link"), eps
        self.plain, self.evaluations = not (self.gap.any() or self.level.any()), 0

    def derivative(self, t: float, x: Array) -> Array:
        """X' = f(x)."""
        self.evaluations += 1
        if self.evaluations > BUDGET:
            raise RuntimeError("it takes too long")
        if self.plain:
            return super().derivative(t, x)
        n = self.arm.n
        q, theta, v, omega = x[:n], x[n : 2 * n], x[2 * n : 3 * n], x[3 * n :]
        delta = theta - q
        tau_s = self.K * (delta - np.clip(delta, -self.gap, self.gap)) + self.D * (omega - v)
        load = tau_s - self.on_link * v - self.level * np.tanh(v / self.eps)
        a = pin.aba(self.model, self.data, q, v, load)
        return np.concatenate([v, omega, a, (self.arm.tau - tau_s - self.on_rotor * omega) / self.J])


@dataclass(frozen=True, eq=False)
class Setting:
    """One method at one setting.

    Attributes:
        method: whose curve it belongs to.
        value: step [s] or tolerance.
        positions: runs it: [q, theta] on the case's grid.
        setup: what of the run is not the motion.
    """

    method: str
    value: float
    positions: Callable[[], Array]
    setup: Callable[[], object] | None = None

    @property
    def contestant(self) -> Contestant:
        """For a race."""
        return Contestant(f"{self.method} @ {self.value:.3g}", self.positions, setup=self.setup)


def ours(case: Case) -> list[Setting]:
    """Flexdyn's four solvers at all their settings; building the model is taken off, as MuJoCo's compiling is."""
    solvers: list[tuple[str, float, fd.solvers.Solver]] = []
    for h in case.steps:
        smoothing = 10.0 * h if case.dry else None
        solvers.append(("RungeKutta4", h, fd.solvers.RungeKutta4(step=h, smoothing=smoothing)))
        solvers.append(("TimeStepping", h, fd.solvers.TimeStepping(step=h)))
    for rtol in TOLERANCES:
        solvers.append(("DormandPrince", rtol, fd.solvers.DormandPrince(rtol=rtol, atol=rtol)))
        solvers.append(("Rosenbrock", rtol, fd.solvers.Rosenbrock(rtol=rtol, atol=rtol)))
    return [_our_setting(case, *each) for each in solvers]


def _our_setting(case: Case, name: str, value: float, solver: fd.solvers.Solver) -> Setting:
    def run() -> Array:
        return flexdyn_positions(case.arm, solver, case.grid)

    def setup() -> object:
        return flexdyn_positions(case.arm, solver, case.grid * 1e-9)

    return Setting(f"flexdyn {name}", value, run, setup)


def mujoco(case: Case) -> list[Setting]:
    """MuJoCo's integrators over steps; a gap is the dead band of the tendon's spring.

    A step too long for the arm makes MuJoCo warn and start again; its error tells that, a log file is not needed.
    """
    set_mju_user_warning(lambda text: None)
    found = []
    for integrator in ("Euler", "implicitfast", "RK4"):
        for h in case.steps:
            between = max(1, round(case.duration / SAMPLES / h))
            step = case.duration / SAMPLES / between
            peer = MujocoArm(case.arm, integrator, step)
            if case.dry:
                harden(peer, step)
            peer.model.tendon_lengthspring[:] = np.column_stack([-case.half_gap, case.half_gap])
            found.append(Setting(f"MuJoCo {integrator}", step, partial(peer.positions, SAMPLES, between)))
    return found


def scipy(case: Case) -> list[Setting]:
    """SciPy's methods over pin.aba; dry friction is smoothed as finely as the tolerance asks for."""
    found = []
    for method in ("DOP853", "LSODA", "Radau"):
        for rtol in TOLERANCES[1:]:

            def run(method: str = method, rtol: float = rtol) -> Array:
                return CorneredArm(case, rtol).scipy_positions(method, case.grid, rtol, rtol)

            found.append(Setting(f"SciPy {method}", rtol, run))
    return found
