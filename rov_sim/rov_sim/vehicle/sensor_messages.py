"""Readings of a vehicle's sensors as messages on their topics.

rov/imu, rov/velocity   in the axes of the sensor (frames imu_frd, velocity_log_frd), at its place
rov/depth               of the sensor, in map_ned
rov/battery             voltage, and the current as BatteryState has it: negative while it is drawn
thruster_i/state        rotor speed; supply and current of a single thruster are not measured

A reading that holds nothing goes out as NaN: whoever waits for the sensor learns that there is nothing to wait for.
"""

from collections.abc import Iterable
from math import nan
from typing import Any

from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, Imu

from rov_sim.vehicle.sensors.live import Reading
from rov_sim.vehicle.sensors.settings import VehicleSensors
from thruster_msgs.msg import Depth, ThrusterState
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import RecordPublisher, format_of
from thruster_runtime.stamps import NANOSECONDS

__all__ = ["SensorPublishers", "battery_of", "depth_of", "imu_of", "state_of", "velocity_of"]

_IMU, _TWIST, _DEPTH, _STATE = map(format_of, (Imu, TwistWithCovarianceStamped, Depth, ThrusterState))


def _diagonal(*deviations: float) -> tuple[float, ...]:
    """Return the rows of a covariance with these deviations."""
    size = len(deviations)
    return tuple(d * d if i == j else 0.0 for i, d in enumerate(deviations) for j in range(size))


def imu_of(reading: Reading, sensors: VehicleSensors, stamp: int) -> Any:
    """Return the record of a reading of the IMU, stamped `stamp` [ns]."""
    w, x, y, z, *rest = reading.values
    noise = sensors.imu.noise
    turn, rate, force = (_diagonal(*noise[i : i + 3]) for i in (0, 3, 6))
    return _IMU.record(stamp, "imu_frd", x, y, z, w, turn, *rest[:3], rate, *rest[3:], force)


def velocity_of(reading: Reading, sensors: VehicleSensors, stamp: int) -> Any:
    """Return the record of a reading of the velocity log, stamped `stamp` [ns]; it measures no turns."""
    covariance = list(_diagonal(*sensors.velocity.noise, 0.0, 0.0, 0.0))
    for i in (21, 28, 35):
        covariance[i] = nan
    return _TWIST.record(stamp, "velocity_log_frd", *reading.values, nan, nan, nan, tuple(covariance))


def depth_of(reading: Reading, sensors: VehicleSensors, stamp: int) -> Any:
    """Return the record of a reading of the depth sensor, stamped `stamp` [ns]."""
    return _DEPTH.record(stamp, "map_ned", reading.values[0], sensors.depth.noise[0])


def state_of(reading: Reading, sensors: VehicleSensors, stamp: int) -> Any:
    """Return the record of a reading of a tachometer, stamped `stamp` [ns]."""
    sign = ThrusterState.SIGN_MEASURED if sensors.signed else ThrusterState.SIGN_UNKNOWN
    return _STATE.record(stamp, f"thruster_{reading.thruster}", reading.values[0], sign, nan, nan)


def battery_of(reading: Reading, sensors: VehicleSensors, stamp: int) -> BatteryState:
    """Return the message of a reading of the battery, stamped `stamp` [ns]; records hold no sequences as it has."""
    voltage, current = reading.values
    message = BatteryState(
        voltage=voltage, current=-current, temperature=nan, charge=nan, capacity=nan, percentage=nan, present=True,
        design_capacity=nan, power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
    )  # fmt: skip
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, NANOSECONDS)
    message.header.frame_id = "base_link_frd"
    return message


_MAKE = {"imu": imu_of, "velocity": velocity_of, "depth": depth_of, "tachometer": state_of, "battery": battery_of}
_TOPICS = {
    "imu": ("rov/imu", Imu),
    "velocity": ("rov/velocity", TwistWithCovarianceStamped),
    "depth": ("rov/depth", Depth),
    "battery": ("rov/battery", BatteryState),
}


class SensorPublishers:
    """Publishers of all sensors that are there, for a node that owns the vehicle."""

    def __init__(self, node: Node, sensors: VehicleSensors, thrusters: int) -> None:
        """Advertise for `node`."""
        self._sensors = sensors
        self.publishers: dict[tuple[str, int], Any] = {}
        for name in sensors.there():
            if name == "tachometer":
                for i in range(thrusters):
                    self.publishers[name, i] = RecordPublisher(node, ThrusterState, f"thruster_{i}/state")
            elif name == "battery":
                self.publishers[name, -1] = node.create_publisher(BatteryState, "rov/battery", RELIABLE)
            else:
                topic, kind = _TOPICS[name]
                self.publishers[name, -1] = RecordPublisher(node, kind, topic)

    def publish(self, readings: Iterable[Reading], offset: int = 0) -> None:
        """Publish readings, `offset` [ns] after their stamps: the stamp of the vehicle's start."""
        for reading in readings:
            message = _MAKE[reading.sensor](reading, self._sensors, reading.stamp + offset)
            self.publishers[reading.sensor, reading.thruster].publish(message)
