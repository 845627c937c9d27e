"""Collect what belongs to each message of one topic, the trigger, without ever waiting for a time.

A node that turns every `state` into one `estimate` needs the flow of the same instant and the throttle that acted
until then. Both usually come, in any order; either may be lost, late, or slower than the state. So a trigger stamped
t waits for an input until one stamped t or later has come (`former`: stamped with the former trigger or later; `every`:
the newest that a slower one can have told by then), but no longer than until the next trigger, and not at all for an
input that has been silent for longer than its time-out. In lockstep that is a join by stamp; when something fails it
is an answer in time, and what failed is counted.

A trigger stamped before the former one is a source that started again: what is stamped later is dropped.
"""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import Any, NamedTuple

__all__ = ["Due", "Input", "TriggeredJoin", "held", "newest_within"]

History = tuple[tuple[int, Any], ...]
_stamp = itemgetter(0)


@dataclass(frozen=True, kw_only=True)
class Input:
    """How one input is waited for.

    Attributes:
        timeout: silence after which it is not waited for any more [ns].
        wait: whether it is waited for at all; else the newest there is.
        former: what acted until the trigger: enough is one stamped with the former trigger.
        every: of an input slower than the trigger: its period and its delay together [ns]; enough is one stamped later
            than that before the trigger. Its stamps and the trigger's count from the same start.
        first: of such an input: when the first one is due [ns]; 0: after `every`.
    """

    timeout: int
    wait: bool = True
    former: bool = False
    every: int = 0
    first: int = 0


class Due(NamedTuple):
    """A trigger with what has arrived for it.

    Attributes:
        stamp: of the trigger [ns].
        former: stamp of the trigger before it [ns], None for the first and after a restart.
        message: the trigger's.
        inputs: of each input the (stamp [ns], message) up to `stamp`, ascending: all after `former`, and the last one
            before that.
        lacking: inputs that were waited for and did not come.
    """

    stamp: int
    former: int | None
    message: Any
    inputs: Mapping[str, History]
    lacking: tuple[str, ...]


class TriggeredJoin:
    """Collects the inputs of each trigger, in bounded memory; at most one trigger waits."""

    def __init__(self, trigger: str, inputs: Mapping[str, Input], *, depth: int = 50) -> None:
        """Wait for `inputs` by name; of each at most `depth` messages are kept.

        Raises:
            ValueError: a trigger that is an input too, or a depth below 2.
        """
        if trigger in inputs or depth < 2:
            raise ValueError(f"expected a trigger of its own and a depth of 2 or more; found {trigger!r} and {depth}")
        self.trigger, self.inputs, self.depth = trigger, dict(inputs), depth
        self.restarts = 0
        """How often the trigger started again."""
        self._missing, self._late = dict.fromkeys(inputs, 0), dict.fromkeys([trigger, *inputs], 0)
        self._kept: dict[str, list[tuple[int, Any]]] = {name: [] for name in inputs}
        self._awaited = [(name, how, self._kept[name]) for name, how in self.inputs.items() if how.wait]
        self._given_up: dict[str, int] = {}
        self._begin()

    def _begin(self) -> None:
        self._pending: tuple[int, Any] | None = None
        self._first: int | None = None
        self._former: int | None = None
        self._given_up.clear()

    @property
    def missing(self) -> Mapping[str, int]:
        """How many triggers went without each input, though it was waited for."""
        return MappingProxyType(self._missing)

    @property
    def late(self) -> Mapping[str, int]:
        """How many messages came after they had been given up; of the trigger, how many repeated a stamp."""
        return MappingProxyType(self._late)

    @property
    def waiting(self) -> tuple[str, ...]:
        """The inputs that the pending trigger lacks."""
        return () if self._pending is None else self._lacking(self._pending[0])

    def put(self, name: str, stamp_ns: int, message: Any) -> tuple[Due, ...]:
        """Take a message; return the triggers that are due now, in order: none, one or two.

        Raises:
            KeyError: a name that is not joined.
        """
        due: tuple[Due, ...] = ()
        if name == self.trigger:
            newest = self._former if self._pending is None else self._pending[0]
            if newest is not None and stamp_ns == newest:
                self._late[name] += 1
                return ()
            if newest is not None and stamp_ns < newest:
                self._restart(stamp_ns)
            if self._pending is not None:
                due = (self._release(self._lacking(self._pending[0])),)
            self._pending = (stamp_ns, message)
            self._first = stamp_ns if self._first is None else self._first
        else:
            self._keep(name, stamp_ns, message)
        if self._pending is not None and not (lacking := self._lacking(self._pending[0])):
            due += (self._release(lacking),)
        return due

    def _restart(self, stamp_ns: int) -> None:
        self.restarts += 1
        self._begin()
        for kept in self._kept.values():
            kept[:] = [entry for entry in kept if entry[0] <= stamp_ns]

    def _keep(self, name: str, stamp_ns: int, message: Any) -> None:
        if name not in self.inputs:
            raise KeyError(f"expected one of {', '.join([self.trigger, *self.inputs])}; found {name!r}")
        kept = self._kept[name]
        if stamp_ns <= self._given_up.get(name, stamp_ns - 1):
            self._late[name] += 1
        if kept and stamp_ns < kept[-1][0]:
            kept.clear()  # this source started again
        kept.append((stamp_ns, message))
        del kept[: -self.depth]

    def _lacking(self, stamp: int) -> tuple[str, ...]:
        """Return the inputs that a trigger waits for: written for speed, as every message asks."""
        lacking: tuple[str, ...] = ()
        for name, how, kept in self._awaited:
            required = self._former if how.former else stamp - how.every
            if required is None or (kept and kept[-1][0] >= required + (how.every > 0)):
                continue
            if how.every and not kept and stamp < (how.first or how.every):
                continue  # the first one is not due yet
            last = kept[-1][0] if kept else self._first
            if last is None or required - last <= how.timeout:
                lacking += (name,)
        return lacking

    def _release(self, lacking: tuple[str, ...]) -> Due:
        assert self._pending is not None
        stamp, message = self._pending
        for name in lacking:
            self._missing[name] += 1
            how = self.inputs[name]
            self._given_up[name] = (self._former if how.former else stamp - how.every) or 0
        found = {name: self._upto(kept, stamp) for name, kept in self._kept.items()}
        due = Due(stamp, self._former, message, found, lacking)
        self._pending, self._former = None, stamp
        return due

    def _upto(self, kept: list[tuple[int, Any]], stamp: int) -> History:
        if self._former is not None:
            del kept[: max(bisect_right(kept, self._former, key=_stamp) - 1, 0)]
        return tuple(kept[: bisect_right(kept, stamp, key=_stamp)])


def newest_within(due: Due, name: str) -> Any | None:
    """Return the newest message after the former trigger, else None: what is measured once counts once."""
    history = due.inputs[name]
    found = bool(history) and (due.former is None or history[-1][0] > due.former)
    return history[-1][1] if found else None


def held(due: Due, name: str, timeout: int) -> Any | None:
    """Return the newest message, None where there is none younger than `timeout` [ns]: what is commanded is held."""
    history = due.inputs[name]
    return history[-1][1] if history and due.stamp - history[-1][0] <= timeout else None
