"""Metrics against closed forms: a mass on springs, pulses on two masses, energy of constant forces."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.batch.aim import aim_of
from flexdyn.batch.catalogue import METRICS
from flexdyn.batch.metrics import metric, metrics_of, metrics_of_runs
from flexdyn.batch.motion import RunsMotion
from tests.arms import EXACT, slider

MASS = 2.5


def oscillator(folder: Path, ratio: float, omega: float = 10.0) -> fd.FlexibleJointModel:
    """A mass on a spring and a damper to the ground: x'' + 2 ratio omega x' + omega^2 x = 0, weightless."""
    effects = [
        fd.effects.ParallelSpring("lift", stiffness=MASS * omega**2, rest=0.0),
        fd.effects.ViscousFriction("lift", side="link", coefficient=2.0 * ratio * omega * MASS),
    ]
    return fd.FlexibleJointModel(slider(folder), effects=effects, gravity=[0.0, 0.0, 0.0])


def two_masses(folder: Path, J: float = 0.5, K: float = 800.0) -> fd.FlexibleJointModel:
    """The mass hangs on its rotor by a spring, weightless."""
    joints = {"lift": {"rotor_inertia": J, "stiffness": K}}
    return fd.FlexibleJointModel(slider(folder), joints, gravity=[0.0, 0.0, 0.0])


def number(name: str, run: fd.Run, command: Any = None) -> float:
    """A metric of one run as a study measures it."""
    aim = aim_of(command, run.model, float(run.t[-1]))
    (found,) = metrics_of([name], run.model, aim)
    return found.of(run, aim)


def decay(t: NDArray[np.float64], ratio: float, omega: float) -> NDArray[np.float64]:
    """Free motion of the oscillator from x = 1 at rest."""
    damped = omega * math.sqrt(1.0 - ratio**2)
    return np.asarray(np.exp(-ratio * omega * t) * (np.cos(damped * t) + ratio * omega / damped * np.sin(damped * t)))


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.7])
def test_settling_time_of_a_damped_oscillator(tmp_path: Path, ratio: float) -> None:
    """It is the last time that the closed-form decay leaves the band of 2 % of where it started."""
    run = fd.simulate(oscillator(tmp_path, ratio), None, 20.0, EXACT, q0=[1.0], rate=500)
    fine = np.linspace(0.0, 20.0, 2_000_001)
    last = fine[np.abs(decay(fine, ratio, 10.0)) > 0.02][-1]
    assert number("settling_time", run) == pytest.approx(last, abs=5e-5)


@pytest.mark.parametrize("ratio", [0.1, 0.5])
def test_overshoot_of_a_step(tmp_path: Path, ratio: float) -> None:
    """A step of a second-order system overshoots by exp(-pi ratio / sqrt(1 - ratio^2)) of the step."""
    run = fd.simulate(oscillator(tmp_path, ratio), None, 20.0, EXACT, q0=[1.0], rate=1000)
    expected = math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio**2))
    assert number("overshoot", run) == pytest.approx(expected, rel=2e-4)


def test_a_motion_that_does_not_settle_has_no_settling_time(tmp_path: Path) -> None:
    """An undamped vibration never stays within the band, and that is said."""
    run = fd.simulate(oscillator(tmp_path, 0.0), None, 5.0, EXACT, q0=[1.0], rate=200)
    with pytest.raises(fd.InputError, match=r"^metric settling_time: the tip does not settle before the run ends$"):
        number("settling_time", run)


def test_an_arm_that_never_moves_has_settled(tmp_path: Path) -> None:
    """Nothing moves: settled at once; and no step, hence no overshoot."""
    run = fd.simulate(oscillator(tmp_path, 0.1), None, 1.0, EXACT, rate=200)
    assert number("settling_time", run) == 0.0
    with pytest.raises(fd.InputError, match="it ends where it began"):
        number("overshoot", run)


def test_tip_deflection_of_a_constant_force(tmp_path: Path) -> None:
    """A force on the rotor of two masses swings the spring by F/(J w^2) (1 - cos w t)."""
    J, K, F = 0.5, 800.0, 6.0
    w = math.sqrt(K * (MASS + J) / (MASS * J))
    periods = 8 * 2.0 * math.pi / w
    run = fd.simulate(two_masses(tmp_path, J, K), [F], periods, EXACT, rate=5000)
    size = F / (J * w**2)
    assert number("tip_deflection_max", run) == pytest.approx(2.0 * size, rel=1e-4)
    assert number("tip_deflection_rms", run) == pytest.approx(math.sqrt(1.5) * size, rel=1e-6)
    assert number("joint_deflection_max", run) == pytest.approx(2.0 * size, rel=1e-4)
    assert number("transmission_torque_max", run) == pytest.approx(2.0 * K * size, rel=1e-4)
    assert number("motor_torque_max", run) == F


