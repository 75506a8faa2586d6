"""Small studies that several test files run: a mass on a rotor, weightless, cheap and known in closed form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import flexdyn as fd
from tests.arms import slider

FORCE = 6.0


def pulse_study(folder: Path, **changes: Any) -> dict[str, Any]:
    """A mass hangs on its rotor by a spring; a force acts on the rotor for 50 ms. Files are written to the folder.

    Args:
        folder: that the study's paths are relative to.
        changes: of the study's entries.
    """
    slider(folder)
    (folder / "model.yaml").write_text(
        "flexdyn: 1\nrobot: {urdf: slider.urdf, gravity: [0.0, 0.0, 0.0]}\n"
        "joints: {lift: {rotor_inertia: 0.5, stiffness: 800.0}}\n"
        "effects:\n- {effect: viscous_friction, joint: lift, side: motor, coefficient: 0.1}\n",
        encoding="utf-8",
    )
    force = np.where(np.arange(6) < 5, FORCE, 0.0)
    fd.write_recording(fd.Recording(0.01 * np.arange(6), {"tau.lift": force}), folder / "pulse.csv")
    study = {
        "flexdyn_study": 1,
        "model": str(folder / "model.yaml"),
        "command": str(folder / "pulse.csv"),
        "duration": 0.4,
        "rate": 250,
        "solver": {"name": "DormandPrince", "rtol": 1e-9, "atol": 1e-11},
        "runs": 40,
        "seed": 3,
        "vary": {
            "joints.lift.stiffness": {"uniform": [600.0, 1000.0]},
            "command.scale": {"uniform": [0.5, 1.5]},
        },
        "keep": ["q", "theta"],
        "metrics": ["motor_torque_max", "residual_vibration"],
    }
    return study | changes
