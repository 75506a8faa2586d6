"""What the study of the friction damper gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from damper_compared import Compared
from damper_data import Array, Errors

import flexdyn as fd


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        diagnoses: of the rigid axis without friction, by file.
        errors: of the fitted models.
        slow_errors: of the same models without the force on accelerations above 15 Hz.
        plain_errors: of the axis without friction.
        less: errors of the fitted cycles where one part is left out, by part and file [1].
        compared: every number over the tensions.
        records: by file.
        forces: of the fitted models over the whole 1 Hz files [N].
    """

    diagnoses: Mapping[str, fd.Diagnosis]
    errors: Errors
    slow_errors: Errors
    plain_errors: Errors
    less: Mapping[str, Mapping[str, float]]
    compared: Sequence[Compared]
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
