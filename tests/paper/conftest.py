"""The arm and the cases that several tests look at."""

from __future__ import annotations

import pytest

from flexdyn.paper.cases import PaperCases
from flexdyn.paper.equations import Arm


@pytest.fixture(scope="session")
def arm() -> Arm:
    """Table I with a rotor inertia and some damping."""
    return Arm(J=0.1, v=0.05)


@pytest.fixture(scope="session")
def cases() -> PaperCases:
    """The shipped model and its variations."""
    return PaperCases()
