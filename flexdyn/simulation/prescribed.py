"""What moves behind a spring whose other end is moved as recorded: the one place that replays a prescribed motion."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect, JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.at_time import at_time, is_timed
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import STIFF, core_settings, fastest_rate
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock

HEAVY = 1e16
"""Inertia of what is moved as recorded [kg m^2 or kg], times that of a metre or a radian at 1 N m: a force of 1e5 N
moves it by less than 1e-9 m in ten seconds, and 16 digits still tell its motion."""
RTOL, ATOL = 1e-6, 1e-9
"""Of the simulation. Two that differ little take the same steps: differences over 1e-5 of a number are right to some
1e-3."""
EVALUATIONS_PER_SECOND = 2_000_000
"""Evaluations of the equations for each second, after which a simulation has failed [1/s]."""


def links_behind(
    model: FlexibleJointModel,
    joints: Sequence[int],
    t: Array,
    course: Array,
    first: Array,
    speeds: Array | None = None,
) -> Array:
    """Positions of links whose rotors are moved as recorded, by simulation.

    What is moved has so much inertia that no force disturbs it (the large mass method: Clough and Penzien, Dynamics of
    Structures, 1975, of supports that are moved), and gets the force that takes it along the spline through the record.
    Joints that are not simulated are held on their recorded motion likewise. No recorded force is read.

    Args:
        model: resolved.
        joints: elastic ones whose links are simulated.
        t: times since the start of the run (samples,) [s].
        course: positions of the rotors of `joints`, and of the links of all others (samples, n) [rad or m].
        first: positions of the links at the first sample (n,).
        speeds: velocities of the links there (n,) [rad/s or m/s]; None: those of the course.

    Returns:
        positions of all links (samples, n) [rad or m]; NaN from where the simulation failed.
    """
    from scipy.interpolate import CubicSpline

    heavy = _heavy(model, joints)
    if any(is_timed(effect) for effect in heavy.all_effects):
        heavy = at_time(heavy, float(t[0]))
    plant = build_plant(heavy)
    spline, times = CubicSpline(t, course), np.ascontiguousarray(t - t[0])
    bend = spline(t, 2)
    pull = np.stack([bend[:-1], np.diff(bend, axis=0) / np.diff(t)[:, None]], axis=1) * HEAVY
    command = _core.open_loop(_core.signal(times, np.ascontiguousarray(pull), np.ascontiguousarray(bend[-1] * HEAVY)))
    speed, elastic = spline(t[0], 1), np.flatnonzero(heavy.elastic)
    q0 = np.where(heavy.elastic, first, course[0])
    v0 = speed if speeds is None else np.where(heavy.elastic, speeds, speed)
    x0 = np.concatenate([q0, course[0, elastic], v0, speed[elastic]])
    x0 = np.ascontiguousarray(np.pad(x0, (0, plant.state_size - len(x0))))
    stiff = fastest_rate(plant, x0) > STIFF
    solver = Rosenbrock(rtol=RTOL, atol=ATOL) if stiff else DormandPrince(rtol=RTOL, atol=ATOL)
    settings = core_settings(solver, math.ceil(EVALUATIONS_PER_SECOND * max(times[-1], 1.0)))
    out = np.full((len(SIGNALS), len(t), model.n), np.nan)
    z = np.full((len(t), plant.internal_states), np.nan)
    job = _core.job(plant, command, [], x0, float(times[-1]), settings, times, [*out, z], None)
    with contextlib.suppress(Exception):  # as of a user's law: what was not reached stays NaN
        _core.simulate(job, None)
    return np.asarray(out[0])


def _heavy(model: FlexibleJointModel, joints: Sequence[int]) -> FlexibleJointModel:
    """The model with all rotors heavy, elastic at the joints that are simulated and there alone."""
    names = [model.joint_names[j] for j in joints]
    others = {name: {"stiffness": math.inf, "damping": 0.0} for name in model.joint_names if name not in names}
    ratios = {name: joint.gear_ratio for name, joint in model.joints.items()}
    rotors = {name: {"rotor_inertia": HEAVY / ratio**2, "actuator": None} for name, ratio in ratios.items()}
    kept = [effect for effect in model.all_effects if _acts_behind(effect, names)]
    numbers = {name: {**rotors[name], **others.get(name, {})} for name in rotors}
    return model.replace(joints=numbers, effects=kept, urdf_dynamics="ignore", rotor_coupling="reduced", tolerance=0.0)


def _acts_behind(effect: Effect, names: Sequence[str]) -> bool:
    """Whether an effect does something to links that are simulated: beyond the rotor, or on the arm as a whole."""
    if not isinstance(effect, JointEffect):
        return effect.stage == "inertia"
    return effect.joint in names and effect.side != "motor"
