"""The regime in which a residual is largest: low speed, one direction, a range of positions, the first minutes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Flags

REGIME_BINS = 12
"""Number of bins of a quantity, with equal numbers of blocks."""
BLOCKS_AS_ONE = 8.0
"""Number of blocks that count as one, because neighbours in time are correlated."""
NAMED_VARIANCE_SHARE = 0.15
"""Share of the variance of the logarithm of the power that a quantity must explain to be named [1]."""
REGIME_DENSITY = 1.6
"""Smallest ratio of excess per time inside a regime to that outside [1]."""
ZERO_BOUND_SHARE = 1e-3
"""A lower bound below this share of the upper one is left out [1]."""
EVERYWHERE = "everywhere"


@dataclass(frozen=True, eq=False)
class Quantity:
    """A quantity on which a residual may depend.

    Attributes:
        text: text of a range; ``{}`` is the placeholder, as in ``"q {} rad"``, ``"abs(omega) {} rad/s"``.
        values: over the blocks (blocks,).
        signed: whether only its sign counts.
    """

    text: str
    values: Array
    signed: bool = False


def regime(power: Array, quantities: Sequence[Quantity]) -> str:
    """The regime in which the power of a residual is largest, in words.

    The quantity is the one whose bins explain most of the variance of the logarithm of the power. A second one is added
    if it explains enough of the rest. The range is the one with the largest excess for its time.

    Args:
        power: mean squares of normalised residuals, block by block (blocks,); 1 is noise.
        quantities: on which it may depend.
    """
    excess = np.maximum(power - 1.0, 0.0)
    if len(power) < 2.0 * BLOCKS_AS_ONE or not excess.sum() > 0.0:
        return EVERYWHERE
    level = np.log(power + 1.0)
    total = float(level.var())
    inside, words, left = np.ones(len(power), dtype=bool), [], list(quantities)
    for _ in range(2):
        scored = [
            (_explained(level, each) * float(level.var()) / total, k) for k, each in enumerate(left) if total > 0.0
        ]
        if not scored or max(scored)[0] < NAMED_VARIANCE_SHARE:
            break
        best = left.pop(max(scored)[1])
        found = _worst_range(excess, best, inside)
        if found is None:
            break
        words.append(found[0])
        inside = inside & found[1]
        level = level - _means(level, _bins(best))
    return " and ".join(words) if words else EVERYWHERE


def _bins(quantity: Quantity) -> NDArray[np.intp]:
    """The bin of every block (blocks,)."""
    if quantity.signed:
        return (quantity.values > 0.0).astype(np.intp)
    return np.searchsorted(_edges(quantity), quantity.values, side="right")


def _edges(quantity: Quantity) -> Array:
    """Edges between the bins; fewer if many values are equal."""
    if quantity.signed:
        return np.zeros(1)
    return np.unique(np.quantile(quantity.values, np.arange(1, REGIME_BINS) / REGIME_BINS))


def _means(level: Array, bins: NDArray[np.intp]) -> Array:
    counts = np.bincount(bins)
    return np.asarray((np.bincount(bins, level) / np.maximum(counts, 1))[bins])


def _explained(level: Array, quantity: Quantity) -> float:
    """Share of the variance that the bins explain, minus the share that is expected by chance."""
    bins = _bins(quantity)
    variance = float(level.var())
    used = len(np.unique(bins))
    if used < 2 or variance == 0.0:
        return 0.0
    share = float(_means(level, bins).var()) / variance
    blocks = len(level) / BLOCKS_AS_ONE
    return 1.0 - (1.0 - share) * (blocks - 1.0) / (blocks - used) if blocks > used else 0.0


def _worst_range(excess: Array, quantity: Quantity, inside: Flags) -> tuple[str, Flags] | None:
    """Consecutive bins with the largest excess for their time, in words and as blocks; None if it is small."""
    bins, edges = _bins(quantity), _edges(quantity)
    many = len(edges) + 1
    time = np.bincount(bins[inside], minlength=many) / max(int(inside.sum()), 1)
    held = np.bincount(bins[inside], excess[inside], minlength=many)
    if not held.sum() > 0.0:
        return None
    gain = held / held.sum() - time
    runs = np.concatenate([[0.0], np.cumsum(gain)])
    first, last = max(
        ((a, b) for a in range(many) for b in range(a + 1, many + 1)), key=lambda run: runs[run[1]] - runs[run[0]]
    )
    share, spent = held[first:last].sum() / held.sum(), time[first:last].sum()
    if spent >= 1.0 or share / spent < REGIME_DENSITY * (1.0 - share) / (1.0 - spent):
        return None
    return quantity.text.format(_words(edges, first, last)), (bins >= first) & (bins < last)


def _words(edges: Array, first: int, last: int) -> str:
    """Bins `first` up to, but without, `last`, in words."""
    if first == 0 or (last <= len(edges) and 0.0 <= edges[first - 1] < ZERO_BOUND_SHARE * edges[last - 1]):
        return f"< {_rounded(edges[last - 1])}"
    if last > len(edges):
        return f"> {_rounded(edges[first - 1])}"
    return f"between {_rounded(edges[first - 1])} and {_rounded(edges[last - 1])}"


def _rounded(value: float) -> str:
    """Round to two digits."""
    if not value:
        return "0"
    digits = 1 - math.floor(math.log10(abs(value)))
    return f"{round(float(value), digits):g}"
