"""Fit the servo's numbers to its motion from the goal alone, by CMA-ES.

    python benchmarks/measured/xl330/xl330_fit.py --data ../shared/data --start fitted.yaml -o fitted.yaml
    python benchmarks/measured/xl330/xl330_fit.py --data ../shared/data --gains 100 400 -o fitted_100_400.yaml

A run that sticks a tick earlier or later goes another way, so the error is no smooth function of the numbers, and a
search that needs no slopes does it. The cost is the mean absolute error over the logs. Source: N. Hansen, The CMA
Evolution Strategy: A Tutorial, arXiv 1604.00772.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from xl330_data import HERE, Log, errors, motor_of, read_logs

import flexdyn as fd

Array = NDArray[np.float64]
STEP = 0.2
"""First standard deviation of the search, of logarithms."""
OFFSET_SCALE = 0.01
"""Of the one number that may be negative, the torque of the tilted bench [N m]."""
EVALUATIONS = 4000
"""Of the cost, in one search."""
FAILED = 1.0
"""Cost of numbers that cannot be simulated [rad]."""


def model_of(x: Array, plain: fd.FlexibleJointModel) -> fd.FlexibleJointModel:
    """The model of a point of the search: logarithms, but for the last."""
    stall, induced, rotor, stiffness, damping, viscous, dry, excess, velocity, *rest = np.exp(x[:-1])
    driving, driven, more, held, creep, scale = rest
    constant = induced / stall  # of the torque per volt kt/R and the back-EMF kt^2/R
    motor = fd.DCMotor(torque_constant=constant, resistance=constant / stall, supply=7.4)
    e = fd.effects
    laws = [
        e.TorqueSaturation("servo", scale=scale),
        e.ViscousFriction("servo", side="motor", coefficient=viscous),
        e.CoulombFriction("servo", side="motor", level=dry),
        e.StribeckFriction("servo", side="motor", excess=excess, velocity=velocity),
        e.DirectionalGearLoss("servo", driving=driving, driven=driven),
        e.StribeckGearLoss("servo", driving=more, driven=held, velocity=creep),
        e.PositionTorque("servo", cos_1=OFFSET_SCALE * x[-1], sin_1=0.0, cos_2=0.0, sin_2=0.0),
    ]
    drive = {
        "rotor_inertia": rotor,
        "stiffness": stiffness,
        "damping": damping,
        "actuator": fd.Actuator(dc_motor=motor),
    }
    return plain.replace(joints={"servo": drive}, effects=laws)


def point_of(model: fd.FlexibleJointModel) -> Array:
    """The point of the search that a fitted model is at."""
    joint, laws = model.joints["servo"], {each.name: each for each in model.effects}
    motor = motor_of(model)
    kt, R = motor.torque_constant, motor.resistance
    numbers = [kt / R, kt * kt / R, joint.rotor_inertia, joint.stiffness, joint.damping]
    for name in ("viscous_friction", "coulomb_friction"):
        numbers += laws[name].values
    numbers += laws["stribeck_friction"].values[:2]
    numbers += [*laws["directional_gear_loss"].values, *laws["stribeck_gear_loss"].values]
    numbers += laws["torque_saturation"].values
    return np.append(np.log(numbers), laws["position_torque"].values[0] / OFFSET_SCALE)


def guess() -> fd.FlexibleJointModel:
    """Where a search starts that nobody helps: the data sheet, and friction of the size of its stall torque."""
    plain = fd.load_model(HERE / "plain.yaml")
    x = np.log([0.104, 0.037, 2e-3, 40.0, 0.05, 0.01, 0.01, 0.02, 0.3, 0.4, 0.1, 0.3, 0.3, 0.3, 2.0])
    return model_of(np.append(x, 0.0), plain)


def search(cost: Callable[[Array], float], x: Array, evaluations: int, step: float = STEP) -> Array:
    """The best point that CMA-ES with rank-one and rank-mu updates comes by.

    Args:
        cost: to be least.
        x: where to start.
        evaluations: of the cost.
        step: first standard deviation.
    """
    draw = np.random.default_rng(0)
    n, many = len(x), 4 + 2 * int(3 * np.log(len(x)))
    w = np.log(many // 2 + 0.5) - np.log(np.arange(1, many // 2 + 1))
    w /= w.sum()
    mu = 1.0 / (w**2).sum()
    cc, cs = (4 + mu / n) / (n + 4 + 2 * mu / n), (mu + 2) / (n + mu + 5)
    c1, cm = 2 / ((n + 1.3) ** 2 + mu), 2 * (mu - 2 + 1 / mu) / ((n + 2) ** 2 + mu)
    damp = 1 + 2 * max(0.0, np.sqrt((mu - 1) / (n + 1)) - 1) + cs
    C, pc, ps = np.eye(n), np.zeros(n), np.zeros(n)
    best, least = x, cost(x)
    for _ in range(evaluations // many):
        sizes, axes = np.linalg.eigh(C)
        sizes = np.sqrt(np.maximum(sizes, 1e-20))
        moves = (draw.standard_normal((many, n)) * sizes) @ axes.T
        costs = np.array([cost(x + step * move) for move in moves])
        order = np.argsort(costs)
        if costs[order[0]] < least:
            best, least = x + step * moves[order[0]], float(costs[order[0]])
            print(f"{1e3 * least:.2f} mrad", flush=True)
        chosen = moves[order[: len(w)]]
        y = w @ chosen
        x = x + step * y
        ps = (1 - cs) * ps + np.sqrt(cs * (2 - cs) * mu) * (axes @ ((axes.T @ y) / sizes))
        pc = (1 - cc) * pc + np.sqrt(cc * (2 - cc) * mu) * y
        C = (1 - c1 - cm) * C + c1 * np.outer(pc, pc) + cm * (chosen.T * w) @ chosen
        step *= float(np.exp(cs / damp * (np.linalg.norm(ps) / np.sqrt(n) - 1)))
    return best


def fitted(
    logs: list[Log], start: fd.FlexibleJointModel, evaluations: int, step: float = STEP
) -> fd.FlexibleJointModel:
    """The model with the least mean error over some logs."""
    plain = fd.load_model(HERE / "plain.yaml")

    def cost(x: Array) -> float:
        try:
            found = float(errors(model_of(x, plain), logs).mean())
        except fd.FlexdynError:
            return FAILED
        return found if np.isfinite(found) else FAILED

    return model_of(search(cost, point_of(start), evaluations, step), plain)


def main() -> None:
    """Fit, and write the model."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-o", type=Path, required=True, help="the model file, in this folder")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    parser.add_argument("--gains", type=int, nargs="+", default=[100, 200, 400, 800], help="of the logs to fit")
    parser.add_argument("--start", type=Path, help="model to start from; default: the data sheet and a guess")
    parser.add_argument("--evaluations", type=int, default=EVALUATIONS)
    parser.add_argument("--step", type=float, default=STEP, help="first standard deviation of the logarithms")
    options = parser.parse_args()
    logs = [log for log in read_logs(options.data / "bam_xl330") if log.gain in options.gains]
    start = guess() if options.start is None else fd.load_model(options.start)
    fd.save_model(fitted(logs, start, options.evaluations, options.step), options.o)


if __name__ == "__main__":
    main()
