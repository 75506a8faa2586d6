"""A test rig's prescribed motion: what moves behind the spring, the force, and the ordinary diagnosis of it."""

from __future__ import annotations

import dataclasses
import pickle
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import flexdyn as fd

Array = NDArray[np.float64]
URDF = """<robot name="rig"><link name="frame"/><link name="mass"><inertial>
<mass value="4"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="frame"/><child link="mass"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1e9" velocity="9"/></joint></robot>"""
MASS, ROTOR, STIFFNESS, DAMPING = 4.0, 2.0, 4e4, 80.0


@pytest.fixture(scope="module")
def axis(tmp_path_factory: pytest.TempPathFactory) -> fd.FlexibleJointModel:
    """A mass behind a spring, without friction."""
    file = tmp_path_factory.mktemp("rig") / "rig.urdf"
    file.write_text(URDF, encoding="utf-8")
    drive = {"rotor_inertia": ROTOR, "stiffness": STIFFNESS, "damping": DAMPING}
    return fd.FlexibleJointModel(fd.load_robot(file), joints={"slide": drive}, tolerance=0.02)


def rig(t: Array, theta: Array, force: Array | None = None, signal: str = "theta") -> fd.Recording:
    """A recording of a rig."""
    channels = {f"{signal}.slide": theta, "tau.slide": np.zeros_like(t) if force is None else force}
    units = {f"{signal}.slide": "m", "tau.slide": "N"}
    return fd.Recording(t, channels, meta={"prescribed": ["slide"], "units": units}, name="rig")


def test_the_force_is_that_of_a_mass_behind_a_spring(axis: fd.FlexibleJointModel) -> None:
    """Against SciPy at a tight tolerance: J alpha + K (theta - q) + D (omega - v), q integrated by itself."""
    t = np.linspace(0.0, 3.0, 3001)
    theta = 0.02 * (1.0 - np.cos(9.0 * t)) + 0.005 * (1.0 - np.cos(31.0 * t))

    def place(s: float) -> tuple[float, float]:
        moved = 0.02 * (1.0 - np.cos(9.0 * s)) + 0.005 * (1.0 - np.cos(31.0 * s))
        return moved, 0.18 * np.sin(9.0 * s) + 0.155 * np.sin(31.0 * s)

    def rate(s: float, x: Array) -> list[float]:
        moved, speed = place(s)
        return [x[1], (STIFFNESS * (moved - x[0]) + DAMPING * (speed - x[1])) / MASS]

    q, v = solve_ivp(rate, (0.0, 3.0), [0.0, 0.0], t_eval=t, rtol=1e-10, atol=1e-13).y
    bend = 1.62 * np.cos(9.0 * t) + 4.805 * np.cos(31.0 * t)
    speed = 0.18 * np.sin(9.0 * t) + 0.155 * np.sin(31.0 * t)
    force = ROTOR * bend + STIFFNESS * (theta - q) + DAMPING * (speed - v)
    found = fd.prescribed_forces(axis, rig(t, theta))
    settled = found.t > 1.0  # the start is in the middle of a motion: what the spring carries there is not known
    wanted = np.interp(found.t, t, force)
    assert np.abs(found["tau.slide"] - wanted)[settled].max() < 0.01 * np.abs(force).max()


def test_play_lets_go_over_its_whole_width(axis: fd.FlexibleJointModel) -> None:
    """Behind a gap, slow sliding takes the level of friction; between two reversals' ends lie 2 L/K and the gap."""
    level, gap = 60.0, 2e-3
    laws = [
        fd.effects.CoulombFriction("slide", side="link", level=level),
        fd.effects.Backlash("slide", half_gap=gap),
    ]
    t = np.linspace(0.0, 8.0, 4001)
    theta = 0.02 * np.sin(0.5 * np.pi * t)
    worn = axis.replace(joints={"slide": {"damping": 1.0}}, effects=laws)  # which acts across the gap as well
    found = fd.prescribed_forces(worn, rig(t, theta))
    at = np.interp(found.t, t, theta)
    force = found["tau.slide"] - (MASS + ROTOR) * np.gradient(np.gradient(at, found.t), found.t)
    back = (found.t > 5.0) & (found.t < 7.0)  # from 20 mm to -20 mm
    travelled, carried = 0.02 - at[back], force[back]
    free = np.ptp(travelled[np.abs(carried) < 1.0])
    assert free == pytest.approx(2.0 * gap + 2.0 / STIFFNESS, rel=0.1)
    assert travelled[carried < -0.95 * level].min() == pytest.approx(2.0 * gap + 2.0 * level / STIFFNESS, rel=0.1)
    assert np.median(carried[travelled > 0.015]) == pytest.approx(-level, rel=0.02)


