"""Parameter sets as YAML files, and the sets that come with the package.

model: hq
name: ...
source: ...
parameters:
  k_n: {value: 13.66, unit: 1/s, source: "Table 4.1", standard_deviation: 0.2}
command: {unit: µs, stop: 1500, per_volt: 80, lowest: 1100, highest: 1900}      optional: how commands are written
force_table: {command: ..., supply: ..., force: ...}     where the model needs it, as in `force_table_io`; name and
                                                         source are the set's where it states none of its own

Or what differs from another set, known by its name or its file (from the folder of this one):

base: hl
parameters:
  k_n: 12.0                                    in the base's unit; or value, unit, source, standard_deviation as above
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from run_bag.unit_spelling import same_unit
from safe_files.whole_files_io import write_whole
from thruster_model.command_scale import VOLTS, CommandScale
from thruster_model.effects.active import ActiveEffects, problems_of
from thruster_model.effects.stages import LIBRARY
from thruster_model.errors import ForceTableError, ParameterSetError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_io import force_table_document, force_table_of
from thruster_model.parameter_set import ParameterSet
from thruster_model.set_document_io import (
    inherited,
    mapping_of,
    number,
    parameter_entries,
    parameters_of,
    shipped,
    text_of,
    unknown_keys,
    wrong_beside_size,
)

__all__ = [
    "available_sets",
    "dump_parameter_set",
    "load_parameter_set",
    "parse_parameter_set",
    "write_parameter_set",
    "write_set_text",
]

_TOP_KEYS = {"model", "name", "source", "parameters"}
_OPTIONAL_KEYS = {"base", "effects", "command", "force_table"}
_COMMAND_KEYS = ("unit", "stop", "per_volt", "lowest", "highest")
_FOLDER = "parameter_sets"


def available_sets() -> tuple[str, ...]:
    """Return the names of the sets that come with the package."""
    return shipped(_FOLDER)


def load_parameter_set(name_or_path: str | Path) -> ParameterSet:
    """Return the set of that name in the package or, failing that, of that YAML file; a set on a base, complete.

    Raises:
        ParameterSetError: neither a known name nor a readable file, or its content, or its base's, is wrong.
    """
    text, origin = text_of(name_or_path, _FOLDER, "sets", ParameterSetError)
    return parse_parameter_set(text, origin=origin)


def parse_parameter_set(text: str, *, origin: str, above: Sequence[Path] = ()) -> ParameterSet:
    """Return the parameter set that a YAML text describes.

    Args:
        text: in the form above.
        origin: names it in errors; where it is a path, files of bases are looked for beside it.
        above: files of the sets that stand on this one, from the first asked for on.

    Raises:
        ParameterSetError: its content, or its base's, is wrong; sets stand on each other in a circle.
    """
    document = mapping_of(text, origin, ParameterSetError)
    problems = unknown_keys("", document, _TOP_KEYS | _OPTIONAL_KEYS)
    base = None
    if "base" in document:
        base = _base(document["base"], origin, (*above, Path(origin).resolve()))
        parameters = inherited(document.get("parameters"), base, str(document.get("source", "")), problems)
        if document.get("model", base.model_name) != base.model_name:
            problems.append(f"key 'model': expected '{base.model_name}', its base's; found {document['model']!r}")
    else:
        problems += [f"key '{key}': missing" for key in sorted(_TOP_KEYS - set(document))]
        parameters = parameters_of(document.get("parameters", {}), problems)
    sizes, wrong = _parse_effects(document.get("effects", {}))
    problems += wrong
    command = _parse_command(document.get("command"), problems)
    table = _parse_table(document, origin, problems)
    if problems:
        raise ParameterSetError(origin, problems)
    given: dict[str, Any] = {
        "name": str(document.get("name")),
        "model_name": str(document.get("model")),
        "source": str(document.get("source")),
        "effects": ActiveEffects(sizes=sizes),
        "command": command,
        "force_table": table,
    }
    if base is None:
        return ParameterSet(parameters=parameters, origin=origin, **given)
    changed = {key: value for key, value in given.items() if key in document}
    words = {"name": f"{base.name}, changed", "source": f"{document['base']}, changed: {base.source}"}
    return replace(base, parameters=parameters, origin=origin, **{**words, **changed})


def _base(name: Any, origin: str, above: Sequence[Path]) -> ParameterSet:
    """Return the set that another one, called `origin`, stands on; `above`: their files, that one's last."""
    known = available_sets()
    if not isinstance(name, str) or not name:
        raise ParameterSetError(origin, [f"key 'base': expected the name or the file of a set; found {name!r}"])
    path = Path(name) if name in known else (Path(origin).parent / name)
    if name not in known and path.resolve() in above:
        circle = " -> ".join(file.name for file in (*above[above.index(path.resolve()) :], path))
        raise ParameterSetError(
            origin, [f"key 'base': expected a set that stands on no other in a circle; found {circle}"]
        )
    if name not in known and not path.is_file():
        expected = f"expected one of the known sets ({', '.join(known)}) or a YAML file"
        raise ParameterSetError(origin, [f"key 'base': {expected}; found {name!r}, and no file {path}"])
    text, base_origin = text_of(path, _FOLDER, "sets", ParameterSetError)
    return parse_parameter_set(text, origin=base_origin, above=above)


