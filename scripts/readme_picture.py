"""Draw the README's first picture: the paper's arm, elastic against rigid, with friction and without."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

OUT = Path(__file__).parents[1] / "benchmarks" / "figures" / "first_screen.png"
ELASTIC, RIGID, FRICTION = "#0072b2", "#555555", "#d55e00"
DURATION = 8.0  # s, of which the torque acts for the first 2.4


def torque() -> fd.Samples:
    """Accelerate for 1.2 s, brake for 1.2 s: within the actuator's line of Table I."""
    t = np.array([0.0, 1.2, 2.4])
    return fd.Samples(t, {"shoulder": [0.35, -0.35, 0.0], "elbow": [-0.08, 0.08, 0.0]})


def elbow_and_tip(q: NDArray[np.float64], length: float = 1.05) -> NDArray[np.float64]:
    """Corners of the arm in the plane (3, 2) [m]: base, elbow, tip."""
    a, b = q[0], q[0] + q[1]
    elbow = length * np.array([np.cos(a), np.sin(a)])
    return np.array([[0.0, 0.0], elbow, elbow + length * np.array([np.cos(b), np.sin(b)])])


def draw_arm(axes: Axes, run: fd.Run, rigid: fd.Run) -> None:
    """The arm at five instants: links where they are, rotors where they would have them."""
    for k in np.linspace(0, 2400, 5).astype(int):
        shade = 0.25 + 0.75 * k / 2400
        axes.plot(*elbow_and_tip(rigid.q[k]).T, color=RIGID, lw=1.2, ls="--", alpha=shade)
        axes.plot(
            *elbow_and_tip(run.q[k]).T, color=ELASTIC, lw=3, alpha=shade, solid_capstyle="round", marker="o", ms=4
        )
    axes.plot(*run.frame_positions("tool")[:, :2].T, color=ELASTIC, lw=0.8)
    axes.plot(*rigid.frame_positions("tool")[:, :2].T, color=RIGID, lw=0.8, ls="--")
    axes.set_xlim(-0.1, 1.3)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="The arm from above, every 0.6 s", aspect="equal")


def main() -> None:
    """Simulate, draw, write."""
    model = fd.load_model("scara_two_link")
    bare = model.replace(effects=[e for e in model.effects if e.name == "torque_speed_limit"])
    runs = {name: fd.simulate(m, torque(), DURATION) for name, m in (("friction", model), ("bare", bare))}
    rigid = fd.simulate(bare.rigid(), torque(), DURATION)
    plt.rcParams |= {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 11}
    figure, panels = plt.subplot_mosaic(
        [["arm", "q"], ["arm", "delta"]], figsize=(10.5, 4.6), width_ratios=[1, 1.7], layout="constrained"
    )
    draw_arm(panels["arm"], runs["bare"], rigid)
    t = rigid.t
    panels["q"].plot(t, np.degrees(rigid.v[:, 1]), color=RIGID, ls="--", label="rigid")
    panels["q"].plot(t, np.degrees(runs["bare"].v[:, 1]), color=ELASTIC, label="elastic")
    panels["q"].plot(t, np.degrees(runs["friction"].v[:, 1]), color=FRICTION, label="elastic, friction")
    panels["q"].set(ylabel="deg/s", title="Elbow speed")
    panels["q"].legend(frameon=False, ncols=3, loc="upper right")
    panels["q"].set_ylim(-60, 48)
    panels["delta"].plot(t, np.degrees(runs["bare"].deflection[:, 1]), color=ELASTIC)
    panels["delta"].plot(t, np.degrees(runs["friction"].deflection[:, 1]), color=FRICTION)
    panels["delta"].set(
        xlabel="time [s]",
        ylabel="deg",
        title="Deflection of the elbow's drive (torque acts in the grey span)",
    )
    for name in ("q", "delta"):
        panels[name].axvspan(0, 2.4, color="0.93", zorder=-1)
        panels[name].set_xlim(0, DURATION)
    OUT.parent.mkdir(exist_ok=True)
    figure.savefig(OUT, dpi=110)


if __name__ == "__main__":
    main()