@pytest.mark.parametrize("length", [0.02, 0.05])
def test_residual_vibration_after_a_pulse(tmp_path: Path, length: float) -> None:
    """A pulse of force leaves the spring swinging by 2 F/(J w^2) |sin(w T/2)|, and counts from the pulse's end."""
    J, K, F = 0.5, 800.0, 6.0
    w = math.sqrt(K * (MASS + J) / (MASS * J))
    pulse = fd.Samples([0.0, length], [[F], [F]])
    end = length + 10 * 2.0 * math.pi / w
    run = fd.simulate(two_masses(tmp_path, J, K), pulse, end, EXACT, times=np.linspace(0.0, end, 4001))
    assert aim_of(pulse, run.model, end).rest == length
    expected = 2.0 * F / (J * w**2) * abs(math.sin(0.5 * w * length))
    assert number("residual_vibration", run, pulse) == pytest.approx(expected, rel=5e-4)


def test_tracking_error_against_the_reference(tmp_path: Path) -> None:
    """The tip's distance from the reference of a controller is that of a mass from where it should be."""
    t = np.linspace(0.0, 1.0, 101)
    reference = fd.Samples(t, 0.3 * t[:, None] ** 2, "cubic")
    command = fd.PD(reference, kp=200.0, kd=10.0)
    run = fd.simulate(oscillator(tmp_path, 0.1), command, 1.5, EXACT, rate=1000)
    wanted = 0.3 * np.minimum(run.t, 1.0) ** 2
    error = np.abs(run.q[:, 0] - wanted)
    assert number("tracking_error_max", run, command) == pytest.approx(error.max(), rel=1e-9)
    rms = math.sqrt(np.trapezoid(error**2, run.t) / 1.5)
    assert number("tracking_error_rms", run, command) == pytest.approx(rms, rel=1e-9)


def test_energies_of_a_decay(tmp_path: Path) -> None:
    """What a spring held at first is what its damper has dissipated at last; nobody supplied any."""
    run = fd.simulate(oscillator(tmp_path, 0.7), None, 5.0, EXACT, q0=[0.1], rate=100)
    assert number("energy_supplied", run) == 0.0
    assert number("energy_dissipated", run) == pytest.approx(0.5 * MASS * 100.0 * 0.1**2, rel=1e-8)


def test_energy_supplied_is_force_times_way(tmp_path: Path) -> None:
    """A constant force of 6 N on both masses together has supplied 6 N times the rotor's way."""
    run = fd.simulate(two_masses(tmp_path), [6.0], 0.7, EXACT, rate=100)
    assert number("energy_supplied", run) == pytest.approx(6.0 * run.theta[-1, 0], rel=1e-9)


def test_every_metric_is_described() -> None:
    """A unit, a sentence and an equation each."""
    for name, each in METRICS.items():
        assert each.name == name
        assert each.unit in ("m", "rad", "s", "1", "J", "N m")
        assert each.description.endswith(".")
        assert each.equation


def test_units_of_an_arm_that_slides(tmp_path: Path) -> None:
    """Forces of a sliding joint are in N, its deflection in m."""
    model = two_masses(tmp_path)
    found = metrics_of(["motor_torque_max", "joint_deflection_max"], model, aim_of(None, model, 1.0))
    assert [each.unit for each in found] == ["N", "m"]


def test_when_a_command_comes_to_rest(tmp_path: Path) -> None:
    """The last change counts: of held torques a sample, of lines their end, of a reference where it stands still."""
    model = oscillator(tmp_path, 0.1)
    t = [0.0, 1.0, 2.0, 3.0]
    cases = [
        (None, 0.0),
        ([5.0], 0.0),
        (fd.Samples(t, [1.0, 2.0, 2.0, 2.0]), 3.0),  # then it falls to zero
        (fd.Samples(t, [1.0, 2.0, 0.0, 0.0]), 2.0),
        (fd.Samples(t, [1.0, 2.0, 0.0, 0.0], "linear"), 2.0),
        (fd.Samples(t, [0.0, 0.0, 0.0, 1.0], "linear"), 3.0),
        (fd.PD(fd.Samples(t, [0.0, 1.0, 1.0, 1.0], "linear"), 1.0, 1.0), 1.0),
        (fd.PD(fd.Samples(t, [0.0, 1.0, 1.0, 2.0], "linear"), 1.0, 1.0), 3.0),
        (fd.Controller(lambda t, state: [0.0]), None),
    ]
    for command, rest in cases:
        assert aim_of(command, model, 10.0).rest == rest
    assert aim_of(fd.Samples(t, [1.0, 2.0, 3.0, 4.0]), model, 3.0).rest == 2.0  # the last row never acts
    assert aim_of(fd.PD(fd.Samples([0.0, 9.0], [0.0, 1.0], "linear"), 1.0, 1.0), model, 5.0).rest is None


