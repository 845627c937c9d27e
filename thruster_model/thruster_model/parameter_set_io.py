"""Parameter sets as YAML files, and the sets that come with the package.

model: hq
name: ...
source: ...
parameters:
  k_n: {value: 13.66, unit: 1/s, source: "Table 4.1", standard_deviation: 0.2}
command: {unit: µs, stop: 1500, per_volt: 80, lowest: 1100, highest: 1900}      optional: how commands are written
force_table: {name: ..., command: ..., supply: ..., force: ...}     where the model needs it, as in `force_table_io`
"""

import math
import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from thruster_model.command_scale import VOLTS, CommandScale
from thruster_model.effects.active import ActiveEffects, problems_of
from thruster_model.effects.stages import LIBRARY
from thruster_model.errors import ForceTableError, ParameterSetError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_io import force_table_document, force_table_of, load_yaml
from thruster_model.parameter_set import Parameter, ParameterSet

__all__ = ["available_sets", "dump_parameter_set", "load_parameter_set", "parse_parameter_set", "write_parameter_set"]

_TOP_KEYS = {"model", "name", "source", "parameters"}
_OPTIONAL_KEYS = {"effects", "command", "force_table"}
_COMMAND_KEYS = ("unit", "stop", "per_volt", "lowest", "highest")
_PARAMETER_KEYS = {"value", "unit", "source", "standard_deviation"}


def available_sets() -> tuple[str, ...]:
    """Return the names of the sets that come with the package."""
    folder = resources.files("thruster_model") / "parameter_sets"
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def load_parameter_set(name_or_path: str | Path) -> ParameterSet:
    """Return the set of that name in the package or, failing that, of that YAML file.

    Raises:
        ParameterSetError: neither a known name nor a readable file, or its content is wrong.
    """
    if str(name_or_path) in available_sets():
        text = (resources.files("thruster_model") / "parameter_sets" / f"{name_or_path}.yaml").read_text("utf-8")
        return parse_parameter_set(text, origin=f"{name_or_path}.yaml")
    path = Path(name_or_path)
    if not path.is_file():
        known = ", ".join(available_sets())
        raise ParameterSetError(str(path), [f"expected a YAML file or one of the known sets ({known}); found neither"])
    return parse_parameter_set(path.read_text("utf-8"), origin=str(path))


def parse_parameter_set(text: str, *, origin: str) -> ParameterSet:
    """Return the parameter set that a YAML text describes; `origin` names it in errors."""
    try:
        document = load_yaml(text)
    except yaml.YAMLError as error:
        raise ParameterSetError(origin, [f"expected YAML; found {' '.join(str(error).split())}"]) from error
    if not isinstance(document, Mapping):
        raise ParameterSetError(origin, [f"expected a mapping at the top; found {type(document).__name__}"])
    problems = [f"key '{key}': missing" for key in sorted(_TOP_KEYS - set(document))]
    problems += [
        f"key '{key}': unknown; known are {', '.join(sorted(_TOP_KEYS | _OPTIONAL_KEYS))}"
        for key in set(document) - _TOP_KEYS - _OPTIONAL_KEYS
    ]
    entries = document.get("parameters")
    if "parameters" in document and not isinstance(entries, Mapping):
        problems.append(f"key 'parameters': expected a mapping; found {type(entries).__name__}")
    parameters = {}
    for name, entry in entries.items() if isinstance(entries, Mapping) else ():
        parameter, wrong = _parse_parameter(str(name), entry)
        problems += wrong
        if parameter is not None:
            parameters[str(name)] = parameter
    sizes, wrong = _parse_effects(document.get("effects", {}))
    problems += wrong
    command = _parse_command(document.get("command"), problems)
    table = _parse_table(document.get("force_table"), problems)
    if problems:
        raise ParameterSetError(origin, problems)
    return ParameterSet(
        name=str(document["name"]),
        model_name=str(document["model"]),
        source=str(document["source"]),
        parameters=parameters,
        origin=origin,
        effects=ActiveEffects(sizes=sizes),
        command=command,
        force_table=table,
    )


