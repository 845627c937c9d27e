"""Several nodes in one process:   compose FILE.yaml [--ros-args ...]

nodes:
  - class: thruster_estimation.observer_node:ObserverNode
    name: observer_0                             # of the node
    parameters: {thruster: 0, estimator: nlo}    # optional
hand_over: true                                  # optional

They share one executor, so that they need no lock. A message between them goes through the middleware as any other,
unless they hand it over: then each of them hears what another one publishes from that one alone, sooner.
"""

import argparse
import importlib
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.utilities import remove_ros_args

from safe_files.errors import YamlError
from safe_files.yaml_io import read_yaml
from thruster_runtime.errors import ThrusterRuntimeError
from thruster_runtime.node_main import REFUSED, run_nodes

__all__ = ["CompositionError", "builders", "main"]

_KEYS = {"class", "name", "parameters"}
_TOP_KEYS = {"nodes", "hand_over"}


class CompositionError(ThrusterRuntimeError):
    """A composition that cannot be started; `problems` holds one sentence for each thing that is wrong."""

    def __init__(self, source: str, problems: Sequence[str]) -> None:
        self.source, self.problems = source, tuple(problems)
        super().__init__("\n".join(f"{source}: {problem}" for problem in self.problems))


def builders(document: Any, source: str, *, context: Context | None = None) -> list[Callable[[], Node]]:
    """Return what makes each node of a composition, as `read_yaml` gives it.

    Args:
        document: mapping with the key `nodes`, perhaps `hand_over`.
        source: names it in errors.
        context: of the nodes, None: the default one.

    Raises:
        CompositionError: with all that is wrong.
    """
    entries = document.get("nodes") if isinstance(document, Mapping) else None
    if not isinstance(entries, list) or not entries:
        raise CompositionError(source, ["key 'nodes': expected a list of nodes; found none"])
    made: list[Callable[[], Node]] = []
    problems = [f"key '{key}': expected one of nodes, hand_over" for key in document if key not in _TOP_KEYS]
    if not isinstance(document.get("hand_over", False), bool):
        problems.append(f"key 'hand_over': expected true or false; found {document['hand_over']!r}")
    for index, entry in enumerate(entries):
        problem, node_class = _class_of(entry)
        if problem:
            problems.append(f"key 'nodes[{index}]': {problem}")
        elif node_class is not None:
            overrides = [Parameter(key, value=value) for key, value in entry.get("parameters", {}).items()]
            remapped = ["--ros-args", "-r", f"__node:={entry['name']}"]
            made.append(partial(node_class, context=context, cli_args=remapped, parameter_overrides=overrides))
    names = [entry["name"] for entry in entries if isinstance(entry, Mapping) and "name" in entry]
    problems += [f"name '{name}': given to {names.count(name)} nodes" for name in set(names) if names.count(name) > 1]
    if problems:
        raise CompositionError(source, problems)
    return made


def _class_of(entry: Any) -> tuple[str, Callable[..., Node] | None]:
    """Return (what is wrong, the class that an entry names)."""
    if not isinstance(entry, Mapping) or not {"class", "name"} <= set(entry) <= _KEYS:
        return f"expected the keys class, name and perhaps parameters; found {entry!r}", None
    if not isinstance(entry.get("parameters", {}), Mapping):
        return f"parameters: expected a mapping; found {entry['parameters']!r}", None
    module, _, name = str(entry["class"]).partition(":")
    try:
        found = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        return f"class: expected package.module:Class; found {entry['class']!r} ({error})", None
    if not (isinstance(found, type) and issubclass(found, Node)):
        return f"class: expected a node; found {entry['class']!r}", None
    return "", found


def main(arguments: Sequence[str] | None = None) -> int:
    """Start the nodes of a file and run them until they are told to stop."""
    given = sys.argv if arguments is None else ["compose", *arguments]
    parser = argparse.ArgumentParser(prog="compose", description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="YAML file with the nodes")
    file = parser.parse_args(remove_ros_args(given)[1:]).file
    try:
        document = read_yaml(file)
        made = builders(document, str(file))
    except (YamlError, CompositionError) as error:
        sys.stderr.write(f"{error}\n")
        return REFUSED
    return run_nodes(made, args=given[1:], handing_over=document.get("hand_over", False))


if __name__ == "__main__":
    sys.exit(main())
