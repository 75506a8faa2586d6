"""Channels computed from others: sums, differences, products and quotients of channels and numbers.

A name is that of a channel, such as ``alpha`` or ``q.elbow``; a name with other letters needs single quotes. Python's
own parser reads the rest: names and numbers are replaced by identifiers first, and only the operators of `_OPERATIONS`
are taken. Nothing is executed.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Collection, Mapping
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
_OPERATIONS: Mapping[type[ast.AST], Callable[..., Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}


@dataclass(frozen=True)
class Expression:
    """An expression that was read.

    Attributes:
        text: as it was written.
        names: of the channels in it, each once.
    """

    text: str
    names: tuple[str, ...] = field(compare=False)
    _tree: ast.expr = field(compare=False, repr=False)
    _leaves: Mapping[str, str | float] = field(compare=False, repr=False)

    def value(self, channels: Mapping[str, Array]) -> Array:
        """Its values, an array of the length of the channels.

        Args:
            channels: by name; they contain all of `names`.
        """
        return np.asarray(self._value(self._tree, channels), dtype=float)

    def _value(self, node: ast.expr, channels: Mapping[str, Array]) -> Any:
        """The value of a part of the expression."""
        match node:
            case ast.BinOp(left, op, right):
                return _OPERATIONS[type(op)](self._value(left, channels), self._value(right, channels))
            case ast.UnaryOp(op, operand):
                return _OPERATIONS[type(op)](self._value(operand, channels))
            case ast.Name(name):
                leaf = self._leaves[name]
                return channels[leaf] if isinstance(leaf, str) else leaf
        raise TypeError(node)


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
    parts, leaves, place = [], {}, 0
    while place < len(text.rstrip()):
        found = _TOKEN.match(text, place)
        if found is None:
            raise _refused(f"'{text[place:].lstrip()[:1]}' is not known", key, text)
        place, part = found.end(), str(found[str(found.lastgroup)])
        if found.lastgroup != "mark":
            leaves[f"x{place}"] = float(part) if found.lastgroup == "number" else part
            part = f"x{place}"
        parts.append(part)
    try:
        tree = ast.parse(" ".join(parts), mode="eval").body
    except (SyntaxError, MemoryError, RecursionError):
        raise _refused("it is cut short, or a part does not fit there", key, text) from None
    if problem := _problem(tree, 0):
        raise _refused(problem, key, text)
    names = tuple(dict.fromkeys(leaf for leaf in leaves.values() if isinstance(leaf, str)))
    if not names:
        raise InputError("no channel is named", key=key, value=text, remedy="such as: alpha + beta")
    return Expression(text, names, tree, leaves)


def check_names(expression: Expression, known: Collection[str], key: str) -> None:
    """Refuse an expression with unknown channels.

    Raises:
        InputError: an unknown channel, with the most similar name.
    """
    for name in expression.names:
        check_known(name, known, "no such channel", key=key, value=name, channel=name)


def _problem(node: ast.expr, depth: int) -> str:
    """What is not allowed in a part of the tree; sums and products of many terms are deep on the left only."""
    if depth > DEEPEST:
        return "brackets nest too deep"
    match node:
        case ast.BinOp(left, op, right) if type(op) in _OPERATIONS:
            return _problem(left, depth) or _problem(right, depth + 1)
        case ast.UnaryOp(op, operand) if type(op) in _OPERATIONS:
            return _problem(operand, depth + 1)
    return "" if isinstance(node, ast.Name) else "a part does not fit there"


def _refused(problem: str, key: str, text: str) -> InputError:
    remedy = "names, numbers, + - * / and brackets are known; quote a name of other letters: 'Ist A1'"
    return InputError(problem, key=key, value=text, remedy=remedy)
