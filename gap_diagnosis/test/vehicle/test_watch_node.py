"""The watch's wires: what it hears of each topic, when it looks, and what it says; its arithmetic is tested apart."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import BatteryState, Imu
from std_msgs.msg import Header

from gap_diagnosis.vehicle import watch_node
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.hypotheses import hypotheses
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.watch_node import VehicleWatch
from gap_diagnosis.vehicle.watching import Alarm
from thruster_msgs.msg import Throttle, ThrusterFailure
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamps import nanoseconds

PERIOD, NANO, THRUSTERS = 40_000_000, 1_000_000_000, 6
(LOSS,) = (
    h for h in hypotheses(load_model("ngs"), {}) if (h.effect, h.thruster) == ("thrust_loss", 3)
)  # fmt: skip
WEAK = Alarm(
    failure=LOSS, size=0.25, deviation=0.04, log_ratio=300.0, probability=0.98,
    since=4.0, found=16.0,
)  # fmt: skip


class Told:
    """Stands in for the bank of filters: keeps the pieces, and raises the alarms that it was given."""

    def __init__(self, *_: Any) -> None:
        self.words = "losses"
        self.time, self.pieces, self.alarms, self.begun = 0.0, list[VehicleLog](), list[Alarm](), 0
        self.stuck = dict[str, str]()

    def step(self, piece: VehicleLog) -> list[Alarm]:
        self.time += piece.duration
        self.pieces.append(piece)
        return self.alarms

    def begin(self) -> None:
        self.begun += 1


class Scene:
    """A watch, and a node that plays the vehicle."""

    def __init__(self, context: Context, spun: Callable[..., Executor], **values: Any) -> None:
        overrides = [Parameter(name, value=value) for name, value in {"vehicle": "ngs", **values}.items()]
        self.subject = VehicleWatch(context=context, parameter_overrides=overrides)
        self.rest = Node("rest", context=context)
        self.heard, self.failures, self.told = list[int](), list[ThrusterFailure](), list[DiagnosticArray]()
        topics = [(Throttle, f"thruster_{i}/throttle") for i in range(THRUSTERS)]
        topics += [(Imu, "rov/imu"), (Odometry, "rov/odometry"), (BatteryState, "rov/battery")]
        self.sent = {name: self.rest.create_publisher(kind, name, RELIABLE) for kind, name in topics}
        hear = self.rest.create_subscription
        hear(Header, "watch/watched", lambda told: self.heard.append(nanoseconds(told.stamp)), RELIABLE)
        hear(ThrusterFailure, "rov/thruster_failure", self.failures.append, RELIABLE)
        hear(DiagnosticArray, "/diagnostics", self.told.append, RELIABLE)
        self.executor = spun(self.subject, self.rest)
        ends = [*self.sent.values(), *(p for p in self.subject.publishers if "/rosout" not in p.topic_name)]
        ends = [p for p in ends if "parameter_events" not in p.topic_name]
        assert spin_until(self.executor, lambda: all(p.get_subscription_count() for p in ends), 10.0)

    @property
    def watch(self) -> Any:
        return self.subject._watch

    def send(self, topic: str, stamp: int, message: Any) -> None:
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, NANO)
        self.sent[topic].publish(message)

    def sail(
        self, begin: int, end: int, apart: int = 0, speaking: tuple[int, ...] = tuple(range(THRUSTERS))
    ) -> None:  # fmt: skip
        """Play these periods: IMU and throttles, each thruster's stamped so much [ns] after the one before."""
        for k in range(begin, end):
            stamp = NANO + k * PERIOD
            imu = Imu()
            imu.orientation.w, imu.angular_velocity.x = 0.0, 0.01 * k  # it tells no attitude
            self.send("rov/imu", stamp, imu)
            for i in speaking:
                self.send(f"thruster_{i}/throttle", stamp + i * apart, Throttle(commanded=1.0 + i))
            expected = [stamp + i * apart for i in speaking]
            assert spin_until(self.executor, lambda: self._has(stamp, speaking, expected), 10.0)  # noqa: B023

    def _has(self, stamp: int, speaking: tuple[int, ...], expected: list[int]) -> bool:
        feed = self.subject._feed
        return feed._newest >= stamp and [feed._throttles.get(i) for i in speaking] == expected

    def looked(self, pieces: int) -> bool:
        return spin_until(self.executor, lambda: len(self.watch.pieces) >= pieces, 10.0)

    def said(self, words: str) -> bool:
        return spin_until(self.executor, lambda: any(words in s.message for a in self.told for s in a.status), 10.0)

    def values(self) -> dict[str, str]:
        return {each.key: each.value for each in self.told[-1].status[0].values}


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch, context: Context, spun: Callable[..., Executor]) -> Scene:
    monkeypatch.setattr(watch_node, "read_logs", lambda _, model: ([], model))
    monkeypatch.setattr(watch_node, "baseline", lambda *_: SimpleNamespace(doubt=""))
    monkeypatch.setattr(watch_node, "Watch", Told)
    return Scene(context, spun, report_failures=True, baseline="healthy")


