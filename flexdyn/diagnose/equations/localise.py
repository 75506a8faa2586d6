"""The place of the gap: the equation and the regime, and the pictures of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_LEVEL_ERROR
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, SENSOR, TRANSMISSION
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.regime import Quantity, regime
from flexdyn.diagnose.report.measures import ResidualPlace
from flexdyn.diagnose.report.trace import ResidualTrace

POWER_BLOCK = 0.025
"""Length of the blocks whose power is compared [s]."""
LEAST_SHARE = 0.01
"""Places with a smaller share of the excess are left out [1]."""
SIDE_OF_EQUATION = {
    "motor": "motor side",
    "link": "link side",
    "total": "motor and link together",
    "transmission": "between motor and link",
    "sensor": "torque sensor",
}


def localise(equations: Equations, white: Array, mask: Flags) -> tuple[ResidualPlace, ...]:
    """Share of the gap and regime of every equation, the largest share first.

    Normalised residuals are used: with a stiff spring, the noise of the encoders is large in both equations of a
    joint and would hide in which of them a torque is missing.

    Only residuals beyond chance count; if there are none, there are no places.

    Args:
        equations: of the model, usually the calibrated one before the findings.
        white: its whitened residuals after the offsets of the encoders are fitted (rows,):
            ``fit.regression.left[: len(mask)]``.
        mask: rows that are not used (rows,).
    """
    many = len(equations.kinds)
    power = white.reshape(-1, many) ** 2
    seen = ~mask.reshape(-1, many)
    rows = seen.sum(axis=0)
    excess = ((power - 1.0) * seen).sum(axis=0)
    excess = np.where(excess > np.maximum(CERTAIN_SIGMAS * np.sqrt(2.0 * rows), NOISE_LEVEL_ERROR * rows), excess, 0.0)
    if not excess.any():
        return ()
    shares = excess / excess.sum()
    found = []
    for place in np.argsort(-shares):
        if shares[place] < LEAST_SHARE:
            break
        j, kind = equations.kinds[place]
        where = _regime(equations, int(place), power[:, place], seen[:, place])
        found.append(ResidualPlace(equations.true.joint_names[j], kind, float(shares[place]), where))
    return tuple(found)


def _regime(equations: Equations, place: int, power: Array, seen: Flags) -> str:
    """The regime of one equation: rows are combined to blocks, without masked rows."""
    j, kind = equations.kinds[place]
    blocks: list[Array] = []
    columns: list[list[Quantity]] = []
    parts = map(equations.by_recording, (power, seen.astype(float)))
    for along, own, used in zip(equations.motions, *parts, strict=True):
        at = equations.filters.instants(len(along.t))
        width = max(1, round(POWER_BLOCK / (along.dt * equations.filters.every)))
        blocks.append(_block_means(own, used, width))
        columns.append(
            [
                replace(e, values=_block_means(e.values[at], used, width))
                for e in _quantities_of_rests(equations, along, j, kind)
            ]
        )
    joined = [replace(same[0], values=np.concatenate([e.values for e in same])) for same in zip(*columns, strict=True)]
    return regime(np.concatenate(blocks), joined)


def _block_means(x: Array, used: Array, width: int) -> Array:
    """Means over the used ones of so many neighbours (blocks,), of which at least half are used."""
    values, weight = (each[: len(x) // width * width].reshape(-1, width).sum(axis=1) for each in (x * used, used))
    kept = weight >= 0.5 * width
    return np.asarray(values[kept] / weight[kept])


def _quantities_of_rests(equations: Equations, along: SmoothedMotion, j: int, kind: str) -> Iterator[Quantity]:
    """Quantities on which an equation's residual may depend, over the samples of a motion (samples,)."""
    model = equations.true
    angle, torque = model.robot.angle_unit(j), model.robot.torque_unit(j)
    x, u, name = (along.q, along.v, "v") if kind in (LINK, SENSOR) else (along.theta, along.omega, "omega")
    yield Quantity(f"abs({name}) {{}} {angle}/s", np.abs(u[:, j]))
    yield Quantity(f"{{}} {angle} after a reversal", _travelled(x[:, j], u[:, j]))
    yield Quantity(f"{name} {{}}", u[:, j], signed=True)
    carried = (
        model.stiffness[j] * along.delta[:, j]
        if equations.kinds.count((j, LINK)) or equations.replayed[j]
        else along.inverse_dynamics[:, j]
    )
    yield Quantity(f"abs(tau_s) {{}} {torque}", np.abs(carried))
    yield Quantity(f"q {{}} {angle}", along.q[:, j])
    yield Quantity("t {} s", along.t)
    for i, other in enumerate(model.joint_names):
        if i != j:
            yield Quantity(
                f"abs({name} of {other}) {{}} {model.robot.angle_unit(other)}/s",
                np.abs((along.v if name == "v" else along.omega)[:, i]),
            )


def _travelled(x: Array, u: Array) -> Array:
    """Distance since the last reversal (samples,) [rad or m]."""
    turns = np.concatenate([[True], (u[1:] * u[:-1] < 0.0)])
    last = np.maximum.accumulate(np.where(turns, np.arange(len(x)), 0))
    return np.asarray(np.abs(x - x[last]))


def traces(before: Equations, after: Equations, mask: Flags) -> tuple[ResidualTrace, ...]:
    """Residual torques of every equation over time, velocity and position, before and after.

    Args:
        before: of the model as it was given.
        after: of the corrected model, over the same recordings.
        mask: rows that are not used (rows,).

    Returns:
        Three pictures for each equation: the first recording over time, all recordings over velocity and position.
    """
    many = len(before.kinds)
    shown, hidden = before.residual.reshape(-1, many), mask.reshape(-1, many)
    left = after.residual.reshape(-1, many)
    stacked = {name: before.at_rows(name) for name in ("t", "q", "theta", "v", "omega")}
    rows = before.counts[0]
    pictures = []
    for place, (j, kind) in enumerate(before.kinds):
        joint = before.true.joint_names[j]
        angle = before.true.robot.angle_unit(joint)
        unit = f"residual torque [{before.true.robot.torque_unit(joint)}]"
        title, unit = (
            f"{joint}, {SIDE_OF_EQUATION[kind]}",
            f"residual deflection [{angle}]" if kind == TRANSMISSION else unit,
        )
        link = kind in (LINK, SENSOR)
        clear = ~hidden[:, place]
        one, two = (np.where(clear, each[:, place], np.nan) for each in (shown, left))
        pictures.append(ResidualTrace.thinned(title, "t [s]", unit, stacked["t"][:rows], one[:rows], two[:rows]))
        for name, label in (("v" if link else "omega", f"{angle}/s"), ("q" if link else "theta", angle)):
            x = stacked[name][:, j]
            pictures.append(ResidualTrace.thinned(title, f"{name} [{label}]", unit, x[clear], one[clear], two[clear]))
    return tuple(pictures)
