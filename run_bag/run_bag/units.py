"""The unit of every field, by message type: the one table of units of recorded data.

"1" is a pure number (counts, indices, flags, qualities). Types that are not in the table have unknown units
(""). Stamps are no fields here: they become the stamps of the channels.
"""

from __future__ import annotations

import re


def _axes(prefix: str, unit: str, axes: str = "xyz") -> dict[str, str]:
    return {f"{prefix}.{axis}": unit for axis in axes}


_FORCE_TORQUE = {**_axes("force", "N"), **_axes("torque", "N m")}
_TWIST = {**_axes("linear", "m/s"), **_axes("angular", "rad/s")}
_POSE = {**_axes("position", "m"), **_axes("orientation", "1", "xyzw")}

_TRANSFORM = {**_axes("translation", "m"), **_axes("rotation", "1", "xyzw")}


def _under(prefix: str, table: dict[str, str]) -> dict[str, str]:
    return {f"{prefix}.{path}": unit for path, unit in table.items()}


def _covariance(prefix: str, first: str, second: str, cross: str) -> dict[str, str]:
    """Units of a row-major 6x6 covariance of three quantities of one unit and three of another."""
    cells = {}
    for row in range(6):
        for column in range(6):
            unit = cross if (row < 3) != (column < 3) else first if row < 3 else second
            cells[f"{prefix}[{6 * row + column}]"] = unit
    return cells


_POSE_COVARIANCE = _covariance("pose.covariance", "m^2", "rad^2", "m rad")
_TWIST_COVARIANCE = _covariance("twist.covariance", "m^2/s^2", "rad^2/s^2", "m rad/s^2")
_STATES = ("rad/s", "m/s", "m/s")  # n, v, U
_ESTIMATE_COVARIANCE = {
    f"covariance[{3 * i + j}]": {"rad/s rad/s": "rad^2/s^2", "m/s m/s": "m^2/s^2"}.get(f"{a} {b}", "rad m/s^2")
    for i, a in enumerate(_STATES)
    for j, b in enumerate(_STATES)
}

UNITS: dict[str, dict[str, str]] = {
    "thruster_msgs/msg/AdvSample": {
        "counter": "1", "status": "1", "velocity": "m/s", "amplitude": "1", "snr": "dB", "correlation": "%",
    },
    "thruster_msgs/msg/Depth": {"depth": "m", "standard_deviation": "m"},
    "thruster_msgs/msg/FlowVelocity": {"axial": "m/s", "ambient": "m/s", "quality": "1", "spike": "1"},
    "thruster_msgs/msg/LoadCellGauges": {"voltage": "V", "force": "N"},
    "thruster_msgs/msg/SpeedSetpoint": {"n": "rad/s"},
    "thruster_msgs/msg/Throttle": {"commanded": "V", "sent": "V"},
    "thruster_msgs/msg/ThrustSetpoint": {"thrust": "N"},
    "thruster_msgs/msg/ThrusterEstimate": {
        "n": "rad/s", "v": "m/s", "ambient": "m/s", **_ESTIMATE_COVARIANCE, "status": "1",
    },
    "thruster_msgs/msg/ThrusterFailure": {"thruster": "1", "kind": "1", "effectiveness": "1", "stuck_thrust": "N"},
    "thruster_msgs/msg/ThrusterState": {
        "n": "rad/s", "sign_source": "1", "supply_voltage": "V", "current": "A",
    },
    "thruster_msgs/msg/ThrusterTruth": {
        "n": "rad/s", "axial": "m/s", "ambient": "m/s", "thrust": "N", "torque": "N m", "throttle": "V",
    },
    "thruster_msgs/msg/VehicleSetpoint": {
        "attitude": "rad", "attitude_rate": "rad/s", "attitude_acceleration": "rad/s^2",
        "velocity": "m/s", "acceleration": "m/s^2",
    },
    "geometry_msgs/msg/Wrench": _FORCE_TORQUE,
    "geometry_msgs/msg/WrenchStamped": _under("wrench", _FORCE_TORQUE),
    "geometry_msgs/msg/Twist": _TWIST,
    "geometry_msgs/msg/TwistStamped": _under("twist", _TWIST),
    "geometry_msgs/msg/TwistWithCovarianceStamped": {**_under("twist.twist", _TWIST), **_TWIST_COVARIANCE},
    "geometry_msgs/msg/TransformStamped": _under("transform", _TRANSFORM),
    "tf2_msgs/msg/TFMessage": _under("transforms.transform", _TRANSFORM),
    "geometry_msgs/msg/PoseStamped": _under("pose", _POSE),
    "nav_msgs/msg/Odometry": {
        **_under("pose.pose", _POSE), **_under("twist.twist", _TWIST),
        **_POSE_COVARIANCE, **_TWIST_COVARIANCE,
    },
    "sensor_msgs/msg/Imu": {
        **_axes("orientation", "1", "xyzw"), **_axes("angular_velocity", "rad/s"),
        **_axes("linear_acceleration", "m/s^2"), "orientation_covariance": "rad^2",
        "angular_velocity_covariance": "rad^2/s^2", "linear_acceleration_covariance": "m^2/s^4",
    },
    "sensor_msgs/msg/BatteryState": {
        "voltage": "V", "temperature": "degC", "current": "A", "charge": "Ah", "capacity": "Ah",
        "design_capacity": "Ah", "percentage": "1", "power_supply_status": "1", "power_supply_health": "1",
        "power_supply_technology": "1", "present": "1", "cell_voltage": "V", "cell_temperature": "degC",
    },
    "rosgraph_msgs/msg/Clock": {"clock.sec": "s", "clock.nanosec": "ns"},
    "diagnostic_msgs/msg/DiagnosticArray": {"status.level": "1"},
}  # fmt: skip

_INDEX = re.compile(r"\[\d+\]")


def unit_of(message_type: str, path: str) -> str:
    """Return the unit of a field ("voltage[0]" as "voltage", unless it has its own), "" if unknown."""
    table = UNITS.get(message_type, {})
    return table.get(path) or table.get(_INDEX.sub("", path), "")
