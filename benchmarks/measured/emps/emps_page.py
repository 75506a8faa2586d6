"""The EMPS page: verdict, tables and pictures."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from result_tables import markdown_table
from told import findings_text, gap_text

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


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its pictures, and the diagnosis' report into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    made.diagnosis.save(folder / "diagnosis")
    _draw_loops(made, folder / "closed_loop.png")
    _draw_missing(made, folder / "missing.png")
    checks = "\n".join(f"- {each}" for each in held)
    head = (
        "# EMPS: what a plain rigid axis lacks\n"
        "\n"
        "One prismatic axis with its position controller, 24.8 s at 1 kHz a record. DATA_EMPS is fitted; PULSES, "
        "in which 5 V pulses are added after the controller, is not used in the fit."
    )
    parts = [head, checks, *_found(made), *_errors(made), *_loop(made)]
    (folder / "page.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _found(made: Study) -> Iterator[str]:
    yield "## What was found"
    yield f"{gap_text(made.diagnosis)}\n\n{findings_text(made.diagnosis)}"
    rows = [[each.of, each.parameter, f"{each.factor:.4f}", f"{each.std:.4f}"] for each in made.diagnosis.calibration]
    yield markdown_table(["number of the file", "", "factor", "std"], rows, text=2)
    yield (
        "The report's own friction: 20.4 N dry and 203.5 N s/m viscous with an offset of -3.16 N (4.08 %), or, "
        "better (3.11 %), 20.1 N and 166.7 N s/m forwards against 20.6 N and 240.4 N s/m backwards. So the authors "
        "find nearly equal dry levels and a *viscous* part that depends on the direction."
    )
    yield "![what is missing](missing.png)"
    yield (
        "Three things are left without a name. At the lowest speed there is a ripple over position of about 1 N "
        "with two cycles per turn of the screw (2.5 mm). In the first centimetres per second after a reversal, the "
        "friction is smaller than its level, the opposite of a Stribeck effect. In PULSES there is one jump of the "
        "force at 22.4 s that nothing in the recording explains. The diagnosis was told (`expect`) that viscous "
        "friction may depend on the direction, as in the authors' second model. Without that it stays unnamed, "
        "because other unknown laws may look like it."
    )


def _errors(made: Study) -> Iterator[str]:
    yield "## Errors of the force"
    rows = [[name, *("" if x is None else f"{x:.3g}" for x in errors)] for name, errors in REPORTED.items()]
    for name, account in made.accounts.items():
        errors = account.errors()
        found = (100.0 * errors[f"{kind}, {record}"] for kind in KINDS for record in RECORDS)
        rows.append([f"**{name}**" if name == AFTER else name, *(f"{each:.3g}" for each in found)])
    plain = [f"{100.0 * made.reference[record]:.3g}" for record in RECORDS]
    rows.append(["plain least squares, friction of either direction", *plain, "", "", "", ""])
    header = ["error [%]", *(f"{kind}, {record}" for kind in KINDS for record in RECORDS)]
    yield markdown_table(header, rows)
    yield (
        "Norm of the difference over the norm of the measured force. Inverse model: position after a Butterworth "
        "filter of fourth order at 100 Hz, forwards and backwards, central differences, one row of ten. Closed "
        "loop: the raw force of every sample."
    )
    yield "![closed loop](closed_loop.png)"


def _loop(made: Study) -> Iterator[str]:
    yield "## The controller in the loop"
    rows = [[str(delay), *(f"{100.0 * by[record]:.3g}" for record in RECORDS)] for delay, by in made.late.items()]
    yield markdown_table(["samples that the output is late", *(f"error [%], {each}" for each in RECORDS)], rows)
    yield (
        "Evaluated along the measured positions, the published control law gives the recorded voltage of the "
        "*same* row. So the loop is simulated without the one-sample delay of the published diagram. With that "
        "delay the published model has errors close to the printed ones; a part of those comes from the delay and "
        "not from the friction. Runs start at the measured position and velocity, because the axis moves already "
        "when the recording begins. The pulses are steps of 5.07 V, according to the edges of the voltage, not of "
        "5 V."
    )


def _draw_loops(made: Study, path: Path) -> None:
    plt = _pyplot()
    figure, axes = plt.subplots(4, 1, figsize=(11, 9), sharex=True, height_ratios=(2, 1, 2, 1))
    for k, record in enumerate(RECORDS):
        loop = made.accounts[AFTER].loops[record]
        axes[2 * k].plot(loop.t, loop.force[:, 0], color="0.6", lw=0.8, label="measured")
        axes[2 * k].plot(loop.t, loop.force[:, 1], color=COLOURS[1], lw=0.8, label="simulated, controller in the loop")
        axes[2 * k].set(ylabel="force [N]", title=record)
        axes[2 * k].legend(loc="upper right", ncols=2, fontsize=8)
        for name, colour in zip((PUBLISHED, AFTER), COLOURS, strict=True):
            each = made.accounts[name].loops[record]
            text = f"{name}: {100 * each.force_error:.2f} %"
            axes[2 * k + 1].plot(each.t, each.force[:, 1] - each.force[:, 0], color=colour, lw=0.6, label=text)
        axes[2 * k + 1].set(ylabel="error [N]", ylim=(-30, 30))
        axes[2 * k + 1].legend(loc="upper right", ncols=2, fontsize=8)
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
