"""The verdict, and what decides it."""

from __future__ import annotations

import pytest

from flexdyn.diagnose.decision.verdict import is_noise, quantities, verdict
from flexdyn.diagnose.report.measures import Left


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
