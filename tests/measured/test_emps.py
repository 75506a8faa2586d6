"""EMPS: the published model and controller give the published errors, and the record says when its voltage acts."""

from __future__ import annotations

from pathlib import Path

import pytest
from emps_data import HERE, closed_loop, inverse, least_squares, published, read_records, replayed_controller

import flexdyn as fd

DATA = Path(__file__).parents[3] / "shared" / "data" / "emps"
Records = dict[str, fd.Recording]

pytestmark = pytest.mark.skipif(
    not (DATA / "DATA_EMPS.mat").is_file(), reason=f"{DATA} is absent: the records of EMPS are read there"
)


@pytest.fixture(scope="module")
def records() -> Records:
    """Both, by name."""
    return read_records(DATA)


@pytest.fixture(scope="module")
def model() -> fd.FlexibleJointModel:
    """The report's first model, from its numbers."""
    return published(fd.load_model(HERE / "plain.yaml"))


@pytest.mark.parametrize(("name", "printed"), [("DATA_EMPS", 0.040834), ("PULSES", 0.059824)])
def test_inverse_model_error_is_the_printed_one(
    records: Records, model: fd.FlexibleJointModel, name: str, printed: float
) -> None:
    """In the authors' way, with the authors' numbers: 4.08 and 5.98 %."""
    assert inverse(model, records[name]).error == pytest.approx(printed, rel=0.02)


@pytest.mark.parametrize(("name", "printed"), [("DATA_EMPS", 0.05848), ("PULSES", 0.089409)])
def test_closed_loop_error_with_the_diagrams_delay_is_near_the_printed_one(
    records: Records, model: fd.FlexibleJointModel, name: str, printed: float
) -> None:
    """5.85 and 8.94 % in the report's Simulink diagram, which has a sample of delay; without it both are better."""
    late = closed_loop(model, records[name], delay=1)
    prompt = closed_loop(model, records[name])
    assert late.force_error == pytest.approx(printed, rel=0.05)
    assert prompt.force_error < 0.8 * late.force_error
    assert prompt.position_error < 2e-5


@pytest.mark.parametrize("name", ["DATA_EMPS", "PULSES"])
def test_the_recorded_voltage_is_of_its_own_row(records: Records, name: str) -> None:
    """The published law along the measured positions gives the recorded output to 0.3 %, and not a sample off."""
    assert replayed_controller(records[name]) < 0.003
    assert min(replayed_controller(records[name], delay) for delay in (-1, 1)) > 0.03


def test_friction_of_either_direction_is_within_reach(records: Records) -> None:
    """Plain least squares with the report's second model finds its 3.11 %: the bound of 3.2 % asks for no more."""
    fit, check = least_squares(records["DATA_EMPS"], list(records.values()))
    assert fit == pytest.approx(0.031117, rel=0.03)
    assert check < 0.06
