"""Cases on the six-joint arm: one hidden effect, of those that MuJoCo can carry, at design size."""

from __future__ import annotations

import dataclasses
from typing import Any

import layout as at
import numpy as np
import pinocchio as pin
import six_run
import sizes
from hidden import Hidden, Site, draw, enter
from layout import Array
from model_text import ERROR, MASS_ERROR
from motions import Style, reference
from recording import Sensors, record
from six_arm import MIDDLE, SixArm, figures, model_yaml, nominal, urdf, varied
from two_link_run import Control, Truth

FIT, CHECK = 40.0, 12.0  # s
BUILT = 0.1  # how much an arm differs from the nominal one
MEMORY = ("presliding_friction", "spring_hysteresis")  # laws with a state: MuJoCo's stages have no room for one
BOTH_SIDES = [name for name in sizes.FRICTION if name not in MEMORY]
WRONG = ("stiffness", "rotor_inertia", "link_mass", "coefficient", "level")
WITHOUT_COULOMB = ("coulomb_friction", "asymmetric_friction")


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


def draw_control(rng: np.random.Generator, arm: SixArm, duration: float, seen: Array, whole: Array) -> Control:
    """All six joints in motion at once."""
    model = arm.pinocchio()
    data, rotor = model.createData(), arm.rotor()
    reach = np.array([0.8, 0.5, 0.5, 0.8, 0.8, 1.2])
    columns = []
    for j in range(6):
        style = Style(
            reach[j] * rng.uniform(0.8, 1.0), rng.uniform(0.8, 1.6), rng.uniform(4.0, 8.0), rng.uniform(0.03, 0.1)
        )
        columns.append(reference(rng, style, MIDDLE[j], duration))
    wanted = np.stack(columns, axis=1)
    v = np.gradient(wanted, 1e-3, axis=0)
    a = np.gradient(v, 1e-3, axis=0)
    forward = np.array([pin.rnea(model, data, *row) for row in zip(wanted, v, a, strict=True)]) + rotor * a
    w = 2.0 * np.pi * rng.uniform(2.0, 3.2, 6)
    return Control(wanted, 0.9 * forward, whole * w**2, whole * 1.6 * w, seen)


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


def make_six(seed: int, index: int, fit: float, check: float, sensors: Sensors) -> dict[str, Any]:
    """Name, files, recordings and truth of one case."""
    order = np.random.default_rng([seed, 11]).permutation(len(sites()))
    site = sites()[order[index % len(order)]]
    rng = np.random.default_rng([seed, 12, index])
    j = site[1]
    arm = prepared(varied(nominal(), rng, BUILT, BUILT), site)
    model = arm.pinocchio()
    whole = np.diag(pin.crba(model, model.createData(), np.array(MIDDLE))) + arm.rotor()
    seen = np.array([sensors.motor_step(N) for N in arm.gear_ratio])
    controls = [draw_control(rng, arm, duration, seen, whole) for duration in (fit, check)]
    nobody = -np.ones(6)
    base = six_run.controlled(arm, plant(arm), 0.0, nobody, _first(controls[0]))
    one = draw(site, _scale(rng, arm, base, controls[0], j, whole), arm.joints, arm.names)
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
    recordings = [record(run, arm.joints, arm.gear_ratio, [one], sensors, rng) for run in runs]
    given = varied(arm, rng, ERROR, MASS_ERROR)
    if one.effect == "parameter_error":
        key = number(one)
        given = given.replace(**{key: _set(getattr(given, key), j, getattr(arm, key)[j])})
        one = _indexed(one, given, j)
    name = f"six_{seed}_{index:03d}"
    truth = {
        "case": name,
        "family": "six",
        "seed": seed,
        "number": index,
        "fit": fit,
        "check": check,
        "hidden": [one.to_dict(arm.joints)],
        "joints": {
            key: list(getattr(truly, key)) for key in ("stiffness", "damping", "rotor_inertia", "viscous", "coulomb")
        },
        "sensors": dataclasses.asdict(sensors),
        "scale": {"peak_torque": [float(x) for x in np.abs(runs[0].tau).max(axis=0)]},
    }
    files = {"model.yaml": model_yaml(given, 0.03), "arm.urdf": urdf(given)}
    return {
        "name": name,
        "files": files,
        "recordings": dict(zip(("fit", "check"), recordings, strict=True)),
        "truth": truth,
    }


def _first(control: Control, seconds: float = 12.0) -> Control:
    count = round(seconds * 1000)
    return dataclasses.replace(control, reference=control.reference[:count], feedforward=control.feedforward[:count])


def _scale(rng: np.random.Generator, arm: SixArm, base: Truth, control: Control, j: int, whole: Array) -> sizes.Scale:
    return sizes.Scale(
        rng=rng,
        factor=1.0,
        joint=j,
        arm=arm,
        other=j - 1,
        peak=np.abs(base.tau).max(axis=0),
        speed=np.abs(base.y[:, 18:24]).max(axis=0),
        wind=np.abs(base.y[:, 6:12] - base.y[:, 0:6]).max(axis=0),
        low=control.reference.min(axis=0),
        high=control.reference.max(axis=0),
        inertia=whole,
    )


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
