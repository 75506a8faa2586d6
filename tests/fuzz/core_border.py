"""What reaches the compiled core through Python: shapes, kinds and sizes of numbers that no caller should give."""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import flexdyn as fd

LENGTHS = (0, 1, *(2,) * 12, 3, 7)
KINDS = ("f8", "f8", "f8", ">f8", "f4", "i1", "u8", "c16", "bool", "O", "U3", "M8[s]", "g")
NUMBERS = (0.0, -0.0, 1.0, -1.0, 1e-3, 1e3, 1e-12, 1e15, 1e-300, 1e300, 5e-324, 1.7e308, np.nan, np.inf, -np.inf)
STRANGE: tuple[Any, ...] = (None, "x", "equilibrium", {}, {"elbow": 1.0}, {"x": 1.0}, {"elbow": None}, [], [[]])
STRANGE += (
    10**400,
    object(),
    True,
    b"1",
    1j,
    np.ma.masked,
    [1.0, None],
    ["1", "2"],
    [np.nan, 0.0],
    lambda: 0,
    slice(3),
)
STEPS = (1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)
STIFFNESS = (0.0, 1e-12, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15)


def run(folder: Path, data: bytes) -> None:
    """Draw one call and make it.

    Raises:
        FlexdynError: it was refused.
        AssertionError: it was answered by numbers that are not finite.
    """
    rng = random.Random(data)
    rng.choice(CALLS)(rng)


def array(rng: random.Random) -> Any:
    """An array that may fit, or anything else."""
    if rng.random() < 0.1:
        return rng.choice((*STRANGE, *NUMBERS))
    shape = tuple(rng.choice(LENGTHS) for _ in range(rng.choice((*(1,) * 12, 0, 2, 3))))
    values = np.full(shape, rng.choice(NUMBERS) if rng.random() < 0.1 else rng.uniform(-1, 1))
    if values.size and rng.random() < 0.1:
        values.flat[rng.randrange(values.size)] = rng.choice(NUMBERS)
    with np.errstate(all="ignore"):
        made = values.astype(rng.choice(KINDS) if rng.random() < 0.15 else "f8")
    layout = rng.random()
    if layout < 0.1 and made.ndim:
        return np.repeat(made, 2, axis=0)[::2]
    return made[::-1] if layout < 0.2 and made.ndim else np.asfortranarray(made) if layout < 0.3 else made


def number(rng: random.Random, *fitting: float) -> float:
    """One of those that fit; of twenty, one that may not."""
    return rng.choice(fitting if rng.random() < 0.95 else NUMBERS)


@cache
def arm() -> fd.FlexibleJointModel:
    """A shipped arm of two joints."""
    return fd.load_model("scara_two_link")


def model(rng: random.Random) -> fd.FlexibleJointModel:
    """The arm with joints from none to extremely stiff."""
    if rng.random() < 0.3:
        return arm()
    joint = {
        "rotor_inertia": number(rng, 1e-9, 1e-3, 0.1, 1e6),
        "stiffness": number(rng, *STIFFNESS),
        "damping": number(rng, 0.0, 1.0, 1e6),
        "gear_ratio": number(rng, 1.0, 100.0),
    }
    effects = []
    if rng.random() < 0.3:
        level = number(rng, 0.0, 0.1, 1e6)
        effects = [fd.effects.CoulombFriction("elbow", side=rng.choice(("link", "motor")), level=level)]
    return fd.FlexibleJointModel(arm().robot, {"*": joint}, effects)


def run_of(rng: random.Random) -> tuple[fd.FlexibleJointModel, Any, float]:
    """A model, a solver, and how long it may be asked to run: no more than some thousand steps."""
    arm, step = model(rng), number(rng, *STEPS)
    duration = rng.choice((step, 3 * step, 1000 * step, 0.5 * step, number(rng, step)))
    kind = rng.choice(("TimeStepping", "RungeKutta4", "DormandPrince"))
    if kind == "DormandPrince":
        # Its steps follow the fastest rate of the model, by the spring or by the damper.
        rates = [max((j.stiffness / j.rotor_inertia) ** 0.5, j.damping / j.rotor_inertia) for j in elastic(arm)]
        return arm, fd.solvers.DormandPrince(rtol=number(rng, 1e-6, 1e-3)), min(duration, 100 / max([1e3, *rates]))
    return arm, getattr(fd.solvers, kind)(step=step), duration if duration <= 5000 * step else 1000 * step


def calm(values: Any) -> Any:
    """What was drawn, no number of it larger than 3."""
    return np.clip(values, -3.0, 3.0) if isinstance(values, np.ndarray) and values.dtype.kind == "f" else values


def elastic(arm: fd.FlexibleJointModel) -> list[fd.Joint]:
    """The joints that are not rigid."""
    return [joint for joint in arm.joints.values() if joint.rotor_inertia and np.isfinite(joint.stiffness)]


def simulated(rng: random.Random) -> None:
    """One run from hostile first states under a hostile command."""
    arm, settings, duration = run_of(rng)
    starts = {name: array(rng) for name in ("q0", "v0", "theta0", "omega0") if rng.random() < 0.3}
    if isinstance(settings, fd.solvers.DormandPrince):  # how fast it starts tells how many steps it takes
        starts = {"q0": calm(starts["q0"])} if "q0" in starts else {}
    command = array(rng) if rng.random() < 0.5 else None
    rate = number(rng, 1000.0, 1.0) if duration < 0.1 else 10.0
    times = array(rng) if rng.random() < 0.1 else None
    run = fd.simulate(arm, command, duration, settings, rate=rate, times=times, **starts)
    finite(run.q, run.v, run.theta, run.omega, run.tau_s)


def many(rng: random.Random) -> None:
    """Several runs at once, some of them refused."""
    first, settings, duration = run_of(rng)
    runs = fd.simulate_many([first, arm()], array(rng), duration, settings, q0=calm(array(rng)), threads=1)
    for each in runs:
        if isinstance(each, fd.Run):
            finite(each.q, each.theta)


def recorded(rng: random.Random) -> None:
    """A recording of hostile arrays, and what is worked out of it."""
    t = np.arange(2.0) * rng.choice((1.0, 1e-9, 1e15)) if rng.random() < 0.8 else array(rng)
    made = fd.Recording(t, {rng.choice(("q.a", "v.b", "x", "<b>", "")): array(rng) for _ in range(2)})
    fd.write_recording(made, "core.npz")
    assert fd.read_recording("core.npz") == made


def analysed(rng: random.Random) -> None:
    """Statics and eigenmodes at hostile postures."""
    kind = rng.choice((fd.modes, fd.linearize, fd.equilibrium))
    kind(model(rng), array(rng))


def finite(*arrays: Any) -> None:
    """No run hands back what is not a number."""
    assert all(np.isfinite(values).all() for values in arrays), "numbers that are not finite"


CALLS: tuple[Callable[[random.Random], None], ...] = (simulated, simulated, simulated, many, recorded, analysed)
