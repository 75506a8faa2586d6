"""Attributes and results that are computed at their first use, in threads that do not wait for one another."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Concatenate, Generic, ParamSpec, Self, TypeVar, overload

Value = TypeVar("Value")
Key = ParamSpec("Key")


class lazy(Generic[Value]):
    """A `functools.cached_property` without its lock.

    Before Python 3.12 all objects of a class share this lock: while one of them computes, every other waits, and
    threads have no advantage. If two threads use the attribute of an object for the first time at once, both compute
    the value.
    """

    def __init__(self, compute: Callable[[Any], Value]) -> None:
        self.compute = compute
        self.__doc__ = compute.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        """Store the name of the attribute for the value, which then hides this descriptor."""
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...

    @overload
    def __get__(self, instance: object, owner: type) -> Value: ...

    def __get__(self, instance: object | None, owner: type) -> Self | Value:
        """The value, computed at the first use."""
        if instance is None:
            return self
        value = self.compute(instance)
        instance.__dict__[self.name] = value
        return value


def last(compute: Callable[Concatenate[Any, Key], Value]) -> Callable[Concatenate[Any, Key], Value]:
    """A function of an object, which keeps its last result as long as the other arguments are the same objects."""
    place = f"{compute.__name__} last"

    @functools.wraps(compute)
    def known(self: Any, /, *given: Key.args, **named: Key.kwargs) -> Value:
        """The last result, where the arguments are the same."""
        now = (*given, *named.values())
        before: tuple[tuple[Any, ...], Value] | None = self.__dict__.get(place)
        if before is None or list(map(id, before[0])) != list(map(id, now)):
            before = self.__dict__[place] = now, compute(self, *given, **named)
        return before[1]

    return known


def kept(compute: Callable[Concatenate[Any, Key], Value]) -> Callable[Concatenate[Any, Key], Value]:
    """A method whose results an object keeps, by their arguments; these are hashable and have no names."""
    place = f"{compute.__name__} kept"

    @functools.wraps(compute)
    def known(self: Any, /, *key: Key.args, **named: Key.kwargs) -> Value:
        """The result, computed at its first use."""
        found: dict[Any, Value] = self.__dict__.setdefault(place, {})
        if key not in found:
            found[key] = compute(self, *key, **named)
        return found[key]

    return known
