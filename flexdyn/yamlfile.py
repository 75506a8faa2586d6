"""YAML files as untrusted input: version 1.2, safe types, bounded size, one line on what is wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexdyn.errors import InputError, did_you_mean

MAX_BYTES = 4_000_000


def read_yaml(path: Path) -> Mapping[str, Any]:
    """The mapping that a YAML file holds; numbers as YAML 1.2 reads them (4e-05 is one).

    Raises:
        InputError: no such file, too large, not YAML, or no mapping.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"the file is larger than {MAX_BYTES} bytes", file=path)
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError("there is no such file", file=path) from None
    except OSError as error:
        raise InputError(f"it cannot be read ({error.strerror})", file=path) from None
    except UnicodeDecodeError:
        raise InputError("it is not a text file in UTF-8", file=path) from None
    return parse_yaml(text, path)


def parse_yaml(text: str, path: Path | None = None) -> Mapping[str, Any]:
    """As `read_yaml`, of text already read; `path` is for messages."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    yaml = YAML(typ="safe", pure=True)  # pure Python: the C parser reads YAML 1.1, where 4e-05 is a string
    try:
        content = yaml.load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = "" if mark is None else f" in line {mark.line + 1}"
        raise InputError(f"not valid YAML{line} ({(error.problem or '').splitlines()[0]})", file=path) from None
    except (YAMLError, ValueError, TypeError, RecursionError) as error:
        raise InputError(f"not valid YAML ({str(error).splitlines()[0]})", file=path) from None
    if not isinstance(content, Mapping):
        raise InputError("a mapping of keys is needed", file=path, value=content)
    return content


def check_keys(content: Any, known: Sequence[str], *, required: Sequence[str] = (), key: str = "") -> None:
    """Refuse a key that nobody reads, and miss one that is needed.

    Raises:
        InputError: with the near miss.
    """
    if not isinstance(content, Mapping):
        raise InputError("a mapping of keys is needed", key=key or None, value=content)
    prefix = f"{key}." if key else ""
    for name in content:
        if name not in known:
            raise InputError("no such key", key=f"{prefix}{name}", remedy=did_you_mean(str(name), known))
    for name in required:
        if name not in content:
            raise InputError("the key is missing", key=f"{prefix}{name}")


def dump_yaml(content: Mapping[str, Any]) -> str:
    """Text of a mapping that reads back bit for bit: floats by their shortest exact form."""
    from io import StringIO

    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 4096
    stream = StringIO()
    yaml.dump(content, stream)
    return stream.getvalue()
