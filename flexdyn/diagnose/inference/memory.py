"""Whether the columns of everything that may be missing fit into the machine's memory."""

from __future__ import annotations

import os
from collections.abc import Iterable

from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.errors import InputError

COLUMN_COPIES = 7.0
"""Memory at the peak, in that of all columns once, as measured on recordings of 200 s and of 600 s."""
MEMORY_SHARE = 0.5
"""Of the machine's memory that a diagnosis may take: other programs need some too."""


def memory_needed(proposals: Iterable[Proposal], rows: int) -> float:
    """Memory that the columns of all candidates take [bytes].

    Args:
        proposals: of effects.
        rows: of all equations.
    """
    columns = sum(len(each.grid) * max(1, len(each.units(each.grid[0]))) for each in proposals)
    return COLUMN_COPIES * 8.0 * columns * rows


def check_memory(proposals: Iterable[Proposal], rows: int, seconds: float) -> None:
    """Refuse recordings whose columns do not fit.

    Args:
        proposals: of effects.
        rows: of all equations.
        seconds: of recordings that these are of.

    Raises:
        InputError: they do not.
    """
    needed, there = memory_needed(proposals, rows), MEMORY_SHARE * installed()
    if needed <= there:
        return
    problem = f"{seconds:.0f} s of recordings need {needed / 1e9:.1f} GB of memory, {there / 1e9:.1f} GB may be used"
    less = f"give {0.9 * seconds * there / needed:.2g} s of them (--trim, Recording.trim)"
    remedy = f"{less} or fewer samples (Recording.decimate)"
    raise InputError(problem, key="recordings", remedy=remedy)


def installed() -> float:
    """Memory of this machine [bytes]."""
    return float(os.sysconf("SC_PHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
