"""Eigenfrequencies, damping, shapes and anti-resonances against closed forms and hand-written matrices."""

from __future__ import annotations

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import flexdyn as fd
from tests.analysis.arms import DAMPER, MASS, ROTOR, SPRING, WEIGHT, matrices, two_mass
from tests.arms import coupled, two_link
from tests.oracles.two_link import TwoLink

TURN = 2.0 * math.pi


def test_two_masses_on_a_spring(tmp_path: Path) -> None:
    """W^2 = K (1/J + 1/M), anti-resonance sqrt(K/M), damping D/(2 sqrt(K mu)), and the centre of mass stays."""
    found = fd.modes(two_mass(tmp_path))
    reduced = 1.0 / (1.0 / ROTOR + 1.0 / MASS)
    w, ratio = math.sqrt(SPRING / reduced), DAMPER / (2.0 * math.sqrt(SPRING * reduced))
    assert found.kinds == ("rigid-body", "vibration")
    assert found.rigid_body.tolist() == [True, False]
    np.testing.assert_allclose(found.frequencies, [0.0, w / TURN], rtol=1e-9)
    assert math.isnan(found.damping_ratios[0])
    assert found.damping_ratios[1] == pytest.approx(ratio, rel=1e-9)
    np.testing.assert_allclose(found.anti_resonances, [[math.sqrt(SPRING / MASS) / TURN]], rtol=1e-9)
    assert found.link_shapes[0] == pytest.approx(found.rotor_shapes[0])
    assert MASS * found.link_shapes[1, 0] + ROTOR * found.rotor_shapes[1, 0] == pytest.approx(0.0, abs=1e-8)
    assert found.rotor_shapes[1, 0] == pytest.approx(1.0)
    pair = -ratio * w + 1j * w * math.sqrt(1.0 - ratio**2)
    np.testing.assert_allclose(found.poles[2:], [pair.conjugate(), pair], rtol=1e-8)


def test_rotors_held(tmp_path: Path) -> None:
    """With its rotor held a mass swings at sqrt(K/M), damped by D/(2 sqrt(K M))."""
    found = fd.modes(two_mass(tmp_path), rotors="held")
    assert found.frequencies == pytest.approx([math.sqrt(SPRING / MASS) / TURN])
    assert found.damping_ratios == pytest.approx([DAMPER / (2.0 * math.sqrt(SPRING * MASS))])
    assert found.rotor_shapes.tolist() == [[0.0]]


@pytest.mark.parametrize("q", [(0.1, math.pi / 2), (0.3, 2.5), (-math.pi / 2, 0.1)])
@pytest.mark.parametrize("gravity", [0.0, 9.81])
@pytest.mark.parametrize("stiffness", [(5.5, 5.5), (3e5, 1e3), (40.0, math.inf), (math.inf, 40.0)])
def test_two_links_against_hand_written_matrices(
    q: tuple[float, float], gravity: float, stiffness: tuple[float, float]
) -> None:
    """The paper's arm (eq. 16-18) by SciPy's eigh: frequencies and shapes; one rotor held: anti-resonances."""
    arm = TwoLink(stiffness=stiffness, damping=(0.2, 0.1), rotor=(0.1, 0.07), gravity=gravity)
    inertia, K, _ = matrices(arm, q)
    found = fd.modes(two_link(arm), q)
    squared, shapes = eigh(K, inertia)
    expected = np.sqrt(np.maximum(squared, 0.0)) / TURN
    np.testing.assert_allclose(found.frequencies[2:], expected[2:], rtol=1e-9)
    np.testing.assert_allclose(found.frequencies[:2], expected[:2], rtol=1e-4, atol=1e-6 * expected[-1])
    kinds = ["rigid-body" if gravity == 0.0 else "unstable" if w < 0 else "vibration" for w in squared[:2]]
    assert list(found.kinds[:2]) == kinds
    assert set(found.kinds[2:]) <= {"vibration"}
    for k in range(2, len(squared)):  # the elastic modes; eigenvectors have no scale
        mine = np.concatenate([found.link_shapes[k], found.rotor_shapes[k, list(arm.elastic)]])
        cosine = abs(mine @ inertia @ shapes[:, k]) / math.sqrt(mine @ inertia @ mine)
        assert cosine == pytest.approx(1.0, abs=1e-9)
        assert max(abs(found.link_shapes[k]).max(), abs(found.rotor_shapes[k]).max()) == 1.0
    for j in (0, 1):
        rotor = 2 + arm.elastic.index(j) if j in arm.elastic else j
        kept = [i for i in range(len(K)) if i != rotor]
        zeros = np.linalg.eigvals(np.linalg.solve(inertia[np.ix_(kept, kept)], K[np.ix_(kept, kept)])).real
        zeros = np.sqrt(np.maximum(np.sort(zeros), 0.0)) / TURN
        np.testing.assert_allclose(found.anti_resonances[j], zeros, rtol=1e-7, atol=1e-6 * expected[-1])


