"""Whether the recordings of a case show what is hidden, by a filter around the simulator that knows all the rest.

A stop that is never met and a limit that is never reached cannot be found, and a name needs both recordings: no data
confirms what it does not show.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from arm_draw import JOINTS, TwoLinkArm
from hidden import Hidden
from layout import Array
from observer import DISC, DISC_HARMONIC, DISC_PHASE, LAG, SENSOR_GAIN, SENSOR_OFFSET, STEP, Filter, design, innovations
from plants import Case, true_plant
from recording import read
from score import INSEPARABLE
from two_link_run import Truth

FAR = 1e6
SENSOR_COLUMNS = {
    "channel_lag": {"delay": LAG},
    "encoder_eccentricity": {"amplitude": DISC, "harmonic": DISC_HARMONIC, "phase": DISC_PHASE},
    "sensor_gain": {"gain": SENSOR_GAIN},
    "sensor_offset": {"offset": SENSOR_OFFSET},
}


def visible(case: Case, one: Hidden) -> bool:
    """Whether both recordings are less likely without it, by more than inseparable laws differ.

    A joint that is taken for rigid is no part of the arm that could be left out. In the ordinary families, which stay
    as they were, wrong numbers and all that is hidden in arms with rigid joints are taken to show.
    """
    if one.effect == "joint_elasticity":
        return True
    if not case.wide and (one.effect == "parameter_error" or np.isinf(case.arm.stiffness).any()):
        return True
    found, others = make_filter(case), [each for each in case.hidden if each is not one]
    for run in (case.fit, case.check):
        z = reported(case, run)
        known, less = (surprises(run, z, case.arm, laws, found) for laws in (case.hidden, others))
        if float((less**2).sum() - (known**2).sum()) < INSEPARABLE * case.sensors.every:
            return False
    return True


def make_filter(case: Case) -> Filter:
    """The filter of a case."""
    sensors = case.sensors
    seen = _seen(case)
    steps = np.array([sensors.link_step()] * 2 + [sensors.motor_step(N) for N in case.arm.gear_ratio])[seen]
    peak = np.abs(case.fit.tau).max(axis=0)
    return design(case.arm.plant(), np.array(case.arm.middle), steps, peak, sensors.noise, seen)


def reported(case: Case, run: Truth) -> Array:
    """What the encoders would report of a run without steps (samples, m)."""
    columns = []
    for i in _seen(case):
        name = f"{'q' if i < 2 else 'theta'}.{JOINTS[i % 2]}"
        columns.append(read(run.y[:, i], [e for e in case.hidden if e.place.get("channel") == name]))
    return np.stack(columns, axis=1)


def surprises(run: Truth, z: Array, arm: TwoLinkArm, hidden: Sequence[Hidden], found: Filter) -> Array:
    """White prediction errors of an arm with these effects along a run, of which z is seen (samples, m)."""
    plant, table = true_plant(arm, hidden), sensor_table(hidden)
    began = first_state(run.y[0], z[0], table, found.seen)
    errors = innovations(began, z, run.tau, plant.P, plant.links, found.gain, found.seen, table, STEP)
    return np.asarray(np.clip(np.nan_to_num(errors @ found.whiten.T, nan=FAR), -FAR, FAR))


def sensor_table(hidden: Sequence[Hidden]) -> Array:
    """Errors of the encoders q1, q2, theta1, theta2 (4, 6)."""
    table = np.zeros((4, 6))
    for one in hidden:
        for key, column in SENSOR_COLUMNS.get(one.effect, {}).items():
            row = (one.joint or 0) + (2 if one.place["channel"].startswith("theta") else 0)
            table[row, column] = one.parameters[key]
    return table


def first_state(y: Array, z: Array, table: Array, seen: Array) -> Array:
    """The true first state with its positions where the encoders, as wrong as they are taken to be, say they are."""
    began = y.copy()
    for i, value in zip(seen.tolist(), z.tolist(), strict=True):
        disc = table[i, DISC] * np.sin(table[i, DISC_HARMONIC] * y[i] + table[i, DISC_PHASE])
        began[i] = (value - table[i, SENSOR_OFFSET]) / (1.0 + table[i, SENSOR_GAIN]) - disc
        if (i + 2) % 4 not in seen:
            began[(i + 2) % 4] += began[i] - y[i]
    return began


def _seen(case: Case) -> Array:
    """Positions that are measured; of a rigid joint, whose rotor has none of its own, the link's."""
    seen = {"both": [0, 1, 2, 3], "motor": [2, 3], "link": [0, 1]}[case.sensors.positions]
    return np.array([i for i in seen if i < 2 or np.isfinite(case.arm.stiffness[i - 2])])
