"""The scene of a run, as the real recorder keeps it, and the ready layouts: all that they name is in the recording."""

import json
import re
import struct
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from tf2_msgs.msg import TFMessage
from vehicle_run import THRUSTERS, Circle, topics

from rov_sim.vehicle.layout_io import layout_of
from rov_sim.vehicle.scene import Layout
from rov_sim.vehicle.scene_node import SceneNode
from run_bag import Run, read_run, write_run
from run_bag.live.raw_topic import message_class
from run_bag.live.recorder_node import RecorderNode
from run_bag.mcap_scan import scan
from run_bag.reader import read_recording
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.qos import RECORDER

CONFIG = Path(__file__).parents[1] / "config"
DRAWN = {"/tf": "tf2_msgs/msg/TFMessage", "/rov/attitude": "geometry_msgs/msg/Vector3Stamped",
         "/rov/path": "nav_msgs/msg/Path", "/rov/scene": "visualization_msgs/msg/MarkerArray"}  # fmt: skip
TURN = 2.0 * np.pi * np.arange(THRUSTERS) / THRUSTERS
LAYOUT = Layout(
    0.3 * np.stack([np.cos(TURN), np.sin(TURN), 0.0 * TURN], axis=1),
    np.stack([-np.sin(TURN), np.cos(TURN), 0.0 * TURN], axis=1),
)


def played(run: Path) -> list[tuple[str, str, bytes]]:
    """Return (topic, type, payload) of a run in the order of the file."""
    found: list[tuple[str, str, bytes]] = []
    for one in read_recording(run, set()).scans:
        scan(one.path, receive=lambda m, raw: found.append((raw.topic, raw.schema.name, m.payload)))  # type: ignore[union-attr]
    return found


