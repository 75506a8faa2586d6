"""Colours: a hue for every joint, the same in all panels; greys for what was measured."""

from __future__ import annotations

from collections.abc import Sequence

from flexdyn.comparison.motion_sources import MotionSource

HUES = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#B8860B", "#3BA3D9", "#332288", "#7A5230")
"""Of joints, in their order and then from the start again: Okabe and Ito's, darkened where pale, and Tol's."""
GREYS = ("#9CA3AF", "#4B5563", "#C9CDD3")
"""Of what was measured, beside a simulation."""
INK, SOFT, RULE = "#1F2937", "#6B7280", "#E5E7EB"
"""Of text, of notes, of grids."""
PARTS = {
    "kinetic": "#882255",
    "spring": "#44AA99",
    "gravity": "#999933",
    "mechanical": "#111827",
    "supplied": "#4477AA",
    "external": "#66CCEE",
    "residual": "#6B7280",
}
"""Of entries of an energy ledger, none of them a joint's."""
LOSSES = ("#CC6677", "#DDCC77", "#117733", "#AA4466", "#888888", "#EE8866", "#99DDFF", "#BBCC33")
"""Of what effects dissipate."""
DASHES = ("solid", "dashed", "dashdot", "dotted")
"""Styles of lines, as both renderers know them."""
_BLENDS = (
    ("#000000", 0.0),
    ("#000000", 0.55),
    ("#FFFFFF", 0.5),
    ("#000000", 0.28),
    ("#FFFFFF", 0.25),
    ("#000000", 0.8),
)


def hue(place: int) -> str:
    """Of the joint at a place in the arm."""
    return HUES[place % len(HUES)]


def shade(colour: str, sources: Sequence[MotionSource], place: int) -> str:
    """Of one of several motions: a grey if it was measured and another was not, else a shade of the joint's hue.

    Args:
        colour: of the joint.
        sources: all that are drawn.
        place: of this one among them.
    """
    measured = [source.measured for source in sources]
    alike = [i for i, entry in enumerate(measured) if entry == measured[place]]
    rank = alike.index(place)
    if measured[place] and not all(measured):
        return GREYS[rank % len(GREYS)]
    towards, share = _BLENDS[rank % len(_BLENDS)]
    return blend(colour, towards, share)


def blend(colour: str, towards: str, share: float) -> str:
    """A colour on the way to another: at share 0 itself, at 1 the other."""
    pairs = [(int(colour[i : i + 2], 16), int(towards[i : i + 2], 16)) for i in (1, 3, 5)]
    return "#" + "".join(f"{round((1.0 - share) * a + share * b):02X}" for a, b in pairs)
