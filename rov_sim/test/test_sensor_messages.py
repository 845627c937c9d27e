"""Readings as messages: one test for each wire."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, Imu
from vehicle_motion import at, moving

from rov_sim.vehicle.sensor_messages import SensorPublishers
from rov_sim.vehicle.sensors.live import Reading, Sensors
from rov_sim.vehicle.sensors.settings_io import load_sensors
from thruster_msgs.msg import Depth, ThrusterState
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE

SENSORS = load_sensors()
Spun = Callable[..., Executor]
TOPICS = {
    "rov/imu": Imu, "rov/velocity": TwistWithCovarianceStamped, "rov/depth": Depth, "rov/battery": BatteryState,
    "thruster_0/state": ThrusterState, "thruster_1/state": ThrusterState,
}  # fmt: skip


def heard(context: Context, spun: Spun, readings: list[Reading], offset: int = 0) -> dict[str, list[Any]]:
    """Return the messages by topic that come of the readings."""
    source, sink = Node("plant", context=context), Node("sink", context=context)
    publishers = SensorPublishers(source, SENSORS, 2)
    found: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
    for topic, kind in TOPICS.items():
        sink.create_subscription(kind, topic, found[topic].append, RELIABLE)
    executor = spun(source, sink)
    ends = [getattr(p, "publisher", p) for p in publishers.publishers.values()]
    assert spin_until(executor, lambda: all(p.get_subscription_count() for p in ends), 10.0)
    publishers.publish(readings, offset)
    spin_until(executor, lambda: sum(map(len, found.values())) >= len(readings), 5.0)
    return found


def test_every_sensor_speaks_on_its_topic_in_its_frame_at_its_instant(context: Context, spun: Spun) -> None:
    truth = moving(0.01 * np.arange(21), thrusters=2)
    subject = Sensors(SENSORS, 0, 2)
    every = [subject.read(k * 10_000_000, at(truth, k)) for k in range(1, 21)]
    readings = list(every[-1])
    assert [r.sensor for r in readings] == ["imu", "velocity", "depth", "tachometer", "tachometer", "battery"]
    last = {(r.sensor, r.thruster): r for r in readings}
    found = heard(context, spun, readings, offset=7_000_000_000)
    (imu,) = found["rov/imu"][-1:]
    q, told = imu.orientation, last["imu", -1].values
    assert (q.w, q.x, q.y, q.z) == told[:4]
    assert (imu.angular_velocity.x, imu.linear_acceleration.z) == (told[4], told[9])
    assert imu.header.frame_id == "imu_frd" and (imu.header.stamp.sec, imu.header.stamp.nanosec) == (7, 200_000_000)
    assert imu.orientation_covariance[4] == pytest.approx(0.004**2)
    (velocity,) = found["rov/velocity"]
    assert velocity.twist.twist.linear.y == last["velocity", -1].values[1] and math.isnan(
        velocity.twist.twist.angular.x
    )
    assert velocity.twist.covariance[7] == pytest.approx(0.008**2)
    (depth,) = found["rov/depth"]
    assert (depth.depth, depth.standard_deviation) == (last["depth", -1].values[0], 0.006)
    assert depth.header.frame_id == "map_ned"
    (battery,) = found["rov/battery"]
    assert battery.voltage == pytest.approx(last["battery", -1].values[0], rel=1e-6)
    assert battery.current == pytest.approx(-last["battery", -1].values[1], rel=1e-6) and battery.current < 0.0


def test_a_tachometer_tells_whether_it_knows_the_direction(context: Context, spun: Spun) -> None:
    readings = [Reading("tachometer", i, 40_000_000, 40_000_000, (-50.0 * i,)) for i in (0, 1)]
    found = heard(context, spun, readings)
    (state,) = found["thruster_1/state"]
    assert (state.n, state.sign_source, state.header.frame_id) == (-50.0, ThrusterState.SIGN_MEASURED, "thruster_1")
    assert math.isnan(state.supply_voltage) and math.isnan(state.current)


def test_a_reading_that_holds_nothing_goes_out_as_nan(context: Context, spun: Spun) -> None:
    found = heard(context, spun, [Reading("velocity", -1, 0, 0, (math.nan,) * 3)])
    assert math.isnan(found["rov/velocity"][0].twist.twist.linear.x)
