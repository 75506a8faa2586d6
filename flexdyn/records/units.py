"""Signals of a recording and their SI units."""

from __future__ import annotations

from collections.abc import Mapping

from flexdyn.errors import InputError

SIGNALS: Mapping[str, str] = {
    "q": "rad",
    "v": "rad/s",
    "theta": "rad",
    "omega": "rad/s",
    "tau": "N m",
    "tau_applied": "N m",
    "tau_s": "N m",
    "voltage": "V",
    "duty": "1",
    "goal": "rad",
    "temperature": "degC",
}
"""Unit of each signal at a revolute joint; other names before the dot are no signals of a joint."""

HELD = ("tau", "tau_applied", "voltage", "duty", "goal")
"""Signals that are held from each sample to the next (contract, section 4)."""

UNITLESS = ("", "1", "-")
"""Words in files for a number without unit."""

_SI_SPELLINGS = {
    "s": ("sec", "second", "seconds"),
    "rad": ("radian", "radians"),
    "rad/s": ("rad/sec", "rad s-1", "rad s^-1", "rad*s^-1"),
    "m": ("meter", "meters", "metre", "metres"),
    "m/s": ("m/sec", "m s-1", "m s^-1", "m*s^-1"),
    "N m": ("Nm", "N*m", "N.m", "N·m", "N-m"),
    "N": ("newton", "newtons"),
    "degC": ("°C", "C", "celsius", "Celsius", "deg C"),
}
_USUAL = {other: unit for unit, others in _SI_SPELLINGS.items() for other in others}


def split_name(channel: str) -> tuple[str, str] | None:
    """Signal and joint of ``<signal>.<joint>`` (a joint's name may hold dots), or None for any other channel."""
    signal, dot, joint = channel.partition(".")
    return (signal, joint) if dot and signal in SIGNALS else None


def signal_unit(signal: str, *, prismatic: bool) -> str:
    """SI unit of a signal at a revolute or prismatic joint."""
    return unit_for(SIGNALS[signal], prismatic=prismatic)


def unit_for(unit: str, *, prismatic: bool) -> str:
    """A unit on this kind of joint: for a prismatic joint N m becomes N, and rad becomes m.

    Example:
        >>> fd.effects.unit_for("N m s/rad", prismatic=True)
        'N s/m'
    """
    return unit.replace("N m", "N").replace("rad", "m") if prismatic else unit


def is_held(channel: str) -> bool:
    """Whether the signal of a channel is held from each sample to the next."""
    return channel.partition(".")[0] in HELD and "." in channel


def unit_of(channel: str, units: Mapping[str, str] | None = None) -> str:
    """Unit of a channel.

    A channel's name does not show whether a joint is prismatic, so radians are assumed unless `units` gives another
    unit.

    Args:
        channel: ``t``, ``<signal>.<joint>`` or any other channel.
        units: known units, by channel; a recording keeps them in ``meta["units"]``.

    Returns:
        The SI unit, such as ``"rad/s"``; empty if it is not known.
    """
    if units and channel in units:
        return usual(units[channel])
    if channel == "t":
        return "s"
    parts = split_name(channel)
    return SIGNALS[parts[0]] if parts else ""


def usual(unit: str) -> str:
    """The spelling used here of a unit that has several: ``Nm`` is ``N m``."""
    unit = " ".join(unit.split())
    return _USUAL.get(unit, unit)


def check_unit(channel: str, unit: str) -> None:
    """Refuse a unit that the channel's signal does not have; channels that are no signals may have any.

    Args:
        channel: name of the channel.
        unit: its unit from the user or a file.

    Raises:
        InputError: a unit such as degrees or milliseconds; without this check the numbers would be taken as SI.
    """
    known = unit_of(channel)
    allowed = dict.fromkeys([known, unit_for(known, prismatic=True)])
    if known and usual(unit) not in allowed:
        remedy = f"convert it to {' or '.join(allowed)}, or read it with a channel map"
        raise InputError("the unit is not SI", key=channel, value=unit, remedy=remedy, channel=channel)
