"""One HTML file with meshcat's viewer, the scene and the controls, which loads nothing else; it in a notebook."""

from __future__ import annotations

import base64
import gzip
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.io import html


def viewer_page(title: str, about: Mapping[str, Any], commands: Iterable[Mapping[str, Any]]) -> str:
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
    script = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
    return html.page("viewer/page.html", title, scripts=(library, script), about=about, scene=packed_commands(commands))


def packed_commands(commands: Iterable[Mapping[str, Any]]) -> str:
    """Commands as base64 of a gzip file with the length (4 bytes, big-endian) and the msgpack of each command."""
    import umsgpack

    parts = []
    for command in commands:
        data = umsgpack.packb(command, force_float_precision="single")
        parts += [struct.pack(">I", len(data)), data]
    return base64.b64encode(gzip.compress(b"".join(parts), compresslevel=6, mtime=0)).decode("ascii")


def floats(values: Array) -> str:
    """Numbers as base64 of little-endian 4-byte floats, row by row."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")


@dataclass(frozen=True, repr=False)
class Inline:
    """A page that a notebook shows in a frame of its own, which has no access to the notebook.

    Attributes:
        text: of the page.
        height: of the frame [px].
    """

    text: str
    height: int

    def _repr_html_(self) -> str:
        """The frame, with the page in it."""
        return html.render("viewer/inline.html", text=self.text, height=self.height)

    def __repr__(self) -> str:
        """The text that is shown without a notebook."""
        return f"<Inline: a page of {len(self.text) / 1e6:.1f} MB for a notebook; fd.play(run) opens the browser>"
