"""The player in a graph: what was recorded is heard again, at the right time, in lockstep where asked."""

import threading
import time
from pathlib import Path

import numpy as np
import pytest
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from recording_graph import Graph, messages
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, String

from run_bag import RunError, Topic, read_run, write_run
from run_bag.benchmark import bench_topics
from run_bag.cli_play import options
from run_bag.errors import MissingParticipantError
from run_bag.finishing import finish
from run_bag.journal import Journal
from run_bag.live.player_node import PlayerNode
from run_bag.live.qos import LONGEST, as_dict, from_dict, offer, request, serves
from run_bag.rosbag2 import DEFAULT_QOS, TopicRecord
from run_bag.timeline import Instant
from thruster_msgs.msg import Throttle, ThrusterState
from thruster_runtime.qos import RECORDER, RELIABLE

BENCH = ("/thruster_0/gauges", "/thruster_0/load", "/thruster_0/state", "/thruster_0/throttle")


def player(graph: Graph, *arguments: str) -> tuple[PlayerNode, threading.Event]:
    stop = threading.Event()
    node = PlayerNode(options([*arguments, "--delay", "0.1"]), stop, context=graph.context)
    return graph.add(node), stop


def played(graph: Graph, *arguments: str) -> PlayerNode:
    """Play to the end."""
    node, stop = player(graph, *arguments)
    graph.until(stop.is_set)
    node.on_stop()
    return node


def sorted_content(path: Path, without: tuple[str, ...]) -> list[tuple[str, bytes]]:
    return sorted((topic, payload) for topic, _, _, payload in messages(path, without))


@pytest.mark.parametrize("how", [["--rate", "2"], ["--fast"]])
def test_a_run_that_is_played_and_recorded_again_has_the_same_content(
    graph: Graph, tmp_path: Path, how: list[str]
) -> None:
    write_run(tmp_path / "a", bench_topics(500))
    recorder = graph.recorder(tmp_path / "b", topics=list(BENCH))
    played(graph, str(tmp_path / "a"), *how)
    graph.until(lambda: recorder.journal.messages == 2000)
    graph.stop(recorder)
    assert recorder.topics.lost == 0
    assert sorted_content(tmp_path / "b", ()) == sorted_content(tmp_path / "a", ())


def test_what_is_played_to_a_device_that_acts_now_is_stamped_now(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(50))
    clocks: list[Clock] = []
    heard: list[Throttle] = []
    graph.node.create_subscription(Clock, "/clock", clocks.append, RECORDER)
    graph.node.create_subscription(Throttle, "thruster_0/throttle", heard.append, RECORDER)
    begin = graph.node.get_clock().now().nanoseconds
    played(graph, str(tmp_path / "a"), "--restamp", "--topics", "thruster_0/throttle")
    graph.until(lambda: len(heard) == 50)
    stamps = np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in heard])
    assert begin < stamps[0] and stamps[-1] < graph.node.get_clock().now().nanoseconds
    assert np.all(np.diff(stamps) > 0) and not clocks
    recorded = read_run(tmp_path / "a")["thruster_0/throttle.commanded"].values
    assert [m.commanded for m in heard] == recorded.tolist()


def test_time_passes_at_the_rate_that_was_asked_for(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(501))
    clocks: list[float] = []
    graph.node.create_subscription(
        Clock, "/clock", lambda m: clocks.append(m.clock.sec + m.clock.nanosec / 1e9), RECORDER
    )
    node, stop = player(graph, str(tmp_path / "a"), "--rate", "2", "--topics", "thruster_0/state")
    publish, published = node._publish, []

    def noted(instant: Instant) -> None:
        published.append((time.monotonic(), instant.time / 1e9))
        publish(instant)

    node._publish = noted
    graph.until(stop.is_set)
    node.on_stop()
    graph.until(lambda: bool(clocks) and clocks[-1] == 1.5)
    late = [(at - published[0][0]) - (due - 1.0) / 2 for at, due in published]
    assert abs(np.median(late)) <= node.played.latest + 0.02  # as late as it says, on a machine that is busy
    assert clocks == sorted(clocks) and clocks[0] == 1.0 and clocks[-1] == 1.5 and len(clocks) >= 501
    assert node.played.messages == 501


