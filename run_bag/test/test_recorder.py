"""The recorder in a graph: what is published is in the run, with its stamps, and the run is whole."""

import json
import time
from pathlib import Path

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from mcap.reader import make_reader
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from recording_graph import Graph, clock_at, messages
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, Header, String

from run_bag import CannotWriteError, InvalidRunError, RunExistsError, read_run
from run_bag.errors import RecordingError
from run_bag.reader import read_recording
from thruster_msgs.msg import ThrusterState
from thruster_runtime.errors import StartRefused

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.mark.parametrize("kind", ["events", "single"])
def test_what_is_published_is_recorded_with_the_times_of_publishing_and_receiving(tmp_path: Path, kind: str) -> None:
    graph = Graph(kind)
    recorder = graph.recorder(tmp_path / "a", topics=["value"])
    publisher = graph.publisher(Float64, "value")
    sent, times = [], []
    for i in range(1000):
        message = Float64(data=float(i))
        sent.append(serialize_message(message))
        times.append(time.time_ns())
        publisher.publish(message)
    graph.until(lambda: recorder.journal.messages == 1000)
    graph.stop(recorder)
    graph.close()
    rows = messages(tmp_path / "a")
    assert [row[3] for row in rows] == sent and {row[0] for row in rows} == {"/value"}
    for (_, logged, published, _), before in zip(rows, times, strict=True):
        assert before <= published <= logged <= before + 10**9


