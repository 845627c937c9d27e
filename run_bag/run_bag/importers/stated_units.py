"""Units that a recording states, against those of the map."""

from __future__ import annotations

from .bag_source import BagSource
from .column_names import bare_name
from .conversions import COMMANDS, conversion, spelled
from .csv_source import CsvSource
from .recording_map import Mapped
from .sources import Source
from .unit_words import named_units

__all__ = ["against_stated", "time_against_stated"]

_CLOCK_GAIN = 0.1
"""By which a map's `time_scale` may correct a clock that is too fast or too slow."""


def against_stated(entry: Mapped, source: Source) -> list[str]:
    """Return what is odd where a table or log states another unit than the map does, or a column's name ends in one.

    A bag's message types have units by convention, which a driver may not keep; scaled cells are in none of ours.
    """
    if isinstance(source, BagSource) or abs(entry.scale) != 1.0 or entry.offset or entry.given_unit in COMMANDS:
        return []
    name, whence = str(entry.column), "as the recording states"
    if isinstance(source, CsvSource):
        name = source.names()[source.index(entry.column, entry.channel)]
    stated = source.unit(name)
    if isinstance(source, CsvSource) and not stated:
        named = [unit for unit in named_units(bare_name(name)) if conversion(unit, entry.unit) is not None]
        stated, whence = named[-1] if named else "", "by its name"
    into = conversion(stated, entry.unit) if stated else None
    if into is None or into == entry.convert:
        return []
    whose = f"{'field' if entry.is_field else 'column'} {name!r}"
    return [f"{entry.channel}: {whose} is in {spelled(stated)}, {whence}; the map says {entry.given_unit}"]


def time_against_stated(entry: Mapped, source: Source) -> list[str]:
    """Return what is odd where a table states another unit of a time than the map does: of dates always seconds."""
    if not isinstance(source, CsvSource) or entry.time_column is None:
        return []
    name = source.names()[source.index(entry.time_column, entry.channel)]
    stated = source.unit(name)
    into = conversion(stated, "s") if stated else None
    if into is None or abs(entry.time_scale / into.factor - 1.0) < _CLOCK_GAIN:
        return []
    what = "has dates or times of day, read as seconds" if name in source.dated else f"is in {spelled(stated)}"
    whose = f"{source.path.name}: time column {name!r}"
    return [
        f"{whose} {what}, as the recording states; the map makes {entry.time_scale:g} s of each, not {into.factor:g}"
    ]