def test_the_clock_goes_on_where_nothing_is_published(graph: Graph, tmp_path: Path) -> None:
    stamps = np.array([10**9, 2 * 10**9])
    topic = Topic(name="x", type="thruster_msgs/Throttle", stamps=stamps, fields={"sent": np.array([1.0, 2.0])})
    write_run(tmp_path / "a", [topic])
    clocks: list[int] = []
    graph.node.create_subscription(Clock, "/clock", lambda m: clocks.append(m.clock.nanosec), RECORDER)
    played(graph, str(tmp_path / "a"), "--fast", "--clock-period", "0.1")
    graph.until(lambda: len(clocks) == 11)
    assert clocks == [*(i * 10**8 for i in range(10)), 0]


class Participant(Node):
    """Answers each state with a throttle of the same stamp, some time later."""

    def __init__(self, graph: Graph, answers: int) -> None:
        super().__init__("participant", context=graph.context)
        self.left, self.stamps = answers, []
        self.output = self.create_publisher(Throttle, "answer", RELIABLE)
        self.create_subscription(ThrusterState, "/thruster_0/state", self.answer, RELIABLE)

    def answer(self, state: ThrusterState) -> None:
        self.stamps.append(state.header.stamp.sec * 10**9 + state.header.stamp.nanosec)
        time.sleep(0.002)  # slower than the player
        self.left -= 1
        if self.left >= 0:
            self.output.publish(Throttle(header=state.header, sent=state.n))


def test_in_lockstep_a_slow_participant_with_a_short_queue_misses_nothing(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(200))
    participant = graph.add(Participant(graph, 200))
    recorder = graph.recorder(
        tmp_path / "b", topics=[*BENCH, "answer"], acknowledge=["answer", *BENCH], use_sim_time=True
    )
    played(graph, str(tmp_path / "a"), "--step", "--wait-for", "answer", "recorder/recorded")
    graph.stop(recorder)
    assert participant.stamps == [10**9 + i * 10**6 for i in range(200)]
    assert sorted_content(tmp_path / "b", ("/answer",)) == sorted_content(tmp_path / "a", ())
    answers = [row for row in messages(tmp_path / "b") if row[0] == "/answer"]
    assert [row[1] for row in answers] == participant.stamps  # logged in simulated time


def test_a_participant_that_does_not_answer_is_named(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(20))
    graph.add(Participant(graph, 5))
    node, stop = player(graph, str(tmp_path / "a"), "--step", "--wait-for", "answer", "--timeout", "0.3")
    graph.until(stop.is_set)
    with pytest.raises(MissingParticipantError, match=r"no message stamped 1.005000000 s within 0.3 s on /answer"):
        node.on_stop()


def test_a_participant_that_is_not_there_is_named(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(20))
    node, stop = player(graph, str(tmp_path / "a"), "--step", "--wait-for", "answer", "--timeout", "0.2")
    graph.until(stop.is_set)
    with pytest.raises(MissingParticipantError, match="nobody publishes /answer"):
        node.on_stop()


def test_a_recorded_output_that_is_waited_for_is_not_played(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(20))
    node, _ = player(graph, str(tmp_path / "a"), "--step", "--wait-for", "thruster_0/throttle:thruster_0/state")
    assert [t.name for t in node._timeline.topics] == [n for n in BENCH if n != "/thruster_0/throttle"]
    node.on_stop()


def test_a_loop_begins_again_until_it_is_stopped(graph: Graph, tmp_path: Path) -> None:
    write_run(tmp_path / "a", bench_topics(20))
    heard: list[float] = []
    graph.node.create_subscription(Throttle, "/thruster_0/throttle", lambda m: heard.append(m.commanded), RECORDER)
    node, stop = player(graph, str(tmp_path / "a"), "--rate", "5", "--loop", "yes")
    graph.until(lambda: len(heard) >= 50)
    stop.set()
    node.on_stop()
    assert heard[20:40] == heard[:20]


