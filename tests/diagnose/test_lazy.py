"""Values that are computed when first asked for, and once."""

from __future__ import annotations

import threading

from flexdyn.diagnose.lazy import last, lazy
from flexdyn.diagnose.parallel import in_parallel


class Slow:
    """A value that takes until another object's is in work as well."""

    def __init__(self, barrier: threading.Barrier) -> None:
        self.barrier = barrier
        self.asked = 0

    @lazy
    def value(self) -> int:
        """Of this object."""
        self.asked += 1
        self.barrier.wait(timeout=20.0)
        return 7


def test_two_objects_are_computed_at_once() -> None:
    """Each waits for the other one; `functools.cached_property` of Python 3.11 lets only one begin."""
    barrier = threading.Barrier(2)
    both = [Slow(barrier), Slow(barrier)]
    assert in_parallel(lambda each: each.value, both) == [7, 7]


def test_a_value_is_computed_once_and_described() -> None:
    """And may be put there by hand."""
    one = Slow(threading.Barrier(1))
    assert one.asked == 0
    assert (one.value, one.value, one.asked) == (7, 7, 1)
    other = Slow(threading.Barrier(1))
    other.__dict__["value"] = 8
    assert (other.value, other.asked) == (8, 0)


class Counted:
    """Counts how often something is computed."""

    def __init__(self) -> None:
        self.asked = 0


@last
def longest(one: Counted, *words: list[str]) -> int:
    """Length of the longest list."""
    one.asked += 1
    return max(map(len, words), default=0)


def test_the_last_result_is_kept_for_the_same_objects() -> None:
    """Equal ones are others; what came before the last one is computed again; each object has its own."""
    one, short, long = Counted(), ["a"], ["a", "b"]
    assert (longest(one), longest(one), one.asked) == (0, 0, 1)
    assert (longest(one, short), longest(one, short), one.asked) == (1, 1, 2)
    assert (longest(one, short, long), longest(one, short, list(long)), one.asked) == (2, 2, 4)
    assert (longest(one, short), one.asked) == (1, 5)
    other = Counted()
    assert (longest(other, short), other.asked) == (1, 1)
    assert Slow.value.__doc__ == "Of this object."
