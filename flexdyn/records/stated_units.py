"""Units in files."""

from __future__ import annotations

from flexdyn.errors import InputError
from flexdyn.records.table import Table
from flexdyn.records.units import UNITLESS, check_unit, unit_of, usual


def settle_units(table: Table) -> None:
    """Keep in meta the units that the channels' names do not determine.

    Args:
        table: whose ``units`` are removed; a channel map, if there is one, has used them before.

    Raises:
        InputError: a unit is not SI, so that the numbers would be misread.
    """
    for name, stated in table.units.items():
        if stated is None:
            problem = "the file states the unit in a way that is not read"
            raise InputError(problem, remedy="state it in a channel map", channel=name)
        unit, units = usual(stated), table.meta.get("units", {})
        if unit in UNITLESS:
            continue
        check_unit(name, unit)
        if isinstance(units, dict) and unit != unit_of(name, units if isinstance(units.get(name, ""), str) else None):
            table.meta["units"] = {**units, name: unit}
    table.units = {}
