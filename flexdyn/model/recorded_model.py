"""The model that a saved run holds: `Run.to_recording` writes it into the recording's meta."""

from __future__ import annotations

from pathlib import Path

from flexdyn.errors import InputError
from flexdyn.io.yaml import parse_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_from_dict
from flexdyn.records import Recording

NAME_IT = "name it: model=..., on the command line --model MODEL"
"""The remedy if a recording does not say which arm it belongs to."""


def model_in(recording: Recording) -> FlexibleJointModel | None:
    """The model in the meta data of a run's recording; None if there is none.

    Raises:
        InputError: the text is no model, or its URDF does not exist any more.
    """
    text = recording.meta.get("model")
    if text is None:
        return None
    try:
        if not isinstance(text, str):
            raise InputError("the text of a model file is needed", value=text)
        return model_from_dict(parse_yaml(text), Path.cwd(), name=recording.name)
    except InputError as error:
        problem = f"the model that the recording holds cannot be read: {error.problem}"
        raise InputError(problem, **{**error.data, "remedy": NAME_IT}) from None
