"""Runs side by side: equal is equal to the bit; what differs is found by its stamp, and how much."""

from pathlib import Path

import numpy as np
import pytest

from run_bag import Topic, write_run
from run_bag.cli_compare import main
from run_bag.comparison import TopicDifference, compared
from run_bag.reader import read_run

SECOND = 1_000_000_000


def run_of(folder: Path, n: list[float], times: list[int] | None = None) -> Path:
    stamps = SECOND + 40_000_000 * np.array(range(len(n)) if times is None else times)
    state = {"n": np.array(n), "supply_voltage": np.full(len(n), 12.0)}
    topics = [
        Topic(name="thruster_0/state", type="thruster_msgs/ThrusterState", stamps=stamps, fields=state),
        Topic(name="rov/depth", type="thruster_msgs/Depth", stamps=stamps, fields={"depth": np.arange(len(n)) * 1.0}),
    ]
    return write_run(folder, topics)


def test_a_run_is_equal_to_itself_what_was_not_measured_too(tmp_path: Path) -> None:
    one, other = (run_of(tmp_path / name, [1.0, np.nan, 3.0]) for name in "ab")
    found = compared(read_run(one), read_run(other))
    assert [(each.topic, each.both, each.differ) for each in found] == [("rov/depth", 3, 0), ("thruster_0/state", 3, 0)]
    assert main([str(one), str(other)]) == 0


def test_what_differs_is_found_by_its_stamp_and_told_by_how_much(tmp_path: Path) -> None:
    one = run_of(tmp_path / "a", [1.0, 2.0, 3.0, 4.0], [0, 1, 2, 3])
    other = run_of(tmp_path / "b", [2.0, 3.5, 4.0, 9.0], [1, 2, 3, 5])
    (found,) = compared(read_run(one), read_run(other), ["thruster_0/state"])
    assert found == TopicDifference("thruster_0/state", 3, 1, 1, 1, "thruster_0/state.n", 0.5)
    (near,) = compared(read_run(one), read_run(other), ["thruster_0/state"], tolerance=0.2)
    assert near.differ == 0, "0.5 of 3"


def test_what_one_run_has_not_measured_differs(tmp_path: Path) -> None:
    one, other = run_of(tmp_path / "a", [1.0, 2.0]), run_of(tmp_path / "b", [1.0, np.nan])
    (found,) = compared(read_run(one), read_run(other), ["thruster_0/.*"], tolerance=1.0)
    assert (found.differ, found.channel) == (1, "thruster_0/state.n") and np.isnan(found.largest)


def test_the_command_says_which_topics_differ_and_its_status_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, other = run_of(tmp_path / "a", [1.0, 2.0]), run_of(tmp_path / "b", [1.0, 2.5, 3.0])
    assert main([str(one), str(other)]) == 1
    printed = capsys.readouterr().out
    assert "thruster_0/state.n by 0.5" in printed and "1 messages differ, 2 are in one run alone" in printed
    assert main([str(one), str(other), "--within", "--exclude", "thruster_0/state"]) == 0
    assert main([str(one), str(other), "--topics", "rov/nothing"]) == 1
    assert "no message of one stamp and topic is in both" in capsys.readouterr().err
    assert main([str(one), str(tmp_path / "c")]) == 1