def test_one_joint_of_an_arm_of_both_kinds() -> None:
    """Torques and forces do not compare: such the greatest is refused until a joint is named, which has its unit."""
    model = fd.load_model("scara")
    aim = aim_of([1.0, -3.0, 20.0, 0.5], model, 0.05)
    with pytest.raises(
        fd.InputError, match=r"joints that slide, got 'motor_torque_max'; name one of them: motor_torqu"
    ):
        metrics_of(["motor_torque_max"], model, aim)
    with pytest.raises(fd.InputError, match=r"metrics\[0\].*no such joint, got 'joint9'"):
        metrics_of(["motor_torque_max.joint9"], model, aim)
    found = metrics_of(["motor_torque_max.joint2", "motor_torque_max.joint3"], model, aim)
    assert [each.unit for each in found] == ["N m", "N"]
    run = fd.simulate(model, [1.0, -3.0, 20.0, 0.5], 0.05)
    values, reasons = metrics_of_runs(found, RunsMotion.of(run, aim))
    assert (values.tolist(), reasons) == ([[3.0], [20.0]], [[]])


def test_what_a_study_lacks_is_said_before_anything_runs() -> None:
    """No reference to track, no rest of the command, no such metric: one line with its place."""
    model = fd.load_model("scara_two_link")
    noise = fd.Samples(np.linspace(0.0, 2.0, 50), np.random.default_rng(0).normal(size=(50, 2)))
    aim = aim_of(noise, model, 2.0)
    cases = {
        "tracking_error_max": r"metrics\[1\]: there is no reference to track, got 'tracking_error_max'; it needs a c",
        "settling_time": r"metrics\[1\]: the command does not come to rest before the run ends, got 'settling_time'; g",
        "setling_time": r"metrics\[1\]: no such metric, got 'setling_time'; did you mean 'settling_time'\?",
        "nowhere:at_all": r"metrics\[1\]: the metric cannot be imported \(No module named 'nowhere'\), got",
        "json:nothing": r"metrics\[1\]: module json has no nothing",
        "math:pi": r"metrics\[1\]: the metric is not callable, got 'math:pi'; it is a function of a Run",
    }
    for name, line in cases.items():
        with pytest.raises(fd.InputError, match=line):
            metrics_of(["motor_torque_max", name], model, aim)
    assert aim_of(noise, model, 3.0).rest == 2.0  # after its end the torque is zero


def test_a_metric_of_ones_own(tmp_path: Path) -> None:
    """A function in the study's folder is imported from there, and gives its unit and sentence; true counts as 1."""
    (tmp_path / "own_numbers_a.py").write_text(
        'def last(run):\n    "Last position."\n    return run.q[-1, 0]\nlast.unit = "m"\n'
        "def moved(run):\n    return run.q[-1, 0] != run.q[0, 0]\n"
        "def none(run):\n    pass\ndef two(run):\n    return run.q[:2, 0]\n"
        "def broken(run):\n    return 1 / 0\ndef nan(run):\n    return float('nan')\n",
        encoding="utf-8",
    )
    run = fd.simulate(oscillator(tmp_path, 0.1), None, 0.1, q0=[1.0], rate=100)
    aim = aim_of(None, run.model, 0.1)
    names = [f"own_numbers_a:{name}" for name in ("last", "moved", "none", "two", "broken", "nan")]
    found = metrics_of([*names, "motor_torque_max"], run.model, aim, tmp_path)
    assert (found[0].unit, found[0].description) == ("m", "Last position.")
    measured, (reasons,) = metrics_of_runs(found, RunsMotion.of(run, aim))
    values = measured[:, 0]
    assert values[:2].tolist() == [run.q[-1, 0], 1.0]
    assert np.isnan(values[2:6]).all()
    assert values[6] == 0.0
    assert reasons == [
        "metric own_numbers_a:none: one number is needed, not a NoneType",
        "metric own_numbers_a:two: one number is needed, not an array of shape (2,)",
        "metric own_numbers_a:broken: ZeroDivisionError: division by zero",
        "metric own_numbers_a:nan: it gives nan",
    ]


def test_a_module_of_the_same_name_from_elsewhere_is_not_taken(tmp_path: Path) -> None:
    """Two studies with files of one name: the second is refused rather than measured by the first's function."""
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "own_numbers_b.py").write_text("def f(run):\n    return 1.0\n", encoding="utf-8")
    assert metric("own_numbers_b:f", tmp_path / "one").name == "own_numbers_b:f"
    with pytest.raises(fd.InputError, match=r"another module own_numbers_b is loaded already, from .*one"):
        metric("own_numbers_b:f", tmp_path / "two")


def test_a_module_that_fails_is_said_in_one_line(tmp_path: Path) -> None:
    """An error in the user's module names the error and the metric."""
    (tmp_path / "own_numbers_c.py").write_text("import this_is_not_there\n", encoding="utf-8")
    with pytest.raises(
        fd.InputError, match=r"cannot be imported \(No module named 'this_is_not_there'\); it is looked"
    ):
        metric("own_numbers_c:f", tmp_path)
