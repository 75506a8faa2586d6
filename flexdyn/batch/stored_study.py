"""What a store's metadata say, as untrusted input: the study, and the arrays that must be those of the study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from flexdyn.batch import study_keys
from flexdyn.batch.layout import array_name
from flexdyn.batch.study import Study
from flexdyn.checks import whole
from flexdyn.control.setting_checks import checked_rate
from flexdyn.errors import InputError
from flexdyn.io.yaml import check_keys, parse_yaml
from flexdyn.robot.urdf import MAX_JOINTS
from flexdyn.simulation.job import MAX_SAMPLES

MAX_STORE_BYTES = 20_000_000
"""Largest size of a store's zarr.json [bytes]: the study, and a kilobyte for each number that varies."""
MAX_STUDY_LETTERS = 2_000_000
"""Largest length of the study in it: a study file of the largest size, with every number written out."""


def stored_study(text: Any) -> Study:
    """The study in the metadata of a store; its files may be gone, so that they are not looked at.

    Args:
        text: from `Study.to_text`.

    Raises:
        InputError: it is no study, or holds a number or name that no study has.
    """
    if not isinstance(text, str) or len(text) > MAX_STUDY_LETTERS:
        raise InputError(f"a study of up to {MAX_STUDY_LETTERS} letters is needed", key="study")
    content = parse_yaml(text)
    names = [each.name for each in fields(Study)]
    check_keys(content, names, required=names)
    kinds = {"name": str, "folder": str, "model": Mapping, "solver": Mapping, "files": Mapping, "vary": Mapping}
    for key, kind in {**kinds, "keep": list, "metrics": list}.items():
        _check(key, content[key], kind)
    if isinstance(content["command"], Mapping):
        _check("command.pd", content["command"].get("pd"), Mapping)
        study_keys.checked_pd(content["command"], "command.pd")
    else:
        _check("command", content["command"], (str, type(None)))
    for path in content["vary"]:
        _check("vary", path, str)
    study_keys.checked_distributions(content["vary"])
    study_keys.checked_solver(content["solver"])
    study_keys.checked_channels(content["keep"])
    study_keys.checked_names("metrics", content["metrics"])
    study_keys.check_number_of_runs(*(whole(key, content[key], 1, study_keys.MAX_RUNS) for key in ("runs", "points")))
    whole("chunk", content["chunk"], 1, study_keys.MAX_RUNS)
    study_keys.checked_seed(content["seed"])
    study_keys.checked_duration(content["duration"])
    checked_rate("rate", content["rate"])
    return Study.from_dict(content)


def _check(key: str, value: Any, kind: type | tuple[type, ...]) -> None:
    if not isinstance(value, kind):
        raise InputError("it is of another kind than in a study", key=key, value=value)


def check_arrays(found: Any, study: Study) -> None:
    """Check that the arrays of a store have the shapes and kinds that the study gives them.

    Args:
        found: xarray.Dataset of them, as they are called in the store.
        study: of the store.

    Raises:
        InputError: an array is missing, or is another.
    """
    run = ("run",)
    shapes: dict[str, tuple[tuple[str, ...], str]]
    shapes = {"run": (run, "i"), "time": (("time",), "f"), "joint": (("joint",), "OTU"), "status": (run, "OTU")}
    shapes |= dict.fromkeys(study.keep, (("run", "time", "joint"), "f"))
    shapes |= {array_name(name): (run, "f") for name in (*study.vary, *study.metrics)}
    for name, (dims, kinds) in shapes.items():
        if name not in found.variables:
            raise InputError("the array is missing", key=name)
        array = found.variables[name]
        if array.dims != dims or array.dtype.kind not in kinds:
            raise InputError("the array is not that of the study", key=name)
    if found.sizes["run"] != study.count or found.sizes["time"] > MAX_SAMPLES or found.sizes["joint"] > MAX_JOINTS:
        raise InputError("the arrays have another size than those of the study", value=dict(found.sizes))
