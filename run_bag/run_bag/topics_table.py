"""The one table of topics, message types and units: `topics.yaml`, read once."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from importlib import resources
from typing import Any, NamedTuple

from safe_files.yaml_io import parse_yaml

FILE = "topics.yaml"


class KnownTopic(NamedTuple):
    """A topic: its name with <i> for a thruster's number, its type, what is on it, units of its own."""

    name: str
    type: str
    content: str
    units: Mapping[str, str]


class KnownChannel(NamedTuple):
    """A channel of a map that programs read: its name with <i>, its parts where it is a vector, what it is."""

    name: str
    parts: tuple[str, ...]
    what: str


@lru_cache(maxsize=1)
def _document() -> Mapping[str, Any]:
    text = (resources.files("run_bag") / FILE).read_text("utf-8")
    document: Mapping[str, Any] = parse_yaml(text, FILE)
    return document


@lru_cache(maxsize=1)
def topics() -> tuple[KnownTopic, ...]:
    """Return all topics in the order of the table."""
    entries = _document()["topics"].items()
    return tuple(KnownTopic(name, _full(e["type"]), e["content"], e.get("units", {})) for name, e in entries)


@lru_cache(maxsize=1)
def channels() -> tuple[KnownChannel, ...]:
    """Return the channels of a map that programs read, in the order of the table."""
    entries = _document()["channels"].items()
    return tuple(KnownChannel(name, tuple(e.get("parts", ())), e["what"]) for name, e in entries)


@lru_cache(maxsize=1)
def units() -> dict[str, dict[str, str]]:
    """Return the unit of every field by message type; an element of a covariance is "covariance[4]"."""
    types = _document()["types"]
    return {_full(name): _flat(types, name) for name in types}


def _full(name: str) -> str:
    package, message = name.split("/")
    return f"{package}/msg/{message}"


def _flat(types: Mapping[str, Any], name: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for path, unit in types[name].items():
        if isinstance(unit, list):
            size = len(unit)
            for i, row in enumerate(unit):
                for j, column in enumerate(unit):
                    found[f"{path}[{size * i + j}]"] = _product(*(row, column) if i <= j else (column, row))
        elif unit in types:
            found |= {f"{path}.{inner}": own for inner, own in _flat(types, unit).items()}
        else:
            found[path] = unit
    return found


def _product(first: str, second: str) -> str:
    """Return the unit of a product: m/s and rad/s make m rad/s^2."""
    (one, _, per), (other, _, by) = first.partition("/"), second.partition("/")
    above = f"{one}^2" if one == other else f"{one} {other}"
    below = [b for b in (per, by) if b]
    if len(below) == 2 and per == by:
        return f"{above}/{per}^2"
    return "/".join([above, *below])
