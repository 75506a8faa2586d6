"""The compiled core's table of laws, `law_table` in flexdyn/core/law_table.hpp: Python declares none of it again."""

from __future__ import annotations

from flexdyn import _core

LAWS = {row.name: row for row in _core.law_table()}
"""Name of a built-in law -> its row."""
