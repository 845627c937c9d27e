"""The topics that a recorder hears: found in the graph as they appear, and written to a journal as they come."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import time_ns

from rclpy.node import Node
from rclpy.qos import QoSProfile

from ..arrivals import Arrivals
from ..definitions import definitions
from ..errors import SchemaError
from ..journal import Journal
from ..loss import LossCounter
from ..rosbag2 import TopicRecord
from ..selection import Selection
from ..stamps import has_header, header_stamp
from .qos import as_dict, request, serves
from .raw_topic import Arrival, RawTopic, message_class


@dataclass(frozen=True)
class _Heard:
    subscription: RawTopic
    receive: Callable[[Arrival], None]
    profile: QoSProfile
    loss: LossCounter
    came: list[bool]


class RecordedTopics:
    """Subscribes to what is selected and appears in the graph, and writes what comes.

    Attributes:
        troubles: why a topic is not recorded, or not from all its publishers; by topic.
    """

    def __init__(
        self,
        node: Node,
        journal: Journal,
        selection: Selection,
        *,
        now: Callable[[], int] | None,
        arrivals: Arrivals,
        acknowledge: Callable[[int], None],
    ) -> None:
        """Begin with no topic.

        Args:
            node: hears them.
            journal: takes the messages.
            selection: what to record.
            now: simulated time [ns], 0 before it is known; None: messages are logged at the time they were received.
            arrivals: the topics that make an instant complete.
            acknowledge: called with the stamp [ns] of each instant that is complete and recorded.
        """
        self.troubles: dict[str, str] = {}
        self._node, self._journal, self._selection = node, journal, selection
        self._now, self._arrivals, self._acknowledge = now, arrivals, acknowledge
        self._heard: dict[str, _Heard] = {}
        self._early: list[tuple[int, Arrival]] = []

    @property
    def lost(self) -> int:
        """How many messages were lost on the way."""
        return sum(heard.loss.lost for heard in self._heard.values())

    @property
    def silent(self) -> list[str]:
        """Topics that have brought nothing."""
        return [name for name, heard in self._heard.items() if not heard.came]

    def hears(self, name: str, *, messages: bool) -> bool:
        """Tell whether a topic is connected, or a message of it has come."""
        heard = self._heard.get(name)
        return heard is not None and bool(heard.came if messages else heard.subscription.publishers)

    def now(self) -> int:
        """Return the time at which messages are logged that come now [ns]."""
        return time_ns() if self._now is None else self._now()

    def __len__(self) -> int:
        return len(self._heard)

    def look(self) -> None:
        """Subscribe to topics that have appeared."""
        for name, types in self._node.get_topic_names_and_types():
            if name not in self._selection:
                continue
            if len(types) > 1:
                self.troubles[name] = f"has several types ({', '.join(sorted(types))})"
                continue
            publishers = self._node.get_publishers_info_by_topic(name)
            if not publishers:
                continue
            offers = [p.qos_profile for p in publishers]
            if name in self._heard:
                if not all(serves(one, self._heard[name].profile) for one in offers):
                    self.troubles[name] = "a publisher that came later offers too little (QoS) and is not recorded"
            elif name not in self.troubles:
                try:
                    self._subscribe(name, types[0], offers)
                except SchemaError as error:
                    self.troubles[name] = str(error)

    def finish(self) -> None:
        """Write what has arrived and was not handed over yet; only while no executor spins."""
        for heard in self._heard.values():
            for arrival in heard.subscription.waiting():
                heard.receive(arrival)
        self._write_early(0)

    def _subscribe(self, name: str, kind: str, offers: list[QoSProfile]) -> None:
        message_class(kind)  # before the journal has the topic
        record = TopicRecord(name=name, type=kind, qos=tuple(as_dict(one) for one in offers))
        stamped = has_header(definitions().fields(kind), kind)
        asked = name in self._arrivals
        if asked and not stamped:
            self.troubles[name] = f"cannot be acknowledged: {kind} has no header"
        channel = self._journal.add_topic(record)
        loss = LossCounter(lambda: self._node.count_publishers(name))

        came: list[bool] = []

        def receive(arrival: Arrival) -> None:
            came[:] = [True]
            if arrival.number:
                loss.arrived(arrival.number)
            self._write(channel, arrival)
            if asked and stamped and self._arrivals.arrived(name, header_stamp(arrival.payload)):
                self._acknowledge(self._arrivals.complete)

        profile = request(offers)
        self._heard[name] = _Heard(RawTopic(self._node, name, kind, profile, receive), receive, profile, loss, came)

    def _write(self, channel: int, arrival: Arrival) -> None:
        time = arrival.received if self._now is None else self._now()
        if time == 0:  # simulated time has not begun; what comes before it is logged at its beginning
            self._early.append((channel, arrival))
            return
        self._write_early(time)
        self._put(channel, arrival, time)

    def _write_early(self, time: int) -> None:
        early, self._early = self._early, []
        for channel, arrival in early:
            self._put(channel, arrival, time)

    def _put(self, channel: int, arrival: Arrival, time: int) -> None:
        self._journal.add(
            channel, arrival.payload, log_time=time, publish_time=arrival.published, sequence=arrival.number
        )
