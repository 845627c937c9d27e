"""Messages between nodes of one process, handed over as records instead of sent out and taken back in.

A topic still gets every message, for all other processes. The nodes that share an executor stop to subscribe to what
one of them publishes, and get its records by a call: half of what an observer and its inner loop would take are each
other's messages. They hear that topic from nobody else then.
"""

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rclpy.node import Node

from thruster_runtime.records import RecordPublisher, ends_of

__all__ = ["hand_over"]

Callback = Callable[[Any], None]


def hand_over(nodes: Sequence[Node]) -> list[str]:
    """Let nodes hand their records to each other; before they spin, in one executor with one thread.

    Returns:
        The topics that are handed over, sorted.
    """
    publishers: dict[str, list[RecordPublisher]] = {}
    for node in nodes:
        for publisher in ends_of(node).publishers:
            publishers.setdefault(publisher.publisher.topic_name, []).append(publisher)
    turns = _Turns()
    topics = set()
    for node in nodes:
        for listener in ends_of(node).listeners:
            callback = listener.callback = partial(turns.take, listener.callback)
            topic = listener.subscription.topic_name
            sources = publishers.get(topic, [])
            for publisher in sources:
                publisher.heard_by.append(callback)
            if sources:
                node.destroy_subscription(listener.subscription)
                topics.add(topic)
    return sorted(topics)


class _Turns:
    """Callbacks one after the other: what is handed over in one of them waits until it has returned."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Callback, Any]] = deque()
        self._busy = False

    def take(self, callback: Callback, record: Any) -> None:
        """Call back, now or after the callbacks that are on."""
        self._waiting.append((callback, record))
        if self._busy:
            return
        self._busy = True
        try:
            while self._waiting:
                callback, record = self._waiting.popleft()
                callback(record)
        finally:
            self._waiting.clear()
            self._busy = False
