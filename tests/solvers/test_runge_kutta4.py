"""RungeKutta4 takes no dry friction, whichever law and side it is, unless it may smooth it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.simulation.solvers import DormandPrince, RungeKutta4
from tests.solvers.arms import planar

DRY = [
    kind for kind in fd.effects.catalogue().values() if kind.stage == "dry" and kind.__module__.startswith("flexdyn.")
]


def cases() -> list[tuple[Any, str]]:
    """Every dry law on every side that it may stand on."""
    return [(kind, side) for kind in DRY for side in kind.sides]


@pytest.mark.parametrize(("kind", "side"), cases(), ids=lambda value: getattr(value, "name", value))
def test_dry_friction_is_refused_with_the_remedy(kind: Any, side: str) -> None:
    """One line that names the law; with smoothing it runs, and the notes say that a loaded joint creeps."""
    example = kind.example("shoulder", "elbow")
    friction = fd.effects.effect_from_dict(example.to_dict() | {"joint": "shoulder", "side": side})
    model = planar(40.0, [friction])
    with pytest.raises(fd.InputError, match=rf"the model has {kind.name}; use DormandPrince, or give .* smoothing"):
        fd.simulate(model, [1.0], 0.1, RungeKutta4(step=1e-3))
    run = fd.simulate(model, [1.0], 0.1, RungeKutta4(step=1e-3, smoothing=0.01))
    assert "creeps" in run.notes[0]
    assert np.isfinite(run.q).all()


def test_smoothed_friction_creeps_as_it_says() -> None:
    """Under half its level the smoothed joint moves at smoothing*atanh(1/2), where the exact one stays."""
    model = planar(np.inf, [fd.effects.CoulombFriction("shoulder", side="link", level=1.0)])
    smoothed = fd.simulate(model, [0.5], 5.0, RungeKutta4(step=1e-3, smoothing=0.01))
    exact = fd.simulate(model, [0.5], 5.0, DormandPrince())
    assert smoothed.v[-1, 0] == pytest.approx(0.01 * np.arctanh(0.5), rel=1e-6)
    assert (exact.q == 0.0).all()
