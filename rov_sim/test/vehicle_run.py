"""A run of a vehicle with a path that is known: a descending circle, pitching; made by code of its own."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from run_bag import Topic, write_run
from run_bag.known_topics import KNOWN_VEHICLE

Array = NDArray[np.float64]

RADIUS, SPEED, SINKING = 2.0, 0.2, 0.02  # m, m/s, m/s
THRUSTERS = 6
PITCH, PITCH_FREQUENCY = 0.4, 0.8  # rad, rad/s
SURGE_ERROR, PITCH_ERROR = 0.01, 0.02  # m/s, rad: what the vehicle lacks of its set points
SECOND = 1_000_000_000


class Circle:
    """The motion: (K,) instants, rotation from body to earth axes, position, velocity in body axes, Euler angles."""

    def __init__(self, duration: float = 20.0, period: float = 0.04) -> None:
        """Take the path at instants 0, period, … < duration [s]."""
        self.time = np.arange(round(duration / period)) * period
        turn = SPEED / RADIUS * self.time
        self.position = np.stack(
            [RADIUS * np.sin(turn), RADIUS * (1 - np.cos(turn)), 1.5 + SINKING * self.time], axis=1
        )
        pitch = PITCH * np.sin(PITCH_FREQUENCY * self.time)
        self.angles = np.stack([0.0 * turn, pitch, np.mod(turn + np.pi, 2 * np.pi) - np.pi], axis=1)
        self.rates = np.stack(
            [0.0 * turn, PITCH * PITCH_FREQUENCY * np.cos(PITCH_FREQUENCY * self.time), turn * 0 + SPEED / RADIUS],
            axis=1,
        )
        self.rotation = Rotation.from_euler("ZYX", self.angles[:, ::-1])
        earth = np.stack([SPEED * np.cos(turn), SPEED * np.sin(turn), 0.0 * turn + SINKING], axis=1)
        # The rate about the body's axes: yaw about the earth's vertical, pitch about the levelled starboard axis.
        level = Rotation.from_euler("z", self.angles[:, [2]]).apply([0.0, 1.0, 0.0])
        turning = self.rates[:, 2:] * [0.0, 0.0, 1.0] + self.rates[:, 1:2] * level
        self.velocity = np.hstack([self.rotation.inv().apply(earth), self.rotation.inv().apply(turning)])

    @property
    def quaternion(self) -> Array:
        """(K, 4) as (w, x, y, z)."""
        return np.asarray(np.roll(self.rotation.as_quat(), 1, axis=1))


def motion_fields(position: Array, quaternion: Array, velocity: Array) -> dict[str, object]:
    """Return the fields of nav_msgs/Odometry."""
    fields: dict[str, object] = {"child_frame_id": "base_link_frd"}
    fields |= {f"pose.pose.position.{axis}": position[:, k] for k, axis in enumerate("xyz")}
    fields |= {f"pose.pose.orientation.{axis}": quaternion[:, k] for k, axis in enumerate("wxyz")}
    for k, axis in enumerate("xyz"):
        fields[f"twist.twist.linear.{axis}"] = velocity[:, k]
        fields[f"twist.twist.angular.{axis}"] = velocity[:, 3 + k]
    return fields


def topics(circle: Circle, *, truth: bool = True, set_points: bool = True) -> list[Topic]:
    """Return all topics of a vehicle's run; the set points are off by `SURGE_ERROR` and `PITCH_ERROR`."""
    t, stamps = circle.time, SECOND + np.round(circle.time * 1e9).astype(np.int64)
    rng = np.random.default_rng(3)

    def of_vehicle(name: str, fields: dict[str, object], frame: str = "base_link_frd") -> Topic:
        return Topic(name=f"rov/{name}", type=KNOWN_VEHICLE[f"rov/{name}"], stamps=stamps, fields=fields, frame=frame)

    motion = (circle.position, circle.quaternion, circle.velocity)
    noisy = (circle.position + rng.normal(0, 0.01, circle.position.shape), circle.quaternion, circle.velocity + 0.003)
    found = [
        of_vehicle("odometry", motion_fields(*noisy), "map_ned"),
        of_vehicle(
            "wrench",
            {f"wrench.{k}.{a}": np.sin(t) * (i + 1) for k in ("force", "torque") for i, a in enumerate("xyz")},
        ),
        of_vehicle("imu", {f"angular_velocity.{a}": circle.velocity[:, 3 + k] for k, a in enumerate("xyz")}),
        of_vehicle("velocity", {f"twist.twist.linear.{a}": circle.velocity[:, k] for k, a in enumerate("xyz")}),
        of_vehicle("depth", {"depth": circle.position[:, 2] + 0.006, "standard_deviation": 0.006 + 0 * t}, "map_ned"),
        of_vehicle("battery", {"voltage": 15.0 - 0.01 * t, "current": -4.0 + 0 * t}),
    ]
    if truth:
        found.append(of_vehicle("truth", motion_fields(*motion), "map_ned"))
    if set_points:
        wanted = circle.angles.copy()
        wanted[:, 1] += PITCH_ERROR
        velocity = circle.velocity[:, :3].copy()
        velocity[:, 0] += SURGE_ERROR
        fields = {"attitude": wanted, "attitude_rate": circle.rates, "velocity": velocity}
        fields |= {name: np.zeros_like(wanted) for name in ("attitude_acceleration", "acceleration")}
        found.append(of_vehicle("setpoint", dict(fields)))
    for k in range(THRUSTERS):
        thrust, n, v = 4.0 * np.sin(0.5 * t + k), 60.0 * np.sin(0.5 * t + k), 0.5 * np.sin(0.5 * t + k)
        found += [
            Topic.of_thruster(k, "throttle", t, {"commanded": 2.0 * np.sin(t + k), "sent": 2.0 * np.sin(t + k)}),
            Topic.of_thruster(k, "state", t, {"n": np.abs(n), "supply_voltage": 15.0 + 0 * t, "current": 0.5 + 0 * t}),
            Topic.of_thruster(
                k, "estimate", t,
                {"n": n + 1.0, "v": v + 0.05, "ambient": 0.1 + 0 * t, "covariance": np.zeros((t.size, 9))},
            ),
            Topic.of_thruster(k, "thrust_setpoint", t, {"thrust": thrust + 0.3}),
            Topic.of_thruster(
                k, "truth", t,
                {"n": n, "axial": v, "ambient": 0.1 + 0 * t, "thrust": thrust, "torque": 0.1 + 0 * t},
            ),
        ]  # fmt: skip
    return found


def write_circle(folder: Path, **which: bool) -> Path:
    """Write the run and return its folder."""
    return write_run(folder, topics(Circle(), **which), {"seed": 3})