@pytest.fixture(scope="module")
def sliding(axis: fd.FlexibleJointModel) -> fd.Diagnosis:
    """A rigid axis with friction that its model lacks, moved by a rig."""
    rigid = axis.replace(joints={"slide": {"stiffness": np.inf, "damping": 0.0}})
    noise, t = np.random.default_rng(3), np.linspace(0.0, 8.0, 2001)
    q = 0.03 * np.sin(4.0 * t) + 0.01 * np.sin(11.0 * t)
    v, a = 0.12 * np.cos(4.0 * t) + 0.11 * np.cos(11.0 * t), -0.48 * np.sin(4.0 * t) - 1.21 * np.sin(11.0 * t)
    force = (MASS + ROTOR) * a + 7.0 * np.sign(v) + 12.0 * v
    seen = rig(t, q + noise.normal(0.0, 1e-7, t.size), force + noise.normal(0.0, 0.05, t.size), "q")
    return fd.diagnose(rigid, [seen], progress=False)


def test_the_ordinary_diagnosis_names_friction_on_the_rig(sliding: fd.Diagnosis) -> None:
    """Right laws with right numbers; the verdict is of forces, and no position is simulated."""
    named = {each.suspect.effect: each.suspect.parameters for each in sliding.findings}
    assert set(named) == {"coulomb_friction", "viscous_friction"}
    assert named["coulomb_friction"]["level"].value == pytest.approx(7.0, abs=0.05)
    assert named["viscous_friction"]["coefficient"].value == pytest.approx(12.0, abs=0.4)
    assert sliding.verdict == "explained"
    assert sliding.gap_test is not None
    assert sliding.gap_test.before > 20.0
    assert 0.8 < sliding.gap_test.after < 1.3


