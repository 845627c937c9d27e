"""The nodes of a graph as files and lines: for shell scripts, for launch files, for one process.

In the folder: NAME.yaml for each node as `--params-file` takes it. A line is NAME PACKAGE EXECUTABLE [OLD:=NEW ...].
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml

from rov_sim.vehicle.graph import GraphNode

__all__ = ["line_of", "write_document", "write_parameters"]


def write_parameters(folder: Path, nodes: Iterable[GraphNode]) -> None:
    """Write each node's parameters into the folder, which exists."""
    for node in nodes:
        write_document(folder / f"{node.name}.yaml", {node.name: {"ros__parameters": dict(node.parameters)}})


def write_document(path: Path, document: Any) -> None:
    """Write one YAML file."""
    path.write_text(yaml.safe_dump(document, sort_keys=False), "utf-8")


def line_of(node: GraphNode) -> str:
    """Return the line of a node."""
    renamed = [f"{old}:={new}" for old, new in node.renamed.items()]
    return " ".join([node.name, node.package, node.executable, *renamed])
