"""Hidden effects of the benchmark, shortened: the diagnosis sees files alone, the truth is read after its verdict."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cases import sensors_of
from make import build, write_case
from score import outcome

import flexdyn as fd

CASES = [
    ("single", 3, 3),  # Coulomb friction on a link
    ("single", 3, 5),  # Stribeck friction on a motor
    ("single", 3, 11),  # a torque offset
    ("single", 3, 17),  # an encoder that lags
    ("none", 4, 0),
    ("none", 4, 1),
    ("outside", 4, 0),  # a torque that drifts: no effect of the catalogue
]


@pytest.mark.parametrize(("family", "seed", "number"), CASES, ids=[f"{f}-{s}-{n}" for f, s, n in CASES])
def test_what_is_hidden_is_named_and_nothing_else(family: str, seed: int, number: int, tmp_path: Path) -> None:
    """Effect, joint and side, with a model file up to 3 % wrong in every number; none named where none is there."""
    case = build(family, seed, number, 24.0, 8.0, sensors_of(family))
    folder = write_case(case, tmp_path / family)
    model = fd.load_model(folder / "model.yaml")
    fit, check = (fd.read_recording(folder / f"{part}.npz") for part in ("fit", "check"))
    found = fd.diagnose(model, [fit], [check]).to_dict()
    truth = json.loads((tmp_path / f"{family}.truth" / f"{folder.name}.json").read_text())
    assert outcome(truth, found) == "right", (found["findings"], truth["hidden"])
