"""What is written comes back, through our reader and through independent ones."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter

from run_bag import InvalidRunError, RunExistsError, Topic, read_run, write_run
from run_bag.benchmark import bench_topics
from run_bag.definitions import definitions
from run_bag.run_metadata import TOPIC

values = st.floats(allow_nan=True, allow_infinity=True)
samples = st.lists(st.tuples(st.integers(0, 10**12), values), min_size=1, max_size=30)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(state=samples, speed=samples, frame=st.text("abc_é", max_size=6))
def test_a_run_comes_back_bit_for_bit(tmp_path_factory, state, speed, frame):
    folder = tmp_path_factory.mktemp("runs") / "a"
    topics = []
    for name, kind, field, rows in (
        ("thruster_0/state", "ThrusterState", "n", state),
        ("x", "ThrustSetpoint", "thrust", speed),
    ):
        rows.sort(key=lambda r: r[0])
        stamps = np.array([r[0] for r in rows])
        fields = {field: np.array([r[1] for r in rows])}
        kind = f"thruster_msgs/{kind}"
        topics.append(Topic(name=name, type=kind, stamps=stamps, fields=fields, frame=frame))
    write_run(folder, topics, {"k": {"é": [1, None, "x"]}})
    wanted = {t.name: t for t in topics if not all(np.isnan(v).all() for v in t.fields.values())}
    if not wanted:
        return
    run = read_run(folder)
    assert run.metadata == {"k": {"é": [1, None, "x"]}} and run.warnings == () and run.name == "a"
    for name, topic in wanted.items():
        (field, column) = next(iter(topic.fields.items()))
        channel = run[f"{name}.{field}"]
        np.testing.assert_array_equal(channel.stamps, topic.stamps)
        assert channel.values.tobytes() == column.tobytes() or np.array_equal(channel.values, column, equal_nan=True)
        assert channel.frame == frame


def test_channels_that_were_not_measured_are_left_out_and_units_are_known(tmp_path):
    run = read_run(write_run(tmp_path / "a", bench_topics(10)))
    assert "thruster_0/state.supply_voltage" not in run
    assert run["thruster_0/state.n"].unit == "rad/s" and run["thruster_0/load.wrench.torque.x"].unit == "N m"
    assert run["thruster_0/gauges.voltage[5]"].unit == "V"
    assert run["thruster_0/load.wrench.force.x"].frame == "thruster_0"


def test_rosbags_reads_the_same_messages_in_log_time_order(tmp_path):
    topics = bench_topics(50)
    folder = write_run(tmp_path / "a", topics, {"seed": 3})
    with AnyReader([folder]) as reader:
        assert reader.message_count == 201 and set(reader.topics) == {TOPIC, *(t.name for t in topics)}
        assert reader.start_time == 10**9
        times, found = [], []
        for connection, stamp, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == TOPIC:
                assert json.loads(message.data) == {"seed": 3} and stamp == reader.start_time
                continue
            times.append(stamp)
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
            if connection.topic == "/thruster_0/gauges":
                found.append(message.voltage)
    assert times == sorted(times)
    np.testing.assert_array_equal(found, topics[3].fields["voltage"])


def test_the_file_is_what_rosbag2_writes_around_its_messages(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(20), {"seed": 3})
    bag = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (bag["version"], bag["storage_identifier"], bag["ros_distro"]) == (9, "mcap", "jazzy")
    assert bag["message_count"] == 81 and bag["relative_file_paths"] == ["a_0.mcap"]
    assert bag["duration"]["nanoseconds"] == 19_000_000
    assert json.loads(bag["custom_data"]["run"]) == {"seed": 3}
    told, first = (t["topic_metadata"]["offered_qos_profiles"][0] for t in bag["topics_with_message_count"][:2])
    assert (told["durability"], told["depth"]) == ("transient_local", 1)
    qos = first
    assert qos["reliability"] == "reliable" and qos["deadline"] == {"sec": 9223372036, "nsec": 854775807}
    with (folder / "a_0.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary.statistics.message_count == 81
        assert all(c.compression == "zstd" and c.message_index_length for c in summary.chunk_indexes)
        assert {s.encoding for s in summary.schemas.values()} == {"ros2msg"}
        for channel in summary.channels.values():
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
            assert yaml.safe_load(channel.metadata["offered_qos_profiles"])[0]["depth"] in (1, 10)
        records = {m.name: m.metadata for m in reader.iter_metadata()}
    assert json.loads(records["run"]["json"]) == {"seed": 3}
    assert yaml.safe_load(records["rosbag2"]["serialized_metadata"]) == bag
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a"]


def test_nothing_is_ever_overwritten_and_nothing_half_done_stays(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(5))
    before = {p: p.read_bytes() for p in folder.iterdir()}
    with pytest.raises(RunExistsError, match="exists; nothing is overwritten"):
        write_run(folder, bench_topics(7))
    (tmp_path / "file").write_text("mine")
    with pytest.raises(RunExistsError):
        write_run(tmp_path / "file", bench_topics(7))
    with pytest.raises(InvalidRunError):
        write_run(tmp_path / "b", [Topic(name="x", type="std_msgs/Float64", stamps=[1], fields={"nope": [1.0]})])
    assert {p: p.read_bytes() for p in folder.iterdir()} == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "file"]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"stamps": [2, 1]}, "backwards at message 1: 2 ns, then 1 ns"),
        ({"stamps": [-1, 1]}, "stamps from 0 s"),
        ({"stamps": [0.5, 1.0]}, "integer stamps in nanoseconds"),
        ({"name": "a b"}, "topic name"),
        ({"fields": {"m": [1.0, 2.0]}}, "no numeric field 'm'"),
        ({"fields": {"n": [1.0]}}, "expected shape (2,), found (1,)"),
        ({"fields": {"sign_source": [0.5, 1]}}, "whole numbers from 0 to 255"),
        ({"fields": {"sign_source": [0, 256]}}, "whole numbers from 0 to 255"),
        ({"fields": {"n": "x"}}, "no string field 'n'"),
        ({"fields": {"header.stamp.sec": [1, 2]}}, "comes from the stamps"),
    ],
)
def test_topics_that_cannot_be_written_are_refused_with_a_sentence(tmp_path, change, sentence):
    good = {"name": "s", "type": "thruster_msgs/ThrusterState", "stamps": [0, 1], "fields": {}}
    with pytest.raises(InvalidRunError) as caught:
        write_run(tmp_path / "a", [Topic(**{**good, **change})])
    assert sentence in str(caught.value)


def test_strings_that_change_from_message_to_message_are_written(tmp_path):
    reasons = ["", "stale input", "é", ""]
    fields = {"n": [1.0, 2.0, 3.0, 4.0], "estimator": "ekf", "reason": reasons}
    topic = Topic(name="e", type="thruster_msgs/ThrusterEstimate", stamps=[1, 2, 3, 4], fields=fields)
    folder = write_run(tmp_path / "a", [topic])
    with AnyReader([folder]) as reader:
        messages = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()]
    assert [m.reason for m in messages] == reasons and {m.estimator for m in messages} == {"ekf"}
    assert read_run(folder)["e.n"].values.tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd", "unchunked"])
def test_bags_of_other_writers_are_read(tmp_path, compression):
    kind, text = "my_msgs/msg/Pair", "uint8 tag\nfloat64 left\nfloat32[2] right\nmy_msgs/Inner inner\n"
    text += "=" * 80 + "\nMSG: my_msgs/Inner\nint16 deep\n"
    path = tmp_path / "x.mcap"
    how = {"lz4": CompressionType.LZ4, "zstd": CompressionType.ZSTD}.get(compression, CompressionType.NONE)
    with path.open("wb") as file:
        writer = Writer(file, compression=how, use_chunking=compression != "unchunked", chunk_size=200)
        writer.start()
        schema = writer.register_schema(kind, "ros2msg", text.encode())
        channel = writer.register_channel("/pair", "cdr", schema)
        for i in range(100):
            raw = b"\0\1\0\0" + bytes([i]) + bytes(7) + np.float64(i / 2).tobytes()
            raw += np.array([i, -i], dtype="<f4").tobytes() + np.int16(3 * i).tobytes()
            writer.add_message(channel, i, raw, i)
        writer.finish()
    run = read_run(path)
    assert run.name == "x" and run.warnings == ()
    assert run["pair.left"].values.tolist() == [i / 2 for i in range(100)]
    assert run["pair.right[1]"].values.tolist() == [-i for i in range(100)]
    assert run["pair.inner.deep"].values.tolist() == [3 * i for i in range(100)]
    assert run["pair.left"].stamps.tolist() == list(range(100)) and run["pair.left"].unit == ""


@pytest.mark.parametrize("version", [8, 9])
def test_a_bag_written_by_rosbags_is_read(tmp_path, version):
    store = definitions().store
    definitions().require("thruster_msgs/msg/Throttle")
    folder = tmp_path / "theirs"
    head = store.types["std_msgs/msg/Header"](store.types["builtin_interfaces/msg/Time"](5, 6), "f")
    with RosbagsWriter(folder, version=version, storage_plugin=StoragePlugin.MCAP) as writer:
        kind = "thruster_msgs/msg/Throttle"
        connection = writer.add_connection("/thruster_0/throttle", kind, typestore=store)
        for i in range(10):
            message = store.types[kind](head, float(i), np.nan)
            writer.write(connection, 100 + i, store.serialize_cdr(message, kind))
    run = read_run(folder)
    channel = run["thruster_0/throttle.commanded"]
    assert channel.values.tolist() == list(range(10)) and set(channel.stamps) == {5 * 10**9 + 6}


def test_a_bag_of_several_files_is_read_as_one(tmp_path):
    first = write_run(tmp_path / "a", bench_topics(30))
    second = write_run(tmp_path / "b", [
        Topic(name=t.name, type=t.type, stamps=np.asarray(t.stamps) + 10**9, fields=t.fields, frame=t.frame)
        for t in bench_topics(30)
    ])  # fmt: skip
    whole = tmp_path / "whole"
    whole.mkdir()
    (whole / "w_0.mcap").write_bytes((first / "a_0.mcap").read_bytes())
    (whole / "w_10.mcap").write_bytes((second / "b_0.mcap").read_bytes())
    run = read_run(whole)
    assert len(run["thruster_0/state.n"]) == 60 and run.warnings == ()
    assert isinstance(Path(run.name), Path)


def test_only_the_topics_asked_for_are_read(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(5))
    assert {name.split(".")[0] for name in read_run(folder, ["/thruster_0/state"])} == {"thruster_0/state"}