def stamp_of(payload: bytes) -> int:
    """Return the stamp [ns] of a message whose first field is its header."""
    seconds, rest = struct.unpack_from("<iI", payload, 4)
    return int(seconds) * 1_000_000_000 + int(rest)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A second of a dive, sent through the graph with the scene beside it, as the recorder kept it."""
    folder = tmp_path_factory.mktemp("scene")
    sent = played(write_run(folder / "dive", topics(Circle(1.0))))
    context = Context()
    rclpy.init(args=[], context=context)
    executor = make_executor("events", context=context)
    out = [Parameter("out", value=str(folder / "recorded"))]
    look = [Parameter("path_period", value=0.2), Parameter("path_spacing", value=0.001)]
    recorder = RecorderNode(context=context, parameter_overrides=out)
    nodes: list[Node] = [
        recorder,
        SceneNode(layout=LAYOUT, context=context, parameter_overrides=look),
        Node("diver", context=context),
    ]
    for node in nodes:
        executor.add_node(node)
    publishers: dict[str, Any] = {}
    for topic, kind, _ in sent:
        if topic not in publishers:
            publishers[topic] = nodes[2].create_publisher(message_class(kind), topic, RECORDER)
    heard = {"/rov/odometry", *(t for t in publishers if t.endswith(("/thrust_setpoint", "truth")) and "rov" not in t)}
    assert spin_until(
        executor,
        lambda: (
            all(p.get_subscription_count() >= 1 + (t in heard) for t, p in publishers.items())
            and all(nodes[1].count_subscribers(t) for t in DRAWN)
        ),
        20.0,
    )
    framed: list[TFMessage] = []
    nodes[2].create_subscription(TFMessage, "/tf", framed.append, RECORDER)
    assert spin_until(executor, lambda: nodes[1].count_subscribers("/tf") == 2, 20.0)
    poses = 0
    for topic, _, payload in sorted(sent, key=lambda one: (stamp_of(one[2]), one[0] == "/rov/odometry")):
        publishers[topic].publish(payload)
        if topic == "/rov/odometry":  # the last of its instant
            poses += 1
            assert spin_until(executor, lambda poses=poses: len(framed) >= poses, 20.0)
    before = -1
    while recorder.journal.messages != before:  # until nothing more comes
        before, end = recorder.journal.messages, time.monotonic() + 0.5
        spin_until(executor, lambda end=end: time.monotonic() > end, 5.0)
    recorder.on_stop()
    for node in nodes:
        executor.remove_node(node)
        node.destroy_node()
    executor.shutdown()
    rclpy.try_shutdown(context=context)
    yield folder / "recorded"


@pytest.fixture(scope="module")
def run(recorded: Path) -> Run:
    return read_run(recorded)


def test_frames_path_and_arrows_are_recorded_as_what_viewers_know(recorded: Path) -> None:
    found = {topic: kind for topic, kind, _ in played(recorded)}
    assert {topic: found.get(topic) for topic in DRAWN} == DRAWN


def test_such_a_run_reads_and_its_pictures_are_left_out_unless_asked_for(run: Run, recorded: Path) -> None:
    assert not [name for name in run if name.startswith(("rov/path", "rov/scene"))]
    assert run.warnings == ()
    assert "rov/scene.markers[0].scale.x" in read_run(recorded, ["rov/scene"])


def test_every_pose_has_its_frames_and_angles(run: Run) -> None:
    circle = Circle(1.0)
    assert run["tf.transforms[0].transform.translation.x"].values == pytest.approx(circle.position[:, 1], abs=0.05)
    assert run["tf.transforms[0].transform.translation.z"].values == pytest.approx(-circle.position[:, 2], abs=0.05)
    assert run["tf.transforms[0].transform.translation.z"].unit == "m"
    assert run["rov/attitude.vector.y"].values == pytest.approx(circle.angles[:, 1], abs=1e-9)


def test_each_thruster_has_its_arrow(recorded: Path) -> None:
    from rclpy.serialization import deserialize_message
    from visualization_msgs.msg import Marker, MarkerArray

    payloads = [payload for topic, _, payload in played(recorded) if topic == "/rov/scene"]
    assert 8 <= len(payloads) <= 11, "ten a second"
    last = deserialize_message(payloads[-1], MarkerArray)
    drawn = [(m.ns, m.id) for m in last.markers if m.action == Marker.ADD]
    assert {("hull", 0), *(("thrust", k) for k in range(THRUSTERS))} - set(drawn) <= {("thrust", 0)}, (
        "sin(0) is no thrust"
    )
    arrow = next(m for m in last.markers if (m.ns, m.id) == ("thrust", 2))
    assert arrow.header.frame_id == "base_link_frd"
    start, end = (np.array([p.x, p.y, p.z]) for p in arrow.points)
    assert start == pytest.approx(LAYOUT.positions[2])
    assert np.linalg.norm(end - start) == pytest.approx(0.03 * 4.0 * abs(np.sin(2.0 + 0.45)), rel=0.05)


def test_foreign_frames_are_not_drawn_and_the_node_says_so(context: Context, spun: Callable[..., Executor]) -> None:
    from diagnostic_msgs.msg import DiagnosticArray
    from nav_msgs.msg import Odometry

    scene = SceneNode(layout=LAYOUT, context=context)
    other = Node("other", context=context)
    heard: dict[str, list[Any]] = {"/tf": [], "/diagnostics": []}
    for topic, kind in (("/tf", TFMessage), ("/diagnostics", DiagnosticArray)):
        other.create_subscription(kind, topic, heard[topic].append, RECORDER)
    poses = other.create_publisher(Odometry, "rov/odometry", RECORDER)
    executor = spun(scene, other)
    assert spin_until(executor, lambda: poses.get_subscription_count() > 0 and scene.count_subscribers("/tf") > 0, 20.0)
    pose = Odometry(child_frame_id="base_link")
    pose.header.frame_id = "odom"
    poses.publish(pose)
    assert spin_until(executor, lambda: bool(heard["/diagnostics"]), 20.0)
    assert "expected map_ned and base_link_frd; found odom and base_link" in heard["/diagnostics"][0].status[0].message
    assert heard["/tf"] == []


@pytest.mark.parametrize(("vehicle", "count"), [("ngs", 6), ("bluerov2_heavy", 8)])
def test_thrusters_are_where_the_vehicle_set_says(vehicle: str, count: int) -> None:
    layout = layout_of(vehicle)
    assert layout.positions.shape == layout.axes.shape == (count, 3)
    assert np.linalg.norm(layout.axes, axis=1) == pytest.approx(np.ones(count))
    assert layout.axes[-1, 2] < -0.9, "the last of either pushes up"


def test_a_vehicle_that_is_unknown_is_refused(context: Context) -> None:
    with pytest.raises(StartRefused, match="vehicle: "):
        SceneNode(context=context, parameter_overrides=[Parameter("vehicle", value="submarine")])


# ---- the ready layouts


def foxglove() -> dict[str, Any]:
    return dict(json.loads((CONFIG / "foxglove.json").read_text("utf-8")))


def panels_in(layout: Any) -> set[str]:
    """Return the panels that a layout shows, those of its tabs too."""
    if isinstance(layout, str):
        tabs = foxglove()["configById"][layout].get("tabs", [])
        return {layout}.union(*(panels_in(tab["layout"]) for tab in tabs))
    assert set(layout) == {"first", "second", "direction", "splitPercentage"}
    return panels_in(layout["first"]) | panels_in(layout["second"])


def test_foxglove_shows_every_panel_that_it_configures_and_no_other() -> None:
    assert panels_in(foxglove()["layout"]) == set(foxglove()["configById"])


def test_every_line_of_the_foxglove_layout_is_a_channel_of_a_recorded_run(run: Run) -> None:
    plots = [panel for name, panel in foxglove()["configById"].items() if name.startswith("Plot!")]
    lines = [line["value"] for panel in plots for line in panel["paths"]]
    assert len(lines) > 40
    assert [line for line in lines if not line.startswith("/") or line[1:] not in run] == []


def test_everything_that_the_foxglove_scene_shows_is_recorded(recorded: Path, run: Run) -> None:
    scene = foxglove()["configById"]["3D!scene"]
    assert set(scene["topics"]) <= {topic for topic, _, _ in played(recorded)}
    assert scene["followTf"] == "base_link" and scene["layers"]["grid"]["frameId"] == "map"
    assert foxglove()["configById"]["DiagnosticSummary!nodes"]["topicToRender"] == "/diagnostics"


def test_every_curve_of_the_plotjuggler_layout_is_a_channel_of_a_recorded_run(run: Run) -> None:
    curves = ElementTree.parse(CONFIG / "plotjuggler.xml").getroot().iter("curve")
    names = [str(curve.get("name")) for curve in curves]
    channels = {re.sub(r"\.", "/", f"/{name}") for name in run}
    assert len(names) > 40
    assert [name for name in names if name not in channels] == []


def test_both_layouts_show_the_same() -> None:
    plots = [panel for name, panel in foxglove()["configById"].items() if name.startswith("Plot!")]
    one = {line["value"].replace(".", "/") for panel in plots for line in panel["paths"]}
    assert one == {c.get("name") for c in ElementTree.parse(CONFIG / "plotjuggler.xml").getroot().iter("curve")}


def test_plotjuggler_s_splits_add_up() -> None:
    for split in ElementTree.parse(CONFIG / "plotjuggler.xml").getroot().iter("DockSplitter"):
        sizes = [float(size) for size in str(split.get("sizes")).split(";")]
        assert len(sizes) == int(str(split.get("count"))) == len(list(split))
        assert sum(sizes) == pytest.approx(1.0, abs=1e-4)