def test_damping_that_couples_the_modes(tmp_path: Path) -> None:
    """Poles are those of the hand-written damped equations; ratios follow them to first order in the damping."""
    arm = TwoLink(stiffness=(30.0, 20.0), damping=(0.2, 0.1), gravity=9.81)
    q = (-math.pi / 2, 0.1)
    coefficient = 0.02
    friction = {"effect": "viscous_friction", "joint": "elbow", "side": "motor", "coefficient": coefficient}
    found = fd.modes(two_link(arm, [friction]), q)
    inertia, K, D = matrices(arm, q)
    D[3, 3] += coefficient
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(inertia, K), -np.linalg.solve(inertia, D)]])
    poles = np.linalg.eigvals(A)
    for pole in poles:
        assert np.abs(found.poles - pole).min() < 1e-6 * abs(pole)
    high = poles[poles.imag > 0]
    exact = (-high.real / np.abs(high))[np.argsort(np.abs(high))]
    np.testing.assert_allclose(found.damping_ratios, exact, rtol=5e-3)


def test_every_spring_at_its_load(tmp_path: Path) -> None:
    """Local stiffness: a hardened spring at its deflection, gap closed, and what holds the link from the base."""
    cubic, gap, parallel, stop = 4e4, 0.01, 50.0, 300.0
    effects = [
        {"effect": "hardening_spring", "cubic": cubic},
        {"effect": "backlash", "half_gap": gap},
        {"effect": "parallel_spring", "stiffness": parallel, "rest": 0.2},
        {"effect": "position_torque", "cos_1": 0.0, "sin_1": 3.0, "cos_2": 0.0, "sin_2": 0.0},
        {"effect": "end_stop", "lower": -9.0, "upper": 0.1, "stiffness": stop, "damping": 7.0},
        {"effect": "spring_hysteresis", "stiffness": 60.0, "width": 0.02},
    ]
    q = 0.3
    load = WEIGHT + parallel * (q - 0.2) + 3.0 * math.sin(q) + stop * (q - 0.1)
    delta = brentq(lambda d: SPRING * d + cubic * d**3 - load, 0.0, 1.0, xtol=1e-15)
    K = SPRING + 3.0 * cubic * delta**2 + 60.0 + parallel + 3.0 * math.cos(q) + stop
    found = fd.modes(two_mass(tmp_path, effects), [q], rotors="held")
    assert found.frequencies == pytest.approx([math.sqrt(K / MASS) / TURN], rel=1e-8)
    assert found.damping_ratios == pytest.approx([(DAMPER + 7.0) / (2.0 * math.sqrt(K * MASS))], rel=1e-8)


def test_bristles_and_cogging_hold_the_rotor(tmp_path: Path) -> None:
    """Within presliding and between cogs a free rotor stands on springs of its own; dry friction is left out."""
    presliding = {"effect": "presliding_friction", "side": "motor", "level": 2.0, "stiffness": 90.0, "damping": 0.5}
    ripple = {"effect": "torque_ripple", "amplitude": 0.7, "harmonic": 20.0, "phase": math.pi}
    dry = {"effect": "coulomb_friction", "side": "motor", "level": 3.0}
    limit = {"effect": "torque_speed_limit", "stall_torque": 1.0, "no_load_speed": 1.0}
    model = two_mass(tmp_path, [presliding, ripple, dry, limit])
    found = fd.modes(model, [-WEIGHT / SPRING])  # theta = 0
    K = np.array([[SPRING, -SPRING], [-SPRING, SPRING + 90.0 + 0.7 * 20.0]])
    squared = eigh(K, np.diag([MASS, ROTOR]), eigvals_only=True)
    np.testing.assert_allclose(found.frequencies, np.sqrt(squared) / TURN, rtol=1e-8)


def test_a_slack_gap_leaves_rotor_and_link_apart(tmp_path: Path) -> None:
    """A transmission with backlash that carries nothing has no stiffness: two rigid-body modes."""
    model = two_mass(tmp_path, [{"effect": "backlash", "half_gap": 0.01}]).replace(gravity=[0.0, 0.0, 0.0])
    assert fd.modes(model, [0.4]).kinds == ("rigid-body", "rigid-body")


def test_a_joint_that_mimics_another(tmp_path: Path) -> None:
    """The leader carries its follower: M = D11 + 2 r D12 + r^2 D22 against one spring."""
    ratio = -0.5
    drive = {"lead": {"rotor_inertia": 0.2, "stiffness": 30.0}}
    model = fd.FlexibleJointModel(coupled(tmp_path, ratio, 0.3), drive)
    d11, d22, d12, _ = TwoLink(tip_mass=0.0).inertias(ratio * 0.7 + 0.3)
    inertia = d11 + 2.0 * ratio * d12 + ratio**2 * d22
    found = fd.modes(model, [0.7])
    reduced = 1.0 / (1.0 / inertia + 1.0 / 0.2)
    assert found.frequencies == pytest.approx([0.0, math.sqrt(30.0 / reduced) / TURN], rel=1e-8)


