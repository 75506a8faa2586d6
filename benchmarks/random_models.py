"""Models drawn at random: 1 to 8 joints of every kind, effects of the catalogue on them, a first state, a command.

`drawn(seed)` gives numbers that drives have; `drawn(seed, extreme=True)` springs up to 1e9 N m/rad on rotors down to
1e-9 kg m^2. The same seed gives the same problem on every machine.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn import effects as fx

Array = NDArray[np.float64]
Draw = np.random.Generator
KINDS = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ, pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ)
OFTEN = (0.25, 0.25, 0.25, 0.08, 0.08, 0.09)


@dataclass(frozen=True)
class Problem:
    """A run to be made.

    Attributes:
        model: the arm.
        command: what drives it, or None.
        start: first state, as `simulate` takes it.
        duration: [s].
    """

    model: fd.FlexibleJointModel
    command: Any
    start: dict[str, Any]
    duration: float

    def run(self, solver: Any, **more: Any) -> fd.Run:
        """Simulate it."""
        return fd.simulate(self.model, self.command, self.duration, solver, **self.start, **more)


def drawn(seed: int, *, extreme: bool = False, duration: float = 1.0) -> Problem:
    """The problem of a seed.

    Args:
        seed: any number.
        extreme: springs up to 1e9 N m/rad, rotors down to 1e-9 kg m^2.
        duration: [s].
    """
    rng = np.random.default_rng([29, seed, int(extreme)])
    count = int(rng.integers(1, 9))
    tree = _tree(rng, count)
    robot = fd.load_robot(tree, name=f"drawn{seed}{'x' if extreme else ''}")
    q0 = rng.uniform(-1.0, 1.0, robot.n)
    M = np.diag(pin.crba(tree, tree.createData(), q0))
    drives = {name: _drive(rng, float(M[j]), extreme) for j, name in enumerate(robot.joint_names)}
    gravity = (0.0, 0.0, -9.81) if rng.random() < 0.7 else (0.0, 0.0, 0.0)
    weight = np.abs(pin.computeGeneralizedGravity(tree, tree.createData(), q0)) + 0.5 * M
    found = [effect for j in range(robot.n) for effect in _effects(rng, robot.joint_names, j, drives, weight, extreme)]
    model = fd.FlexibleJointModel(robot, drives, found, gravity=gravity)
    start: dict[str, Any] = {"q0": q0, "v0": rng.uniform(-1.0, 1.0, robot.n) * (rng.random() < 0.7)}
    return Problem(model, _command(rng, model, q0, weight, M, duration), start, duration)


def _tree(rng: Draw, count: int) -> pin.Model:
    """A chain, sometimes with branches, of rods."""
    tree = pin.Model()
    tree.name = "drawn"
    for k in range(count):
        parent = k
        while parent > 0 and rng.random() < 0.1:
            parent = tree.parents[parent]  # a branch; Pinocchio wants all of one before the next
        length, mass = rng.uniform(0.1, 0.6), 10.0 ** rng.uniform(-0.7, 1.0)
        turn = pin.utils.rotate("xyz"[int(rng.integers(3))], float(rng.uniform(-np.pi, np.pi)))
        place = pin.SE3(turn, np.array([0.0, 0.0, length if k else 0.0]))
        kind = KINDS[int(rng.choice(len(KINDS), p=OFTEN))]
        joint = tree.addJoint(parent, kind(), place, f"joint{k}")
        across, along = mass * length**2 / 12.0, mass * (0.1 * length) ** 2 / 2.0
        body = pin.Inertia(mass, np.array([0.0, 0.0, 0.5 * length]), np.diag([across, across, along]))
        tree.appendBodyToJoint(joint, body, pin.SE3.Identity())
    return tree


def _drive(rng: Draw, inertia: float, extreme: bool) -> dict[str, float]:
    """Rotor, spring and damper of a joint that moves so much inertia [kg m^2]."""
    if rng.random() < 0.1:
        return {"rotor_inertia": inertia * 10.0 ** rng.uniform(-2.0, 0.0)}
    if extreme:
        rotor, stiffness = 10.0 ** rng.uniform(-9.0, -1.0), 10.0 ** rng.uniform(2.0, 9.0)
    else:
        rotor = inertia * 10.0 ** rng.uniform(-2.0, 0.5)
        stiffness = (2.0 * np.pi * 10.0 ** rng.uniform(0.3, 1.6)) ** 2 * inertia
    lighter = 1.0 / (1.0 / rotor + 1.0 / inertia)
    damping = 0.0 if rng.random() < 0.2 else 2.0 * 10.0 ** rng.uniform(-3.0, -0.3) * np.sqrt(stiffness * lighter)
    return {"rotor_inertia": rotor, "stiffness": stiffness, "damping": float(damping)}


def _command(rng: Draw, model: fd.FlexibleJointModel, q0: Array, weight: Array, inertia: Array, duration: float) -> Any:
    """Nothing, a torque that stays, a torque that swings, or a controller at 1 kHz on the motors."""
    kind = int(rng.integers(4))
    if kind == 0:
        return None
    size = weight * rng.uniform(-2.0, 2.0, model.n)
    if kind == 1:
        return [float(value) for value in size]
    t = np.linspace(0.0, duration, 101)
    wave = np.sin(2.0 * np.pi * rng.uniform(0.5, 5.0, model.n) * t[:, None])
    if kind == 2:
        return fd.Samples(t, size * wave, "linear" if rng.random() < 0.5 else "hold")
    # Of some 20 rad/s, well below what a controller at 1 kHz can hold.
    kp = 400.0 * (model.rotor_inertia + np.minimum(inertia, 5.0 * model.rotor_inertia))
    return fd.PD(fd.Samples(t, q0 + 0.2 * wave, "cubic"), kp=kp, kd=0.07 * kp)


def _presliding(rng: Draw, joint: str, side: Any, level: float, extreme: bool) -> fx.Effect:
    """Bristles that reach over 0.03 mrad to 3 mrad; extreme ones over as little as 0.1 microrad."""
    reach = 10.0 ** rng.uniform(-7.0 if extreme else -4.5, -2.5)
    damping = level * 10.0 ** rng.uniform(-2.0, 0.0) if rng.random() < 0.5 else 0.0
    return fx.PreslidingFriction(joint, side=side, level=level, stiffness=level / reach, damping=float(damping))


def _effects(
    rng: Draw,
    names: tuple[str, ...],
    j: int,
    drives: dict[str, dict[str, float]],
    weight: Array,
    extreme: bool,
) -> list[fx.Effect]:
    """Some of the catalogue's effects on a joint."""
    drive, torque, joint = drives[names[j]], float(weight[j]), names[j]
    K = drive.get("stiffness", np.inf)
    side: Any = "motor" if rng.random() < 0.6 else "link"

    def size(low: float = -2.0, high: float = -0.3) -> float:
        return torque * float(10.0 ** rng.uniform(low, high))

    def wide(low: float, high: float) -> float:
        return float(10.0 ** rng.uniform(low, high))

    make: dict[str, Callable[[], fx.Effect]] = {
        "viscous": lambda: fx.ViscousFriction(joint, side=side, coefficient=size()),
        "coulomb": lambda: fx.CoulombFriction(joint, side=side, level=size()),
        "asymmetric": lambda: fx.AsymmetricFriction(joint, side=side, level_positive=size(), level_negative=size()),
        "stribeck": lambda: fx.StribeckFriction(joint, side=side, excess=size(), velocity=wide(-3.0, -0.5)),
        "drag": lambda: fx.QuadraticDrag(joint, side=side, coefficient=size()),
        "position": lambda: fx.PositionDependentFriction(
            joint, side=side, amplitude=size(), harmonic=float(rng.integers(1, 20)), phase=float(rng.uniform(-3.0, 3.0))
        ),
        "presliding": lambda: _presliding(rng, joint, side, size(), extreme),
        "warm_up": lambda: fx.WarmUpFriction(joint, side=side, coefficient=size(), time_constant=wide(-1.0, 2.0)),
        "ripple": lambda: fx.TorqueRipple(
            joint, side="motor", amplitude=size(), harmonic=float(rng.integers(1, 60)), phase=float(rng.uniform(-3, 3))
        ),
        "speed_limit": lambda: fx.TorqueSpeedLimit(
            joint, side="motor", stall_torque=torque * wide(-0.5, 0.7), no_load_speed=wide(-0.5, 1.0)
        ),
        "saturation": lambda: fx.TorqueSaturation(joint, side="motor", scale=torque * wide(-0.5, 1.0)),
        "parallel_spring": lambda: fx.ParallelSpring(joint, side="link", stiffness=size(-1.0, 1.0), rest=0.1),
        "end_stop": lambda: fx.EndStop(
            joint, side="link", lower=-1.1, upper=1.1, stiffness=wide(2.0, 5.0) * torque, damping=size(-1.0, 1.5)
        ),
    }
    if np.isfinite(K):
        make |= {
            "load": lambda: fx.LoadDependentFriction(joint, side="motor", coefficient=wide(-2.0, -0.5)),
            "gear_loss": lambda: fx.DirectionalGearLoss(
                joint, side="motor", driving=wide(-2.0, -0.5), driven=wide(-2.0, -0.5)
            ),
            "hardening": lambda: fx.HardeningSpring(joint, side="transmission", cubic=K * wide(2.0, 5.0)),
            "backlash": lambda: fx.Backlash(joint, side="transmission", half_gap=wide(-4.5, -2.0)),
            "hysteresis": lambda: fx.SpringHysteresis(
                joint, side="transmission", stiffness=K * wide(-1.5, 0.0), width=wide(-4.5, -2.0)
            ),
            "error": lambda: fx.KinematicError(
                joint, side="transmission", amplitude=wide(-5.0, -3.0), harmonic=float(rng.integers(1, 30)), phase=0.3
            ),
        }
    chosen = [name for name in make if rng.random() < 0.12]
    return [make[name]() for name in chosen]
