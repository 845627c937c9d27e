"""A vehicle that moves, and what its sensors tell: written with SciPy's rotations and differences, beside the code
under test. Noise and biases are drawn; the places of the sensors are arguments."""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
GRAVITY = 9.81
NOISE = {"attitude": 0.004, "gyro": 0.003, "force": 0.05, "velocity": 0.008, "depth": 0.006}
STEP = 0.01  # s


class Motion:
    """A smooth motion with rolls and pitches of half a radian, turning on, depth around 5 m."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.phase = rng.uniform(0.0, 2 * np.pi, 6)
        self.pace = rng.uniform(0.2, 1.2, 6)

    def _sines(self, t: Array, which: slice) -> Array:
        return np.sin(np.multiply.outer(t, self.pace[which]) + self.phase[which])

    def attitude(self, t: Array) -> Rotation:
        euler = [0.4, 0.5, 0.5] * self._sines(t, slice(0, 3))
        euler[..., 2] += 0.2 * t
        return Rotation.from_euler("ZYX", euler[..., ::-1])

    def place(self, t: Array, arm: Any = (0.0, 0.0, 0.0)) -> Array:
        """Return where a point of the body is in the earth frame."""
        return [0.4, 0.3, 0.3] * self._sines(t, slice(3, 6)) + [0.0, 0.0, 5.0] + self.attitude(t).apply(arm)

    def speed(self, t: Array, arm: Any = (0.0, 0.0, 0.0), h: float = 1e-3) -> Array:
        near = self.place(t + h, arm) - self.place(t - h, arm)
        far = self.place(t + 2 * h, arm) - self.place(t - 2 * h, arm)
        return (8 * near - far) / (12 * h)

    def rate(self, t: Array, h: float = 1e-4) -> Array:
        """Return the angular velocity in body axes."""
        return (self.attitude(t - h).inv() * self.attitude(t + h)).as_rotvec() / (2 * h)

    def force(self, t: Array, arm: Any, h: float = 2e-3) -> Array:
        """Return the specific force at a place, in body axes."""
        felt = (self.speed(t + h, arm) - self.speed(t - h, arm)) / (2 * h)
        return self.attitude(t).inv().apply(felt - [0.0, 0.0, GRAVITY])


def sailed(
    seed: int, seconds: float = 30.0, places: Mapping[str, Any] | None = None, noise: Mapping[str, float] = NOISE
) -> SimpleNamespace:
    """Return the truth and what the sensors told, every `STEP`; log each 0.2 s, depth each 0.1 s.

    places: imu, velocity, depth: positions [m]; imu_turn, velocity_turn: rotations of their axes.
    """
    rng = np.random.default_rng(seed)
    p = {name: np.zeros(3) for name in ("imu", "velocity", "depth")} | dict(places or {})
    turn, log_turn = p.get("imu_turn", Rotation.identity()), p.get("velocity_turn", Rotation.identity())
    motion, t = Motion(rng), STEP * np.arange(round(seconds / STEP) + 1)
    size, R = (len(t), 3), motion.attitude(t)
    gyro_bias, force_bias = 0.001 * rng.standard_normal(3), 0.02 * rng.standard_normal(3)
    heard = np.full((len(t), 14), np.nan)
    xyzw = (R * turn * Rotation.from_rotvec(noise["attitude"] * rng.standard_normal(size))).as_quat()
    heard[:, :4] = np.concatenate((xyzw[:, 3:], xyzw[:, :3]), axis=1)
    heard[:, 4:7] = turn.inv().apply(motion.rate(t)) + gyro_bias + noise["gyro"] * rng.standard_normal(size)
    heard[:, 7:10] = (
        turn.inv().apply(motion.force(t, p["imu"])) + force_bias + noise["force"] * rng.standard_normal(size)
    )
    over_ground = (R * log_turn).inv().apply(motion.speed(t, p["velocity"]))
    heard[::20, 10:13] = (over_ground + noise["velocity"] * rng.standard_normal(size))[::20]
    heard[::10, 13] = (motion.place(t, p["depth"])[:, 2] + noise["depth"] * rng.standard_normal(len(t)))[::10]
    start = motion.place(t[:1])[0] * [1.0, 1.0, 0.0]
    velocity = np.concatenate((R.inv().apply(motion.speed(t)), motion.rate(t)), axis=1)
    return SimpleNamespace(
        heard=heard, dt=np.full(len(t), STEP), position=motion.place(t) - start, attitude=R, velocity=velocity,
        gyro_bias=gyro_bias, force_bias=force_bias,
    )  # fmt: skip


def errors_of(truth: SimpleNamespace, found: Any) -> Array:
    """Return truth less estimate: place, turn about the earth's axes, velocity; shape (K, 12)."""
    estimated = Rotation.from_quat(found.attitude[:, [1, 2, 3, 0]])
    turn = (truth.attitude * estimated.inv()).as_rotvec()
    return np.concatenate((truth.position - found.position, turn, truth.velocity - found.velocity), axis=1)