def test_without_a_baseline_it_does_not_start_and_says_why(context: Context) -> None:
    given = [Parameter("vehicle", value="ngs")]
    with pytest.raises(StartRefused, match="parameter baseline: expected a run of the healthy vehicle; found none"):
        VehicleWatch(context=context, parameter_overrides=given)


@pytest.mark.parametrize("apart", [0, 1_000_000])
def test_it_looks_each_second_however_throttles_are_stamped(scene: Scene, apart: int) -> None:
    scene.sail(0, 110, apart)
    assert scene.looked(4)
    for piece in scene.watch.pieces:
        assert piece.throttles[5] == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert scene.said("well")


def test_each_instant_is_answered_once_when_the_last_throttle_of_it_has_come(scene: Scene) -> None:
    scene.sail(0, 10)
    assert spin_until(scene.executor, lambda: len(scene.heard) >= 10, 10.0)
    scene.sail(10, 11, speaking=tuple(range(THRUSTERS - 1)))
    spin_until(scene.executor, lambda: len(scene.heard) > 10, 0.2)
    assert scene.heard == [NANO + k * PERIOD for k in range(10)]


def test_a_silent_throttle_is_named_while_the_others_are_watched(scene: Scene) -> None:
    scene.sail(0, 30)
    scene.sail(30, 160, speaking=(0, 1, 2, 3, 5))
    assert scene.looked(4)
    assert scene.said("thruster 4: no throttle, counts as zero")
    assert scene.watch.pieces[-1].throttles[-1] == pytest.approx([1.0, 2.0, 3.0, 4.0, 0.0, 6.0])


def test_a_sensor_that_tells_nothing_new_is_said_beside_a_silent_throttle(scene: Scene) -> None:
    scene.watch.stuck = {"depth": "depth: nothing new for 7 s; it is left out"}
    scene.sail(0, 60)
    assert scene.said("depth: nothing new for 7 s; it is left out")
    scene.sail(60, 190, speaking=(0, 1, 2, 3, 5))
    assert scene.said("thruster 4: no throttle, counts as zero; depth: nothing new for 7 s; it is left out")


def test_without_any_throttle_nothing_is_watched_and_all_begins_anew(scene: Scene) -> None:
    scene.sail(0, 60)
    scene.sail(60, 200, speaking=())
    assert scene.said("not watching: all throttles are silent")
    assert scene.watch.begun > 0
    seen = len(scene.watch.pieces)
    scene.sail(200, 330)
    assert scene.looked(seen + 3)


def test_an_alarm_says_what_how_sure_and_how_late_and_what_false_alarms_there_are(scene: Scene) -> None:
    scene.watch.alarms = [WEAK]
    scene.sail(0, 60)
    assert scene.said("thruster 3: loses 25 ± 4 % thrust, p 0.98; 12 s after it began")
    assert scene.values()["false alarms [1/h]"] == "0.09 (less than 0.14 at 95 %, 173 h counted)"
    assert scene.values()["probability of thrust_loss 3 share [1]"] == "0.98"
    assert spin_until(scene.executor, lambda: bool(scene.failures), 10.0)
    (failure,) = scene.failures
    assert (failure.thruster, failure.kind, failure.effectiveness) == (3, ThrusterFailure.KIND_WEAK, 0.75)


def test_an_alarm_and_a_sensor_that_tells_nothing_new_are_said_together(scene: Scene) -> None:
    scene.watch.alarms = [WEAK]
    scene.watch.stuck = {"velocity": "velocity: nothing new for 5 s; it is left out"}
    scene.sail(0, 60)
    assert scene.said("12 s after it began; velocity: nothing new for 5 s; it is left out")


def test_attitude_of_odometry_and_the_battery_are_read_as_in_a_recording(scene: Scene) -> None:
    for k in range(110):
        stamp = NANO + k * PERIOD
        odometry = Odometry()
        odometry.pose.pose.orientation.w, odometry.pose.pose.orientation.x = np.cos(0.002 * k), np.sin(0.002 * k)
        scene.send("rov/odometry", stamp, odometry)
        scene.send("rov/battery", stamp, BatteryState(voltage=16.0, current=-5.0 - 0.01 * k))
        scene.sail(k, k + 1)
    assert scene.looked(4)
    last = scene.watch.pieces[-1]
    assert last.attitude[10, 1] == pytest.approx(np.sin(0.002 * 85), abs=1e-3)
    assert last.battery[10] == pytest.approx([16.0, 5.85], abs=1e-3)
