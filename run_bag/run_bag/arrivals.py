"""Lockstep: which of the named topics have delivered an instant, and which are missing."""

from __future__ import annotations

from collections.abc import Iterable


class Arrivals:
    """The latest stamp [ns] that each of some topics has delivered."""

    def __init__(self, topics: Iterable[str]) -> None:
        self._latest: dict[str, int] = dict.fromkeys(topics, -1)

    def __contains__(self, topic: str) -> bool:
        return topic in self._latest

    def arrived(self, topic: str, stamp: int) -> bool:
        """Take a message's stamp [ns].

        Returns:
            Whether the instant up to which all topics have delivered moved on by it.
        """
        before = self.complete
        self._latest[topic] = max(stamp, self._latest[topic])
        return self.complete > before

    @property
    def complete(self) -> int:
        """Stamp [ns] up to which every topic has delivered; -1 while one of them is silent."""
        return min(self._latest.values(), default=-1)

    def missing(self, stamp: int, among: Iterable[str] | None = None) -> tuple[str, ...]:
        """Return the topics (None: all) that have not delivered this instant [ns]."""
        asked = self._latest if among is None else among
        return tuple(topic for topic in asked if self._latest[topic] < stamp)
