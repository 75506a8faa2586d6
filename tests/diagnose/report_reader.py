"""report.html read back: every sentence of it is taken apart and held against report.json."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from typing import Any

from tests.diagnose.report_claims import CLAIMS, CONSTANT

Document = dict[str, Any]
TOLD = ("h1", "li", "p", "footer", "figcaption")
"""Elements whose text is sentences."""
VOID = ("br", "img", "input", "meta", "link", "hr", "line", "circle")


class _Sentences(HTMLParser):
    """Texts of the elements that tell something, each with the section that it stands in."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, str]] = []
        self._open: list[tuple[str, str]] = []
        self._text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in VOID:
            return
        if tag in TOLD:
            self._flush()
        given = dict(attrs)
        self._open.append((tag, given.get("id") or given.get("class") or ""))

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        if tag in TOLD:
            self._flush()
        while self._open and self._open.pop()[0] != tag:
            pass

    def handle_data(self, data: str) -> None:
        tags = [tag for tag, _ in self._open]
        if "article" in tags and tags[-1] == "code":  # the formula of a law
            return
        if any(tag in TOLD for tag in tags) and not {"script", "style", "details"} & set(tags[-2:]):
            self._text.append(data)

    def _flush(self) -> None:
        text = " ".join("".join(self._text).split())
        self._text.clear()
        if text:
            sections = [name for tag, name in self._open if tag in ("section", "header", "article")]
            self.found.append((sections[-1] if sections else "", text))


def sentences(html: str) -> list[tuple[str, str]]:
    """Section and text of everything that the page tells in words."""
    reader = _Sentences()
    reader.feed(html)
    return [(where, _plain(text)) for where, text in reader.found]


def _plain(text: str) -> str:
    for letter in "\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}":
        text = text.replace(letter, " ")
    return text.replace("\N{MINUS SIGN}", "-")


def unchecked(html: str, document: Document) -> Iterator[str]:
    """What is told and is neither a claim that was checked nor an explanation without numbers.

    Raises:
        AssertionError: a claim that report.json does not bear out.
    """
    place = -1
    for where, text in sentences(html):
        place += bool(re.match(r"^Posterior probability", text))
        left = text
        for told in (*document["notes"], *_experiments(document)):
            left = left.replace(told, " ")
        left = _checked(left, document, max(place, 0))
        if left.strip(" .:,;"):
            yield f"{where}: {text!r}: {left.strip()!r}"


def _checked(text: str, document: Document, place: int) -> str:
    """The text without what was checked."""
    for pattern, check in CLAIMS:
        text = _without(text, pattern, check, document, place)
    for pattern in CONSTANT:
        text = re.sub(pattern, " ", text)
    return text


def _without(text: str, pattern: str, check: Callable[..., None], document: Document, place: int) -> str:
    for match in re.finditer(pattern, text):
        check(document, *match.groups(), **({"place": place} if "place" in check.__code__.co_varnames else {}))
    return re.sub(pattern, " ", text)


def _experiments(document: Document) -> list[str]:
    told = [finding["experiment"] for finding in document["findings"] if finding["experiment"]]
    return [*told, *(text[:1].upper() + text[1:] for text in told)]
