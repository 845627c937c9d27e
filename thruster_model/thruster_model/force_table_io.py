"""A table of forces as a YAML file: every row of numbers with its unit, and where they come from.

name: ...
source: ...
command: {unit: µs, stop: 1500.0, value: [1100.0, ...]}
supply: {unit: V, value: [10.0, ...]}
force: {unit: N, value: [[...], ...]}        one row per supply voltage; speed, current and power likewise
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from run_bag.unit_spelling import same_unit
from safe_files.whole_files_io import write_whole
from safe_files.yaml_io import yaml_mapping
from thruster_model.errors import ForceTableError
from thruster_model.force_table import QUANTITIES, ForceTable

__all__ = [
    "dump_force_table",
    "force_table_document",
    "force_table_of",
    "load_force_table",
    "parse_force_table",
    "write_force_table",
]

_NEEDED = ("name", "source", "command", "supply", "force")
_KEYS = (*_NEEDED, *(name for name in QUANTITIES if name != "force"))


def load_force_table(path: Path) -> ForceTable:
    """Return the table in a YAML file of ours.

    Raises:
        ForceTableError: it cannot be read, or all that is wrong with it.
    """
    return force_table_of(yaml_mapping(path, ForceTableError), origin=str(path))


def parse_force_table(text: str, *, origin: str) -> ForceTable:
    """Return the table that a YAML text describes; `origin` names it in errors."""
    return force_table_of(yaml_mapping(text, ForceTableError, origin), origin=origin)


def force_table_of(document: Mapping[Any, Any], *, origin: str) -> ForceTable:
    """Return the table that a YAML mapping describes; `origin` names it in errors."""
    problems = [f"key '{key}': missing" for key in _NEEDED if key not in document]
    problems += [f"key '{key}': unknown; known are {', '.join(_KEYS)}" for key in document if key not in _KEYS]
    values: dict[str, Any] = {}
    for name in (k for k in _KEYS[2:] if k in document):
        entry = document[name]
        keys = {"unit", "value", "stop"} if name == "command" else {"unit", "value"}
        if not isinstance(entry, Mapping) or set(entry) != keys:
            found = ", ".join(map(str, entry)) if isinstance(entry, Mapping) else type(entry).__name__
            problems.append(f"key '{name}': expected {', '.join(sorted(keys))}; found {found}")
            continue
        unit = {"supply": "V", **QUANTITIES}.get(name)
        if unit is not None and not same_unit(str(entry["unit"]), unit):
            problems.append(f"key '{name}.unit': expected '{unit}'; found {entry['unit']!r}")
        values[name] = entry["value"]
    stop = document["command"].get("stop") if isinstance(document.get("command"), Mapping) else None
    if "command" in values and (isinstance(stop, bool) or not isinstance(stop, int | float)):
        problems.append(f"key 'command.stop': expected a number; found {stop!r}")
    if problems:
        raise ForceTableError(origin, problems)
    return ForceTable(
        **values,
        command_unit=str(document["command"]["unit"]),
        stop=float(stop),  # type: ignore[arg-type]
        name=str(document["name"]),
        source=str(document["source"]),
        origin=origin,
    )


def dump_force_table(table: ForceTable) -> str:
    """Return the table as YAML text that `parse_force_table` reads back to the same numbers."""
    document = force_table_document(table)
    return yaml.safe_dump(document, sort_keys=False, width=120, allow_unicode=True, default_flow_style=None)


def force_table_document(table: ForceTable) -> dict[str, Any]:
    """Return the table as a YAML mapping."""
    document: dict[str, Any] = {
        "name": table.name,
        "source": table.source,
        "command": {"unit": table.command_unit, "stop": float(table.stop), "value": table.command.tolist()},
        "supply": {"unit": "V", "value": table.supply.tolist()},
    }
    for name in table.quantities:
        document[name] = {"unit": QUANTITIES[name], "value": getattr(table, name).tolist()}
    return document


def write_force_table(table: ForceTable, path: Path) -> None:
    """Write the table to a new file; FileExistsError where there is one."""
    write_whole(path, dump_force_table(table))
