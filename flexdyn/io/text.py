"""Files of plain text, such as Markdown and YAML, from templates of the same engine as HTML; nothing is escaped."""

from __future__ import annotations

from typing import Any

from flexdyn.io.html import engine


def fill(template: str, **filled: Any) -> str:
    """A filled template; what is put into it must be safe there.

    Args:
        template: its path below the package.
        filled: what its names stand for.
    """
    return engine().overlay(autoescape=False).get_template(template).render(filled)