def test_a_finished_run_is_what_stock_readers_expect(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["thruster_./state", "latched"])
    publisher = graph.publisher(ThrusterState, "thruster_0/state")
    latched = graph.publisher(String, "latched", LATCHED)
    latched.publish(String(data="once"))
    for i in range(300):
        message = ThrusterState(n=float(i))
        message.header.stamp.sec, message.header.frame_id = i + 1, "thruster_0"
        publisher.publish(message)
    graph.until(lambda: recorder.journal.messages == 301)
    graph.stop(recorder)
    bag = yaml.safe_load((tmp_path / "a/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert bag["version"] == 9 and bag["message_count"] == 302 and bag["relative_file_paths"] == ["a_0.mcap"]
    topics = {t["topic_metadata"]["name"]: t for t in bag["topics_with_message_count"]}
    assert topics["/latched"]["topic_metadata"]["offered_qos_profiles"][0]["durability"] == "transient_local"
    assert topics["/thruster_0/state"]["message_count"] == 300
    with (tmp_path / "a/a_0.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None and summary.statistics is not None
    assert summary.statistics.message_count == 302 and summary.chunk_indexes[0].compression == "zstd"
    assert all(chunk.message_index_offsets for chunk in summary.chunk_indexes)
    with AnyReader([tmp_path / "a"]) as reader:
        state = [c for c in reader.connections if c.topic == "/thruster_0/state"]
        values = [reader.deserialize(raw, c.msgtype).n for c, _, raw in reader.messages(state)]
    assert values == [float(i) for i in range(300)]
    run = read_run(tmp_path / "a")
    assert run.warnings == () and run["thruster_0/state.n"].stamps[0] == 10**9
    assert list((tmp_path / "a").iterdir()) != [] and not list((tmp_path / "a").glob(".*"))


def test_what_was_latched_before_the_recorder_came_is_in_the_run(graph: Graph, tmp_path: Path) -> None:
    graph.publisher(String, "latched", LATCHED, heard_by=0).publish(String(data="before"))
    recorder = graph.recorder(tmp_path / "a", topics=["latched"])
    graph.until(lambda: recorder.journal.messages == 1)
    graph.stop(recorder)
    assert b"before" in messages(tmp_path / "a")[0][3]


def test_topics_that_appear_later_and_those_of_best_effort_are_recorded(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=[".*"], exclude=["unwanted"])
    graph.publisher(Float64, "first").publish(Float64())
    graph.until(lambda: recorder.journal.messages >= 1)
    graph.publisher(Float64, "later", BEST_EFFORT).publish(Float64(data=2.0))
    unwanted = graph.node.create_publisher(Float64, "unwanted", 10)
    seen = recorder.journal.messages
    graph.until(lambda: recorder.journal.messages > seen)
    assert unwanted.get_subscription_count() == 0
    graph.stop(recorder)
    assert [row[0] for row in messages(tmp_path / "a")] == ["/first", "/later"]


def test_in_simulated_time_messages_are_logged_at_the_time_of_the_clock(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["value"], use_sim_time=True)
    value = graph.publisher(Float64, "value")
    clock = graph.publisher(Clock, "/clock")
    value.publish(Float64(data=-1.0))  # before time began: logged at its beginning
    graph.until(lambda: bool(recorder.topics._early))
    assert recorder.journal.messages == 0
    for i in range(5):
        now = 7 * 10**9 + i * 40_000_000
        clock.publish(clock_at(now))
        graph.until(lambda now=now: recorder.get_clock().now().nanoseconds == now)
        value.publish(Float64(data=float(i)))
        graph.until(lambda i=i: recorder.journal.messages == i + 2)
    graph.stop(recorder)
    first = 7 * 10**9
    expected = [first, *(first + i * 40_000_000 for i in range(5))]
    assert [row[1] for row in messages(tmp_path / "a")] == expected
    assert all(abs(row[2] - time.time_ns()) < 60 * 10**9 for row in messages(tmp_path / "a"))


def test_the_run_says_what_was_run(graph: Graph, tmp_path: Path) -> None:
    kept = tmp_path / "set.yaml"
    kept.write_text("k_n: 11.3\n")
    other = graph.add(Node("other", namespace="/rov", context=graph.context))
    other.declare_parameter("gain", [1.0, float("nan")])
    recorder = graph.recorder(tmp_path / "a", topics=["value"], about="{seed: 3}", files=[str(kept)])
    graph.publisher(Float64, "value").publish(Float64())
    graph.until(lambda: recorder.journal.messages == 1)
    graph.until(lambda: "/rov/other" in recorder._node_parameters.found)
    graph.stop(recorder)
    metadata = read_recording(tmp_path / "a").metadata
    assert metadata["seed"] == 3 and metadata["files"] == {str(kept): "k_n: 11.3\n"}
    assert metadata["nodes"]["/rov/other"]["gain"] == [1.0, "nan"]
    assert metadata["recorder"]["host"] and metadata["recorder"]["version"] and metadata["recorder"]["started"]
    json.dumps(dict(metadata), allow_nan=False)


def test_a_parameter_that_is_changed_while_it_runs_is_kept_with_the_run(graph: Graph, tmp_path: Path) -> None:
    other = graph.add(Node("other", namespace="/rov", context=graph.context))
    other.declare_parameter("gain", 1.0)
    recorder = graph.recorder(tmp_path / "a", topics=["value"])
    graph.publisher(Float64, "value").publish(Float64())
    graph.until(lambda: recorder.journal.messages == 1 and "/rov/other" in recorder._node_parameters.found)
    other.set_parameters([Parameter("gain", value=2.0)])
    graph.until(lambda: bool(recorder._node_parameters.changes))
    graph.stop(recorder)
    metadata = read_recording(tmp_path / "a").metadata
    assert metadata["nodes"]["/rov/other"]["gain"] == 1.0
    (change,) = metadata["parameter_changes"]
    assert (change["node"], change["values"]) == ("/rov/other", {"gain": 2.0})
    assert change["time [ns]"] > 0


def test_a_recorder_that_is_told_its_topics_says_that_it_is_ready_once_it_hears_them(
    graph: Graph, tmp_path: Path
) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["[ab]"], wait_for=["a", "/b"])
    a, b = graph.publisher(Float64, "a"), graph.publisher(Float64, "b")
    a.publish(Float64())
    graph.until(lambda: recorder._unheard() == ["/b"])
    assert graph.node.count_publishers("/recorder/recorded") == 0
    b.publish(Float64())
    graph.until(lambda: graph.node.count_publishers("/recorder/recorded") == 1)
    graph.stop(recorder)


def test_a_recorder_that_got_nothing_from_what_it_waits_for_fails_and_names_it(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["[abc]"], wait_for=["a", "b"])
    graph.publisher(Float64, "a")
    graph.publisher(Float64, "c").publish(Float64())
    graph.until(lambda: recorder.journal.messages == 1)
    with pytest.raises(RecordingError, match="nothing at all of /a, /b was recorded"):
        graph.stop(recorder)
    assert read_run(tmp_path / "a")  # what came is whole all the same


def test_a_recorder_to_which_nothing_came_fails(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["a"])
    with pytest.raises(RecordingError, match="nothing at all was recorded"):
        graph.stop(recorder)


def test_a_topic_without_header_is_recorded_but_named_where_it_is_to_be_acknowledged(
    graph: Graph, tmp_path: Path
) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["a"], acknowledge=["a"])
    graph.publisher(Float64, "a").publish(Float64())
    graph.until(lambda: recorder.journal.messages == 1)
    assert "has no header" in recorder.topics.troubles["/a"]
    graph.stop(recorder)


def test_stamped_instants_are_acknowledged_in_order_and_not_before_the_last_topic(graph: Graph, tmp_path: Path) -> None:
    heard: list[int] = []
    graph.node.create_subscription(Header, "/recorder/recorded", lambda m: heard.append(m.stamp.sec), 10)
    recorder = graph.recorder(tmp_path / "a", topics=["[ab]"], acknowledge=["a", "/b"])
    a, b = graph.publisher(ThrusterState, "a"), graph.publisher(ThrusterState, "b")
    for second in (1, 2, 3):
        message = ThrusterState()
        message.header.stamp.sec = second
        a.publish(message)
        graph.until(lambda n=2 * second - 1: recorder.journal.messages == n)
        assert heard == list(range(1, second))
        b.publish(message)
        graph.until(lambda n=second: len(heard) == n)
    assert heard == [1, 2, 3]
    graph.stop(recorder)


def test_a_loss_is_counted_and_reported(graph: Graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arrays: list[DiagnosticArray] = []
    graph.node.create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)
    monkeypatch.setattr("run_bag.live.qos.QUEUE", 5)
    recorder = graph.recorder(tmp_path / "a", topics=["value"])
    publisher = graph.publisher(Float64, "value")
    publisher.publish(Float64())
    graph.until(lambda: recorder.journal.messages == 1)
    for i in range(50):
        publisher.publish(Float64(data=float(i)))
    graph.until(lambda: recorder.topics.lost > 0)
    graph.until(lambda: recorder.journal.messages + recorder.topics.lost == 51)
    assert recorder.topics.lost == 45
    graph.until(lambda: any(s.message.endswith("not everything") for a in arrays for s in a.status))
    values = {v.key: v.value for v in arrays[-1].status[0].values}
    assert values["lost"] == "45" and int(values["disk left [bytes]"]) > 0 and values["messages"] == "6"
    graph.stop(recorder)


def test_a_publisher_that_comes_later_and_offers_less_is_named(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["value"])
    graph.publisher(Float64, "value")
    graph.node.create_publisher(Float64, "value", BEST_EFFORT)
    graph.until(lambda: "offers too little" in recorder.topics.troubles.get("/value", ""))
    with pytest.raises(RecordingError):  # nothing was published
        graph.stop(recorder)


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"out": ""}, "out: expected a directory"),
        ({"reserve": -1.0}, r"reserve \[MB\]: expected a finite number from 0"),
        ({"topics": ["("]}, "'\\(' is no regular expression"),
        ({"topics": [""]}, "expected at least one name"),
        ({"about": "[1]"}, "expected a mapping"),
        ({"about": "{nodes: 1}"}, "'nodes' is the recorder's own"),
        ({"files": ["absent.yaml"]}, "absent.yaml: cannot be read"),
    ],
)
def test_wrong_parameters_are_refused_with_a_sentence_and_leave_nothing(
    graph: Graph, tmp_path: Path, parameters: dict[str, object], sentence: str
) -> None:
    with pytest.raises((InvalidRunError, StartRefused), match=sentence):
        graph.recorder(**{"out": tmp_path / "a", **parameters})
    assert list(tmp_path.iterdir()) == []


def test_nothing_that_exists_is_overwritten(graph: Graph, tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    with pytest.raises(RunExistsError, match="exists; nothing is overwritten"):
        graph.recorder(tmp_path / "a")
    assert list((tmp_path / "a").iterdir()) == []


def test_too_little_space_is_refused_at_the_start(graph: Graph, tmp_path: Path) -> None:
    with pytest.raises(CannotWriteError, match=r"MB are left on the disk, .* are to stay free"):
        graph.recorder(tmp_path / "a", reserve=1e12)
    assert not (tmp_path / "a").exists()


def test_a_disk_that_fills_ends_the_recording_with_a_whole_run(
    graph: Graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = graph.recorder(tmp_path / "a", topics=["value"])
    graph.publisher(Float64, "value").publish(Float64(data=1.0))
    graph.until(lambda: recorder.journal.messages == 1)
    monkeypatch.setattr("run_bag.live.recorder_node.free_bytes", lambda path: 5_000_000)
    with pytest.raises(CannotWriteError, match=r"5.0 MB are left on the disk, 100.0 MB are to stay free"):
        graph.until(lambda: False, 5.0)
    graph.stop(recorder)
    assert (tmp_path / "a/metadata.yaml").exists() and len(messages(tmp_path / "a")) == 1
