"""CSV: pandas and pyarrow against our own reader, which itself parses its numbers with `numpy.loadtxt`.

Every file is given as it is: no reader is told anything but the path. Right means: the columns by their names, as
doubles, bit for bit; and an error where a file is damaged.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow.csv
from comparison import Case, Comparison, outcome, times_of

import flexdyn as fd

T = np.arange(4) * 0.25
DRAW = np.random.default_rng(3)
Q = DRAW.standard_normal(4) * 10.0 ** DRAW.integers(-12, 12, 4)
RIGHT = {"t": T, "q.a": Q}
Columns = Mapping[str, Any]
Reader = Callable[[Path], Columns]
PANDAS, ARROW = "pandas, pandas.read_csv", "pyarrow, pyarrow.csv.read_csv"


def _rows(separator: str = ",", head: str = "", decimal: str = ".") -> str:
    numbers = (f"{t!r}{separator}{q!r}" for t, q in zip(T.tolist(), Q.tolist(), strict=True))
    return f"{head}t{separator}q.a\n" + "".join(f"{row}\n" for row in numbers).replace(".", decimal)


def _dates() -> str:
    rows = zip(T.tolist(), Q.tolist(), strict=True)
    return "t,q.a\n" + "".join(f"2024-05-03T12:00:{t:05.2f}+02:00,{q!r}\n" for t, q in rows)


SOUND: dict[str, bytes] = {
    "as pandas writes it": _rows().encode(),
    "semicolons": _rows(";").encode(),
    "semicolons and decimal commas": _rows(";", decimal=",").encode(),
    "names behind a #, spaces between, as NumPy writes it": _rows(" ", "# ").encode(),
    "Unicode text of Excel": _rows("\t").encode("utf-16"),
    "dates and times": _dates().encode(),
    "quoted cells": "".join(f'"{row}"\n' for row in _rows('","').splitlines()).encode(),
}
DAMAGED: dict[str, bytes] = {
    "a row is cut": _rows().encode()[:-25],
    "a cell is text": _rows().replace("0.5,", "0.5,x").encode(),
    "a cell too many": _rows().replace("0.5,", "0.5,1,").encode(),
    "an empty line between samples": _rows().replace("\n0.5,", "\n\n0.5,").encode(),
    "a column twice": _rows().replace("t,q.a", "q.a,q.a").encode(),
}


def compare(data: Path) -> list[Comparison]:
    """Both libraries.

    Args:
        data: folder of the measured data.
    """
    found = []
    with tempfile.TemporaryDirectory() as place:
        files = _written(Path(place))
        large = Path(place) / "large.csv"
        _write_large(large)
        for name, read in ((PANDAS, _pandas), (ARROW, _arrow)):
            cases = [_sound(what, path, read) for what, path in files.items() if what in SOUND]
            cases += [_damaged(what, path, read) for what, path in files.items() if what in DAMAGED]
            cases += [_measured(path, read) for path in sorted(data.glob("screw_drives/*/start_stop/50.csv"))[:1]]
            times = {"20 MB, 20 channels": times_of(partial(read, large), partial(_ours, large), 3)}
            extra = f"{name.split(',')[0]} is an extra, and CSV is read without one"
            found.append(Comparison("CSV files", "flexdyn.records.csv", name, cases, times, extra))
    return found


def _written(folder: Path) -> dict[str, Path]:
    paths = {}
    for number, (what, content) in enumerate((SOUND | DAMAGED).items()):
        paths[what] = folder / f"{number}.csv"
        paths[what].write_bytes(content)
    return paths


def _ours(path: Path) -> Columns:
    rec = fd.read_recording(path)
    return {"t": rec.t, **rec.channels}


def _pandas(path: Path) -> Columns:
    frame = pandas.read_csv(path, float_precision="round_trip")
    return {name: frame[name].to_numpy() for name in frame.columns}


def _arrow(path: Path) -> Columns:
    table = pyarrow.csv.read_csv(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def _same(found: Columns) -> bool:
    return list(found) == list(RIGHT) and all(
        np.asarray(found[name]).dtype == np.float64 and np.array_equal(found[name], RIGHT[name]) for name in RIGHT
    )


def _sound(what: str, path: Path, read: Reader) -> Case:
    return Case(what, outcome(lambda: _same(_ours(path))), outcome(lambda: _same(read(path))))


def _damaged(what: str, path: Path, read: Reader) -> Case:
    """An error is right there, whatever it is called."""

    def refused(reader: Reader) -> str:
        told = outcome(lambda: bool(reader(path)))
        return "" if told else "read without a word"

    return Case(what, refused(_ours), refused(read))


def _measured(path: Path, read: Reader) -> Case:
    """A drive's export: 12 lines of settings, names, units, semicolons; ours is read through its channel map."""
    with open(path, encoding="utf-8") as stream:
        rows = list(csv.reader(stream, delimiter=";"))[14:]
    first = np.array([float(row[0]) for row in rows if row and row[0]])
    channel_map = Path(__file__).parents[1] / "measured" / "screw_drives" / "map_lead_screw.yaml"

    def ours() -> bool:
        return np.allclose(fd.read_recording(path, map=channel_map).t, first * 1e-3, rtol=1e-14)

    def library() -> bool:
        return any(np.array_equal(values, first) for values in read(path).values())

    return Case(f"screw_drives/{path.parent.parent.name}/{path.name}", outcome(ours), outcome(library))


def _write_large(path: Path) -> None:
    block = np.random.default_rng(1).standard_normal((50_000, 20))
    lines = (",".join(map(repr, [k * 1e-3, *row])) for k, row in enumerate(block.tolist()))
    names = ",".join(["t", *(f"q.joint{k}" for k in range(20))])
    path.write_text(names + "\n" + "\n".join(lines) + "\n", encoding="utf-8")
