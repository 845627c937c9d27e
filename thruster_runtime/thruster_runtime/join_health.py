"""The health of a node that joins messages: what it did, and how many messages were missing or late."""

from collections.abc import Mapping
from typing import Protocol

from rclpy.node import Node

from thruster_runtime.diagnostics import Diagnostics, Level

__all__ = ["JoinHealth"]

_REFRESH = 1_000_000_000  # ns


class _Counting(Protocol):
    restarts: int

    @property
    def missing(self): ...  # type: ignore[no-untyped-def]

    @property
    def late(self): ...  # type: ignore[no-untyped-def]


class JoinHealth:
    """Reports to /diagnostics at each change of level or words, and refreshes its counts once a second of stamps."""

    def __init__(self, node: Node, join: _Counting) -> None:
        """Report for `node` the counts of `join`."""
        self._diagnostics = Diagnostics(node)
        self._join = join
        self._told: tuple[Level, str] | None = None
        self._told_at = 0

    def report(self, stamp_ns: int, level: Level, message: str, more: Mapping[str, object] | None = None) -> None:
        """Say how the node is at a stamp [ns]; `more`: values besides the join's counts."""
        if (level, message) == self._told and 0 <= stamp_ns - self._told_at < _REFRESH:
            return
        self._told, self._told_at = (level, message), stamp_ns
        values: dict[str, object] = {"stamp [s]": stamp_ns / 1e9, "restarts": self._join.restarts}
        values |= {f"missing {name}": count for name, count in self._join.missing.items()}
        values |= {f"late {name}": count for name, count in self._join.late.items()}
        self._diagnostics.report(level, message, {**values, **(more or {})})
