"""The depth that a pressure tells, (pressure - that at the surface) / (density * gravity), or a unit alone."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from .column_names import bare_name
from .conversions import PASCALS, WATER, G, conversion, is_pressure, written_so
from .csv_source import CsvSource
from .guessed_values import values_of
from .sources import Array
from .vehicle_advice import SHALLOWEST

__all__ = ["WHICH_WATER", "depth_by_unit", "depth_of_pressure", "depths_of_pressures", "is_height"]

_NAMES = re.compile(
    r"(((abs(olute)?|water|wasser)_?)?(press(ure)?|druck)(_?abs(olute)?)?_?)?(?P<unit>dbar|mbar|bar|hpa|kpa|pa)?",
    re.IGNORECASE,
)
_NO_DEPTH = re.compile(
    r"range|dist|abstand|entfernung|pos|lat|lon|north|east|nord|ost|length|tether|cable|laenge|länge|"
    r"bottom|ground|grund|floor|boden|wave|dvl|sonar|ping|beam|echo|accuracy|sigma|std|error|target|set_?point|soll|wanted|desired|^[xyz]$",
    re.IGNORECASE,
)
"""Names of what is in a unit of length, too: no depth by its unit alone."""
_HEIGHT = re.compile(r"alt|height|h(ö|oe)he", re.IGNORECASE)
"""Names of what is above the ground, or above the surface: the latter where it is negative."""
_SURFACE = 101325.0
"""The pressure at the surface [Pa]."""
_OF_AIR = 0.8
"""Share of it that an absolute pressure has at least; one that is less is over that of the surface."""
OVER_SURFACE = " over the pressure at the surface by its values, taken as fresh water's"
WHICH_WATER = " scale is that of fresh water, offset that of 1013 mbar at the surface: write yours"


def depths_of_pressures(columns: Sequence[tuple[CsvSource, str]]) -> list[tuple[CsvSource, str, str, str]]:
    """Return table, name, what a map's entry says of a depth and why, for each pressure in a known unit."""
    found = []
    for source, name in columns:
        match = _NAMES.fullmatch(bare_name(name))
        unit = next(iter(written_so(source.unit(name) or match["unit"] or "")), "") if match else ""
        if unit not in PASCALS:
            continue
        values = values_of(source, name)
        if values is not None and PASCALS[unit] * float(np.nanmin(values)) < _OF_AIR * _SURFACE:
            found.append((source, name, f"unit: {unit}", OVER_SURFACE))
        else:
            found.append((source, name, depth_of_pressure(PASCALS[unit]), WHICH_WATER))
    return found


def depth_by_unit(columns: Sequence[tuple[CsvSource, str]]) -> list[tuple[CsvSource, str]]:
    """Return the column of a vehicle's table that is stated to be a length and may be a depth; none of several."""
    found = [
        (source, name)
        for source, name in columns
        if (unit := source.unit(name))
        and conversion(unit, "m") is not None
        and not is_pressure(unit)
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
    scale, offset = pascals / (WATER * G), -_SURFACE / (WATER * G)
    return f"unit: m, scale: {scale:.5g}, offset: {offset:.6g}"
