"""The navigation's wires: one test for each topic, what is told on diagnostics, and what is refused."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Imu

from thruster_estimation.navigation_node import NavigationNode
from thruster_estimation.navigation_parameters import NAVIGATION_PARAMETERS
from thruster_msgs.msg import Depth
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE

TICK = 10_000_000  # ns
AT_ORIGIN = {f"{sensor}_{axis}": 0.0 for sensor in ("imu", "velocity", "depth") for axis in "xyz"}


class Scene:
    """A navigation, and a node that plays the sensors."""

    def __init__(self, context: Context, spun: Callable[..., Executor], **values: Any) -> None:
        overrides = [Parameter(name, value=value) for name, value in {**AT_ORIGIN, **values}.items()]
        self.subject = NavigationNode(context=context, parameter_overrides=overrides)
        self.rest = Node("rest", context=context)
        kinds = {"imu": Imu, "velocity": TwistWithCovarianceStamped, "depth": Depth}
        self.kinds = kinds
        self.sent = {name: self.rest.create_publisher(kind, f"rov/{name}", RELIABLE) for name, kind in kinds.items()}
        self.found: list[Odometry] = []
        self.enu: list[Odometry] = []
        self.told: list[DiagnosticArray] = []
        self.rest.create_subscription(Odometry, "rov/odometry", self.found.append, RELIABLE)
        self.rest.create_subscription(Odometry, "rov/odometry_enu", self.enu.append, RELIABLE)
        self.rest.create_subscription(DiagnosticArray, "/diagnostics", self.told.append, RELIABLE)
        self.executor = spun(self.subject, self.rest)
        ends = [*self.sent.values(), *(p for p in self.subject.publishers if "rosout" not in p.topic_name)]
        ends = [p for p in ends if "parameter_events" not in p.topic_name]
        assert spin_until(self.executor, lambda: all(p.get_subscription_count() for p in ends), 10.0)

    def send(self, name: str, k: int, message: Any) -> None:
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(k * TICK, 10**9)
        self.sent[name].publish(message)

    def imu(self, k: int, **fields: float) -> None:
        message = Imu()
        message.orientation.w = fields.get("w", 1.0)
        message.angular_velocity.z = fields.get("r", 0.0)
        message.linear_acceleration.x, message.linear_acceleration.z = fields.get("force", 0.0), -9.81
        self.send("imu", k, message)

    def velocity(self, k: int, surge: float) -> None:
        message = TwistWithCovarianceStamped()
        message.twist.twist.linear.x = surge
        self.send("velocity", k, message)

    def depth(self, k: int, depth: float) -> None:
        self.send("depth", k, Depth(depth=depth))

    def count(self, expected: int, timeout: float = 5.0) -> bool:
        """Return whether exactly that many estimates come."""
        spin_until(self.executor, lambda: len(self.found) >= expected, timeout)
        spin_until(self.executor, lambda: len(self.found) > expected, 0.1)
        return len(self.found) == expected

    def words(self) -> list[str]:
        return [status.message for array in self.told for status in array.status]


@pytest.fixture
def sailing(context: Context, spun: Callable[..., Executor]) -> Callable[..., Scene]:
    return partial(Scene, context, spun)


FREE = {"velocity_every": 0.0, "depth_every": 0.0}


def test_the_imu_becomes_odometry_at_the_control_rate(sailing: Callable[..., Scene]) -> None:
    scene = sailing(**FREE)
    for k in range(1, 13):
        scene.imu(k, r=0.5)
    assert scene.count(3)
    stamps = [odometry.header.stamp.nanosec for odometry in scene.found]
    assert stamps == [40_000_000, 80_000_000, 120_000_000]
    last = scene.found[-1]
    assert (last.header.frame_id, last.child_frame_id) == ("map_ned", "base_link_frd")
    assert last.twist.twist.angular.z == pytest.approx(0.5, abs=0.01)
    covariance = np.reshape(last.twist.covariance, (6, 6))
    assert np.all(np.linalg.eigvalsh(covariance) > 0.0)
    assert np.all(np.linalg.eigvalsh(np.reshape(last.pose.covariance, (6, 6))) > -1e-15)


def test_an_imu_as_slow_as_the_control_makes_an_estimate_of_each_reading(sailing: Callable[..., Scene]) -> None:
    scene = sailing(**FREE)
    for k in (4, 8, 12):
        scene.imu(k)
    assert scene.count(3)


def test_velocity_and_depth_are_taken_in(sailing: Callable[..., Scene]) -> None:
    scene = sailing(velocity_every=0.04, depth_every=0.04)
    for k in (4, 8):
        scene.imu(k)
        scene.velocity(k, 0.3)
        scene.depth(k, 7.0)
    assert scene.count(2)
    assert scene.found[-1].twist.twist.linear.x == pytest.approx(0.3, abs=0.01)
    assert scene.found[-1].pose.pose.position.z == pytest.approx(7.0, abs=0.05)


def test_an_estimate_waits_for_what_is_due_and_for_nothing_else(sailing: Callable[..., Scene]) -> None:
    scene = sailing(velocity_every=0.08, depth_every=0.0)
    scene.imu(4)
    assert scene.count(1), "no velocity is due before 80 ms"
    scene.imu(8)
    assert scene.count(1)
    scene.velocity(8, 0.2)
    assert scene.count(2)
    assert scene.found[-1].twist.twist.linear.x == pytest.approx(0.2, abs=0.01)
    scene.imu(12)
    assert scene.count(3)


def test_late_readings_count_where_they_belong(sailing: Callable[..., Scene]) -> None:
    """Two graphs, one with a log that is 40 ms late: the same estimate once all has come."""
    results = []
    for late in (0, 4):
        scene = sailing(velocity_every=0.0, depth_every=0.0)
        for k in range(1, 13):
            if k == 4 + late:
                scene.velocity(4, 0.3)
            if k in (4, 8, 12):
                assert spin_until(scene.executor, lambda: False, 0.05) is False
            scene.imu(k, force=0.2)
        assert scene.count(3)
        results.append(scene.found[-1].twist)
    assert results[0] == results[1]
    assert results[0].twist.linear.x == pytest.approx(0.3 + 0.2 * 0.08, abs=0.01)


def test_a_lost_velocity_log_and_depth_are_told_in_words(sailing: Callable[..., Scene]) -> None:
    scene = sailing(**FREE)
    for k in range(0, 240, 4):
        scene.imu(k)
        if k < 100:
            scene.velocity(k, 0.0)
            scene.depth(k, 5.0)
        spin_until(scene.executor, lambda k=k: len(scene.found) > k // 4, 5.0)  # type: ignore[misc]
    assert scene.count(60)
    assert spin_until(scene.executor, lambda: any("no velocity log for too long" in w for w in scene.words()), 5.0)
    assert spin_until(scene.executor, lambda: any("no depth for too long" in w for w in scene.words()), 5.0)


def test_silence_of_the_imu_is_told_from_the_start(sailing: Callable[..., Scene]) -> None:
    scene = sailing(**FREE)
    assert spin_until(scene.executor, lambda: "nothing heard on rov/imu yet" in scene.words(), 5.0)


def test_an_attitude_marked_as_unknown_is_none(sailing: Callable[..., Scene]) -> None:
    scene = sailing(**FREE)
    message = Imu()
    message.orientation.x = 1.0
    message.orientation_covariance[0] = -1.0
    message.linear_acceleration.z = -9.81
    scene.send("imu", 4, message)
    assert scene.count(1)
    assert scene.found[0].pose.pose.orientation.w == 1.0
    assert scene.found[0].pose.covariance[35] == pytest.approx(0.25, rel=1e-3)


def test_readings_that_are_nan_are_none(sailing: Callable[..., Scene]) -> None:
    scene = sailing(velocity_every=0.04, depth_every=0.04)
    for k in (4, 8):
        scene.imu(k)
        scene.velocity(k, math.nan)
        scene.depth(k, math.nan)
    assert scene.count(2)
    assert scene.found[-1].twist.covariance[0] > 0.2


def test_on_request_it_goes_out_in_the_primary_frames_too(sailing: Callable[..., Scene]) -> None:
    scene = sailing(rep103=True, **FREE)
    scene.depth(4, 7.0)
    assert spin_until(scene.executor, lambda: False, 0.05) is False
    scene.imu(4, r=0.5)
    assert spin_until(scene.executor, lambda: bool(scene.enu), 5.0)
    (odometry,) = scene.enu
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "base_link")
    assert odometry.pose.pose.position.z == pytest.approx(-7.0)
    assert odometry.twist.twist.angular.z == pytest.approx(-0.5)
    assert odometry.pose.pose.orientation.z == pytest.approx(math.sqrt(0.5))


def test_sensors_that_start_again_begin_a_new_estimate(sailing: Callable[..., Scene]) -> None:
    scene = sailing(**FREE)
    for k in (100, 104, 4):
        scene.imu(k)
    assert scene.count(3)
    assert scene.found[2].twist.covariance[0] == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"gate": 0.0}, r"gate \[1\]: expected a finite number above 0; found 0.0"),
        ({"imu_x": math.inf}, r"imu_x \[m\]: expected a finite number from -100 up to 100; found inf"),
    ],
    ids=str,
)
def test_wrong_parameters_are_refused_in_a_sentence(context: Context, values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(StartRefused, match=sentence):
        NavigationNode(context=context, parameter_overrides=[Parameter(name, value=v) for name, v in values.items()])


def test_the_parameter_file_holds_every_parameter_at_its_default() -> None:
    file = Path(__file__).parents[1] / "config/navigation.yaml"
    given = yaml.safe_load(file.read_text("utf-8"))["/**"]["ros__parameters"]
    assert {name: str(value) for name, value in given.items()} == {
        p.name: str(p.default) for p in NAVIGATION_PARAMETERS
    }
