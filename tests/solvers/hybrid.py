"""A motion whose law has corners, integrated by SciPy from corner to corner."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Switch = Callable[[float, Sequence[float]], float]
HOP = 1e-7
"""Time after a corner in which no other is looked for: the root found is on either side of it by rounding [s]."""


def integrate(
    f: Callable[[float, Sequence[float]], Sequence[float]], x0: ArrayLike, times: Array, switches: Sequence[Switch]
) -> tuple[Array, list[float]]:
    """States at `times`, and the instants at which one of the switches changed its sign."""
    t, x, end = float(times[0]), np.array(x0, dtype=float), float(times[-1])
    rows: list[Array] = []
    found: list[float] = []
    watched = [_terminal(switch) for switch in switches]
    hop = False
    while True:
        until = min(t + HOP, end) if hop else end
        piece = solve_ivp(
            lambda t, x: f(t, x.tolist()),
            (t, until),
            x,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            max_step=0.01,
            events=None if hop else watched,
            t_eval=np.append(times[(times >= t) & (times < until)], until),
        )
        assert piece.success, piece.message
        passed = [] if hop else [k for k, at in enumerate(piece.t_events) if len(at)]
        last, x = (piece.t_events[passed[0]][0], piece.y_events[passed[0]][0]) if passed else (until, piece.y[:, -1])
        if len(piece.t):
            rows.append(piece.y.T[piece.t < last])
        if last == end:
            return np.vstack([*rows, x]), found
        if not hop:
            found.append(float(last))
        t, hop = float(last), not hop
        assert len(found) < 500


def _terminal(switch: Switch) -> Any:
    def event(t: float, x: Array) -> float:
        return switch(t, x.tolist())

    event.terminal = True  # type: ignore[attr-defined]
    return event
