"""Lockstep: what time waits for, who is named, when it begins."""

from collections.abc import Callable
from typing import Any

import pytest
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from thruster_runtime.executors import spin_until
from thruster_runtime.lockstep import Lockstep, known_participants
from thruster_runtime.qos import RELIABLE

PERIOD = 40_000_000


class Graph:
    """An owner of time, a participant on each of two topics, and one who listens to /clock."""

    def __init__(self, context: Context, spun: Callable[..., Executor], timeout: float = 0.1) -> None:
        self.owner, self.worker, self.other = (Node(name, context=context) for name in ("owner", "worker", "other"))
        self.made: list[int] = []
        self.ticks: list[int] = []
        self.also: list[str] = []
        self.owner.create_timer(0.001, self._look)
        self.time = Lockstep(
            self.owner, period=PERIOD, pass_until=self.made.append, participants={"a": Header, "b": Header},
            wires=("a",), settle=0.05, timeout=timeout, also=lambda: self.also,
        )  # fmt: skip
        self.sent = {
            "a": self.worker.create_publisher(Header, "a", RELIABLE),
            "b": self.other.create_publisher(Header, "b", RELIABLE),
        }
        self.other.create_subscription(Clock, "/clock", lambda m: self.ticks.append(m.clock.nanosec), RELIABLE)
        self.executor = spun(self.owner, self.worker, self.other)

    def _look(self) -> None:
        self.time.look()

    def wire(self) -> None:
        self.worker.create_subscription(Header, "a", lambda _: None, RELIABLE)

    def say(self, topic: str, stamp: int) -> None:
        message = Header()
        message.stamp.nanosec = stamp
        self.sent[topic].publish(message)

    def until(self, predicate: Callable[[], bool], longest: float = 10.0) -> bool:
        return spin_until(self.executor, predicate, longest)


@pytest.fixture
def graph(context: Context, spun: Callable[..., Executor]) -> Graph:
    return Graph(context, spun)


def begin(graph: Graph) -> None:
    graph.wire()
    assert graph.until(lambda: len(graph.ticks) == 1), graph.time.waiting_for()


def test_time_begins_when_its_wires_are_there_and_says_what_it_lacks(graph: Graph) -> None:
    assert not graph.until(lambda: bool(graph.made), 0.3)
    assert graph.time.waiting_for() == ["a publisher and a subscription of a"]
    begin(graph)
    assert graph.made == graph.ticks == [PERIOD]


def test_an_instant_passes_when_every_participant_has_spoken_of_it(graph: Graph) -> None:
    begin(graph)
    assert graph.time.waiting_for() == ["a", "b"]
    graph.say("b", PERIOD)
    assert graph.until(lambda: graph.time.waiting_for() == ["a"])
    graph.say("a", PERIOD - 1)
    assert not graph.until(lambda: len(graph.made) > 1, 0.2), "a word of an instant before counts for nothing"
    graph.say("a", PERIOD)
    assert graph.until(lambda: graph.ticks == [PERIOD, 2 * PERIOD])


def test_what_else_an_instant_waits_for_is_asked_when_all_have_spoken(graph: Graph) -> None:
    graph.also = ["bytes"]
    begin(graph)
    for topic in "ab":
        graph.say(topic, PERIOD)
    assert graph.until(lambda: graph.time.waiting_for() == ["bytes"])
    graph.also.clear()
    assert graph.until(lambda: len(graph.made) == 2)


def test_who_is_late_and_who_has_left_the_graph_are_named_after_the_time_out(graph: Graph) -> None:
    begin(graph)
    assert graph.time.standstill() == ""
    graph.say("b", PERIOD)
    assert graph.until(lambda: graph.time.standstill() == "time stands still, waiting for a")
    graph.worker.destroy_publisher(graph.sent["a"])
    said = "time stands still, waiting for worker is gone, who published a; a"
    assert graph.until(lambda: graph.time.standstill() == said), graph.time.standstill()


def test_a_participant_of_an_unknown_type_is_said() -> None:
    types: dict[str, Any] = {"x": Header, "rov/y": Clock}
    found, problems = known_participants(["n/x", "rov/y", "n/x", "z"], types)
    assert found == {"n/x": Header, "rov/y": Clock}
    assert problems == ["participants: expected topics that end in one of x, rov/y; found 'z'"]
