"""What the benchmark's own simulator says of laws that are the same and of laws that are not."""

from __future__ import annotations

import cases
import pytest
from hidden import Hidden, Site
from plants import true_plant
from score import INSEPARABLE
from separable import delta_bic, site_of
from two_link_run import controlled

KINEMATIC = Hidden("kinematic_error", 0, "transmission", {"amplitude": 1e-4, "harmonic": 2.0, "phase": 0.6})
OFFSET = Hidden("sensor_offset", 0, "sensor", {"offset": 2e-3}, {"channel": "q.shoulder"})
DRAG = Hidden("quadratic_drag", 0, "motor", {"coefficient": 1.0})


@pytest.mark.parametrize(
    ("true", "rival", "apart"),
    [
        # It bends the same, and hardly pulls.
        pytest.param(KINEMATIC, ("encoder_eccentricity", 0, "theta"), False, marks=pytest.mark.slow),
        # Lying down, the first joint has no zero of its own.
        pytest.param(OFFSET, ("sensor_offset", 0, "theta"), False, marks=pytest.mark.slow),
        pytest.param(DRAG, ("torque_offset", 0, "motor"), True, marks=pytest.mark.slow),
        (KINEMATIC, None, True),
    ],
    ids=lambda each: each if isinstance(each, bool) else (each[0] if isinstance(each, tuple) else None),
)
def test_laws_are_apart_where_they_do_not_do_the_same(true: Hidden, rival: Site | None, apart: bool) -> None:
    """By a delta BIC of 20, over a short motion of an arm that lies."""
    one = next(c for c in (cases.make_case("none", 5, k, 3.0, 1.5) for k in range(20)) if not c.arm.vertical)
    plant = true_plant(one.arm, (true,))
    runs = [controlled(plant, control) for control in one.controls]
    case = type(one)(
        one.name, (true,), one.arm, one.arm, plant, runs[0], runs[1], one.recordings, one.sensors, one.controls
    )
    assert (delta_bic(case, true, rival) > INSEPARABLE) == apart


@pytest.mark.parametrize(
    ("effect", "expected"), [("directional_gear_loss", None), ("viscous_friction", ("viscous_friction", 1, "motor"))]
)
def test_a_rival_has_a_site_only_where_the_simulator_has_its_law(effect: str, expected: Site | None) -> None:
    """A report may name laws of the catalogue that no case can hide."""
    given = cases.make_case("none", 5, 0, 3.0, 1.5).given
    assert site_of({"effect": effect, "joint": "elbow", "side": "motor"}, given) == expected
