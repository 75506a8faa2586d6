"""The base of effects that act on one joint, on one side of its transmission."""

from __future__ import annotations

import dataclasses
from typing import Any

from flexdyn.effects.base import Effect, Side
from flexdyn.errors import InputError


class JointEffect(Effect, abstract=True):
    """An effect on one joint, on one side of its transmission.

    Example:
        >>> fd.effects.Backlash("elbow", half_gap=0.01).side  # the only one that is possible
        'transmission'
    """

    joint: str = dataclasses.field(kw_only=False)
    side: Side | None = None

    def __post_init__(self) -> None:
        """Fill in the side if only one is possible, and refuse a side that the law does not have."""
        super().__post_init__()
        if not isinstance(self.joint, str) or not self.joint:
            raise InputError("a joint's name is needed", key=f"{self.name}.joint", value=self.joint)
        side = self.sides[0] if self.side is None and len(self.sides) == 1 else self.side
        if side not in self.sides:
            problem = "the side must be said" if side is None else "no such side for this effect"
            raise InputError(problem, key=f"{self.name}.side", value=side, remedy=f"it is {' or '.join(self.sides)}")
        object.__setattr__(self, "side", side)

    @classmethod
    def uncertain(cls) -> tuple[str, ...]:
        """See the base class."""
        return () if cls.makes_elastic else tuple(f.name for f in cls.parameters() if f.name not in cls.exact)

    @classmethod
    def _example_place(cls, joint: str, other: str) -> dict[str, Any]:
        return {"joint": joint, "side": cls.sides[0]}
