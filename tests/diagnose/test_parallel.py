"""Work on all cores comes back in its order, and its errors come back as well."""

from __future__ import annotations

import threading

import pytest

from flexdyn.diagnose.parallel import in_parallel


def test_results_stand_in_the_order_of_the_items() -> None:
    """Although the first waits for the second, which shows that both are in work at once."""
    second = threading.Event()

    def work(k: int) -> int:
        if k == 0:
            assert second.wait(timeout=20.0)
        if k == 1:
            second.set()
        return k * k

    assert in_parallel(work, range(5)) == [0, 1, 4, 9, 16]
    assert in_parallel(work, [7]) == [49]
    assert in_parallel(work, []) == []


def test_an_error_is_raised_where_the_work_was_asked_for() -> None:
    """As in a loop."""
    with pytest.raises(ZeroDivisionError):
        in_parallel(lambda k: 1 / k, [1, 0, 2])
