"""The types of arrays of numbers, of truth values and of indices; entries that are spread evenly over one."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]


def evenly(count: int, most: int) -> Indices:
    """Indices of at most `most` of `count` entries, evenly spaced, the first and the last included."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.intp))
