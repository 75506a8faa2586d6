"""A torque that no effect of the catalogue describes: a smooth function of the state, as a rival of every name.

Without it, what the catalogue lacks would be shared out among effects that imitate parts of it. Each is a Gaussian
process of a squared exponential covariance, by random Fourier features (Rahimi and Recht, 2007):

    torque(x) = sum_k a_k cos(w_k x + b_k),   a_k ~ N(0, s^2/M)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.motion import Motion
from flexdyn.diagnose.proposal import Point, Proposal

Array = NDArray[np.float64]
FEATURES = 16
"""Of each process."""
LENGTH = 0.25
"""Length over which a torque changes, as a share of the range of what it depends on [1]."""
PREFIX = "unmodelled"


@dataclass(frozen=True, eq=False)
class Unmodelled(Proposal):
    """A smooth torque on one joint's side.

    Attributes:
        side: motor or link.
        joint: place of the joint.
        features: of a motion (samples, features).
        depends_on: what it is a function of.
    """

    side: str = "motor"
    joint: int = 0
    features: Callable[[Motion], Array] = lambda along: along.q
    depends_on: tuple[str, ...] = ()

    def columns(self, equations: Equations, point: Point) -> Array:
        """Derivatives of the residual (rows, features)."""
        motions = equations.motions
        tables = {id(along): self.features(along) for along in motions}
        count = next(iter(tables.values())).shape[1]
        made = np.zeros((len(equations.residual), count))
        for side, sign in ((self.side, 1.0),) if self.side != "transmission" else (("motor", -1.0), ("link", 1.0)):
            for k in range(count):
                made[:, k] += sign * equations.of_torque(self.joint, partial(_torque, tables, side, k))
        return made


def _torque(tables: dict[int, Array], side: str, k: int, along: Motion) -> tuple[str, Array]:
    return side, tables[id(along)][:, k]


def unmodelled(equations: Equations) -> Iterator[Proposal]:
    """Smooth torques of positions, of speed and of time, on every joint and side."""
    true = equations.true
    for j, name in enumerate(true.joint_names):
        for side in ("motor", "link") if true.elastic[j] else ("motor",):
            x, u = ("theta", "omega") if side == "motor" else ("q", "v")
            kinds: dict[str, tuple[Callable[[Motion], Array], tuple[str, ...]]] = {
                "position": (_of(equations, lambda along: along.q, j), ("q",)),
                "speed": (_by_speed(equations, x, u, j), ("v", "q")),
                "time": (_by_time(equations, u, j), ("t",)),
            }
            for kind, (features, depends_on) in kinds.items():
                place = {"effect": f"{PREFIX}_{kind}", "joint": name, "side": side}
                yield Unmodelled(
                    place, lambda point, x: None, lambda point: [], numbers=FEATURES, side=side, joint=j,
                    features=features, depends_on=depends_on,
                )  # fmt: skip


def _waves(low: Array, high: Array, count: int, seed: int) -> Callable[[Array], Array]:
    """Random Fourier features of columns between bounds (samples, count)."""
    draw = np.random.default_rng(seed)
    width = np.maximum(high - low, 1e-12)
    w = draw.standard_normal((len(width), count)) / (LENGTH * width)[:, None]
    b = draw.uniform(0.0, 2.0 * np.pi, count)
    return lambda x: np.cos(x @ w + b)


def _bounds(equations: Equations, of: Callable[[Motion], Array]) -> tuple[Array, Array]:
    whole = np.concatenate([of(along) for along in equations.motions])
    return np.quantile(whole, 0.01, axis=0), np.quantile(whole, 0.99, axis=0)


def _of(equations: Equations, x: Callable[[Motion], Array], j: int) -> Callable[[Motion], Array]:
    """Of all positions; a joint's own is as likely as all others together to be what matters."""
    low, high = _bounds(equations, x)
    whole = _waves(low, high, FEATURES, 1)
    own = _waves(low[[j]], high[[j]], FEATURES // 2, 2)
    return lambda along: np.concatenate([whole(x(along)), own(x(along)[:, [j]])], axis=1)


def _by_speed(equations: Equations, x: str, u: str, j: int) -> Callable[[Motion], Array]:
    """Of the speed, and the speed times a function of the position."""

    def both(along: Motion) -> Array:
        return np.stack([getattr(along, u)[:, j], getattr(along, x)[:, j]], axis=1)

    low, high = _bounds(equations, both)
    speed, place = _waves(low[:1], high[:1], FEATURES // 2, 3), _waves(low[1:], high[1:], FEATURES // 2, 4)
    size = max(float(high[0] - low[0]), 1e-12)

    def features(along: Motion) -> Array:
        table = both(along)
        return np.concatenate([speed(table[:, :1]), table[:, :1] / size * place(table[:, 1:])], axis=1)

    def plain(along: Motion) -> Array:
        """Friction that every drive has and that has names: it is not what is unmodelled."""
        rate = both(along)[:, 0] / size
        return np.stack([np.ones_like(rate), rate, np.tanh(rate / 0.02)], axis=1)

    whole = [(plain(along), features(along)) for along in equations.motions]
    X, F = (np.concatenate(part) for part in zip(*whole, strict=True))
    taken = np.linalg.lstsq(X, F, rcond=None)[0]
    return lambda along: features(along) - plain(along) @ taken


def _by_time(equations: Equations, u: str, j: int) -> Callable[[Motion], Array]:
    """Of time, and friction that changes with it."""
    end = np.array([max(float(along.t[-1]) for along in equations.motions)])
    slow = _waves(np.zeros(1), end, FEATURES // 2, 5)
    size = max(float(np.std(np.concatenate([getattr(along, u)[:, j] for along in equations.motions]))), 1e-12)

    def features(along: Motion) -> Array:
        table = slow(along.t[:, None])
        turning = np.tanh(getattr(along, u)[:, [j]] / (0.1 * size))
        return np.concatenate([table, turning * table], axis=1)

    return features
