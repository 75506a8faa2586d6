"""The KUKA's recordings: a balancer is what the torque of axis 2 lacks, a lag is what parts the encoders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kuka_encoders import account, differences, ripple
from kuka_torque import inverse, motor_side, read_records, references, torque_noise

import flexdyn as fd

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "benchmarks" / "measured" / "kuka_kr300"
DATA = ROOT.parent / "shared" / "data" / "kuka_kr300"

pytestmark = pytest.mark.skipif(
    not (DATA / "recorded_A.mat").is_file(), reason=f"{DATA} is absent: recordings of a KUKA KR 300 are read there"
)


@pytest.fixture(scope="module")
def records() -> dict[str, fd.Recording]:
    """All three."""
    return read_records(DATA)


@pytest.fixture(scope="module")
def corrected() -> fd.FlexibleJointModel:
    """The published model with the spring of plain least squares."""
    spring = fd.effects.ParallelSpring("axis2", stiffness=6560.0, rest=-1.69)
    model = fd.load_model(STUDY / "rigid.yaml")
    return model.replace(effects=[*model.effects, spring])


def test_friction_is_not_what_axis_2_lacks_and_a_spring_is(records: dict[str, fd.Recording]) -> None:
    """Fitted to A: viscous, Coulomb and offset leave over 70 % of the torque of B and C, a spring at most 20 %."""
    found = references(fd.load_model(STUDY / "rigid.yaml"), records, 1)
    plain, spring = found["viscous, Coulomb, offset"], found["and a spring"]
    assert min(plain["B"], plain["C"]) > 0.7
    assert max(spring["B"], spring["C"]) < 0.2
    assert max(spring["B moving"], spring["C moving"]) < 0.1


def test_four_free_numbers_of_position_fit_better_and_predict_worse(records: dict[str, fd.Recording]) -> None:
    """Record A does not tell two harmonics: what fits it best fails on B, whose range is another one."""
    found = references(fd.load_model(STUDY / "rigid.yaml"), records, 1)
    assert found["and harmonics 1 and 2"]["A"] < found["and a spring"]["A"]
    assert found["and harmonics 1 and 2"]["B"] > 1.0


def test_inverse_model_with_the_spring_explains_the_other_records(
    records: dict[str, fd.Recording], corrected: fd.FlexibleJointModel
) -> None:
    """The published friction and one spring of axis 2, no other number touched."""
    for name in ("B", "C"):
        assert inverse(corrected, records[name]).error(1, moving=True) < 0.2


def test_a_lag_of_three_milliseconds_parts_the_encoders(
    records: dict[str, fd.Recording], corrected: fd.FlexibleJointModel
) -> None:
    """The same on three axes of other size and load, so it is of the channel; a spring comes second on axes 2 and 3."""
    seen = {name: differences(corrected, each, (0, 1, 2)) for name, each in records.items()}
    accounts = [account({name: each[j] for name, each in seen.items()}) for j in range(3)]
    assert [each.terms[0] for each in accounts] == ["lag"] * 3
    lags = [value for each in accounts for value in each.estimates["lag"].values()]
    assert np.mean(lags) == pytest.approx(3.03e-3, abs=0.05e-3)
    assert np.std(lags) < 0.06e-3
    assert [each.terms[1] for each in accounts[1:]] == ["spring"] * 2
    for each in accounts:
        assert each.left[-1]["B"] < 0.12 * each.left[0]["B"]


def test_the_ripple_of_axis_2_is_the_link_encoders_own(
    records: dict[str, fd.Recording], corrected: fd.FlexibleJointModel
) -> None:
    """Counted by the encoder's own angle its phase is one at all speeds; a gear's would follow the motor's angle."""
    seen = {name: differences(corrected, each, (1,))[0] for name, each in records.items()}
    wave = ripple(seen)
    assert wave.harmonic == pytest.approx(826.0, abs=1.5)
    assert wave.own < 0.5 * wave.motor
    assert wave.size[-1] > 0.5 * wave.size[0]


def test_some_of_the_files_numbers_are_told_and_some_are_not(
    records: dict[str, fd.Recording], corrected: fd.FlexibleJointModel
) -> None:
    """Ten seconds of one motion: the first rotor acts in one sum with links, the second link weighs hardly alone."""
    record = motor_side(records["A"])
    told = fd.base_parameters(corrected, record, noise=torque_noise(inverse(corrected, record)), friction=True)
    verdicts = {(each.of, each.parameter): each.verdict for each in told.numbers}
    assert verdicts["axis1", "rotor_inertia"] == "combined"
    assert verdicts["link2", "link_mass"] == "weak"
    assert {verdicts[f"axis{k}", "rotor_inertia"] for k in (4, 5, 6)} <= {"told", "weak"}
    assert told.rank < 6 * 14
