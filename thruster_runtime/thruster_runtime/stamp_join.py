"""Join messages of several topics by their stamp: integer nanoseconds, equal or not at all.

Lockstep in one rule: what is stamped t is computed once everything stamped t has arrived. Nothing here waits or
looks at a clock. What never comes is given up when a later stamp is complete, or when too many wait, and is counted;
so is what comes after its stamp was given up or done. Publishers keep their order, so a stamp that lies before the
former one of the same name is a source that started again: all that waits is dropped and the join begins anew.
"""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

__all__ = ["StampJoin", "nanoseconds"]


def nanoseconds(stamp: Any) -> int:
    """Return a builtin_interfaces/Time as integer nanoseconds."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


class StampJoin:
    """Collects one message of each name per stamp, in bounded memory."""

    def __init__(self, names: Iterable[str], *, depth: int = 10) -> None:
        """Join messages of `names`; at most `depth` stamps wait at a time.

        Raises:
            ValueError: no name, one twice, or a depth below 1.
        """
        self.names = tuple(names)
        if not self.names or len(set(self.names)) != len(self.names) or depth < 1:
            raise ValueError(f"expected different names and a depth of 1 or more; found {self.names} and {depth}")
        self.depth = depth
        self.restarts = 0
        """How often a source started again."""
        self._missing = dict.fromkeys(self.names, 0)
        self._late = dict.fromkeys(self.names, 0)
        self._begin()

    def _begin(self) -> None:
        self._waiting: dict[int, dict[str, Any]] = {}
        self._newest: dict[str, int] = {}
        self.done: int | None = None

    @property
    def missing(self) -> Mapping[str, int]:
        """How many stamps were given up without a message of each name."""
        return MappingProxyType(self._missing)

    @property
    def late(self) -> Mapping[str, int]:
        """How many messages of each name came after their stamp was complete or given up."""
        return MappingProxyType(self._late)

    @property
    def waiting(self) -> Mapping[int, tuple[str, ...]]:
        """The stamps that wait [ns], in their order, with the names that each still lacks."""
        return {stamp: self._lacking(stamp) for stamp in sorted(self._waiting)}

    def put(self, name: str, stamp_ns: int, message: Any) -> dict[str, Any] | None:
        """Take a message; return all messages of its stamp by name once they are complete, else None.

        A second message of a name with the same stamp takes the place of the first while it waits.

        Raises:
            KeyError: a name that is not joined.
        """
        if name not in self._late:
            raise KeyError(f"expected one of {', '.join(self.names)}; found {name!r}")
        if stamp_ns < self._newest.get(name, stamp_ns):
            self.restarts += 1
            self._begin()
        self._newest[name] = stamp_ns
        if self.done is not None and stamp_ns <= self.done:
            self._late[name] += 1
            return None
        found = self._waiting.setdefault(stamp_ns, {})
        found[name] = message
        if len(found) == len(self.names):
            return self.take(stamp_ns)
        while len(self._waiting) > self.depth:
            self.take(min(self._waiting))
        return None

    def take(self, stamp_ns: int) -> dict[str, Any]:
        """Stop waiting for a stamp and all before it; return what has arrived of that stamp, by name."""
        for earlier in [stamp for stamp in self._waiting if stamp <= stamp_ns]:
            for name in self._lacking(earlier):
                self._missing[name] += 1
            found = self._waiting.pop(earlier)
            if earlier == stamp_ns:
                self.done = stamp_ns
                return {name: found[name] for name in self.names if name in found}
        self.done = stamp_ns if self.done is None else max(self.done, stamp_ns)
        return {}

    def _lacking(self, stamp: int) -> tuple[str, ...]:
        return tuple(name for name in self.names if name not in self._waiting[stamp])
