"""Sensors for tests, and a known motion of a vehicle, written with other means than the code under test."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rov_sim.vehicle.sensors.settings import QUANTITIES, Sensor, VehicleSensors
from rov_sim.vehicle.sensors.settings_io import load_sensors

Array = NDArray[np.float64]
GRAVITY = 9.81
DEFAULT = load_sensors()


def exact(sensors: VehicleSensors = DEFAULT, **changes: object) -> VehicleSensors:
    """Return sensors without random errors and losses."""
    quiet = {}
    for name in QUANTITIES:
        sensor: Sensor = getattr(sensors, name)
        none = (0.0,) * len(sensor.noise)
        quiet[name] = replace(sensor, noise=none, bias=none, bias_deviation=none, lost_share=0.0)
    return replace(sensors, **(quiet | changes))


def wobble(t: Array) -> tuple[Array, Array]:
    """Return roll, pitch, yaw (K, 3) [rad] and the body's place in the earth frame (K, 3) [m] of a smooth motion."""
    euler = np.stack((0.3 * np.sin(0.9 * t), 0.4 * np.sin(0.7 * t + 0.5), 0.5 * t + 0.3 * np.sin(0.4 * t)), axis=-1)
    place = np.stack((0.5 * np.sin(0.5 * t), 0.3 * np.cos(0.8 * t), 4.0 + 0.6 * np.sin(0.3 * t)), axis=-1)
    return euler, place


def rotations(t: Array) -> Rotation:
    """Return the body's attitudes."""
    return Rotation.from_euler("ZYX", wobble(t)[0][:, ::-1])


def moving(t: Array, thrusters: int = 3) -> SimpleNamespace:
    """Return the truth of the motion at t (K,) [s], by central differences of sixth order."""
    h = 1e-2
    steps, weights = np.array([-3, -2, -1, 1, 2, 3]) * h, np.array([-1, 9, -45, 45, -9, 1]) / (60 * h)

    def body(at: Array) -> Array:
        R = rotations(at)
        nu = R.inv().apply(sum(w * wobble(at + s)[1] for s, w in zip(steps, weights, strict=True)))
        turns = sum(w * (R.inv() * rotations(at + s)).as_rotvec() for s, w in zip(steps, weights, strict=True))
        return np.concatenate((nu, turns), axis=1)

    acceleration = sum(w * body(t + s) for s, w in zip(steps, weights, strict=True))
    xyzw = rotations(t).as_quat()
    phases = np.arange(thrusters)
    return SimpleNamespace(
        time=t,
        position=wobble(t)[1],
        attitude=np.concatenate((xyzw[:, 3:], xyzw[:, :3]), axis=1),
        velocity=body(t),
        acceleration=acceleration,
        n=100.0 * np.sin(t[:, None] + phases),
        axial=0.1 * np.sin(t[:, None] + phases),
        ambient=0.2 * np.cos(t[:, None] + phases),
        thrust=10.0 * np.sin(t[:, None] + phases),
        torque=0.1 * np.sin(t[:, None] + phases),
        supply=1.0 - 0.1 * np.abs(np.sin(t)),
        current=0.3 + 0.2 * np.sin(2.0 * t),
    )


def at(truth: SimpleNamespace, k: int) -> SimpleNamespace:
    """Return one instant of a truth."""
    return SimpleNamespace(**{name: rows[k] for name, rows in vars(truth).items()})
