"""A copy with other stamps: messages, log times and all else stay."""

import numpy as np
import pytest

from run_bag import RunExistsError, Topic, read_run, write_run
from run_bag.restamping import restamp

STAMPS = 1_000_000_000 + 10_000_000 * np.arange(50)


@pytest.fixture
def run(tmp_path):
    topics = [
        Topic(name=name, type="thruster_msgs/ThrusterState", stamps=STAMPS, fields={"n": np.arange(50.0)}, frame="a")
        for name in ("thruster_0/state", "thruster_1/state")
    ]
    return write_run(tmp_path / "run", topics, {"seed": 3})


def late(stamps):
    topic = next(name for name in stamps if name.endswith("thruster_0/state"))
    sources = np.arange(50)
    sources[10:13] = 9
    return {topic: (stamps[topic] + 5_000_000, sources)}


def test_the_named_topic_has_new_stamps_and_repeats_and_the_others_are_as_they_were(run, tmp_path):
    before = read_run(run)
    done = restamp(run, tmp_path / "late", late, {"clock": "another"})
    assert (done.messages, done.warnings) == (100, ())
    found = read_run(tmp_path / "late")
    assert found.warnings == ()
    assert found.metadata == {"seed": 3, "clock": "another"}
    np.testing.assert_array_equal(found["thruster_0/state.n"].stamps, STAMPS + 5_000_000)
    np.testing.assert_array_equal(found["thruster_0/state.n"].values[8:15], [8, 9, 9, 9, 9, 13, 14])
    for name in ("thruster_1/state.n", "thruster_0/state.n"):
        np.testing.assert_array_equal(read_run(run)[name].stamps, before[name].stamps)
    np.testing.assert_array_equal(found["thruster_1/state.n"].stamps, STAMPS)
    np.testing.assert_array_equal(found["thruster_1/state.n"].values, np.arange(50.0))


def test_nothing_is_overwritten(run, tmp_path):
    with pytest.raises(RunExistsError):
        restamp(run, run, late)
