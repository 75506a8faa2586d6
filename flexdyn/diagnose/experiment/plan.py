"""A simulated motion as the experiment for the report, with its picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.covariance import Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.experiment.apart import hypothesis_of_refit
from flexdyn.diagnose.experiment.rehearsal import Rehearsal, RehearsalBench
from flexdyn.diagnose.report.suspects import Experiment
from flexdyn.diagnose.shooting.gap import shoot

PICTURE_POINTS = 240
"""Number of points of a picture; samples between them are averaged."""
DRAWS = 60
"""Number of draws of noise for the standard deviation of the averages."""


def planned(made: Rehearsal, passes: int, names: Sequence[str], bench: RehearsalBench) -> Experiment:
    """The experiment with the data of its picture: the channel or equation with the largest error of the nearest rival.

    Args:
        made: the motion that separates the named hypothesis from its rivals.
        passes: how often it must be repeated.
        names: of the hypotheses.
        bench: with which it was tried.
    """
    model, j, near = bench.space.equations.true, made.move.joint, made.nearest
    t, left, noise, label = _by_windows(made, bench) if made.sides[0].by_windows else _by_equations(made, passes)
    name = model.joint_names[j]
    return Experiment(
        motion=made.move.words,
        seconds=passes * made.seconds,
        passes=passes,
        payload=made.move.mass,
        delta_bic=made.apart(passes),
        command=made.command,
        names=(names[0], names[1 + near]),
        t=t,
        position=np.interp(t, made.sides[0].run.t, made.move.path[:, j]),
        left=left,
        noise=noise,
        labels=(f"{name} [{model.robot.angle_unit(name)}]", label),
    )


def _by_equations(made: Rehearsal, passes: int) -> tuple[Array, Array, Array, str]:
    """Times, the rival's residual torque in one equation, its noise, and its label."""
    space = made.sides[0].space
    refit = made.sides[0].by_equations[made.nearest][1]
    white = refit.left(passes)[: refit.rows] / np.sqrt(passes)
    t, place, left, noise = _averaged(space.equations, space.whiten, white)
    of, kind = space.equations.kinds[place]
    model = space.equations.true
    side = {"motor": "on the rotor of ", "link": "on the link of "}.get(kind, "")
    return t, left, noise, f"torque {side}{model.joint_names[of]} [{model.robot.torque_unit(of)}]"


def _by_windows(made: Rehearsal, bench: RehearsalBench) -> tuple[Array, Array, Array, str]:
    """Times, the error of the rival's simulated windows in one channel, its noise, and its label."""
    side, load = made.sides[0], bench.load(made.move)
    rival = hypothesis_of_refit(bench.known[1 + made.nearest], side.by_windows[made.nearest][1], load).seen()
    shot = shoot(rival, bench.windows(side.recording))
    left, std, model = shot.residual, shot.std, bench.space.equations.true
    channel = int(np.argmax((left / std).std(axis=(0, 1))))
    name = shot.windows.channels[channel]
    t, off, noise = (each.ravel() for each in (shot.windows.t, left[:, :, channel], std[:, :, channel]))
    every = max(1, len(t) // PICTURE_POINTS)
    unit = model.robot.angle_unit(name.partition(".")[2])
    return t[::every], off[::every], noise[::every], f"{name}, simulated - measured [{unit}]"


def _averaged(equations: Equations, whiten: Whitener, white: Array) -> tuple[Array, int, Array, Array]:
    """Times, the equation with the largest residual, this residual as torque, and its noise; masked rows are NaN."""
    many = len(equations.kinds)
    share = (white.reshape(-1, many) ** 2).sum(axis=0)
    place = int(np.argmax(share))
    draws = np.random.default_rng(0).standard_normal((len(white), DRAWS))
    draws[whiten.mask] = 0.0
    raw = _coloured(whiten.factor, np.column_stack([white, draws]))
    raw[whiten.mask] = np.nan
    rows = raw.reshape(-1, many, 1 + DRAWS)[:, place]
    along = equations.motions[0]
    t = along.t[equations.filters.instants(len(along.t))]
    block = max(1, len(t) // PICTURE_POINTS)
    count = len(t) // block
    blocks = rows[: count * block].reshape(count, block, -1)
    means = np.full((count, 1 + DRAWS), np.nan)
    seen = ~np.isnan(blocks).all(axis=(1, 2))
    means[seen] = np.nanmean(blocks[seen], axis=1)
    return t[: count * block].reshape(count, block).mean(axis=1), place, means[:, 0], means[:, 1:].std(axis=1)


def _coloured(factor: Array, white: Array) -> Array:
    """Convert white rows (rows, columns) back to rows of the equations: the lower band times them."""
    rows = np.zeros_like(white)
    for below, diagonal in enumerate(factor.T):
        rows[below:] += diagonal[below:, None] * white[: len(white) - below]
    return rows
