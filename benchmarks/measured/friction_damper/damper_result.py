"""What the study of the friction damper gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from damper_data import Array, Errors

import flexdyn as fd


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        diagnoses: by 1 Hz file.
        mass: of the bench, of all files [kg].
        errors: of the corrected models.
        errors_without: of the same models without the bench's mass.
        plain_errors: of the models before their diagnosis, brakes behind springs, without damping.
        compared: the corrected models over the tensions.
        records: by file.
        forces: computed by the corrected models over the whole 1 Hz files [N].
    """

    diagnoses: Mapping[str, fd.Diagnosis]
    mass: float
    errors: Errors
    errors_without: Errors
    plain_errors: Errors
    compared: fd.ModelsCompared
    records: Mapping[str, fd.Recording]
    forces: Mapping[str, Array]

    def named(self) -> list[str]:
        """What the diagnoses name, by tension."""
        found = []
        for file, diagnosis in self.diagnoses.items():
            for each in diagnosis.findings:
                effects = dict.fromkeys((each.suspect.effect, *(rival.effect for rival in each.rivals)))
                found.append(f"{' or '.join(effects)} ({file.rpartition('_')[2].replace('lb', ' lb')})")
        return found
