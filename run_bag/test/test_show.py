"""The channels of a run as plots in one file."""

import numpy as np
import pytest

from run_bag import Topic, write_run
from run_bag.benchmark import bench_topics
from run_bag.cli_show import main


def vehicle(folder):
    stamps = 10**9 + np.arange(100) * 10**7
    wave = np.sin(np.arange(100) / 10)
    topics = [
        Topic(name="rov/odometry", type="nav_msgs/Odometry", stamps=stamps,
              fields={"pose.pose.position.x": wave, "pose.pose.position.y": 2 * wave, "twist.twist.angular.z": wave}),
        Topic(name="rov/depth", type="thruster_msgs/Depth", stamps=stamps, fields={"depth": 1 + wave}),
        *(Topic(name=f"thruster_{i}/throttle", type="thruster_msgs/Throttle", stamps=stamps,
                fields={"commanded": wave}) for i in range(6)),
    ]  # fmt: skip
    return write_run(folder, topics, {"what": "<b>a dive</b>"})


def test_a_vehicle_s_run_is_drawn_by_thruster_and_quantity(tmp_path, capsys):
    run = vehicle(tmp_path / "dive")
    assert main([str(run)]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "dive.html")
    page = (tmp_path / "dive.html").read_text()
    for text in ("odometry.pose.pose.position", "depth.depth", "thruster_5", "throttle.commanded", "[V]", "[m]"):
        assert text in page
    assert "<b>a dive</b>" not in page and "&lt;b&gt;a dive" in page
    assert str(tmp_path) not in page
    assert main([str(run)]) == 1
    assert "dive.html exists; nothing is overwritten" in capsys.readouterr().err


def test_a_bench_run_is_drawn_with_gaps_and_only_the_topics_asked_for(tmp_path, capsys):
    run = write_run(tmp_path / "a", bench_topics(5000))
    out = tmp_path / "load.html"
    assert main([str(run), "--topics", "thruster_0/load", "--out", str(out)]) == 0
    page = out.read_text()
    assert "load.wrench.force" in page and "thruster_0/state.n" not in page
    assert out.stat().st_size < 6_000_000


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["none"], "none: no such file or directory"),
        (["a", "--out", "no/such/x.html"], "expected an existing folder"),
        (["a", "--topics", "nothing"], "no topic nothing"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_a_sentence(tmp_path, capsys, monkeypatch, arguments, sentence):
    monkeypatch.chdir(tmp_path)
    write_run(tmp_path / "a", bench_topics(5))
    assert main(arguments) == 1
    assert sentence in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_what_a_damaged_run_lost_is_said_on_the_screen_too(tmp_path, capsys):
    whole = write_run(tmp_path / "a", bench_topics(50_000))
    (data,) = whole.glob("*.mcap")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data.read_bytes()[: data.stat().st_size // 2])
    assert main([str(cut)]) == 0
    assert "warning: cut.mcap: " in capsys.readouterr().err
