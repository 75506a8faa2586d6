"""The long runs' script with a hundredth of its work: memory stays flat. Times say nothing on a busy machine."""

from __future__ import annotations

import sys
from dataclasses import asdict

import pytest


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
@pytest.mark.filterwarnings("ignore::flexdyn.simulation.limits.LimitWarning")
@pytest.mark.slow
def test_memory_stays_flat() -> None:
    """Of a run, of models made and dropped, of short runs, of pages; and the table says so."""
    import long_runs
    from trust_tables import long_runs_table

    first, run = long_runs.hour(400.0)
    found = [first, long_runs.models(100), long_runs.short_runs(1000), *long_runs.pages(run, 3)]
    assert [row.name for row in found][:3] == ["one run", "models made and dropped", "short runs"]
    for row in found:
        memory, _ = row.bounds
        assert memory.passed, str(memory)
        assert min(row.memory) > 10.0
    table = long_runs_table({"rows": [asdict(row) for row in found]})
    assert table.count("\n") == len(found) + 1
