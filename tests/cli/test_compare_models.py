"""flexdyn compare-models: tables and JSON."""

from __future__ import annotations

from pathlib import Path

import flexdyn as fd
from tests.cli.conftest import Runner


def test_tables_and_json(flexdyn: Runner, tmp_path: Path) -> None:
    """What moved, with both values; the JSON is that of fd.compare_models; one model is a mistake."""
    arm = fd.load_model("scara_two_link").replace(tolerance=0.01)
    worn = arm.replace(joints={"elbow": {"stiffness": 0.8 * arm.joints["elbow"].stiffness}})
    for name, model in (("new", arm), ("worn", worn)):
        fd.save_model(model, tmp_path / f"{name}.yaml")
    outcome = flexdyn("compare-models", "new.yaml", "worn.yaml")
    assert (outcome.code, outcome.err) == (0, "")
    (row,) = [line for line in outcome.out.splitlines() if "stiffness of elbow" in line]
    assert row.rstrip().endswith("moved")
    found = flexdyn("compare-models", "new.yaml", "worn.yaml", "--json").json
    assert found["labels"] == ["new", "worn"]
    assert found["numbers"][0]["name"] == "stiffness of elbow"
    assert found["numbers"][0]["verdict"] == "moved"
    alone = flexdyn("compare-models", "new.yaml")
    assert alone.code == 2
    assert "give a list of two models or more" in alone.err
