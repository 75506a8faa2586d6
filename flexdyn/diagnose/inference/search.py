"""Compare structures: best-first search over additions, removals and swaps."""

from __future__ import annotations

from flexdyn.diagnose.constants import OCCAM_WINDOW
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.refinement import refined
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.progress import check

STRUCTURES_EXPLORED = 30
"""Structures whose neighbours are all compared, at most."""


def explore(space: Space, starts: list[Structure], explored: int = STRUCTURES_EXPLORED) -> Structure:
    """Compare the neighbours of the most likely structures, until none in Occam's window is left.

    Returns:
        the most likely one.
    """
    scan = Scan(space)
    done: set[Structure] = set()
    for start in starts:
        _climb(scan, start, done)
    for _ in range(explored):
        bound = max(space.known.values()) - OCCAM_WINDOW
        open_ = [s for s, value in space.known.items() if s not in done and value > bound]
        if not open_:
            break
        _neighbours(scan, max(open_, key=lambda s: (space.known[s], sorted(s))), done)
    return space.best()


def _climb(scan: Scan, start: Structure, done: set[Structure]) -> None:
    """From a structure to the best of its neighbours, its grid points refined, as long as that is better.

    Swaps take as many scans as the structure has candidates. So they are compared where no addition or removal helps.
    """
    here, space = start, scan.space
    space.value(here)
    while here not in done:
        check()
        space.weigh(ModelError.of(space.left(here), space.seen))
        _compare_additions_and_removals(scan, here)
        if space.known[space.best()] <= space.known[here]:
            _compare_swaps(scan, here)
            done.add(here)
        best = space.best()
        if space.known[best] <= space.known[here]:
            break
        here = refined(space, best)


def _neighbours(scan: Scan, here: Structure, done: set[Structure]) -> None:
    """All additions, removals and swaps of one structure."""
    check()
    done.add(here)
    _compare_additions_and_removals(scan, here)
    _compare_swaps(scan, here)


def _compare_additions_and_removals(scan: Scan, here: Structure) -> None:
    _add(scan, here, scan.space.value(here))
    for each in sorted(here):
        scan.space.value(here - {each})


def _compare_swaps(scan: Scan, here: Structure) -> None:
    for each in sorted(here):
        without = here - {each}
        _add(scan, without, scan.space.value(without))


def _add(scan: Scan, base: Structure, value: float) -> None:
    """The additions to a structure that come into the window, each known by its exact value."""
    space = scan.space
    best = max(space.known.values())
    for more, point in scan.additions(base):
        if value + more < best - OCCAM_WINDOW:
            break
        best = max(best, space.value(base | {point}))
