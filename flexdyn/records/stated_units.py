"""Units that files state beside their numbers."""

from __future__ import annotations

from flexdyn.errors import InputError
from flexdyn.records.table import Table
from flexdyn.records.units import UNITLESS, check_unit, unit_of, usual


def settle_units(table: Table) -> None:
    """Keep in meta what the stated units tell beyond the channels' names.

    Args:
        table: whose ``units`` are used up; a channel map has used them before, if there is one.

    Raises:
        InputError: a unit is not SI; the numbers would be taken for something that they are not.
    """
    for name, stated in table.units.items():
        if stated is None:
            problem = "the file states the unit in a way that is not read"
            raise InputError(problem, key=name, remedy="state it in a channel map", channel=name)
        unit, units = usual(stated), table.meta.get("units", {})
        if unit in UNITLESS:
            continue
        check_unit(name, unit)
        if isinstance(units, dict) and unit != unit_of(name, units if isinstance(units.get(name, ""), str) else None):
            table.meta["units"] = {**units, name: unit}
    table.units = {}
