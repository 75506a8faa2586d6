"""Cases on the six-joint arm: one hidden effect, of those that MuJoCo can carry, at design size."""

from __future__ import annotations

import dataclasses
from typing import Any

import layout as at
import numpy as np
import pinocchio as pin
import six_run
import sizes
import wide
from hidden import Hidden, Site, draw, enter
from lab import cut
from layout import Array
from model_text import ERROR, MASS_ERROR, TOLERANCE
from recording import Sensors, record
from six_arm import MIDDLE, SixArm, figures, model_yaml, nominal, urdf, varied
from six_motion import ORDINARY, draw_control, first, scale_of
from wide import SUFFIX, Setup, draw_setup

FIT, CHECK = 40.0, 12.0  # s
ATTEMPTS = 5
BUILT = 0.1  # how much an arm differs from the nominal one
MEMORY = ("presliding_friction", "spring_hysteresis")  # laws with a state: MuJoCo's stages have no room for one
BOTH_SIDES = [name for name in sizes.FRICTION if name not in MEMORY]
WRONG = ("stiffness", "rotor_inertia", "link_mass", "coefficient", "level")
WITHOUT_COULOMB = ("coulomb_friction", "asymmetric_friction")
STIFFER = (0.1, 10.0)  # times the nominal springs, in wide cases


def sites() -> list[Site]:
    """Everything that can be hidden; of sensors and wrong numbers those that a heavy joint shows."""
    found: list[Site] = []
    for j in range(6):
        found += [(name, j, side) for name in BOTH_SIDES for side in ("link", "motor")]
        found += [(name, j, "transmission") for name in sizes.TRANSMISSION if name not in MEMORY]
        found += [(name, j, "motor") for name in sizes.MOTOR if name != "joint_coupling" or j > 3]
        found += [(name, j, "link") for name in sizes.LINK]
        found += [(name, j, signal) for name in sizes.SENSOR for signal in ("q", "theta")]
        found += [("parameter_error", j, number) for number in WRONG if number != "link_mass" or j in (1, 2)]
    return [*found, ("payload", 5, "link")]


def plant(arm: SixArm) -> Array:
    """The table of `layout` for six joints without anything hidden."""
    P = np.vstack([at.neutral()] * 3)
    P[:, at.K], P[:, at.D], P[:, at.ROTOR] = arm.stiffness, arm.damping, arm.rotor()
    P[:, at.MOTOR + at.VISCOUS] = arm.viscous
    P[:, at.MOTOR + at.POSITIVE] = P[:, at.MOTOR + at.NEGATIVE] = arm.coulomb
    return P


def prepared(arm: SixArm, site: Site) -> SixArm:
    """Without what the effect would merely change."""
    name, j, side = site
    off = {"viscous": name == "viscous_friction" and side == "motor", "damping": name == "transmission_damping"}
    off["coulomb"] = name in WITHOUT_COULOMB and side == "motor"
    return arm.replace(**{key: _set(getattr(arm, key), j, 0.0) for key, wanted in off.items() if wanted})


def true_arm(arm: SixArm, one: Hidden, j: int) -> SixArm:
    """With the wrong number set right."""
    if one.effect != "parameter_error":
        return arm
    key = number(one)
    old = getattr(arm, key)
    return arm.replace(**{key: _set(old, j, old[j] * one.parameters["factor"])})


def number(one: Hidden) -> str:
    """Which number of the arm a `parameter_error` sits on."""
    names = {"link_mass": "mass", "coefficient": "viscous", "level": "coulomb"}
    return names.get(one.place["parameter"], one.place["parameter"])


def make_six(
    seed: int, index: int, fit: float, check: float, sensors: Sensors, *, wider: bool = False
) -> dict[str, Any]:
    """Name, files, recordings and truth of one case; wider: from wider ranges.

    Raises:
        ArithmeticError: no arm that follows its reference was found.
    """
    if not wider:
        return _attempt(np.random.default_rng([seed, 12, index]), seed, index, (fit, check), sensors, ORDINARY)
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, 13, index, attempt])
        setup = draw_setup(rng)
        try:
            measured = dataclasses.replace(sensors, every=setup.every)
            return _attempt(rng, seed, index, (fit, check), measured, setup)
        except ArithmeticError:
            continue
    raise ArithmeticError(f"six{SUFFIX} {seed} {index}: nothing in {ATTEMPTS} draws")


