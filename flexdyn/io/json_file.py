"""JSON files as untrusted input: bounded size, UTF-8, no NaN, errors of one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NoReturn

from flexdyn.errors import InputError
from flexdyn.io.files import bounded_text


def read_json(path: Path, most: int) -> Any:
    """Read a JSON file; infinite numbers and NaN, which JSON does not have, are refused.

    Args:
        path: of the file.
        most: largest size that is read [bytes].

    Raises:
        InputError: no such file, a file that is too large, or not JSON.
    """
    text = bounded_text(path, most, encoding="utf-8", remedy="give the file as it was written")
    try:
        return json.loads(text, parse_constant=_refuse)
    except RecursionError:
        raise InputError("not valid JSON (lists and objects nest too deep)", file=path) from None
    except ValueError as error:
        raise InputError(f"not valid JSON ({str(error)[:200]})", file=path) from None


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number of JSON")
