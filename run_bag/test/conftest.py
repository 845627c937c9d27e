"""What the tests of nodes share."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from recording_graph import Graph


@pytest.fixture
def graph() -> Iterator[Graph]:
    """A graph of its own."""
    graph = Graph()
    yield graph
    graph.close()
