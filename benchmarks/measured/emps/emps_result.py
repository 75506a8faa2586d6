"""What the EMPS study gives: the diagnosis, and models held against both records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from emps_data import Inverse, Loop, closed_loop, inverse

import flexdyn as fd


@dataclass(frozen=True, eq=False)
class Account:
    """One model held against both records.

    Attributes:
        loops: by record, the published controller in the loop.
        inverses: by record, along the measured motion.
    """

    loops: Mapping[str, Loop]
    inverses: Mapping[str, Inverse]

    @classmethod
    def of(cls, model: fd.FlexibleJointModel, records: Mapping[str, fd.Recording], delay: int = 0) -> Account:
        """Of a model; `delay` is the controller's, in samples."""
        loops = {name: closed_loop(model, each, delay) for name, each in records.items()}
        return cls(loops, {name: inverse(model, each) for name, each in records.items()})

    def errors(self) -> dict[str, float]:
        """Force errors by kind and record [1]."""
        found = {f"inverse model, {name}": each.error for name, each in self.inverses.items()}
        found |= {f"closed loop, {name}": each.force_error for name, each in self.loops.items()}
        return found | {f"closed loop position, {name}": each.position_error for name, each in self.loops.items()}


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        diagnosis: of the plain axis.
        accounts: by model.
        late: errors of the controller's law along the measured positions, by delay in samples [1].
        reference: force errors of plain least squares with friction of either direction, by record [1].
    """

    diagnosis: fd.Diagnosis
    accounts: Mapping[str, Account]
    late: Mapping[int, Mapping[str, float]]
    reference: Mapping[str, float]
