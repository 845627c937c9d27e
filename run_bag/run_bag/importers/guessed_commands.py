"""Commands of thrusters whose names no rule knows: columns that differ by a number, in % or in pulses.

A vehicle's table has one such group: M1 ... M8 of 1283 to 1701, or thrust_pct_1 ... thrust_pct_6 of -57 to 57.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .column_names import bare_name
from .conversions import spelled
from .csv_source import CsvSource
from .guessed_clock import values_of
from .guessed_names import numbered
from .guessed_units import named_units, pulses

__all__ = ["alike_commands"]


def alike_commands(columns: Sequence[tuple[CsvSource, str]]) -> list[tuple[CsvSource, str, int, str]]:
    """Return table, name, thruster and what tells it ("unit", "values"); none where two groups may be the commands."""
    groups: dict[tuple[str, str], list[tuple[CsvSource, str, int, str]]] = {}
    for source, name in columns:
        stem, thruster = numbered(bare_name(name), source.names())
        if stem != bare_name(name):
            told = _tells_a_command(source, name)
            groups.setdefault((str(source.path), stem.lower()), []).append((source, name, thruster, told))
    likely = [group for group in groups.values() if len(group) > 1 and all(told for *_, told in group)]
    return likely[0] if len(likely) == 1 else []


def _tells_a_command(source: CsvSource, name: str) -> str:
    """Return "unit" or "values" where that tells a column to be a command, "" where neither does.

    Pulses without a unit are whole numbers, as a timer counts them; a pressure in mbar may be as large.
    """
    values, stated = values_of(source, name), source.unit(name)
    unit = spelled(stated) if stated else next(iter(named_units(name)[-1:]), "")
    if values is None or (unit == "us" and not pulses(values)):
        return ""
    if unit in ("us", "%"):
        return "unit"
    known = values[np.isfinite(values)]
    return "values" if not unit and pulses(values) and np.array_equal(known, np.round(known)) else ""