def test_errors_are_forces(sliding: fd.Diagnosis, tmp_path: Path) -> None:
    """In N, at the full rate, with their share; the position says nothing; the page draws force over position."""
    entry = sliding.to_dict()["errors"]["slide"]
    assert entry["force"]["unit"] == "N"
    assert entry["force"]["before"] > 6.0
    assert entry["force"]["after"] < 0.2 * entry["force"]["before"]
    assert np.isnan(entry["position"]["after"])
    assert {each.role for each in sliding.loops} == {"fit", "test"}
    sliding.save(tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Force of the prescribed motion" in page
    assert 'id="force-0"' in page


def test_play_is_found_behind_a_prescribed_motor(axis: fd.FlexibleJointModel) -> None:
    """One encoder in front of the gap: the link behind it is simulated, and its friction is in the model."""
    rubbing = axis.replace(effects=[fd.effects.CoulombFriction("slide", side="link", level=60.0)])
    worn = rubbing.replace(effects=[*rubbing.effects, fd.effects.Backlash("slide", half_gap=1.5e-3)])
    t = np.linspace(0.0, 3.0, 751)
    theta = (0.008 + 0.004 * t) * np.sin(6.0 * t)
    made = fd.prescribed_forces(worn, rig(t, theta))
    noise = np.random.default_rng(1)
    t = made.t
    theta = (0.008 + 0.004 * t) * np.sin(6.0 * t) + noise.normal(0.0, 1e-7, t.size)
    seen = rig(t - t[0], theta, made["tau.slide"] + noise.normal(0.0, 0.3, t.size))
    found = fd.diagnose(rubbing, [seen], expect=["backlash"], progress=False)
    (gap,) = [each for each in found.findings if each.suspect.effect == "backlash"]
    assert gap.suspect.parameters["half_gap"].value == pytest.approx(1.5e-3, rel=0.05)


def test_a_recording_keeps_what_its_rig_prescribes() -> None:
    """Through cuts, other rates, pickles and files side by side."""
    t = np.linspace(0.0, 1.0, 201)
    seen = rig(t, np.sin(t))
    sent = pickle.loads(pickle.dumps(seen))  # noqa: S301 - made here
    for other in (seen.trim(0.2, 0.8), seen.decimate(2), seen.resample(rate=50.0), sent):
        assert other.prescribed == ("slide",)
    beside = fd.Recording(t, {"q.other": t}).beside(seen)
    assert beside.prescribed == ("slide",)


def test_a_channel_map_says_it(tmp_path: Path) -> None:
    """prescribed: [slide] is in the recording's meta, and in the map's own mapping."""
    (tmp_path / "log.csv").write_text("t,x,f\n0,0,0\n0.1,1,2\n0.2,2,3\n", encoding="utf-8")
    content = {"flexdyn_map": 1, "prescribed": ["slide"], "channels": {"theta.slide": "x", "tau.slide": "f"}}
    made = fd.ChannelMap.from_dict(content)
    assert fd.read_recording(tmp_path / "log.csv", map=made).prescribed == ("slide",)
    assert fd.ChannelMap.from_dict(made.to_dict()) == made
    with pytest.raises(fd.InputError, match="no channel of this joint, got 'slid'; did you mean 'slide'"):
        fd.ChannelMap.from_dict(content | {"prescribed": ["slid"]})
    with pytest.raises(fd.InputError, match="a list of joints is needed"):
        fd.ChannelMap.from_dict(content | {"prescribed": "slide"})


def test_mistakes_are_one_line(axis: fd.FlexibleJointModel) -> None:
    """A recording that prescribes nothing; the position of an elastic joint's link; a joint without channels."""
    t = np.linspace(0.0, 1.0, 201)
    free = fd.Recording(t, {"theta.slide": t, "tau.slide": t})
    with pytest.raises(fd.InputError, match="no joint's motion is prescribed"):
        fd.prescribed_forces(axis, free)
    with pytest.raises(fd.InputError, match=r"theta\.slide"):
        fd.prescribed_forces(axis, rig(t, np.sin(t), signal="q"))
    with pytest.raises(fd.InputError, match="no channel of this joint"):
        fd.Recording(t, {"q.slide": t}, meta={"prescribed": ["elbow"]})


def test_warm_up_goes_on_in_later_parts(axis: fd.FlexibleJointModel) -> None:
    """A law of the time since the start of the run is that of the whole recording's time."""
    cold = fd.effects.WarmUpFriction("slide", side="link", coefficient=200.0, time_constant=1.0)
    t = np.linspace(0.0, 4.0, 2001)
    theta = 0.02 * np.sin(6.0 * t)
    warm, none = (fd.prescribed_forces(axis.replace(effects=e), rig(t, theta)) for e in ([cold], []))
    felt = np.abs(warm["tau.slide"] - none["tau.slide"])
    early, late = (felt[(warm.t > a) & (warm.t < a + 1.0)].max() for a in (0.5, 3.0))
    assert late / early == pytest.approx(np.exp(-2.5), rel=0.3)


def test_the_link_starts_where_the_force_winds_the_spring(axis: fd.FlexibleJointModel) -> None:
    """In the middle of a slow motion under friction there is no swing at the start."""
    model = axis.replace(effects=[fd.effects.CoulombFriction("slide", side="link", level=50.0)])
    t = np.linspace(0.0, 1.0, 1001)
    found = fd.prescribed_forces(model, rig(t, 0.05 * t, np.full_like(t, 50.0)))
    assert np.abs(found["tau.slide"] - 50.0).max() < 0.5
    assert dataclasses.is_dataclass(found)
