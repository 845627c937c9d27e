"""The depth that a pressure tells: (pressure - that at the surface) / (density * gravity)."""

from __future__ import annotations

import re
from collections.abc import Sequence

from .column_names import bare_name
from .conversions import G
from .csv_source import CsvSource

__all__ = ["WHICH_WATER", "depth_of_pressure", "depths_of_pressures"]

_NAMES = re.compile(
    r"((abs(olute)?_?)?(press(ure)?|(wasser)?druck)(_?abs(olute)?)?_?)?(?P<unit>mbar|bar|hpa|kpa|pa)?", re.IGNORECASE
)
_PASCALS = {"pa": 1.0, "hpa": 100.0, "mbar": 100.0, "kpa": 1000.0, "bar": 1e5}
_DENSITY, _SURFACE = 1000.0, 101325.0
"""Fresh water [kg/m^3], and the pressure at its surface [Pa]."""
WHICH_WATER = " scale is that of fresh water, offset that of 1013 mbar at the surface: write yours"


def depths_of_pressures(columns: Sequence[tuple[CsvSource, str]]) -> list[tuple[CsvSource, str, str]]:
    """Return table, name and what a map's entry says of a depth, for each column that is a pressure in a known unit."""
    found = []
    for source, name in columns:
        match = _NAMES.fullmatch(bare_name(name))
        pascals = _PASCALS.get((source.unit(name) or match["unit"] or "").lower()) if match else None
        if pascals is not None:
            found.append((source, name, depth_of_pressure(pascals)))
    return found


def depth_of_pressure(pascals: float) -> str:
    """Return what a map's entry says of a depth that is told by a pressure in a unit of so many Pa."""
    scale, offset = pascals / (_DENSITY * G), -_SURFACE / (_DENSITY * G)
    return f"unit: m, scale: {scale:.5g}, offset: {offset:.6g}"