def _parse_command(entry: Any, problems: list[str]) -> CommandScale:
    if entry is None:
        return VOLTS
    if not isinstance(entry, Mapping) or not set(entry) >= set(_COMMAND_KEYS[:3]) or set(entry) - set(_COMMAND_KEYS):
        found = ", ".join(map(str, entry)) if isinstance(entry, Mapping) else repr(entry)
        expected = "unit, stop and per_volt, lowest and highest if there are any"
        problems.append(f"key 'command': expected {expected}; found {found}")
        return VOLTS
    numbers = {k: _number(v) for k, v in entry.items() if k != "unit"}
    wrong = [f"key 'command.{k}': expected a number; found {entry[k]!r}" for k, v in numbers.items() if v is None]
    if not wrong:
        try:
            return CommandScale(unit=str(entry["unit"]), **{k: v for k, v in numbers.items() if v is not None})
        except ValueError as error:
            wrong = [f"key 'command': {problem}" for problem in str(error).split("\n")]
    problems += wrong
    return VOLTS


def _parse_table(entry: Any, problems: list[str]) -> ForceTable | None:
    if entry is None:
        return None
    if not isinstance(entry, Mapping):
        problems.append(f"key 'force_table': expected a mapping; found {type(entry).__name__}")
        return None
    try:
        return force_table_of(entry, origin="force_table")
    except ForceTableError as error:
        problems += [f"key 'force_table': {problem}" for problem in error.problems]
        return None


def _parse_parameter(name: str, entry: Any) -> tuple[Parameter | None, list[str]]:
    key = f"key 'parameters.{name}"
    if not isinstance(entry, Mapping):
        return None, [f"{key}': expected value, unit and source; found {entry!r}"]
    problems = [f"{key}.{k}': missing" for k in ("value", "unit", "source") if k not in entry]
    problems += [
        f"{key}.{k}': unknown; known are {', '.join(sorted(_PARAMETER_KEYS))}" for k in set(entry) - _PARAMETER_KEYS
    ]
    numbers = {}
    for field in ("value", "standard_deviation"):
        if entry.get(field) is not None:
            number = _number(entry[field])
            if number is None:
                problems.append(f"{key}.{field}': expected a number; found {entry[field]!r}")
            else:
                numbers[field] = number
    if problems:
        return None, problems
    return (
        Parameter(
            value=numbers["value"],
            unit=str(entry["unit"]),
            source=str(entry["source"]),
            standard_deviation=numbers.get("standard_deviation"),
        ),
        [],
    )


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
            value = _number(entry.get("value")) if isinstance(entry, Mapping) else None
            if value is None:
                problems.append(f"key 'effects.{effect}.{name}': expected value and unit; found {entry!r}")
                continue
            sizes[str(effect)][str(name)] = value
            if name in units and entry.get("unit") != units[name]:
                found = f"found {entry.get('unit')!r}"
                problems.append(f"key 'effects.{effect}.{name}.unit': expected '{units[name]}'; {found}")
    return sizes, problems + problems_of(sizes)


def _number(value: Any) -> float | None:
    """Return a float; YAML 1.1 reads 1e-3 as text, which is accepted here."""
    try:
        return None if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        return None


def dump_parameter_set(parameter_set: ParameterSet) -> str:
    """Return the set as YAML text that `parse_parameter_set` reads back to the same numbers."""
    parameters = {}
    for name, p in parameter_set.parameters.items():
        entry: dict[str, Any] = {"value": p.value, "unit": p.unit, "source": p.source}
        if p.standard_deviation is not None:
            entry["standard_deviation"] = p.standard_deviation
        parameters[name] = entry
    document: dict[str, Any] = {
        "model": parameter_set.model_name,
        "name": parameter_set.name,
        "source": parameter_set.source,
        "parameters": parameters,
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
    if path.exists():
        raise FileExistsError(f"{path}: exists and is not overwritten")
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.write_text(dump_parameter_set(parameter_set), "utf-8")
    temporary.rename(path)
