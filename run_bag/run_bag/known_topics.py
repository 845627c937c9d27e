"""The topics of a thruster and of the vehicle by name, and the type of each."""

from __future__ import annotations

KNOWN = {
    "thrust_setpoint": "thruster_msgs/msg/ThrustSetpoint",
    "speed_setpoint": "thruster_msgs/msg/SpeedSetpoint",
    "throttle": "thruster_msgs/msg/Throttle",
    "state": "thruster_msgs/msg/ThrusterState",
    "flow": "thruster_msgs/msg/FlowVelocity",
    "adv_raw": "thruster_msgs/msg/AdvSample",
    "load": "geometry_msgs/msg/WrenchStamped",
    "gauges": "thruster_msgs/msg/LoadCellGauges",
    "estimate": "thruster_msgs/msg/ThrusterEstimate",
    "truth": "thruster_msgs/msg/ThrusterTruth",
}
"""Last part of `thruster_<i>/...` -> type."""
KNOWN_VEHICLE = {
    "rov/truth": "nav_msgs/msg/Odometry",
    "rov/setpoint": "thruster_msgs/msg/VehicleSetpoint",
    "rov/odometry": "nav_msgs/msg/Odometry",
    "rov/odometry_enu": "nav_msgs/msg/Odometry",
    "rov/imu": "sensor_msgs/msg/Imu",
    "rov/velocity": "geometry_msgs/msg/TwistWithCovarianceStamped",
    "rov/depth": "thruster_msgs/msg/Depth",
    "rov/battery": "sensor_msgs/msg/BatteryState",
    "rov/operator": "geometry_msgs/msg/TwistStamped",
    "rov/wrench": "geometry_msgs/msg/WrenchStamped",
    "rov/thruster_failure": "thruster_msgs/msg/ThrusterFailure",
    "rov/attitude": "geometry_msgs/msg/Vector3Stamped",
    "rov/path": "nav_msgs/msg/Path",
    "rov/scene": "visualization_msgs/msg/MarkerArray",
}


def topic_type(topic: str) -> str | None:
    """Return the message type of a known topic, None for others."""
    parts = topic.strip("/").split("/")
    if len(parts) == 2 and parts[0].startswith("thruster_") and parts[0][9:].isdigit():
        return KNOWN.get(parts[1])
    return KNOWN_VEHICLE.get(topic.strip("/"))


def known_topics() -> str:
    """Return the names of all of them, for a sentence."""
    return ", ".join([*(f"thruster_<i>/{k}" for k in KNOWN), *KNOWN_VEHICLE])
