"""YAML in which a key that is given twice is an error, not the last one's victory."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import yaml


class _Loader(yaml.SafeLoader):
    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[tuple[str, str]] = set()
        for key, _ in node.value:
            name = (key.tag, str(key.value))
            if name in seen:
                found = f"line {key.start_mark.line + 1}: expected each key once, found {key.value!r} again"
                raise yaml.YAMLError(found)
            seen.add(name)
        return super().construct_mapping(node, deep)


def load(text: str) -> Any:
    """Return the content of a YAML text.

    Raises:
        yaml.YAMLError: no YAML, or a key given twice, with its line.
        ValueError: a date or number that is none.
    """
    return yaml.load(text, Loader=_Loader)
