"""Channels computed from others: sums, differences, products and quotients of channels and numbers.

::

    expression = term (("+" | "-") term)*
    term       = factor (("*" | "/") factor)*
    factor     = ("+" | "-") factor | number | name | "(" expression ")"

A name is that of a channel, such as ``alpha`` or ``q.elbow``; a name with other letters needs single quotes.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexdyn.checks import Array, check_known
from flexdyn.errors import InputError

LONGEST_EXPRESSION = 1000
"""Largest number of letters of an expression."""
DEEPEST = 50
"""Deepest nesting of brackets and signs."""
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d][\w.]*)|'(?P<quoted>[^']+)'|(?P<mark>[-+*/()]))"
)
_END = ("end", "")
_OPERATIONS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}


@dataclass(frozen=True)
class Expression:
    """An expression that was read.

    Attributes:
        text: as it was written.
        names: of the channels in it, each once.
    """

    text: str
    names: tuple[str, ...] = field(compare=False)
    _tree: Any = field(compare=False, repr=False)

    def value(self, channels: Mapping[str, Array]) -> Array:
        """Its values, an array of the length of the channels.

        Args:
            channels: by name; they contain all of `names`.
        """
        return np.asarray(_value(self._tree, channels), dtype=float)


def expression_of(text: Any, key: str) -> Expression:
    """Read an expression.

    Args:
        text: as it was written.
        key: its path in the file, for errors.

    Raises:
        InputError: the text is no expression, or it names no channel.
    """
    if not isinstance(text, str) or len(text) > LONGEST_EXPRESSION:
        raise InputError("an expression is needed", key=key, value=text, remedy="such as: alpha + beta")
    reader = _Reader(text, key)
    tree = reader.sum(0)
    if reader.token != _END:
        raise reader.refused(f"'{reader.token[1]}' does not fit there")
    names = tuple(dict.fromkeys(reader.names))
    if not names:
        raise InputError("no channel is named", key=key, value=text, remedy="such as: alpha + beta")
    return Expression(text, names, tree)


def check_names(expression: Expression, known: Collection[str], key: str) -> None:
    """Refuse an expression with unknown channels.

    Raises:
        InputError: an unknown channel, with the most similar name.
    """
    for name in expression.names:
        check_known(name, known, "no such channel", key=key, value=name, channel=name)


class _Reader:
    """Recursive descent over the tokens of a text."""

    def __init__(self, text: str, key: str) -> None:
        self._text, self._key = text, key
        self._tokens = self._all()
        self.names: list[str] = []
        self.token = next(self._tokens)

    def refused(self, problem: str) -> InputError:
        remedy = "names, numbers, + - * / and brackets are known; quote a name of other letters: 'Ist A1'"
        return InputError(problem, key=self._key, value=self._text, remedy=remedy)

    def _all(self) -> Iterator[tuple[str, str]]:
        place, text = 0, self._text.rstrip()
        while place < len(text):
            found = _TOKEN.match(text, place)
            if found is None:
                raise self.refused(f"'{text[place:].lstrip()[:1]}' is not known")
            place, kind = found.end(), str(found.lastgroup)
            yield ("name" if kind == "quoted" else kind, found[kind])
        yield _END

    def _take(self) -> str:
        text, self.token = self.token[1], next(self._tokens, _END)
        return text

    def sum(self, depth: int) -> Any:
        return self._chain("+-", self._product, depth)

    def _product(self, depth: int) -> Any:
        return self._chain("*/", self._factor, depth)

    def _chain(self, marks: str, part: Any, depth: int) -> Any:
        left = part(depth)
        while self.token[0] == "mark" and self.token[1] in marks:
            left = (self._take(), left, part(depth))
        return left

    def _factor(self, depth: int) -> Any:
        if depth > DEEPEST:
            raise self.refused("brackets nest too deep")
        kind, text = self.token
        if kind == "number":
            return float(self._take())
        if kind == "name":
            self.names.append(text)
            return self._take()
        if kind == "mark" and text in "+-":
            sign = self._take()
            return (sign, 0.0, self._factor(depth + 1))
        if text == "(":
            self._take()
            inner = self.sum(depth + 1)
            if self.token[1] != ")":
                raise self.refused("a bracket is not closed")
            self._take()
            return inner
        raise self.refused("it ends too early" if kind == "end" else f"'{text}' does not fit there")


def _value(tree: Any, channels: Mapping[str, Array]) -> Any:
    if isinstance(tree, float):
        return tree
    if isinstance(tree, str):
        return channels[tree]
    mark, left, right = tree
    return _OPERATIONS[mark](_value(left, channels), _value(right, channels))