@pytest.mark.parametrize("stiffness", [1.0, 1e4, 1e7])
def test_stiff_joints_do_not_hide_how_an_arm_hangs(stiffness: float) -> None:
    """Rigid-body modes are told from slow pendulum modes at any stiffness; rotors take part in the pendulum."""
    arm = TwoLink(stiffness=(stiffness, stiffness))
    assert fd.modes(two_link(arm), [0.7, -2.0]).kinds[:2] == ("rigid-body", "rigid-body")
    heavy = TwoLink(stiffness=(stiffness, stiffness), gravity=9.81)
    hanging = fd.modes(two_link(heavy), [-math.pi / 2, 0.0])
    assert set(hanging.kinds) == {"vibration"}
    inertia, K, _ = matrices(heavy, (-math.pi / 2, 0.0))
    slow = np.sqrt(1.0 / eigh(inertia, K, eigvals_only=True)[::-1][:2]) / TURN  # small roots from the inverse problem
    np.testing.assert_allclose(hanging.frequencies[:2], slow, rtol=1e-4)
    assert fd.modes(two_link(heavy), [math.pi / 2, 0.0]).kinds[:2] == ("unstable", "unstable")


def test_frequencies_over_a_path(tmp_path: Path) -> None:
    """Every pose of a path has the modes of that pose; a run is a path too."""
    model = two_link(TwoLink(stiffness=(30.0, 20.0)))
    path = np.column_stack([np.zeros(9), np.linspace(0.0, math.pi, 9)])
    found = fd.frequencies_over_path(model, path)
    for k in (0, 5):
        single = fd.modes(model, path[k])
        np.testing.assert_array_equal(found.frequencies[k], single.frequencies)
        np.testing.assert_array_equal(found.anti_resonances[k], single.anti_resonances)
    np.testing.assert_allclose(found.distance, path[:, 1])
    assert (np.diff(found.frequencies[:, 3]) != 0).all()
    run = fd.simulate(model, [0.1, 0.0], 0.01)
    assert fd.frequencies_over_path(model, run, rotors="held").frequencies.shape == (11, 2)
    assert "9 poses" in repr(found)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(found)).frequencies, found.frequencies)  # noqa: S301


def test_modes_show_themselves_in_a_line_and_in_a_notebook() -> None:
    """Of an arm of six joints as of one of two: `repr` is short, the notebook has every mode."""
    found = fd.modes(fd.load_model("ur5"), rotors="held")
    assert repr(found).startswith("<Modes of ur5, rotors held: ")
    assert repr(found).count("\n") == 0
    html = fd.modes(fd.load_model("ur5"))._repr_html_()
    assert html.count("<tr>") == 1 + 2 * 12
    assert "anti-resonances of wrist_3_joint" in html


def test_modes_read_as_a_table_and_as_data() -> None:
    """A line a mode, rows that JSON takes, arrays that are locked, also after pickling."""
    found = fd.modes(fd.load_model("scara_two_link"))
    lines = str(found).splitlines()
    assert lines[0].startswith("scara_two_link: 4 modes at shoulder 0, elbow 1.571; rotors free")
    assert sum(line.split()[0].isdigit() for line in lines if line.strip()) == len(found) == 4
    assert lines[-1].startswith("anti-resonances of elbow: 0.8202, ")
    rows = json.loads(json.dumps(found.rows()))
    assert rows[0]["damping_ratio"] is None
    assert rows[3]["frequency"] == found.frequencies[3]
    again = pickle.loads(pickle.dumps(found))  # noqa: S301
    assert str(again) == str(found)
    assert repr(again) == "<Modes of scara_two_link, rotors free: 2 rigid-body; 2 vibration at 1.233, 1.472 Hz>"
    with pytest.raises(ValueError, match="read-only"):
        again.frequencies[0] = 1.0


def test_what_modes_refuse(tmp_path: Path) -> None:
    """Wrong arguments are named in one line."""
    model = two_mass(tmp_path)
    with pytest.raises(fd.InputError, match=r"^rotors: no such choice, got 'locked'; it is free or held$"):
        fd.modes(model, rotors="locked")  # type: ignore[arg-type]
    with pytest.raises(fd.InputError, match=r"^q: 1 finite numbers are needed"):
        fd.modes(model, [1.0, 2.0])
    with pytest.raises(fd.InputError, match=r"^q\.lif: the robot has no such joint; did you mean 'lift'\?$"):
        fd.modes(model, {"lif": 1.0})
    with pytest.raises(fd.InputError, match="every joint is rigid"):
        fd.modes(model.rigid(), rotors="held")
    with pytest.raises(fd.InputError, match=r"^model: a FlexibleJointModel is needed"):
        fd.modes("panda")  # type: ignore[arg-type]
    with pytest.raises(fd.InputError, match=r"^path: finite positions \(samples, 1\) are needed"):
        fd.frequencies_over_path(model, [0.1, 0.2])
