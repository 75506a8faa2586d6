"""What the tests of channel maps share: raw columns in memory, and a map as it would stand in a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexdyn.records import Recording
from flexdyn.records.channelmap.apply import apply_map
from flexdyn.records.channelmap.description import ChannelMap
from flexdyn.records.table import Table


def channel_map(**entries: Any) -> ChannelMap:
    """A map of the keys of a map file."""
    return ChannelMap.from_dict({"flexdyn_map": 1, **entries})


def mapped(raw: Mapping[str, Any], units: Mapping[str, str | None] | None = None, **entries: Any) -> Recording:
    """The recording that a map makes of raw columns, for which a file may state units."""
    columns = {name: np.array(values) for name, values in raw.items()}
    return Recording.from_table(apply_map(Table(columns, units=dict(units or {})), channel_map(**entries)))
