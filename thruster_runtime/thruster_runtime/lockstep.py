"""Lockstep for the node that owns time: an instant passes when all participants have done their part of it.

A participant is a topic whose message stamped t says that somebody is done with the instant t. Time begins when all
wires are there and have been for a while: before that, a message could be lost to a node that is not connected yet.
Who keeps time waiting is named in words.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from thruster_runtime.records import RecordPublisher, format_of, listen

__all__ = ["Lockstep", "known_participants"]

_CLOCK = format_of(Clock)
_LONGEST_TURN = 0.05
"""[s] of the wall for which instants follow each other without giving way to other work of the process."""


def _nothing(_name: str, _record: Any) -> None:
    """What a node does with a participant's message that only needs to know its stamp."""


def _none() -> list[str]:
    return []


def known_participants(names: Sequence[str], types: Mapping[str, type]) -> tuple[dict[str, type], list[str]]:
    """Return the message type of each participant, and a sentence for each whose type is not known.

    Args:
        names: topics, repetitions count once.
        types: by the last part of a topic's name, or by the whole of it.
    """
    found, problems = {}, []
    for name in dict.fromkeys(names):
        kind = types.get(name) or types.get(name.rpartition("/")[2])
        if kind is None:
            problems.append(f"participants: expected topics that end in one of {', '.join(types)}; found {name!r}")
        else:
            found[name] = kind
    return found, problems


class Lockstep:
    """Owns /clock.

    Attributes:
        now: the present instant [ns]; 0: time has not begun.
    """

    def __init__(
        self, node: Node, *, period: int, pass_until: Callable[[int], None], participants: Mapping[str, type],
        wires: Sequence[str], settle: float, timeout: float, heard: Callable[[str, Any], None] = _nothing,
        also: Callable[[], list[str]] = _none, monotonic: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        """Listen to the participants; time passes when `look` is called, or a participant's message is the last one.

        Args:
            node: publishes /clock and listens.
            period: between two instants [ns].
            pass_until: makes the next instant, given as stamp [ns], before /clock tells it.
            participants: topics with their message types.
            wires: topics that need a publisher and somebody else's subscription before time begins.
            settle: wall time between the last wire's appearance and the beginning [s].
            timeout: wall time after which standing still is worth a word [s].
            heard: gets each participant's records by topic.
            also: what else an instant waits for, in words.
            monotonic: the wall's clock [s].
        """
        self.now = 0
        self._node, self._period, self._pass_until = node, period, pass_until
        self._wires, self._settle, self._timeout = tuple(wires), settle, timeout
        self._heard, self._also, self._monotonic = heard, also, monotonic
        self._participants = tuple(participants)
        self._late = set(self._participants)
        self._since = self._turn = monotonic()
        self._ready_since = math.inf
        self._passing = False
        self._sources: dict[str, str] = {}
        self._clock = RecordPublisher(node, Clock, "/clock")
        for name, kind in participants.items():
            listen(node, kind, name, partial(self._on_done, name))

    def _on_done(self, name: str, record: Any) -> None:
        self._heard(name, record)
        if record.stamp >= self.now > 0:
            self._late.discard(name)
        if not self._late and self._monotonic() - self._turn < _LONGEST_TURN:
            self._step()

    def look(self) -> None:
        """Let the next instant come if nothing is missing for it; to be called now and then, best by a timer.

        A timer whose callback takes longer than its period would be called again and again before anything else is:
        so one call in a while does nothing.
        """
        now = self._monotonic()
        if now - self._turn < _LONGEST_TURN:
            self._step()
        else:
            self._turn = now

    def waiting_for(self) -> list[str]:
        """Return what the next instant waits for, in words."""
        if self.now == 0:
            missing = [f"a publisher and a subscription of {name}" for name in self._wires_missing()]
            return missing or ["the graph to settle"]
        late = [name for name in self._participants if name in self._late] or self._also()
        gone = [
            f"{name} is gone, who published {topic}"
            for topic, name in self._sources.items()
            if not self._node.count_publishers(topic)
        ]
        return [*gone, *late]

    def standstill(self) -> str:
        """Return a sentence that names whom time has been waiting for too long, else ""."""
        if self._monotonic() - self._since <= self._timeout:
            return ""
        return f"time stands still, waiting for {'; '.join(self.waiting_for()) or 'nothing'}"

    def _wires_missing(self) -> list[str]:
        clock = [] if self._clock.publisher.get_subscription_count() or self._clock.heard_by else ["/clock"]
        wires = [name for name in self._wires if not self._is_wired(name)]
        absent = [name for name in self._participants if not self._node.count_publishers(name)]
        return list(dict.fromkeys([*clock, *wires, *absent]))

    def _is_wired(self, name: str) -> bool:
        full = self._node.resolve_topic_name(name)
        own = sum(each.topic_name == full for each in self._node.subscriptions)
        return bool(self._node.count_publishers(name) and self._node.count_subscribers(name) > own)

    def _remember_sources(self) -> None:
        for topic in dict.fromkeys([*self._participants, *self._wires]):
            for each in self._node.get_publishers_info_by_topic(topic):
                if each.node_name != self._node.get_name():
                    self._sources[topic] = each.node_name

    def _step(self) -> None:
        if self._passing:  # what is handed over comes while the instant is still being made
            return
        if self.now == 0:
            moment = self._monotonic()
            if self._wires_missing():
                self._ready_since = math.inf
                return
            self._ready_since = min(self._ready_since, moment)
            if moment - self._ready_since < self._settle:
                return
            self._remember_sources()
        elif self._late or self._also():
            return
        self._passing = True
        try:
            self.now += self._period
            self._late = set(self._participants)
            self._pass_until(self.now)
            self._clock.publish(_CLOCK.record(clock=self.now))
        finally:
            self._passing = False
        self._since = self._monotonic()
