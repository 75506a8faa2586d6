"""Pictures of the KUKA's page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kuka_result import Study

AXIS = 1


def draw(made: Study, folder: Path) -> None:
    """Write torque.png and encoders.png."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.2), layout="constrained")
    _torque(made, figure)
    figure.savefig(folder / "torque.png", dpi=110)
    figure = Figure(figsize=(11, 6.2), layout="constrained")
    _encoders(made, figure)
    figure.savefig(folder / "encoders.png", dpi=110)


def _torque(made: Study, figure: object) -> None:
    axes = figure.subplots(2, 2)  # type: ignore[attr-defined]
    for ax, name in zip(axes[0], ("B", "C"), strict=True):
        before, after = made.before[name], made.after[name]
        ax.plot(before.t, before.torque[:, AXIS], color="black", lw=1.4, label="measured")
        ax.plot(before.t, (before.torque - before.missing)[:, AXIS], color="tab:red", lw=1.0, label="published model")
        ax.plot(after.t, (after.torque - after.missing)[:, AXIS], color="tab:blue", lw=1.0, label="with what was found")
        ax.set(title=f"axis 2, record {name} (took no part)", xlabel="t [s]", ylabel="motor torque [N m]")
    axes[0, 0].legend(fontsize=8)
    for ax, which, title in (
        (axes[1, 0], made.before, "published model"),
        (axes[1, 1], made.after, "with what was found"),
    ):
        for name, color in (("A", "tab:gray"), ("B", "tab:orange"), ("C", "tab:green")):
            of = which[name]
            moves = np.abs(of.omega[:, AXIS]) > 5e-3
            ax.plot(of.q[moves, AXIS], of.missing[moves, AXIS], ".", ms=2.5, color=color, label=name)
        ax.set(title=f"missing torque, {title}", xlabel="q of axis 2 [rad]", ylabel="[N m]", ylim=(-6000, 6000))
        ax.axhline(0.0, color="black", lw=0.6)
    axes[1, 0].legend(fontsize=8)


def _encoders(made: Study, figure: object) -> None:
    axes = figure.subplots(2, 3)  # type: ignore[attr-defined]
    for j, seen in enumerate(made.differences):
        of, told = seen["B"], made.accounts[j]
        axes[0, j].plot(of.t, 1e3 * (of.theta - of.q), color="tab:gray", lw=0.5, label="theta - q")
        X = np.stack([of.columns[term] for term in told.terms], axis=1)
        sums = (X - X.mean(axis=0)) @ np.array([told.estimates[term]["A"] for term in told.terms]) + of.left.mean()
        axes[0, j].plot(of.t, 1e3 * sums, color="tab:blue", lw=1.2, label=" + ".join(told.terms) + ", of A")
        axes[0, j].set(title=f"axis {j + 1}, record B", xlabel="t [s]", ylabel="[mrad]")
        axes[0, j].margins(y=0.3)  # room for the legend
        axes[0, j].legend(fontsize=7)
        steps = ["all", *told.terms]
        for name, color in (("A", "tab:gray"), ("B", "tab:orange"), ("C", "tab:green")):
            axes[1, j].semilogy(steps, [1e6 * each[name] for each in told.left], "o-", color=color, label=name)
        axes[1, j].set(title="left when taken in one by one", ylabel="rms [urad]", ylim=(20, 1000))
    axes[1, 0].legend(fontsize=8)
