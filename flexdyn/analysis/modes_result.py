"""Modes: eigenfrequencies, damping ratios and shapes as data and as a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Flags
from flexdyn.errors import listed
from flexdyn.io.locked import Locked
from flexdyn.io.notebook import card, html_table

MOST_FREQUENCIES = 8
"""Frequencies that the short form lists."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Modes(Locked):
    """Free small vibrations about a pose at rest, m of them by rising frequency.

    Attributes:
        name: of the model.
        joint_names: in the order of q.
        q: the pose (n,) [rad or m].
        rotors: ``free`` or ``held``.
        frequencies: undamped, w/(2 pi) (m,) [Hz]; 0 where there is no restoring torque.
        damping_ratios: s^T D s/(2 w) of mass-normalised shapes (m,) [1]: exact where damping does not couple the modes
            (damping across transmissions in proportion to stiffness, say), first order in damping elsewhere, where
            `poles` is exact. NaN where the frequency is 0.
        kinds: ``vibration``; ``rigid-body`` (w = 0: it moves freely); ``unstable`` (w^2 < 0: it falls).
        link_shapes: q part of every shape (m, n); the largest entry of a shape, links and rotors together, is 1.
        rotor_shapes: theta part (m, n), reflected; the link's on a rigid joint, 0 where rotors are held.
        poles: eigenvalues of the damped motion (2 m,) [rad/s], complex, by size.
        anti_resonances: zeros of the response from a motor's torque to its own speed: the frequencies with that rotor
            held and the others free (n, others) [Hz], a row for each motor; 0 where the zero is no oscillation.

    Example:
        >>> model = fd.load_model("ur5")
        >>> found = fd.modes(model)
        >>> found.frequencies.size == found.damping_ratios.size
        True
    """

    name: str
    joint_names: tuple[str, ...]
    q: Array
    rotors: str
    frequencies: Array
    damping_ratios: Array
    kinds: tuple[str, ...]
    link_shapes: Array
    rotor_shapes: Array
    poles: NDArray[np.complex128]
    anti_resonances: Array

    def __len__(self) -> int:
        """Number of modes."""
        return len(self.frequencies)

    @property
    def rigid_body(self) -> Flags:
        """Whether each mode moves without a restoring torque (m,)."""
        return np.array([kind == "rigid-body" for kind in self.kinds])

    def rows(self) -> list[dict[str, Any]]:
        """One plain mapping for each mode: mode, frequency, damping_ratio or None, kind, shapes by joint."""
        return [
            {
                "mode": k + 1,
                "frequency": float(self.frequencies[k]),
                "damping_ratio": None if np.isnan(self.damping_ratios[k]) else float(self.damping_ratios[k]),
                "kind": self.kinds[k],
                "link": dict(zip(self.joint_names, self.link_shapes[k].tolist(), strict=True)),
                "rotor": dict(zip(self.joint_names, self.rotor_shapes[k].tolist(), strict=True)),
            }
            for k in range(len(self))
        ]

    def __repr__(self) -> str:
        """The number of modes of each kind, and their frequencies; `print` gives the whole table."""
        told = []
        for kind in dict.fromkeys(self.kinds):
            rows = [k for k, each in enumerate(self.kinds) if each == kind]
            hertz = [f"{self.frequencies[k]:.4g}" for k in rows if self.frequencies[k] > 0.0]
            at = f" at {listed(hertz, MOST_FREQUENCIES)} Hz" if hertz else ""
            told.append(f"{len(rows)} {kind}{at}")
        return f"<Modes of {self.name}, rotors {self.rotors}: {'; '.join(told)}>"

    def _repr_html_(self) -> str:
        """HTML for notebooks: a row for each mode, its shape in the columns of the joints."""
        rows = [(*head, part, *(f"{value:.3f}" for value in shape)) for head, part, shape in self._lines()]
        heads = ("mode", "Hz", "damping", "kind", "part", *self.joint_names)
        facts = {"rotors": self.rotors, "at": self._at()}
        return card(f"Modes of {self.name}", facts, html_table(heads, rows, len(rows)), notes=self._zeros())

    def __str__(self) -> str:
        """A table: a line for each mode, then a line of anti-resonances for each motor."""
        width = max(10, *(len(name) + 2 for name in self.joint_names))
        head = f"{'mode':>4}  {'Hz':>9}  {'damping':>8}  {'kind':<10}  part"
        names = "".join(f"{joint:>{width}}" for joint in self.joint_names)
        lines = [f"{self.name}: {len(self)} modes at {self._at()}; rotors {self.rotors}", head.ljust(47) + names]
        for (mode, hertz, ratio, kind), part, shape in self._lines():
            at = f"{hertz:>9.4g}" if hertz != "" else " " * 9
            start = f"{mode:>4}  {at}  {ratio:>8}  {kind:<10}  {part:<5}"
            lines.append(start.ljust(47) + "".join(f"{value:>{width}.3f}" for value in shape))
        return "\n".join([*lines, *self._zeros()])

    def _at(self) -> str:
        return ", ".join(f"{joint} {value:.4g}" for joint, value in zip(self.joint_names, self.q, strict=True))

    def _lines(self) -> Iterator[tuple[tuple[Any, ...], str, Iterable[float]]]:
        """Lines of a table: number, frequency, damping and kind of a mode, a part, and that part of its shape."""
        for row in self.rows():
            ratio = "-" if row["damping_ratio"] is None else f"{row['damping_ratio']:.2%}"
            head: tuple[Any, ...] = (row["mode"], row["frequency"], ratio, row["kind"])
            for part in ("link",) if self.rotors == "held" else ("link", "rotor"):
                yield head, part, row[part].values()
                head = ("", "", "", "")

    def _zeros(self) -> tuple[str, ...]:
        """A line of anti-resonances for each motor."""
        found = (row[row > 0] for row in self.anti_resonances)
        told = [", ".join(f"{zero:.4g}" for zero in zeros) + " Hz" if len(zeros) else "none" for zeros in found]
        return tuple(f"anti-resonances of {joint}: {each}" for joint, each in zip(self.joint_names, told, strict=True))
