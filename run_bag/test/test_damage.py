"""Cut, damaged and hostile files: a clear sentence or all that is whole, never anything else."""

import shutil
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mcap.writer import CompressionType, Writer
from rclpy.serialization import serialize_message

from run_bag import (
    EmptyRunError,
    MissingTopicError,
    NotARunError,
    RunError,
    SchemaError,
    StampOrderError,
    TooLargeError,
    Topic,
    read_run,
    write_run,
)
from run_bag.benchmark import bench_topics
from run_bag.definitions import definitions
from run_bag.topic import check_topic

COUNT = 300


def journal(path, *, chunked):
    """Write an MCAP file as a recorder does; return where in the file each message is whole."""
    columns = [check_topic(t) for t in bench_topics(COUNT)[:2]]
    ends, before = [], 0
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=chunked, chunk_size=2000, compression=CompressionType.NONE)
        writer.start(profile="ros2")
        channels = [
            writer.register_channel(
                c.name, "cdr", writer.register_schema(c.type, "ros2msg", definitions().text(c.type).encode())
            )
            for c in columns
        ]
        before = file.tell()
        for i in range(COUNT):
            for column, channel in zip(columns, channels, strict=True):
                stamp = int(column.stamps[i])
                writer.add_message(channel, stamp, next(column.payloads(i, i + 1)), stamp)
                ends.append(None)
                if file.tell() != before:  # a chunk, or a single message, has gone to the file
                    before = file.tell()
                    ends = [before if e is None else e for e in ends]
        writer.finish()
        return [file.tell() if e is None else e for e in ends]


@pytest.mark.parametrize("chunked", [False, True])
def test_a_file_cut_anywhere_loses_no_whole_message(tmp_path, chunked):
    whole = tmp_path / "whole.mcap"
    ends = np.array(journal(whole, chunked=chunked))
    data = whole.read_bytes()
    random = np.random.default_rng(1)
    cut = tmp_path / "cut.mcap"
    for position in random.integers(0, len(data), 200):
        cut.write_bytes(data[:position])
        written = int(np.count_nonzero(ends <= position))
        try:
            run = read_run(cut)
        except RunError as error:
            assert str(cut) in str(error)
            assert written == 0 or (chunked and written < 50), f"lost {written} messages at {position}"
            continue
        got = sum(len(run[n]) for n in ("thruster_0/state.n", "thruster_0/throttle.commanded") if n in run)
        assert got >= written and got <= 2 * COUNT
        assert got == 2 * COUNT or (run.warnings and "cut.mcap" in run.warnings[0])


def test_inside_a_compressed_chunk_everything_that_decompresses_is_read(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(3000))
    file = folder / "a_0.mcap"
    data = file.read_bytes()
    lost = []
    for share in (0.3, 0.6, 0.9):
        file.write_bytes(data[: int(len(data) * share)])
        run = read_run(folder)
        got = len(run["thruster_0/state.n"])
        lost.append(got / 3000)
        assert any("messages that metadata.yaml counts are lost, the last" in w for w in run.warnings)
    assert lost == sorted(lost) and lost[-1] > 0.5


def test_a_damaged_chunk_is_left_out_and_the_rest_is_read(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(20_000))
    file = folder / "a_0.mcap"
    data = bytearray(file.read_bytes())
    at = len(data) // 2
    data[at : at + 4] = bytes(b ^ 0xFF for b in data[at : at + 4])
    file.write_bytes(bytes(data))
    run = read_run(folder)
    assert 10_000 < len(run["thruster_0/state.n"]) < 20_000
    assert any("damaged" in w or "decompressed" in w for w in run.warnings)


def test_messages_whose_channel_nothing_describes_are_counted_and_the_others_are_read(tmp_path):
    file = tmp_path / "x.mcap"
    journal(file, chunked=False)
    data = bytearray(file.read_bytes())
    at, message = 8, []
    while data[at] != 15:
        message += [at] if data[at] == 5 else []
        at += 9 + struct.unpack_from("<Q", data, at + 1)[0]
    struct.pack_into("<H", data, message[100] + 9, 77)
    file.write_bytes(bytes(data))
    run = read_run(file)
    assert len(run["thruster_0/state.n"]) + len(run["thruster_0/throttle.commanded"]) == 2 * COUNT - 1
    assert "1 messages of channels that the file does not describe were left out" in run.warnings[0]


