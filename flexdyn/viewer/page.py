"""One HTML file with meshcat's viewer, the scene and the controls. It loads nothing else."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import re
import struct
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"


def page(title: str, about: Mapping[str, Any], commands: Iterable[Mapping[str, Any]]) -> str:
    """The page.

    Names from any source are safe in it: texts are JSON and inserted as text, and the browser runs only the two scripts
    whose hashes are in the page's policy.

    Args:
        title: of the page.
        about: data for page.js.
        commands: meshcat's, in order.
    """
    import meshcat

    # `</script` would end the element; in JavaScript text `<\/script` means the same.
    library = Path(meshcat.viewer_assets_path(), "dist", "main.min.js").read_text(encoding="utf-8")
    library = library.replace("</script", "<\\/script")
    script = _own("page.js")
    hashes = " ".join(f"'sha256-{_sha256(text)}'" for text in (library, script))
    filled = {
        "POLICY": f"{POLICY}; script-src {hashes}",
        "TITLE": html.escape(title),
        "STYLE": _own("page.css"),
        "ABOUT": _json(about),
        "SCENE": packed(commands),
        "MESHCAT": library,
        "SCRIPT": script,
    }
    return re.sub(r"\{\{([A-Z]+)\}\}", lambda hole: filled[hole[1]], _own("page.html"))


def packed(commands: Iterable[Mapping[str, Any]]) -> str:
    """Commands as base64 of a gzip file with the length (4 bytes, big-endian) and the msgpack of each command."""
    import umsgpack

    parts = []
    for command in commands:
        data = umsgpack.packb(command, force_float_precision="single")
        parts += [struct.pack(">I", len(data)), data]
    return base64.b64encode(gzip.compress(b"".join(parts), compresslevel=6, mtime=0)).decode("ascii")


def floats(values: NDArray[np.float64]) -> str:
    """Numbers as base64 of little-endian 4-byte floats, row by row."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")


def _own(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def _json(about: Mapping[str, Any]) -> str:
    """JSON that no HTML parser can take for markup."""
    text = json.dumps(about, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _sha256(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
