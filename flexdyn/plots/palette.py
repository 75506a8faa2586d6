"""Colours: a hue for every joint, the same in all panels; greys for measured motions."""

from __future__ import annotations

from collections.abc import Sequence

from flexdyn.comparison.motion_sources import MotionSource

HUES = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#B8860B", "#3BA3D9", "#332288", "#7A5230")
"""Colours of joints, used cyclically: those of Okabe and Ito, pale ones darkened, and of Tol."""
GREYS = ("#9CA3AF", "#4B5563", "#C9CDD3")
"""Greys of measured motions, if there is a simulated one."""
INK, SOFT, RULE = "#1F2937", "#6B7280", "#E5E7EB"
"""Colours of text, notes and grids."""
PARTS = {
    "kinetic": "#882255",
    "spring": "#44AA99",
    "gravity": "#999933",
    "mechanical": "#111827",
    "supplied": "#4477AA",
    "external": "#66CCEE",
    "residual": "#6B7280",
}
"""Colours of the entries of an energy ledger; no joint has one of them."""
LOSSES = ("#CC6677", "#DDCC77", "#117733", "#AA4466", "#888888", "#EE8866", "#99DDFF", "#BBCC33")
"""Colours of the energies that effects dissipate."""
_BLENDS = (
    ("#000000", 0.0),
    ("#000000", 0.55),
    ("#FFFFFF", 0.5),
    ("#000000", 0.28),
    ("#FFFFFF", 0.25),
    ("#000000", 0.8),
)


def hue(place: int) -> str:
    """The colour of the joint with an index."""
    return HUES[place % len(HUES)]


def shade(colour: str, sources: Sequence[MotionSource], place: int) -> str:
    """The colour of a motion: grey if it was measured and another was not, else a shade of the joint's hue.

    Args:
        colour: of the joint.
        sources: all motions that are drawn.
        place: index of this one.
    """
    measured = [source.measured for source in sources]
    alike = [i for i, entry in enumerate(measured) if entry == measured[place]]
    rank = alike.index(place)
    if measured[place] and not all(measured):
        return GREYS[rank % len(GREYS)]
    towards, share = _BLENDS[rank % len(_BLENDS)]
    return blend(colour, towards, share)


def blend(colour: str, towards: str, share: float) -> str:
    """A mixture of two colours: at share 0 the first, at 1 the other."""
    pairs = [(int(colour[i : i + 2], 16), int(towards[i : i + 2], 16)) for i in (1, 3, 5)]
    return "#" + "".join(f"{round((1.0 - share) * a + share * b):02X}" for a, b in pairs)
