"""The EMPS page: verdict, tables and pictures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from pages import fill_page
from result_tables import markdown_table

if TYPE_CHECKING:
    from emps_result import Study
    from measure import Bound

BEFORE, AFTER, PUBLISHED = "plain axis, as given", "found", "published model"
KINDS = ("inverse model", "closed loop", "closed loop position")
RECORDS = ("DATA_EMPS", "PULSES")
REPORTED = {
    "published model, as the report prints it": (4.0834, 5.9824, 5.848, 8.9409, 0.013752, 0.0080248),
    "friction of either direction, as printed": (3.1117, None, None, None, None, None),
}
"""Errors in the report [%], in the order of the table."""
COLOURS = ("#b3261e", "#1b5e9e")
ABOVE: dict[str, Any] = {
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 0.98),
    "ncols": 2,
    "fontsize": 8,
    "frameon": False,
}
"""A legend above its axes: the curves fill them."""


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its pictures, and the diagnosis' report into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    made.diagnosis.save(folder / "diagnosis")
    _draw_loops(made, folder / "closed_loop.png")
    _draw_missing(made, folder / "missing.png")
    fill_page(__file__, made, held, folder, errors=_errors(made), late=_late(made))


def _errors(made: Study) -> str:
    """Errors of the force: reported, of every account, and of plain least squares."""
    rows = [[name, *("" if x is None else f"{x:.3g}" for x in errors)] for name, errors in REPORTED.items()]
    for name, account in made.accounts.items():
        errors = account.errors()
        found = (100.0 * errors[f"{kind}, {record}"] for kind in KINDS for record in RECORDS)
        rows.append([f"**{name}**" if name == AFTER else name, *(f"{each:.3g}" for each in found)])
    plain = [f"{100.0 * made.reference[record]:.3g}" for record in RECORDS]
    rows.append(["plain least squares, friction of either direction", *plain, "", "", "", ""])
    header = ["error [%]", *(f"{kind}, {record}" for kind in KINDS for record in RECORDS)]
    return markdown_table(header, rows)


def _late(made: Study) -> str:
    """Errors of the control law by its delay."""
    rows = [[str(delay), *(f"{100.0 * by[record]:.3g}" for record in RECORDS)] for delay, by in made.late.items()]
    return markdown_table(["samples that the output is late", *(f"error [%], {each}" for each in RECORDS)], rows)


def _draw_loops(made: Study, path: Path) -> None:
    plt = _pyplot()
    figure, axes = plt.subplots(4, 1, figsize=(11, 9), sharex=True, height_ratios=(2, 1, 2, 1))
    for k, record in enumerate(RECORDS):
        loop = made.accounts[AFTER].loops[record]
        axes[2 * k].plot(loop.t, loop.force[:, 0], color="0.6", lw=0.8, label="measured")
        axes[2 * k].plot(loop.t, loop.force[:, 1], color=COLOURS[1], lw=0.8, label="simulated, controller in the loop")
        axes[2 * k].set(ylabel="force [N]", title=record)
        axes[2 * k].legend(**ABOVE)
        for name, colour in zip((PUBLISHED, AFTER), COLOURS, strict=True):
            each = made.accounts[name].loops[record]
            text = f"{name}: {100 * each.force_error:.2f} %"
            axes[2 * k + 1].plot(each.t, each.force[:, 1] - each.force[:, 0], color=colour, lw=0.6, label=text)
        axes[2 * k + 1].set(ylabel="error [N]", ylim=(-30, 30))
        axes[2 * k + 1].legend(**ABOVE)
    axes[-1].set_xlabel("t [s]")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_missing(made: Study, path: Path) -> None:
    plt = _pyplot()
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.2))
    for name, colour in zip((BEFORE, AFTER), COLOURS, strict=True):
        seen = made.accounts[name].inverses[RECORDS[1]]
        order = np.argsort(seen.q)
        axes[0].plot(seen.v, seen.missing, ".", ms=1.5, color=colour, label=name)
        axes[1].plot(seen.q[order], seen.missing[order], ".", ms=1.5, color=colour, label=name)
    axes[0].set(xlabel="velocity [m/s]", ylabel="missing force [N]", ylim=(-40, 40), title="PULSES, took no part")
    axes[1].set(xlabel="position [m]", ylim=(-40, 40))
    axes[0].legend(markerscale=6)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _pyplot() -> Any:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    return plt
