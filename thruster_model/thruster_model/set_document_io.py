"""What YAML files of parameter sets and of vehicle sets have in common: where they are found, their parameters.

Problems are sentences that name the key, what was expected and what was found; they are collected, not raised.
"""

from collections.abc import Collection, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from safe_files.yaml_io import yaml_mapping
from thruster_model.parameter_set import Parameter, ParameterSet

__all__ = [
    "inherited",
    "mapping_of",
    "number",
    "parameter_entries",
    "parameters_of",
    "shipped",
    "text_of",
    "unknown_keys",
    "wrong_beside_size",
]

_PARAMETER_KEYS = {"value", "unit", "source", "standard_deviation"}


def shipped(folder: str) -> tuple[str, ...]:
    """Return the names of the YAML files in a folder of the package."""
    files = (resources.files("thruster_model") / folder).iterdir()
    return tuple(sorted(f.name.removesuffix(".yaml") for f in files if f.name.endswith(".yaml")))


def text_of(name_or_path: str | Path, folder: str, known: str, error: Any) -> tuple[str, str]:
    """Return (text, origin) of the file of that name in a folder of the package or, failing that, of that YAML file.

    `known`: what the names in the folder are called; `error`: raised as error(origin, problems) where there is neither.
    """
    names = shipped(folder)
    if str(name_or_path) in names:
        file = f"{name_or_path}.yaml"
        return (resources.files("thruster_model") / folder / file).read_text("utf-8"), file
    path = Path(name_or_path)
    if not path.is_file():
        found = f"expected a YAML file or one of the known {known} ({', '.join(names)}); found neither"
        raise error(str(path), [found])
    try:
        return path.read_text("utf-8"), str(path)
    except (OSError, UnicodeDecodeError) as wrong:
        raise error(str(path), [f"expected a YAML file in UTF-8; cannot be read: {wrong}"]) from wrong


def mapping_of(text: str, origin: str, error: Any) -> Mapping[str, Any]:
    """Return the mapping at the top of a YAML text; error(origin, problems) is raised where there is none."""
    return yaml_mapping(text, error, origin)


def unknown_keys(prefix: str, entry: Mapping[str, Any], known: Collection[str]) -> list[str]:
    """Return a sentence for each key that is not known."""
    return [f"key '{prefix}{key}': unknown; known are {', '.join(sorted(known))}" for key in entry if key not in known]


def wrong_beside_size(key: str, entry: Mapping[str, Any]) -> list[str]:
    """Return a sentence for each key of a known effect's size that is none; such a size is exact."""
    if "standard_deviation" in entry:
        return [
            f"key '{key}.standard_deviation': a known effect is exact; leave this out, or leave the effect out, and a "
            "diagnosis finds its size"
        ]
    return unknown_keys(f"{key}.", entry, ("value", "unit", "source"))


def number(value: Any) -> float | None:
    """Return a float, None where there is no number (a quoted one is text)."""
    return None if isinstance(value, bool) or not isinstance(value, int | float) else float(value)


def parameters_of(entries: Any, problems: list[str]) -> dict[str, Parameter]:
    """Return the parameters in a mapping of entries with value, unit, source and perhaps standard_deviation."""
    if not isinstance(entries, Mapping):
        problems.append(f"key 'parameters': expected a mapping; found {type(entries).__name__}")
        return {}
    found = {}
    for name, entry in entries.items():
        key = f"parameters.{name}"
        if not isinstance(entry, Mapping):
            problems.append(f"key '{key}': expected value, unit and source; found {entry!r}")
            continue
        wrong = [f"key '{key}.{k}': missing" for k in ("value", "unit", "source") if k not in entry]
        wrong += unknown_keys(f"{key}.", entry, _PARAMETER_KEYS)
        numbers = {k: number(entry[k]) for k in ("value", "standard_deviation") if entry.get(k) is not None}
        wrong += [f"key '{key}.{k}': expected a number; found {entry[k]!r}" for k, n in numbers.items() if n is None]
        if "value" in entry and entry["value"] is None:
            wrong.append(f"key '{key}.value': expected a number; found None")
        problems += wrong
        value = numbers.get("value")
        if not wrong and value is not None:
            found[str(name)] = Parameter(
                value=value,
                unit=str(entry["unit"]),
                source=str(entry["source"]),
                standard_deviation=numbers.get("standard_deviation"),
            )
    return found


def inherited(entries: Any, base: ParameterSet, source: str, problems: list[str]) -> dict[str, Parameter]:
    """Return the parameters of a base with those that `entries` change: a number, or some of a parameter's keys.

    A new value has the source that is stated with it, else the set's `source`; its standard deviation is not the
    base's.
    """
    if not isinstance(entries, Mapping | None):
        problems.append(f"key 'parameters': expected a mapping; found {type(entries).__name__}")
        return {}
    stated, changed = parameter_entries(base.parameters), {}
    for name, entry in (entries or {}).items():
        if name not in stated:
            has = ", ".join(sorted(stated))
            problems.append(f"key 'parameters.{name}': model '{base.model_name}' has none such; it has {has}")
        elif isinstance(entry, Mapping) or number(entry) is not None:
            own = dict(entry) if isinstance(entry, Mapping) else {"value": entry}
            before = {k: v for k, v in stated[name].items() if "value" not in own or k in ("value", "unit")}
            before.setdefault("source", source or f"changed from {base.name}")
            changed[str(name)] = {**before, **own}
        else:
            problems.append(
                f"key 'parameters.{name}': expected a number, or value and what goes with it; found {entry!r}"
            )
    return {**base.parameters, **parameters_of(changed, problems)}


def parameter_entries(parameters: Mapping[str, Parameter]) -> dict[str, dict[str, Any]]:
    """Return entries that `parameters_of` reads back to the same numbers."""
    entries = {}
    for name, p in parameters.items():
        entry: dict[str, Any] = {"value": p.value, "unit": p.unit, "source": p.source}
        if p.standard_deviation is not None:
            entry["standard_deviation"] = p.standard_deviation
        entries[name] = entry
    return entries
