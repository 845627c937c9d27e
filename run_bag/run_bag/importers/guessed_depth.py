"""The depth that a pressure tells, (pressure - that at the surface) / (density * gravity), or a unit alone."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from .column_names import bare_name
from .conversions import G, conversion
from .csv_source import CsvSource
from .guessed_values import values_of
from .sources import Array
from .vehicle_advice import SHALLOWEST

__all__ = ["WHICH_WATER", "depth_by_unit", "depth_of_pressure", "depths_of_pressures", "is_height"]

_NAMES = re.compile(
    r"((abs(olute)?_?)?(press(ure)?|(wasser)?druck)(_?abs(olute)?)?_?)?(?P<unit>mbar|bar|hpa|kpa|pa)?", re.IGNORECASE
)
_NO_DEPTH = re.compile(
    r"range|dist|abstand|entfernung|pos|lat|lon|north|east|nord|ost|length|tether|cable|laenge|länge|"
    r"bottom|ground|grund|floor|boden|wave|dvl|sonar|ping|beam|echo|accuracy|sigma|std|error|target|set_?point|soll|wanted|desired|^[xyz]$",
    re.IGNORECASE,
)
"""Names of what is in a unit of length, too: no depth by its unit alone."""
_HEIGHT = re.compile(r"alt|height|h(ö|oe)he", re.IGNORECASE)
"""Names of what is above the ground, or above the surface: the latter where it is negative."""
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


def depth_by_unit(columns: Sequence[tuple[CsvSource, str]]) -> list[tuple[CsvSource, str]]:
    """Return the column of a vehicle's table that is stated to be a length and may be a depth; none of several."""
    found = [
        (source, name)
        for source, name in columns
        if (unit := source.unit(name))
        and conversion(unit, "m") is not None
        and not _NO_DEPTH.search(bare := bare_name(name))
        and (not _HEIGHT.search(bare) or ((own := values_of(source, name)) is not None and is_height(own, unit)))
    ]
    return found if len(found) == 1 else []


def is_height(values: Array, unit: str) -> bool:
    """Tell whether readings in a unit are positive up: they are of a vehicle below the surface."""
    into = conversion(unit, "m")
    return into is not None and into.factor * float(np.nanmedian(values)) < SHALLOWEST


def depth_of_pressure(pascals: float) -> str:
    """Return what a map's entry says of a depth that is told by a pressure in a unit of so many Pa."""
    scale, offset = pascals / (_DENSITY * G), -_SURFACE / (_DENSITY * G)
    return f"unit: m, scale: {scale:.5g}, offset: {offset:.6g}"
