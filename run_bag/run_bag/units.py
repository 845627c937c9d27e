"""The unit of every field, by message type.

"1" is a pure number (counts, indices, flags, qualities). Types that are not in the table have unknown units
(""). Stamps are no fields here: they become the stamps of the channels.
"""

from __future__ import annotations

import re

from .known_topics import known_topic
from .topics_table import units

UNITS: dict[str, dict[str, str]] = units()
_INDEX = re.compile(r"\[\d+\]")


def unit_of(message_type: str, path: str, topic: str = "") -> str:
    """Return the unit of a field ("voltage[0]" as "voltage", unless it has its own), "" if unknown.

    `topic`: on some the fields of a general type mean something of their own.
    """
    known = known_topic(topic)
    if known is not None and known.type == message_type and path in known.units:
        return known.units[path]
    table = UNITS.get(message_type, {})
    return table.get(path) or table.get(_INDEX.sub("", path), "")
