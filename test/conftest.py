"""What tests that cross packages share: contexts and graphs of their own, and this folder's modules."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.context import Context

sys.path.insert(0, str(Path(__file__).parent))

from graph_context import a_context


@pytest.fixture
def fresh_context() -> Iterator[Callable[[], Context]]:
    """Make graphs of their own."""
    made: list[Context] = []

    def fresh() -> Context:
        made.append(a_context())
        return made[-1]

    yield fresh
    for context in made:
        rclpy.try_shutdown(context=context)


@pytest.fixture
def make(fresh_context: Callable[[], Context], tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Make graphs of a whole vehicle (`vehicle_graph.Graph`)."""
    from vehicle_graph import SCRIPT, Graph  # only where it is needed: it imports all packages

    graphs: list[Graph] = []
    script = tmp_path / "script.yaml"
    script.write_text(SCRIPT, "utf-8")

    def made(**given: Any) -> Graph:
        graphs.append(Graph(fresh_context(), script, **given))
        return graphs[-1]

    yield made
    for graph in graphs:
        graph.close()
