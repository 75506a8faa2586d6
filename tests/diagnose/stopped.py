"""A real diagnosis that is stopped as soon as it has read its recordings: what it took, without the minutes after."""

from __future__ import annotations

from typing import Any

import pytest

import flexdyn as fd
from flexdyn.diagnose.report.result import Interrupted


def taken_by_a_diagnosis(model: fd.FlexibleJointModel, fit: Any, check: Any = ()) -> list[tuple[str, float, int]]:
    """Name, first time [s] and number of samples of every recording that is fitted, as the report lists them.

    Args:
        model: as given.
        fit: as `fd.diagnose` takes it.
        check: likewise.
    """

    def stop(stage: str, share: float) -> None:
        if stage.startswith("comparing"):
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        fd.diagnose(model, fit, check, progress=stop)
    assert caught.value.diagnosis is not None
    data = caught.value.diagnosis.to_dict()["data"]
    assert {each["role"] for each in data} == {"fit"}
    return [(each["file"], each["from"], each["samples"]) for each in data]