def _attempt(
    rng: np.random.Generator, seed: int, index: int, durations: tuple[float, float], sensors: Sensors, setup: Setup
) -> dict[str, Any]:
    order = np.random.default_rng([seed, 11]).permutation(len(sites()))
    site = sites()[order[index % len(order)]]
    j = site[1]
    arm = varied(nominal(), rng, BUILT, BUILT)
    if setup.wide:
        springs = sizes.log_uniform(rng, STIFFER, 6)
        arm = arm.replace(
            stiffness=figures(np.array(arm.stiffness) * springs),
            damping=figures(np.array(arm.damping) * np.sqrt(springs)),
        )
    arm = prepared(arm, site)
    model = arm.pinocchio()
    whole = np.diag(pin.crba(model, model.createData(), np.array(MIDDLE))) + arm.rotor()
    seen = np.array([sensors.motor_step(N) for N in arm.gear_ratio])
    controls = [draw_control(rng, arm, duration, seen, whole, setup) for duration in durations]
    nobody = -np.ones(6)
    base = six_run.controlled(arm, plant(arm), 0.0, nobody, first(controls[0]))
    scale = scale_of(rng, arm, base, controls[0], j, whole, setup)
    one = draw(site, scale, arm.joints, arm.names)
    truly = true_arm(arm, one, j)
    P, other = plant(truly), nobody
    enter(P, one)
    if one.effect == "joint_coupling":
        other = np.where(np.arange(6) == j, j - 1, -1).astype(float)
    if one.effect == "command_delay":
        one = dataclasses.replace(
            one, parameters={"delay": round(one.parameters["delay"] / six_run.STEP) * six_run.STEP}
        )
        P[j, at.DELAY] = one.parameters["delay"]
    payload = one.parameters["mass"] if one.effect == "payload" else 0.0
    runs = [six_run.controlled(truly, P, payload, other, control) for control in controls]
    if setup.wide:
        runs = [cut(run) for run in runs]
        strayed = [run.y[:, 0:6] - c.reference[: len(run.t)] for run, c in zip(runs, controls, strict=True)]
        if max(float(np.abs(each).max()) for each in strayed) > wide.STRAYED:
            raise ArithmeticError("lost its reference")
    recordings = [record(run, arm.joints, arm.gear_ratio, [one], sensors, rng) for run in runs]
    more = setup.tolerance / TOLERANCE
    given = varied(arm, rng, ERROR * more, MASS_ERROR * more)
    if one.effect == "parameter_error":
        key = number(one)
        given = given.replace(**{key: _set(getattr(given, key), j, getattr(arm, key)[j])})
        one = _indexed(one, given, j)
    family = f"six{SUFFIX}" if setup.wide else "six"
    name = f"{family}_{seed}_{index:03d}"
    truth = {
        "case": name,
        "family": family,
        "seed": seed,
        "number": index,
        "fit": durations[0],
        "check": durations[1],
        "hidden": [one.to_dict(arm.joints)],
        "joints": {
            key: list(getattr(truly, key)) for key in ("stiffness", "damping", "rotor_inertia", "viscous", "coulomb")
        },
        "sensors": dataclasses.asdict(sensors),
        "scale": {"peak_torque": [float(x) for x in np.abs(runs[0].tau).max(axis=0)]},
    }
    files = {"model.yaml": model_yaml(given, setup.tolerance), "arm.urdf": urdf(given)}
    return {
        "name": name,
        "files": files,
        "recordings": dict(zip(("fit", "check"), recordings, strict=True)),
        "truth": truth,
    }


def _indexed(one: Hidden, given: SixArm, j: int) -> Hidden:
    if one.place["parameter"] not in ("coefficient", "level"):
        return one
    rows = [("coefficient", k) for k in range(6) if given.viscous[k] > 0.0]
    rows += [("level", k) for k in range(6) if given.coulomb[k] > 0.0]
    index = rows.index((one.place["parameter"], j))
    return dataclasses.replace(one, side="motor", place=one.place | {"of": f"effects[{index}]"})


def _set(values: Any, j: int, value: float) -> tuple[float, ...]:
    changed = np.array(values, dtype=float)
    changed[j] = value
    return figures(changed)
