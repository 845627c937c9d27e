"""The map from a maker's columns to a table of forces, a YAML file.

name: ...
source: who measured, when, how
sheets: "[0-9]+ V"                                        optional: the sheets of an xlsx to read, a regular expression
command: {column: PWM (µs), unit: µs, stop: 1500}
supply: {column: Voltage (V), unit: V}                    or {sheet: "([0-9.]+) ?V", unit: V}: from the sheet's name
force: {column: Force (Kg f), unit: N, scale: 9.80665, zero_up_to: 0.0}
speed: {column: RPM, unit: rad/s, scale: 0.104719755, signed: false}           optional, as are current and power

Patterns are regular expressions, with four repetitions at most and none inside another.
value = scale * cell, in `unit` (scale defaults to 1). A csv has one sheet, called as the file without its ending.
Forces of at most `zero_up_to` [N, default 0] are zero: the noise of a scale at rest. `signed: false`: the column holds
the magnitude; it gets the sign of command - stop.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from safe_files.yaml_io import yaml_mapping
from thruster_model.bounded_pattern import bounded
from thruster_model.errors import ForceTableError
from thruster_model.force_table import QUANTITIES

__all__ = ["ColumnMap", "MappedColumn", "read_column_map"]

_TEXTS = ("name", "source")
_NEEDED = (*_TEXTS, "command", "supply", "force")
_KEYS = (*_NEEDED, "sheets", "speed", "current", "power")


@dataclass(frozen=True, kw_only=True)
class MappedColumn:
    """Where one quantity is found: in the column of this heading, or (supply only) in the sheet's name."""

    quantity: str
    unit: str
    column: str = ""
    sheet: str = ""
    scale: float = 1.0
    signed: bool = True


@dataclass(frozen=True, kw_only=True)
class ColumnMap:
    """A whole map, checked when read."""

    name: str
    source: str
    sheets: str
    stop: float
    zero_up_to: float
    columns: tuple[MappedColumn, ...]

    @property
    def command_unit(self) -> str:
        """Unit of the command."""
        return next(c.unit for c in self.columns if c.quantity == "command")


def read_column_map(path: Path) -> ColumnMap:
    """Return the map in a YAML file.

    Raises:
        ForceTableError: it cannot be read, or all that is wrong with it.
    """
    document = yaml_mapping(path, ForceTableError)
    problems = [f"key '{key}': missing" for key in _NEEDED if key not in document]
    problems += [f"key '{key}': unknown; known are {', '.join(_KEYS)}" for key in document if key not in _KEYS]
    for key in _TEXTS:
        if key in document and not _is_text(document[key]):
            problems.append(f"key '{key}': expected a text; found {document[key]!r}")
    sheets = document.get("sheets", ".*")
    _pattern("sheets", sheets, 0, problems)
    entries = {k: document[k] for k in ("command", "supply", *QUANTITIES) if k in document}
    columns = tuple(c for name, entry in entries.items() if (c := _column(name, entry, problems)) is not None)
    stop = _number(entries, "command", "stop", problems, default=None)
    zero = _number(entries, "force", "zero_up_to", problems, default=0.0)
    if zero < 0.0:
        problems.append(f"key 'force.zero_up_to': expected a number >= 0; found {zero:g}")
    if problems:
        raise ForceTableError(str(path), problems)
    texts = {key: str(document[key]) for key in _TEXTS}
    return ColumnMap(**texts, sheets=sheets, stop=stop, zero_up_to=zero, columns=columns)


def _column(name: str, entry: Any, problems: list[str]) -> MappedColumn | None:
    before = len(problems)
    places = ("column", "sheet") if name == "supply" else ("column",)
    known = [
        *places,
        "unit",
        "scale",
        *{"command": ["stop"], "force": ["zero_up_to"], "speed": ["signed"]}.get(name, []),
    ]
    if not isinstance(entry, Mapping):
        problems.append(f"key '{name}': expected {places[0]} and unit; found {entry!r}")
        return None
    problems += [f"key '{name}.{k}': unknown; known are {', '.join(known)}" for k in entry if k not in known]
    given = [place for place in places if place in entry]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        problems.append(f"key '{name}': expected {' or '.join(places)}; found {found}")
    for place in given:
        if not _is_text(entry[place]):
            problems.append(f"key '{name}.{place}': expected a text; found {entry[place]!r}")
    if "sheet" in given:
        _pattern(f"{name}.sheet", entry["sheet"], 1, problems)
    unit, expected = entry.get("unit"), {"supply": "V", **QUANTITIES}.get(name)
    if expected is not None and unit != expected:
        problems.append(f"key '{name}.unit': expected '{expected}', with a scale that brings there; found {unit!r}")
    elif not _is_text(unit):
        problems.append(f"key '{name}.unit': expected a unit; found {unit!r}")
    scale = _number({name: entry}, name, "scale", problems, default=1.0)
    if scale == 0.0:
        problems.append(f"key '{name}.scale': expected a number other than 0; found 0")
    if not isinstance(entry.get("signed", True), bool):
        problems.append(f"key '{name}.signed': expected true or false; found {entry['signed']!r}")
    if len(problems) > before:
        return None
    return MappedColumn(
        quantity=name,
        unit=str(unit),
        column=str(entry.get("column", "")).strip(),
        sheet=str(entry.get("sheet", "")),
        scale=scale,
        signed=bool(entry.get("signed", True)),
    )


def _number(entries: Mapping[str, Any], name: str, key: str, problems: list[str], *, default: float | None) -> float:
    """Return the number at name.key; where there is none, the default or (None) a problem."""
    entry = entries.get(name)
    if not isinstance(entry, Mapping):
        return 0.0
    value = entry.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        problems.append(f"key '{name}.{key}': expected a number; found {'none' if value is None else repr(value)}")
        return 1.0
    return float(value)


def _pattern(key: str, text: Any, groups: int, problems: list[str]) -> None:
    try:
        found = bounded(text).groups if isinstance(text, str) else None
    except ValueError as error:
        problems.append(f"key '{key}': expected a regular expression; found {text!r}: {error}")
        return
    if found is None or found < groups:
        what = "a regular expression" + (" with the voltage in brackets, such as '([0-9.]+) V'" if groups else "")
        problems.append(f"key '{key}': expected {what}; found {text!r}")


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())
