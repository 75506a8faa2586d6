"""The verdict, and what decides it."""

from __future__ import annotations

import pytest

from flexdyn.diagnose.decision.verdict import is_noise, quantities, simulations_tell, verdict
from flexdyn.diagnose.report.measures import Gap, Left


@pytest.mark.parametrize(
    ("named", "noise", "said"),
    [
        (False, True, "no_discrepancy"),
        (True, True, "explained"),
        (True, False, "partly_explained"),
        (False, False, "unexplained"),
        (True, None, "untested"),
        (False, None, "untested"),
    ],
)
def test_the_verdict_says_what_is_named_and_what_is_left(*, named: bool, noise: bool | None, said: str) -> None:
    """And nothing of it where the fit had not converged."""
    assert verdict(named=named, noise=noise, converged=True) == said
    assert verdict(named=named, noise=noise, converged=False) == "not_converged"


def test_without_windows_the_equations_decide() -> None:
    """Test data shorter than a window still have rows."""
    assert is_noise(None, ())
    assert not is_noise(None, (Left("elbow", 0.02, 0.1),))


def test_simulations_that_noise_rules_tell_nothing() -> None:
    """Those of a right model are off by about as much as noise makes, whatever the given one was."""
    assert simulations_tell(Gap(before=196.0, calibrated=196.0, after=1.1, floor=1.0))
    assert simulations_tell(Gap(before=0.9, calibrated=0.9, after=0.9, floor=1.1))
    assert not simulations_tell(Gap(before=196.0, calibrated=196.0, after=60_000.0, floor=50_667.0))


@pytest.mark.parametrize(
    ("regime", "expected"),
    [
        ("everywhere", []),
        ("abs(omega) < 0.1 rad/s", ["omega"]),
        ("q between 0.4 and 0.6 rad and t < 11 s", ["q", "t"]),
        ("omega > 0 and abs(tau_s) > 26 N m", ["omega", "tau_s"]),
        ("< 0.02 rad after a reversal and abs(v of shoulder) between 0.0023 and 0.084 rad/s",
         ["reversal", "v of shoulder"]),
    ],
)  # fmt: skip
def test_quantities_are_read_from_a_regime(regime: str, expected: list[str]) -> None:
    """In the order in which they stand there."""
    assert quantities(regime) == expected
