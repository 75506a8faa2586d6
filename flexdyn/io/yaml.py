"""YAML files as untrusted input: version 1.2, safe types, bounded size, errors of one line."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.io.files import bounded_text

MAX_YAML_BYTES = 500_000
"""Largest size of a file [bytes]; such a file is read in some seconds."""
MAX_NODES = 100_000
"""Largest number of entries after aliases are unfolded."""
MAX_DEPTH = 32
"""Deepest nesting of lists and mappings."""
MAX_BRACKETS = 1000
"""Largest number of open brackets anywhere in the text: the parser is slow with more."""
_BRACKET = re.compile(r"[\[\]{}]")


def read_yaml(path: Path) -> Mapping[str, Any]:
    """Read the mapping in a YAML file, with numbers as in YAML 1.2 (4e-05 is a number).

    Raises:
        InputError: no such file, a file that is too large, not YAML, or no mapping.
    """
    text = bounded_text(path, MAX_YAML_BYTES, encoding="utf-8-sig", remedy="keep long data in recordings")
    return parse_yaml(text, path)


def parse_yaml(text: str, path: Path | None = None) -> Mapping[str, Any]:
    """Like `read_yaml`, for text that is already read; `path` is used in messages.

    Raises:
        InputError: not YAML, no mapping, or nested too deep.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    if _brackets(text) > MAX_BRACKETS:
        raise _too_deep(path)
    yaml = YAML(typ="safe", pure=True)  # pure Python: the C parser reads YAML 1.1, where 4e-05 is a string
    yaml.composer.warn_double_anchors = False  # YAML 1.2 allows an anchor to be defined again
    try:
        if "&" in text and _expanded_size(yaml.compose(text), {}) > MAX_NODES:
            raise InputError(f"its aliases unfold to more than {MAX_NODES} entries", file=path)
        content = yaml.load(text)
    except InputError:
        raise
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = "" if mark is None else f" in line {mark.line + 1}"
        raise InputError(f"not valid YAML{line}{_reason(error.problem)}", file=path) from None
    except RecursionError:
        raise _too_deep(path) from None
    except (YAMLError, ValueError) as error:
        raise InputError(f"not valid YAML{_reason(error)}", file=path) from None
    except Exception as error:  # ruamel raises various exceptions for unusual tags (!!int '', !!bool x)
        raise InputError(f"not valid YAML ({type(error).__name__})", file=path) from None
    if not isinstance(content, Mapping):
        raise InputError("a mapping of keys is needed", file=path, value=content)
    if _deeper(content, MAX_DEPTH):
        raise _too_deep(path)
    return content


def _brackets(text: str) -> int:
    """The largest number of open brackets, including those in texts and comments."""
    steps = (1 if bracket[0] in "[{" else -1 for bracket in _BRACKET.finditer(text))
    return max(itertools.accumulate(steps), default=0)


def _too_deep(path: Path | None) -> InputError:
    return InputError(f"lists and mappings nest deeper than {MAX_DEPTH}", file=path, remedy="write it plainer")


def _deeper(content: Any, left: int) -> bool:
    """Whether lists and mappings nest deeper than `left`."""
    inside = content.values() if isinstance(content, Mapping) else content if isinstance(content, list) else ()
    return left < 0 or any(_deeper(entry, left - 1) for entry in inside if isinstance(entry, Mapping | list))


def _expanded_size(node: Any, known: dict[int, float]) -> float:
    """The number of entries of a node after its aliases are unfolded; infinite if it contains itself."""
    if id(node) not in known:
        known[id(node)] = math.inf  # met again before it is finished: it contains itself
        children = node.value if isinstance(getattr(node, "value", None), list) else []
        flat = [child for entry in children for child in (entry if isinstance(entry, tuple) else (entry,))]
        known[id(node)] = 1.0 + sum(_expanded_size(child, known) for child in flat)
    return known[id(node)]


def _reason(error: Any) -> str:
    lines = str(error or "").splitlines()
    return f" ({lines[0][:200]})" if lines else ""


def check_keys(content: Any, known: Sequence[str], *, required: Sequence[str] = (), key: str = "") -> None:
    """Refuse an unknown key, and a mapping without a required key.

    Raises:
        InputError: an unknown key, with the most similar known one, or a missing key.
    """
    if not isinstance(content, Mapping):
        raise InputError("a mapping of keys is needed", key=key or None, value=content)
    prefix = f"{key}." if key else ""
    for name in content:
        check_known(name, known, "no such key", key=f"{prefix}{name}")
    for name in required:
        if name not in content:
            raise InputError("the key is missing", key=f"{prefix}{name}")


def check_format(content: Any, name: str, version: int, known: Sequence[str], *, required: Sequence[str] = ()) -> None:
    """Check the keys of a whole file, and the version of its format, which stands under a key of that name.

    Raises:
        InputError: another version, an unknown key or a missing one.
    """
    check_keys(content, (name, *known), required=(name, *required))
    if isinstance(content[name], bool) or content[name] != version:
        raise InputError("no such format", key=name, value=content[name], remedy=f"this version reads format {version}")


def dump_yaml(content: Mapping[str, Any]) -> str:
    """Text of a mapping that can be read back bit for bit: floats in their shortest exact form."""
    from io import StringIO

    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 4096
    stream = StringIO()
    yaml.dump(content, stream)
    return stream.getvalue()