def test_latched_messages_reach_who_comes_later(graph: Graph, tmp_path: Path) -> None:
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    recorder = graph.recorder(tmp_path / "a", topics=["info", "value"])
    graph.publisher(String, "info", latched).publish(String(data="kept"))
    source = graph.publisher(Float64, "value", QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT))
    source.publish(Float64())
    graph.until(lambda: recorder.journal.messages == 2)
    graph.stop(recorder)
    node = played(graph, str(tmp_path / "a"), "--fast")
    heard: list[str] = []
    graph.node.create_subscription(String, "info", lambda m: heard.append(m.data), latched)
    graph.until(lambda: "kept" in heard)
    (value,) = [p for p in node._publishers if p.topic_name == "/value"]
    assert value.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT


def test_a_type_that_is_defined_otherwise_here_is_left_out_and_said(graph: Graph, tmp_path: Path) -> None:
    journal = Journal(tmp_path / "b", {})
    for name, digest in (("/ok", None), ("/other", "RIHS01_" + "0" * 64)):
        channel = journal.add_topic(TopicRecord(name=name, type="std_msgs/msg/Float64", type_hash=digest))
        journal.add(channel, b"\0\1\0\0" + bytes(8), log_time=1, publish_time=1)
    journal.close()
    finish(tmp_path / "b")
    node, _ = player(graph, str(tmp_path / "b"))
    assert [t.name for t in node._timeline.topics] == ["/ok"]
    assert any("/other is not played" in s and "defined otherwise" in s for s in node._timeline.left_out)
    node.on_stop()
    with pytest.raises(RunError, match="/other is not played"):
        player(graph, str(tmp_path / "b"), "--topics", "other")


@pytest.mark.parametrize(
    "profile",
    [
        RELIABLE,
        QoSProfile(
            depth=7,
            reliability=ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            deadline=Duration(nanoseconds=1_500_000_001),
            lifespan=Duration(seconds=3),
        ),
    ],
)
def test_a_profile_comes_back_from_its_record(profile: QoSProfile) -> None:
    again = from_dict(as_dict(profile))
    assert (again.depth, again.reliability, again.durability) == (
        profile.depth,
        profile.reliability,
        profile.durability,
    )
    for name in ("deadline", "lifespan", "liveliness_lease_duration"):
        before, after = getattr(profile, name).nanoseconds, getattr(again, name).nanoseconds
        assert after == before or (after == LONGEST and before in (0, LONGEST))


def test_one_offer_serves_what_all_recorded_publishers_served() -> None:
    best_effort = {**DEFAULT_QOS, "reliability": "best_effort"}
    latched = {**DEFAULT_QOS, "durability": "transient_local", "depth": 1}
    assert offer([best_effort]).reliability == ReliabilityPolicy.BEST_EFFORT
    assert offer([DEFAULT_QOS]).depth == RECORDER.depth
    assert offer([latched]).depth == 1
    both = offer([best_effort, latched])
    assert both.reliability == ReliabilityPolicy.RELIABLE and both.durability == DurabilityPolicy.TRANSIENT_LOCAL
    unknown = offer([{**latched, "history": "unknown", "depth": 0, "liveliness": "unknown"}])
    assert unknown.depth == RECORDER.depth and unknown.durability == DurabilityPolicy.TRANSIENT_LOCAL
    offers = [from_dict(best_effort), from_dict(latched)]
    assert all(serves(o, request(offers)) for o in offers)
    assert not serves(from_dict(best_effort), request([from_dict(latched)]))
    assert not serves(from_dict(DEFAULT_QOS), request([from_dict(latched)]))


@pytest.mark.parametrize(
    "arguments",
    [["--rate", "0"], ["--rate", "2", "--step"], ["--wait-for", "x"], ["--timeout", "inf"], ["--fast", "--step"]],
)
def test_a_command_line_that_makes_no_sense_is_refused(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as error:
        options(["run", *arguments])
    assert error.value.code == 2
