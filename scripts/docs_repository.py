"""Pages of the repository that lie outside docs/, as pages of the site, and links between all of them.

In the repository a link is a path, so that a visitor of the sources can follow it. On the site the same link leads to
the page made from that file. docs/conf.py calls `write` before every build and `redirect` for every page.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from docs_folder import fresh

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
LINK = re.compile(r"(!?)(\[[^\]]*\]\()([^)#\s:]+)(#[^)\s]*)?\)")


def pages() -> dict[Path, str]:
    """The files that become pages, and the names of these."""
    found = {ROOT / f"{name}.md": name.lower() for name in ("CHANGELOG", "CONTRIBUTING")}
    found[ROOT / "benchmarks" / "README.md"] = "benchmarks"
    found[ROOT / "benchmarks" / "discovery" / "README.md"] = "discovery"
    found |= {path: f"measured_{path.parent.name}" for path in sorted(ROOT.glob("benchmarks/results/*/page.md"))}
    found |= {path: f"robot_{path.parent.name}" for path in sorted(ROOT.glob("robots/*/README.md"))}
    return found


def write(folder: Path) -> None:
    """Write the pages into a folder, which is emptied before."""
    fresh(folder)
    for source, name in pages().items():
        target = folder / f"{name}.md"
        target.write_text(relinked(source.read_text(encoding="utf-8"), source, target), encoding="utf-8")


def relinked(text: str, source: Path, target: Path) -> str:
    """The text of a file with the links that it has as a page of the site.

    Args:
        text: of the file.
        source: the file, from which its links lead.
        target: the page, from which they shall lead.

    Raises:
        FileNotFoundError: a link leads nowhere.
    """
    known = {path: DOCS / "generated" / "repository" / f"{name}.md" for path, name in pages().items()}

    def lead(found: re.Match[str]) -> str:
        picture, text, link, anchor = found[1], found[2], found[3], found[4] or ""
        there = (source.parent / link).resolve()
        if not there.exists():
            raise FileNotFoundError(f"{source.relative_to(ROOT)}: a link leads to {link}, which is not there")
        on_site = known.get(there, there)
        if not picture and not on_site.is_relative_to(DOCS):
            return text[1:-2]  # a file that is no page: its name stays, without a link
        return f"{picture}{text}{Path(os.path.relpath(on_site, target.parent)).as_posix()}{anchor})"

    return LINK.sub(lead, text)


def redirect(app: Any, docname: str, content: list[str]) -> None:
    """Sphinx's event ``source-read``: links of the pages of docs/, and from the catalogue to the effects' pages."""
    path = Path(app.env.doc2path(docname))
    if path.suffix == ".md" and "generated" not in path.parts:
        content[0] = relinked(content[0], path, path)
    if docname == "catalogue":
        content[0] = re.sub(r"^\| `(\w+)` \|", r"| [`\1`](generated/effects/\1.md) |", content[0], flags=re.MULTILINE)