def _parse_command(entry: Any, problems: list[str]) -> CommandScale:
    if entry is None:
        return VOLTS
    if not isinstance(entry, Mapping) or not set(entry) >= set(_COMMAND_KEYS[:3]) or set(entry) - set(_COMMAND_KEYS):
        found = ", ".join(map(str, entry)) if isinstance(entry, Mapping) else repr(entry)
        expected = "unit, stop and per_volt, lowest and highest if there are any"
        problems.append(f"key 'command': expected {expected}; found {found}")
        return VOLTS
    numbers = {k: number(v) for k, v in entry.items() if k != "unit"}
    wrong = [f"key 'command.{k}': expected a number; found {entry[k]!r}" for k, v in numbers.items() if v is None]
    if not wrong:
        try:
            return CommandScale(unit=str(entry["unit"]), **{k: v for k, v in numbers.items() if v is not None})
        except ValueError as error:
            wrong = [f"key 'command': {problem}" for problem in str(error).split("\n")]
    problems += wrong
    return VOLTS


def _parse_table(document: Mapping[str, Any], origin: str, problems: list[str]) -> ForceTable | None:
    """Return the set's table; without a name or a source of its own it has the set's."""
    entry = document.get("force_table")
    if entry is None:
        return None
    if not isinstance(entry, Mapping):
        problems.append(f"key 'force_table': expected a mapping; found {type(entry).__name__}")
        return None
    try:
        of_set = {key: document.get(key) or Path(origin).stem for key in ("name", "source")}
        return force_table_of({**of_set, **entry}, origin="force_table")
    except ForceTableError as error:
        problems += [f"key 'force_table': {problem}" for problem in error.problems]
        return None


def _parse_effects(entries: Any) -> tuple[dict[str, dict[str, float]], list[str]]:
    """Return the sizes of effects and what is wrong with them."""
    if not isinstance(entries, Mapping):
        return {}, [f"key 'effects': expected a mapping; found {type(entries).__name__}"]
    sizes: dict[str, dict[str, float]] = {}
    problems = []
    for effect, parameters in entries.items():
        if not isinstance(parameters, Mapping):
            problems.append(f"key 'effects.{effect}': expected its parameters; found {parameters!r}")
            continue
        sizes[str(effect)] = {}
        units = {p.name: p.unit for p in LIBRARY[effect].parameters} if effect in LIBRARY else {}
        for name, entry in parameters.items():
            value = number(entry.get("value")) if isinstance(entry, Mapping) else None
            if value is None:
                example = f"{{value: 0.0, unit: {units[name]}}}" if name in units else "value and unit"
                problems.append(f"key 'effects.{effect}.{name}': expected {example}; found {entry!r}")
                continue
            sizes[str(effect)][str(name)] = value
            problems += wrong_beside_size(f"effects.{effect}.{name}", entry)
            if name in units and not same_unit(str(entry.get("unit")), units[name]):
                found = f"found {entry.get('unit')!r}"
                problems.append(f"key 'effects.{effect}.{name}.unit': expected '{units[name]}'; {found}")
    return sizes, problems + problems_of(sizes)


def dump_parameter_set(parameter_set: ParameterSet) -> str:
    """Return the set as YAML text that `parse_parameter_set` reads back to the same numbers."""
    document: dict[str, Any] = {
        "model": parameter_set.model_name,
        "name": parameter_set.name,
        "source": parameter_set.source,
        "parameters": parameter_entries(parameter_set.parameters),
    }
    if parameter_set.effects.sizes:
        document["effects"] = {
            effect: {
                p.name: {"value": sizes[p.name], "unit": p.unit} for p in LIBRARY[effect].parameters if p.name in sizes
            }
            for effect, sizes in parameter_set.effects.sizes.items()
        }
    if parameter_set.command != VOLTS:
        command = {k: getattr(parameter_set.command, k) for k in _COMMAND_KEYS}
        document["command"] = {k: v for k, v in command.items() if isinstance(v, str) or math.isfinite(v)}
    text = yaml.safe_dump(document, sort_keys=False, width=1000, allow_unicode=True)
    if parameter_set.force_table is not None:
        rows = {"force_table": force_table_document(parameter_set.force_table)}
        text += yaml.safe_dump(rows, sort_keys=False, width=120, allow_unicode=True, default_flow_style=None)
    return text


def write_parameter_set(parameter_set: ParameterSet, path: Path) -> None:
    """Write the set to a new file; FileExistsError where there is one."""
    write_set_text(dump_parameter_set(parameter_set), path)


def write_set_text(text: str, path: Path) -> None:
    """Write a set's YAML text to a new file, whole or not at all; FileExistsError where there is one."""
    write_whole(path, text)
