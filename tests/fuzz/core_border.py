"""What reaches the compiled core through Python: shapes, kinds and sizes of numbers that no caller should give."""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import flexdyn as fd
from flexdyn.effects import Effect
from tests.fuzz import core_arrays

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
    """The arm with joints from none to extremely stiff, and effects of any size."""
    if rng.random() < 0.2:
        return arm()
    joint = {
        "rotor_inertia": number(rng, 1e-9, 1e-3, 0.1, 1e6),
        "stiffness": number(rng, *STIFFNESS),
        "damping": number(rng, 0.0, 1.0, 1e6),
        "gear_ratio": number(rng, 1.0, 100.0),
    }
    return fd.FlexibleJointModel(arm().robot, {"*": joint}, [effect(rng) for _ in range(rng.choice((0, 0, 1, 1, 3)))])


def effect(rng: random.Random) -> Effect:
    """One of the catalogue, each of its numbers as it is shown, or that times any power of ten, or none that fits."""
    kind = rng.choice([kind for kind in fd.effects.catalogue().values() if kind.__module__.startswith("flexdyn.")])
    joints = ["shoulder", "elbow"]
    rng.shuffle(joints)
    shown = kind.example(*joints)
    changed: dict[str, Any] = {}
    for parameter in kind.parameters():
        usual = getattr(shown, parameter.name)
        if rng.random() < 0.5:
            changed[parameter.name] = number(rng, usual, usual * 10.0 ** rng.uniform(-9.0, 9.0), 0.0)
    if len(kind.sides) > 1:
        changed["side"] = rng.choice(kind.sides)
    return shown.replace(**changed)


def solver(rng: random.Random) -> tuple[Any, float]:
    """A solver with settings that may fit, and how long it may be asked to run.

    A fixed step comes to its end however small it is: such runs are no longer than some thousand steps. Those that
    choose their steps have a budget of them, so that they may be asked for any time.
    """
    kind = rng.choice(("TimeStepping", "RungeKutta4", "DormandPrince", "Rosenbrock", "auto"))
    if kind in ("TimeStepping", "RungeKutta4"):
        step = number(rng, *STEPS)
        duration = rng.choice((step, 3 * step, 1000 * step, 0.5 * step, number(rng, step)))
        width = {"smoothing": number(rng, 1e-3, 1.0)} if kind == "RungeKutta4" and rng.random() < 0.7 else {}
        return getattr(fd.solvers, kind)(step=step, **width), duration if duration <= 5000 * step else 1000 * step
    if kind == "auto" or rng.random() < 0.05:
        return kind, min(number(rng, *STEPS), 1.0)
    # A budget of 1e15 steps is what was asked for, and no hang.
    settings: dict[str, Any] = {"max_steps": rng.choice((10.0, 1e4, 1e4, 1e4, number(rng, 300.0) % 1e4))}
    settings |= {"rtol": number(rng, 1e-12, 1e-6, 1e-3), "atol": number(rng, 1e-14, 1e-8)}
    settings |= {"max_step": number(rng, *STEPS)} if rng.random() < 0.2 else {}
    settings |= {"smoothing": number(rng, 1e-9, 1e-3)} if rng.random() < 0.2 else {}
    return getattr(fd.solvers, kind)(**settings), number(rng, *STEPS)


def large(rng: random.Random, values: Any) -> Any:
    """What was drawn, sometimes times any power of ten."""
    if rng.random() < 0.6 or not isinstance(values, np.ndarray) or values.dtype.kind != "f":
        return values
    with np.errstate(all="ignore"):
        return values * 10.0 ** rng.uniform(-15.0, 15.0)


def simulated(rng: random.Random) -> None:
    """One run from hostile first states under a hostile command."""
    arm, (settings, duration) = model(rng), solver(rng)
    starts = {name: large(rng, array(rng)) for name in ("q0", "v0", "theta0", "omega0") if rng.random() < 0.3}
    command = large(rng, array(rng)) if rng.random() < 0.5 else None
    rate = number(rng, 1000.0, 1.0) if duration < 0.1 else 10.0
    times = array(rng) if rng.random() < 0.1 else None
    run = fd.simulate(arm, command, duration, settings, rate=rate, times=times, **starts)
    finite(run.q, run.v, run.theta, run.omega, run.tau_s)


def many(rng: random.Random) -> None:
    """Several runs at once, some of them refused or stopped."""
    first, (settings, duration) = model(rng), solver(rng)
    starts = large(rng, array(rng))
    runs = fd.simulate_many([first, arm()], array(rng), duration, settings, q0=starts, threads=1, rate=10.0)
    for each in runs:
        if isinstance(each, fd.Run):
            finite(each.q, each.theta)
        else:
            assert str(each).isprintable(), "an error of more than one line"


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


CALLS: tuple[Callable[[random.Random], None], ...] = (
    simulated, simulated, simulated, many, recorded, analysed, core_arrays.run, core_arrays.run
)  # fmt: skip
