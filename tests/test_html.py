"""The template engine: what is put into a page is text, whatever it holds, and a page runs its own scripts only."""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path

import pytest
from jinja2 import UndefinedError

import flexdyn
from flexdyn.io.html import engine, page, render
from flexdyn.io.notebook import card, html_table

EVIL = "</script><b onclick='x'>\"&"
PACKAGE = Path(flexdyn.__file__).parent


def test_plain_text_is_escaped_once_and_markup_is_not() -> None:
    """In cells, titles and facts; a table that a card holds keeps its elements."""
    shown = card(EVIL, {EVIL: EVIL}, html_table([EVIL], [[EVIL]]), notes=[EVIL])
    assert "<b onclick" not in shown
    assert shown.count("&lt;/script&gt;") == 6
    assert shown.count("<table>") == 1


def test_a_page_allows_its_own_scripts_only() -> None:
    """By their hashes; data for a script cannot end its element."""
    text = page("viewer/page.html", EVIL, scripts=("run();",), about={"title": EVIL}, scene="")
    own = base64.b64encode(hashlib.sha256(b"run();").digest()).decode()
    assert f'script-src &#39;sha256-{own}&#39;">' in text
    assert text.count("</script>") == 3
    assert type(text) is str, "markup of a type of its own would not be escaped where a page stands in another"


def test_what_a_template_needs_must_be_given() -> None:
    """A name that nobody filled is an error and not an empty place."""
    with pytest.raises(UndefinedError):
        render("viewer/inline.html", text="")
    with pytest.raises(ValueError, match="JSON"):
        page("viewer/page.html", "", scripts=(), about={"q": float("nan")}, scene="")


def test_every_template_is_a_part_of_something() -> None:
    """Each compiles, and no file of the report's folder is left over."""
    report = PACKAGE / "diagnose" / "report"
    parts = re.findall(
        r'"(\w+)"', (report / "page.html").read_text("utf-8").partition("for part in [")[2].partition("]")[0]
    )
    assert {path.stem for path in report.glob("*.html")} == {*parts, "page", "parts", "finding"}
    for path in PACKAGE.rglob("*.html"):
        if "robots" not in path.parts:
            engine().get_template(path.relative_to(PACKAGE).as_posix())
