"""A joint that the model file takes for rigid, end to end, shortened."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from make import build, write_case
from recording import Sensors
from score import outcome

import flexdyn as fd


def test_an_elasticity_is_named_alone_and_its_stiffness_is_right(tmp_path: Path) -> None:
    """At its joint, on an arm of which the model says that no joint is elastic, to 2 percent."""
    case = build("rigid", 3, 5, 24.0, 8.0, Sensors())
    folder = write_case(case, tmp_path / "rigid")
    model = fd.load_model(folder / "model.yaml")
    fit, check = (fd.read_recording(folder / f"{part}.npz") for part in ("fit", "check"))
    found = fd.diagnose(model, [fit], [check]).to_dict()
    truth = json.loads((tmp_path / "rigid.truth" / f"{folder.name}.json").read_text())
    assert outcome(truth, found) == "right", (found["findings"], truth["hidden"])
    stiffness = found["findings"][0]["parameters"]["stiffness"]["value"]
    assert stiffness == pytest.approx(truth["hidden"][0]["parameters"]["stiffness"], rel=0.02)