def test_random_bytes_never_raise_anything_but_a_run_error(tmp_path):
    whole = tmp_path / "whole.mcap"
    journal(whole, chunked=False)
    data = np.frombuffer(whole.read_bytes(), dtype=np.uint8)
    random = np.random.default_rng(2)
    path = tmp_path / "bad.mcap"
    for _ in range(150):
        bad = data.copy()
        at = random.integers(0, len(bad), 3)
        bad[at] = random.integers(0, 256, 3)
        path.write_bytes(bad.tobytes())
        try:
            read_run(path)
        except RunError as error:
            assert str(path) in str(error)


def write_mcap(path, *, schema=b"float64 data\n", name="std_msgs/msg/Float64", encoding="ros2msg", cdr="cdr",
               messages=((1, b"\0\1\0\0" + bytes(8)),)):  # fmt: skip
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/t", cdr, writer.register_schema(name, encoding, schema))
        for stamp, raw in messages:
            writer.add_message(channel, stamp, raw, stamp)
        writer.finish()


@pytest.mark.parametrize(
    ("change", "kind", "sentence"),
    [
        ({"messages": ()}, EmptyRunError, "the run has no message"),
        ({"messages": [(1, b"\0\1\0\0" + b"\xff" * 8)]}, EmptyRunError, "no channel with a measured value"),
        ({"encoding": "protobuf"}, SchemaError, "expected encoding ros2msg or ros2idl, found 'protobuf'"),
        ({"schema": b"float64 data\nother/Thing x\n"}, SchemaError, "lacks other/msg/Thing"),
        ({"schema": b"float64 % no definition\n"}, SchemaError, "cannot parse its ros2msg definition"),
        ({"schema": b"float64[2] data\n"}, SchemaError, "message 0: expected 20 bytes"),
        ({"schema": b"wstring data\n"}, SchemaError, "lacks std_msgs/msg/wstring"),
        ({"cdr": "json"}, SchemaError, "expected encoding cdr, found 'json'"),
        ({"schema": b"", "name": "none/msg/Such"}, SchemaError, "not found; looked in"),
    ],
)
def test_undecodable_files_are_refused_with_file_and_topic(tmp_path, change, kind, sentence):
    path = tmp_path / "x.mcap"
    write_mcap(path, **change)
    with pytest.raises(kind) as caught:
        read_run(path, ["t"])
    assert sentence in str(caught.value) and str(path) in str(caught.value)


def test_an_undecodable_topic_that_was_not_asked_for_is_left_out_with_a_warning(tmp_path):
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        good = writer.register_channel("/g", "cdr", writer.register_schema("a/msg/G", "ros2msg", b"uint8 x\n"))
        bad = writer.register_channel("/b", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"float64 x\n"))
        writer.add_message(good, 1, b"\0\1\0\0\5", 1)
        writer.add_message(bad, 1, b"\0\1\0\0\5", 1)
        writer.finish()
    run = read_run(path)
    assert run["g.x"].values.tolist() == [5] and "topic b" in run.warnings[0]


