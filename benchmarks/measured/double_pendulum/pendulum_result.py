"""What the double pendulum's study gives: the diagnosis, and models held against every record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pendulum_data import Current, Windows

import flexdyn as fd


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        diagnosis: of the frictionless model.
        windows: by model and record.
        currents: by record and joint.
    """

    diagnosis: fd.Diagnosis
    windows: Mapping[str, Mapping[str, Windows]]
    currents: Mapping[str, Mapping[str, Current]]
