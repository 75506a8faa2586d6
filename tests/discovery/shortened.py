"""Cases of the benchmark with shorter recordings, from files to the verdict."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from cases import sensors_of
from make import build, write_case

import flexdyn as fd

SHORT, LONGER, WIDE = (8.0, 4.0), (20.0, 8.0), (40.0, 12.0)
"""Lengths of the fit and of the check [s]: with both encoders, with one, which needs more, and of wide ranges."""


def diagnosed(family: str, seed: int, number: int, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the diagnosis says of a case; then the truth, which is read after it."""
    lengths = WIDE if family.endswith("_wide") else LONGER if family in ("motor_only", "link_only") else SHORT
    case = write_case(build(family, seed, number, *lengths, sensors_of(family)), folder / family)
    fit, check = (fd.read_recording(case / f"{part}.npz") for part in ("fit", "check"))
    found = fd.diagnose(fd.load_model(case / "model.yaml"), [fit], [check]).to_dict()
    return found, json.loads((folder / f"{family}.truth" / f"{case.name}.json").read_text())
