"""The navigation believes in the sensors that are simulated by default, and makes odometry of their messages."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from rov_sim.vehicle.sensor_messages import SensorPublishers
from rov_sim.vehicle.sensors.believed import navigation_parameters, navigation_settings
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.live import Sensors
from rov_sim.vehicle.sensors.settings import VehicleSensors
from rov_sim.vehicle.sensors.settings_io import load_sensors
from thruster_estimation.navigation_node import NavigationNode
from thruster_estimation.navigation_parameters import NAVIGATION_PARAMETERS, chosen_settings
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE


def test_the_nodes_defaults_are_the_places_and_noise_of_the_simulated_sensors() -> None:
    sensors = load_sensors()
    believed = chosen_settings({p.name: p.default for p in NAVIGATION_PARAMETERS})
    expected = navigation_settings(sensors)
    for name in believed._fields:
        if name not in ("gyro_bias_deviation", "force_bias_deviation"):
            assert getattr(believed, name) == pytest.approx(getattr(expected, name), abs=1e-15), name


def test_the_nodes_defaults_wait_for_readings_at_the_simulated_rates() -> None:
    defaults = {p.name: p.default for p in NAVIGATION_PARAMETERS}
    for name, value in navigation_parameters(load_sensors()).items():
        expected = defaults[name] or (defaults[name.replace("first", "every")] if name.endswith("first") else 0.0)
        assert value == pytest.approx(expected, abs=1e-12), name


LATE = replace(load_sensors(), depth=replace(load_sensors().depth, phase=0.03, delay=0.05))


@pytest.mark.parametrize(("sensors", "late"), [(load_sensors(), 0.0), (LATE, 0.055)], ids=["default", "late"])
def test_in_lockstep_each_control_tick_has_its_odometry_of_a_vehicle_at_rest(
    context: Context, spun: Callable[..., Executor], sensors: VehicleSensors, late: float
) -> None:
    """Tick by tick as a plant does it: four readings of the IMU, whatever else is due, one estimate."""
    tick, c = 10_000_000, sensor_coefficients(sensors)._replace(velocity_late=late)
    rest = SimpleNamespace(
        position=np.array([0.0, 0.0, 5.0]), attitude=np.array([1.0, 0.0, 0.0, 0.0]), velocity=np.zeros(6),
        acceleration=np.zeros(6), n=np.zeros(1), supply=1.0, current=0.0,
    )  # fmt: skip
    given = [Parameter(name, value=value) for name, value in navigation_parameters(sensors, c).items()]
    plant, navigation = Node("plant", context=context), NavigationNode(context=context, parameter_overrides=given)
    publishers, subject = SensorPublishers(plant, sensors, 1), Sensors(sensors, 4, 1, c)
    found: list[Odometry] = []
    plant.create_subscription(Odometry, "rov/odometry", found.append, RELIABLE)
    executor = spun(plant, navigation)
    heard = [p.publisher for (name, _), p in publishers.publishers.items() if name in ("imu", "velocity", "depth")]
    ends = [*heard, *(p for p in navigation.publishers if p.topic_name.endswith("odometry"))]
    assert spin_until(executor, lambda: all(p.get_subscription_count() for p in ends), 10.0)
    for k in range(1, 401):
        publishers.publish(subject.read(k * tick, rest))
        if k % 4 == 0:
            assert spin_until(executor, lambda k=k: len(found) == k // 4, 5.0)  # type: ignore[misc]
            assert found[-1].header.stamp.nanosec + found[-1].header.stamp.sec * 10**9 == k * tick
    last = found[-1]
    assert last.pose.pose.position.z == pytest.approx(5.0, abs=0.02)
    assert abs(last.twist.twist.linear.x) < 0.02 and abs(last.twist.twist.linear.z) < 0.02
