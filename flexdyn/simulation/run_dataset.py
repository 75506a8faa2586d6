"""Runs as xarray datasets."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.records import Recording
from flexdyn.simulation.energy import Energy

_ENERGIES = {
    "kinetic": "kinetic energy of links and rotors",
    "spring": "energy held by springs",
    "gravity": "energy of the links in the field of gravity",
    "supplied": "energy supplied by the motors since the start",
    "external": "energy supplied by external wrenches since the start",
    "dissipated": "energy dissipated since the start",
}


def run_dataset(rec: Recording, energy: Energy | None) -> Any:
    """Make the dataset of a run's recording, with its energy ledger if that is given.

    Args:
        rec: every signal of every joint.
        energy: adds kinetic, spring, gravity and external over ``t``, supplied over ``(t, joint)`` and dissipated over
            ``(t, entry)`` [J].

    Returns:
        An xarray.Dataset.

    Raises:
        MissingExtra: xarray is not installed.
    """
    dataset = rec.to_xarray()
    if energy is None:
        return dataset
    entries = list(energy.dissipated)
    lost = np.column_stack(list(energy.dissipated.values())) if entries else np.empty((len(rec), 0))
    parts: dict[str, Any] = {
        name: ("t", getattr(energy, name)) for name in ("kinetic", "spring", "gravity", "external")
    }
    parts |= {"supplied": (("t", "joint"), energy.supplied), "dissipated": (("t", "entry"), lost)}
    dataset = dataset.assign_coords(entry=np.array(entries, dtype=str)).assign(parts)
    for name, words in _ENERGIES.items():
        dataset[name].attrs |= {"units": "J", "long_name": words}
    return dataset
