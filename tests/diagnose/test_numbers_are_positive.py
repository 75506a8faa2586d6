"""Numbers of the file are positive: none that is little known may become negative to imitate a law."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import lsq_linear

import flexdyn as fd
from flexdyn.diagnose.inference.apart import at_least
from tests.diagnose.test_inference_gram import BASE, COLUMNS, Problem

Array = NDArray[np.float64]
MASS, ROTOR, STIFFNESS, DAMPING, LEVEL, HALF_GAP = 4.0, 2.0, 4e4, 900.0, 60.0, 1.5e-3
"""Of the rig in kg, kg, N/m, N s/m, N and m. Critical damping is 800 N s/m."""
URDF = f"""<robot name="rig"><link name="frame"/><link name="mass"><inertial>
<mass value="{MASS}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="frame"/><child link="mass"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1e9" velocity="9"/></joint></robot>"""


@pytest.mark.parametrize("seed", range(4))
def test_marginals_of_what_every_structure_has(seed: int) -> None:
    """Mean and standard deviation of single columns are those of the whole posterior."""
    gram = Problem.of(seed).gram()
    columns = np.arange(BASE, COLUMNS, 2)
    whole = gram.whole(columns)
    mean, spread = gram.of_base(gram.estimate(columns), np.array([1, 0]))
    assert mean == pytest.approx(whole.mean[[1, 0]], rel=1e-9)
    assert spread == pytest.approx(np.sqrt(np.diag(whole.covariance))[[1, 0]], rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_an_imitation_stays_above_its_bounds(seed: int) -> None:
    """Least squares with one bound, against SciPy."""
    draw = np.random.default_rng(seed)
    X, y = draw.standard_normal((30, 5)), draw.standard_normal(30)
    least = np.full(5, -np.inf)
    least[2] = draw.normal(0.0, 0.2)
    found = at_least(X.T @ X, X.T @ y, least)
    assert found == pytest.approx(lsq_linear(X, y, (least, np.inf), tol=1e-14).x, abs=1e-6)


def pulled() -> tuple[Array, Array, Array]:
    """Times, positions and forces of a rig that pulls a rubbing mass through a gap, by SciPy (friction is a slope)."""
    t = np.linspace(0.0, 4.0, 2001)
    sizes = ((0.012, 6.0), (0.004, 2.3))

    def moved(s: Array | float, order: int) -> Array:
        turns = [(a * w**order, w * s + 0.5 * math.pi * order) for a, w in sizes]
        return np.asarray(sum(a * np.sin(x) for a, x in turns))

    def carried(s: Array | float, q: Array | float, v: Array | float) -> Array:
        delta = moved(s, 0) - q
        wound = np.sign(delta) * np.maximum(np.abs(delta) - HALF_GAP, 0.0)
        return np.asarray(STIFFNESS * wound + DAMPING * (moved(s, 1) - v))

    def rate(s: float, x: Array) -> list[float]:
        return [x[1], (float(carried(s, x[0], x[1])) - LEVEL * math.tanh(x[1] / 1e-5)) / MASS]

    made = solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0], "Radau", t_eval=t, rtol=1e-6, atol=1e-10)
    return t, moved(t, 0), ROTOR * moved(t, 2) + carried(t, made.y[0], made.y[1])


@pytest.mark.slow
def test_a_gap_is_named_although_the_damping_is_unknown(tmp_path: Path) -> None:
    """A negative damping would imitate it: it is not possible, and the damping is estimated with its error."""
    (tmp_path / "rig.urdf").write_text(URDF, encoding="utf-8")
    drive = {"rotor_inertia": ROTOR, "stiffness": STIFFNESS, "damping": "unknown"}
    rubbing = fd.effects.CoulombFriction("slide", side="link", level=LEVEL)
    model = fd.FlexibleJointModel(
        fd.load_robot(tmp_path / "rig.urdf"), joints={"slide": drive}, effects=[rubbing], tolerance=0.1
    )
    (t, theta, force), noise = pulled(), np.random.default_rng(5)
    seen = fd.Recording(
        t,
        {
            "theta.slide": theta + noise.normal(0.0, 1e-7, t.size),
            "tau.slide": force + noise.normal(0.0, 0.3, t.size),
        },
        meta={"prescribed": ["slide"], "units": {"theta.slide": "m", "tau.slide": "N"}},
    )
    found = fd.diagnose(model, [seen], expect=["backlash"], progress=False)
    (gap,) = [each for each in found.findings if each.suspect.effect == "backlash"]
    assert gap.suspect.parameters["half_gap"].value == pytest.approx(HALF_GAP, rel=0.05)
    assert found.model.resolved().damping[0] == pytest.approx(DAMPING, rel=0.15)
