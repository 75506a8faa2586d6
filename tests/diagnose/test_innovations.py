"""The Kalman filter of the core on the linear response of windows, against dense algebra of all blocks at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn import _core

Array = NDArray[np.float64]
LIMIT = 1e9


class Windows:
    """Windows of a random linear response, with the arrays that the core fills."""

    def __init__(self, windows: int, blocks: int, nx: int, channels: int) -> None:
        draw = np.random.default_rng(blocks + 10 * nx)
        self.flow = np.eye(nx) + 0.3 * draw.standard_normal((windows, blocks, nx, nx))
        root = 0.5 * draw.standard_normal((windows, blocks, nx, nx))
        self.push = root @ root.swapaxes(2, 3)
        self.seen = draw.standard_normal((windows, blocks, channels, nx))
        self.counted = (draw.random((windows, blocks, channels)) < 0.8).astype(float)
        self.sensor = 0.1 + draw.random((windows, blocks, channels))
        root = draw.standard_normal((windows, nx, nx))
        self.prior = root @ root.swapaxes(1, 2)
        self.mean = self.counted * draw.standard_normal((windows, blocks, channels))
        self.known = draw.standard_normal((windows, nx))
        self.gain, self.first_gain = np.empty((2, windows, blocks, nx, channels))
        self.whitener = np.empty((windows, blocks, channels, channels))
        self.carried, self.doubt = np.empty((2, windows, blocks, channels))

    def filtered(self) -> tuple[Array, Array]:
        """White innovations, and errors of the first states, by the core."""
        _core.window_gains(
            self.flow, self.push, self.seen, self.counted, self.sensor, self.prior, LIMIT,
            self.gain, self.first_gain, self.whitener, self.carried, self.doubt,
        )  # fmt: skip
        first, white = self.known.copy(), np.empty_like(self.mean)
        _core.window_innovations(
            self.flow, self.seen, self.counted, LIMIT, self.gain, self.first_gain, self.whitener,
            self.mean, first, white,
        )  # fmt: skip
        return white, first

    def dense(self, w: int) -> tuple[Array, Array, Array, Array]:
        """White innovations, error of the first state, and both variances of one window, without a filter."""
        blocks, channels, nx = self.seen.shape[1:]
        first = self.prior[w]
        levers, moved = [], np.eye(nx)
        push: list[Array] = []  # what is left of every push
        for k in range(blocks):
            moved = self.flow[w, k] @ moved
            push = [self.flow[w, k] @ each for each in push] + [np.eye(nx)]
            C = self.counted[w, k][:, None] * self.seen[w, k]
            later = [np.zeros((channels, nx))] * (blocks - k - 1)
            levers.append(np.concatenate([C @ moved, *(C @ each for each in push), *later], axis=1))
        H = np.concatenate(levers)
        spread = np.zeros((nx * (blocks + 1),) * 2)
        for k, covariance in enumerate([first, *self.push[w]]):
            spread[k * nx : (k + 1) * nx, k * nx : (k + 1) * nx] = covariance
        noise = H[:, nx:] @ spread[nx:, nx:] @ H[:, nx:].T
        S = H @ spread @ H.T + np.diag(self.sensor[w].ravel())
        rest = self.mean[w].ravel() - H[:, :nx] @ self.known[w]
        lever = first @ H[:, :nx].T
        left = first - lever @ np.linalg.solve(S, lever.T)
        return (
            np.linalg.solve(np.linalg.cholesky(S), rest).reshape(blocks, channels),
            self.known[w] + lever @ np.linalg.solve(S, rest),
            np.diag(noise).reshape(blocks, channels),
            np.diag(H[:, :nx] @ left @ H[:, :nx].T).reshape(blocks, channels),
        )


@pytest.mark.parametrize(("blocks", "nx", "channels"), [(1, 1, 1), (5, 4, 2), (6, 2, 3), (9, 8, 5)])
def test_the_filter_is_the_dense_factor(blocks: int, nx: int, channels: int) -> None:
    """White innovations, first states and variances; some channels of some blocks were not measured."""
    windows = Windows(3, blocks, nx, channels)
    white, first = windows.filtered()
    for w in range(3):
        wanted = windows.dense(w)
        for found, right in zip((white, first, windows.carried, windows.doubt), wanted, strict=True):
            np.testing.assert_allclose(found[w], right, rtol=1e-8, atol=1e-9 * (1.0 + np.abs(right).max()))


def test_windows_that_diverge_or_are_not_numbers_disturb_no_other() -> None:
    """The filter of the others is the same bits, and what diverges stays within the limit."""
    windows, disturbed = Windows(3, 6, 4, 2), Windows(3, 6, 4, 2)
    disturbed.flow[0] *= 1e4
    disturbed.mean[1], disturbed.seen[1, 2] = np.nan, np.inf
    white, first = windows.filtered()
    others, firsts = disturbed.filtered()
    np.testing.assert_array_equal(others[2], white[2])
    np.testing.assert_array_equal(firsts[2], first[2])
    assert np.abs(firsts[0]).max() <= LIMIT


def test_threads_do_not_disturb_each_other() -> None:
    """The core computes without the interpreter's lock: the same bits as one after the other."""
    sizes = [(2, 40, 6, 3), (3, 30, 4, 2), (1, 60, 8, 4), (4, 20, 5, 2)] * 4
    alone = [Windows(*size).filtered() for size in sizes]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda size: Windows(*size).filtered(), sizes))
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one[0], other[0])
        np.testing.assert_array_equal(one[1], other[1])
