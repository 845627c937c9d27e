"""What was run survives whatever is done to a bag; two clocks in one bag are told."""

import json
import shutil

import numpy as np
import pytest
from foreign_recordings import ros2_bag
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.rosbag2 import StoragePlugin

from run_bag import ClockError, Topic, read_run, write_run
from run_bag.cli_info import main as info
from run_bag.finishing import recover
from run_bag.reader import read_recording
from run_bag.run_metadata import TOPIC
from safe_files.yaml_io import read_yaml

TOLD = {"seed": 3, "hold": {"throttle": "previous"}, "text": "µ 'quoted': {}"}
STAMPS = np.arange(1, 6) * 10**9


def run_at(folder, *topics, told=None):
    made = [
        Topic(name=n, type="thruster_msgs/Throttle", stamps=stamps, fields={"commanded": np.arange(5.0)})
        for n, stamps in topics
    ]
    return write_run(folder, made, told)


def converted(bag, target):
    """Copy messages, schemas and channels alone, as stock conversion does: no metadata, no custom data."""
    target.mkdir()
    with next(bag.glob("*.mcap")).open("rb") as file, (target / "x_0.mcap").open("wb") as out:
        writer = Writer(out)
        writer.start()
        known = {}
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.id not in known:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                known[channel.id] = writer.register_channel(channel.topic, "cdr", number, channel.metadata)
            writer.add_message(known[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()
    return target


def test_metadata_are_read_from_the_message_that_conversion_keeps(tmp_path):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS), told=TOLD)
    assert read_run(converted(bag, tmp_path / "b")).metadata == TOLD
    assert read_run(bag).metadata == TOLD and TOPIC.strip("/") not in str(list(read_run(bag)))


def test_metadata_are_read_from_custom_data_where_nothing_else_is_left(tmp_path):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS), told=TOLD)
    plain = converted(run_at(tmp_path / "b", ("thruster_0/throttle", STAMPS)), tmp_path / "c")
    assert read_run(plain).metadata == {}
    text = (bag / "metadata.yaml").read_text().replace("a_0.mcap", "x_0.mcap")
    (plain / "metadata.yaml").write_text(text)
    assert read_run(plain).metadata == TOLD
    assert json.loads(read_yaml(bag / "metadata.yaml")["rosbag2_bagfile_information"]["custom_data"]["run"]) == TOLD


def test_recovery_keeps_what_was_run_and_adds_to_it(tmp_path):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS), told=TOLD)
    lone = converted(bag, tmp_path / "b")
    done = recover(lone, tmp_path / "c", about={"more": 1})
    assert done.messages == 5 and read_run(tmp_path / "c").metadata == {**TOLD, "more": 1}
    assert read_run(converted(tmp_path / "c", tmp_path / "d")).metadata == {**TOLD, "more": 1}
    assert len(read_recording(tmp_path / "d").scans[0].told) == 1


def test_a_recording_without_metadata_says_so(tmp_path, capsys):
    assert info([str(ros2_bag(tmp_path / "x", StoragePlugin.MCAP))]) == 0
    assert "nothing says what was run" in capsys.readouterr().out


@pytest.mark.parametrize(
    "text",
    ['{"a": ' * 100_000, "[" * 500 + "]" * 500, '{"a": "\\ud800"}', '{"a": 1e999}', "{", '"\udc80"', '{"a": NaN}'],
)
def test_metadata_that_make_no_sense_are_a_warning(tmp_path, text):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS))
    file = bag / "metadata.yaml"
    described = file.read_text().replace("custom_data: null", "custom_data: {run: " + json.dumps(text) + "}")
    file.write_text(described, "utf-8", "surrogatepass")
    run = read_run(bag)
    assert run["thruster_0/throttle.commanded"].values.size == 5
    assert any("metadata" in w for w in run.warnings) or run.metadata == {"a": "NaN"}


@pytest.mark.parametrize("imported", [None, 3, "x", [], {"sources": None, "decisions": 3}, {"decisions": [None, "x"]}])
def test_a_record_of_an_import_in_another_form_is_printed_as_it_is(tmp_path, capsys, imported):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS), told={"import": imported})
    assert info([str(bag)]) == 0
    assert "thruster_0/throttle.commanded" in capsys.readouterr().out


WALL = STAMPS + 1_700_000_000 * 10**9


def test_of_two_clocks_that_of_the_used_topics_counts(tmp_path):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS), ("thruster_0/throttle_sent", STAMPS), ("other", WALL))
    run = read_run(bag)
    assert run.duration == 4.0 and "other.commanded" not in run
    (warning,) = run.warnings
    assert "2 clocks: /thruster_0/throttle, /thruster_0/throttle_sent from 1.000 s (simulated time) on" in warning
    assert "/other from 2023-11-14 22:13:21 (wall time) on" in warning


def test_used_topics_on_two_clocks_are_refused_in_a_sentence_that_names_both(tmp_path, capsys):
    bag = run_at(tmp_path / "a", ("thruster_0/throttle", STAMPS), ("thruster_0/throttle_sent", WALL))
    with pytest.raises(ClockError, match=r"expected one clock, found 2: /thruster_0/throttle from 1.000 s \(simulated"):
        read_run(bag)
    assert read_run(bag, ["thruster_0/throttle"]).duration == 4.0
    assert info([str(bag)]) == 1 and "wall time" in capsys.readouterr().err


def test_a_storage_that_is_not_read_comes_with_the_command_that_converts_it(tmp_path):
    bag = ros2_bag(tmp_path / "x", StoragePlugin.SQLITE3)
    from run_bag import NotARunError

    with pytest.raises(NotARunError, match=r"ros2 bag convert -i .*x sqlite3 -o convert.yaml"):
        recover(bag, tmp_path / "y")
    shutil.rmtree(bag)
