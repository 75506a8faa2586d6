"""flexdyn compare-models: tables and JSON; and a rig's recording on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import flexdyn as fd
from tests.arms import slider
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


def test_a_rig_is_diagnosed_from_its_map(flexdyn: Runner, tmp_path: Path) -> None:
    """prescribed: [slide] in the map is all that the command line needs; the table says that the position is given."""
    t = np.linspace(0.0, 6.0, 1501)
    x = 0.03 * np.sin(4.0 * t) + 0.01 * np.sin(11.0 * t)
    v = 0.12 * np.cos(4.0 * t) + 0.11 * np.cos(11.0 * t)
    a = -0.48 * np.sin(4.0 * t) - 1.21 * np.sin(11.0 * t)
    noise = np.random.default_rng(2)
    seen = {"x": x + noise.normal(0.0, 1e-7, t.size), "f": 3.0 * a + 5.0 * np.sign(v) + noise.normal(0.0, 0.05, t.size)}
    fd.write_recording(fd.Recording(t, seen), tmp_path / "rig.csv")
    model = fd.FlexibleJointModel(slider(tmp_path), {"lift": {"rotor_inertia": 0.5}}, gravity=[0.0] * 3)
    fd.save_model(model, tmp_path / "axis.yaml")
    channels = "{q.lift: {from: x, unit: m}, tau.lift: {from: f, unit: N}}"
    (tmp_path / "map.yaml").write_text(
        f"{{flexdyn_map: 1, prescribed: [lift], channels: {channels}}}", encoding="utf-8"
    )
    outcome = flexdyn("diagnose", "axis.yaml", "rig.csv", "--map", "map.yaml", "-o", "report")
    assert outcome.code == 0, outcome.err
    assert "Coulomb friction" in outcome.out
    assert "prescribed" in outcome.out