def test_what_is_no_run_is_refused_with_a_sentence(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    table = [
        (tmp_path / "none", "no such file or directory"),
        (folder, "expected an .mcap file in it, found nothing"),
    ]
    runs = tmp_path / "runs"
    (runs / "one").mkdir(parents=True)
    (runs / "one" / "one.mcap").write_bytes(b"")
    table.append((runs, f"found one; for all runs in it: {runs}/*"))
    (tmp_path / "text.mcap").write_text("hello, this is text")
    (tmp_path / "empty.mcap").write_bytes(b"")
    table += [
        (tmp_path / "text.mcap", "expected an MCAP file"),
        (tmp_path / "empty.mcap", "found an empty file"),
    ]
    lite = tmp_path / "lite"
    lite.mkdir()
    text = "rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n"
    (lite / "metadata.yaml").write_text(text)
    table.append((lite, "expected storage mcap, found sqlite3"))
    for path, sentence in table:
        with pytest.raises(NotARunError) as caught:
            read_run(path)
        assert sentence in str(caught.value) and caught.value.path == path


def test_a_missing_topic_is_answered_with_those_that_are_there(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(3))
    with pytest.raises(MissingTopicError, match="no topic x; it has: thruster_0/gauges") as caught:
        read_run(folder, ["x"])
    assert caught.value.topic == "x"


def test_on_a_topic_that_all_nodes_share_stamps_need_not_follow_each_other(tmp_path):
    kind = "diagnostic_msgs/msg/DiagnosticArray"
    messages = []
    for logged, stamp in ((10, 7), (11, 6), (12, 8)):
        array = DiagnosticArray(status=[DiagnosticStatus(level=b"\1", name="node")])
        array.header.stamp.nanosec = stamp
        messages.append((logged, serialize_message(array)))
    write_mcap(tmp_path / "x.mcap", schema=definitions().text(kind).encode(), name=kind, messages=messages)
    run = read_run(tmp_path / "x.mcap")
    (level,) = (run[name] for name in run)
    assert level.stamps.tolist() == [10, 11, 12]
    assert level.values.tolist() == [1.0, 1.0, 1.0]


def write_stamps(path: Path, stamps: Sequence[int]) -> None:
    kind = "thruster_msgs/msg/ThrustSetpoint"
    raws = []
    for i, stamp in enumerate(stamps):
        (raw,) = check_topic(Topic(name="t", type=kind, stamps=[stamp], fields={"thrust": [float(i)]})).payloads(0, 1)
        raws.append((i, raw))
    write_mcap(path, schema=definitions().text(kind).encode(), name=kind, messages=raws)


def test_messages_that_overtook_each_other_are_brought_into_order(tmp_path: Path) -> None:
    write_stamps(tmp_path / "x.mcap", (5_000_000, 9_000_000, 6_000_000, 7_000_000, 10_000_000))
    run = read_run(tmp_path / "x.mcap")
    assert run["t.thrust"].stamps.tolist() == [5_000_000, 6_000_000, 7_000_000, 9_000_000, 10_000_000]
    assert run["t.thrust"].values.tolist() == [0.0, 2.0, 3.0, 1.0, 4.0]
    assert any("2 of 5 messages came up to 3 ms after later ones" in text for text in run.warnings)


def test_stamps_that_run_backwards_are_refused_with_position_and_both_stamps(tmp_path):
    write_stamps(tmp_path / "x.mcap", (5, 700_000_000, 6))
    with pytest.raises(StampOrderError, match="backwards at message 2: 700000000 ns, then 6 ns") as caught:
        read_run(tmp_path / "x.mcap")
    assert (caught.value.position, caught.value.expected, caught.value.found, caught.value.topic) == (
        2,
        700_000_000,
        6,
        "t",
    )


def test_a_chunk_that_claims_to_be_huge_is_refused_before_it_is_unpacked(tmp_path):
    body = struct.pack("<QQQI", 0, 0, 1 << 40, 0) + struct.pack("<I", 4) + b"zstd" + struct.pack("<Q", 0)
    path = tmp_path / "x.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body)
    with pytest.raises(TooLargeError, match="a chunk of 1099511627776 bytes"):
        read_run(path)


def test_metadata_that_is_broken_does_not_hide_the_messages(tmp_path):
    folder = write_run(tmp_path / "a", bench_topics(3))
    for text in ("{ this is: [no yaml", "", "a: 2001-99-99", "[" * 5000, "rosbag2_bagfile_information: 3"):
        (folder / "metadata.yaml").write_text(text)
        run = read_run(folder)
        assert len(run["thruster_0/state.n"]) == 3
        assert len(run.warnings) == 1 and "metadata.yaml cannot be used" in run.warnings[0]
        assert "\n" not in run.warnings[0]
    shutil.move(folder / "a_0.mcap", tmp_path / "alone.mcap")
    assert read_run(tmp_path / "alone.mcap").name == "alone"
