"""HTML: one engine fills all templates, and whatever is put into one is text, not markup."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

ROOT = Path(__file__).parent.parent
"""The package's folder; templates are named by their paths below it."""
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"


@cache
def engine() -> Environment:
    """The template engine."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    loader = FileSystemLoader(ROOT)
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.policies["json.dumps_kwargs"] = {"allow_nan": False}
    return made


def render(template: str, **filled: Any) -> Markup:
    """A filled template.

    Args:
        template: its path below the package.
        filled: what its names stand for; plain texts are escaped.
    """
    return _markup(engine().get_template(template).render(filled))


def page(template: str, title: str, *, scripts: tuple[str, ...], **filled: Any) -> str:
    """A whole page, which runs no script but its own and asks no host for anything.

    Args:
        template: extends ``io/page.html``; a ``page.css`` beside it is the page's style.
        title: of the page.
        scripts: texts of all scripts that may run; the template reads them as ``scripts``.
        filled: what else the template needs.
    """
    digests = (base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii") for text in scripts)
    hashes = " ".join(f"'sha256-{digest}'" for digest in digests)
    style = _markup((ROOT / template).with_name("page.css").read_text(encoding="utf-8"))
    texts = [_markup(text) for text in scripts]
    policy = f"{POLICY}; script-src {hashes}"
    return str(render(template, title=title, policy=policy, style=style, scripts=texts, **filled))


def _markup(text: str) -> Markup:
    """Text of our own, or a library's, that is put into a page as it is."""
    from markupsafe import Markup

    return Markup(text)  # noqa: S704
