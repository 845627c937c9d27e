"""What recordings show of conventions before any physics, wires and mountings, and recordings read so."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.mounting import MOUNTINGS, imu_mounted, named, turned_too, velocity_mounted
from gap_diagnosis.vehicle.oddities import Oddity
from gap_diagnosis.vehicle.rules import TURNED_BY
from gap_diagnosis.vehicle.velocity_axes import velocity_between, velocity_mounting
from gap_diagnosis.vehicle.wiring import Wiring, wiring_of

__all__ = ["Conventions", "conventions_of"]

Array = NDArray[np.float64]
_ONLY_RIGHT_ANGLES = (
    "Only right angles are tried, so axes are about these: another angle is stated as `rotation` in the sensors' file."
)
_BETWEEN = (
    "The velocity log's direction is neither as stated nor at a right angle, but some {:.0f} degrees from the nearest "
    "one: state its `rotation` in the sensors' file."
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mounted:
    """How a sensor is mounted beside what is stated (3, 3), log odds in each recording of that, and what is stated."""

    R: Array
    log_odds: float
    stated: Array

    @property
    def turned(self) -> bool:
        """Whether it is not as stated."""
        return not np.array_equal(self.R, MOUNTINGS[0])

    @property
    def axes(self) -> tuple[str, str, str]:
        """Which reading of the sensor is forward, starboard and down."""
        return named(self.R @ self.stated)

    def words(self, sensor: str) -> tuple[str, ...]:
        """Return a sentence where it is turned."""
        if not self.turned:
            return ()
        forward, starboard, down = self.axes
        return (
            f"The {sensor} is mounted turned: its {forward} is forward, its {starboard} starboard, its {down} down.",
        )

    def oddity(self, sensor: str) -> tuple[Oddity, ...]:
        """Return what a recording shows of it."""
        if not self.turned:
            return ()
        angle = float(Rotation.from_matrix(self.R).magnitude())
        return (Oddity(f"{sensor}_misalignment", sensor, None, angle, TURNED_BY, self.log_odds),)


@dataclass(frozen=True, kw_only=True, eq=False)
class Conventions:
    """Wires; how IMU and velocity log are mounted; whether the attitude was told with the IMU's turn; by how much the
    velocity log is turned from all right angles [rad], 0 where it is not."""

    wiring: Wiring
    imu: Mounted
    velocity: Mounted
    attitude: bool
    between: float = 0.0

    @property
    def verdict(self) -> str:
        """That of the wires, or turned where these are as stated and a sensor is not."""
        return "turned" if self.turned and self.wiring.verdict == "as_stated" else self.wiring.verdict

    @property
    def turned(self) -> tuple[str, ...]:
        """A sentence for each sensor that is, and one on what else it may be."""
        found = (*self.imu.words("IMU"), *self.velocity.words("velocity log"))
        told = (*found, _ONLY_RIGHT_ANGLES) if found else ()
        return (*told, _BETWEEN.format(np.degrees(self.between))) if self.between else told

    @property
    def sentences(self) -> tuple[str, ...]:
        """What is said of all of it."""
        return (*self.turned, *self.wiring.sentences)

    def read(self, log: VehicleLog) -> VehicleLog:
        """Return a log read so, and that it shows this."""
        if self.imu.turned:
            log = imu_mounted(log, self.imu.R, self.attitude)
        if self.velocity.turned:
            log = velocity_mounted(log, self.velocity.R)
        shown = (*self.imu.oddity("imu"), *self.velocity.oddity("velocity"))
        return replace(log, oddities=(*log.oddities, *shown)) if shown else log

    def content(self) -> dict[str, Any]:
        """Return it for diagnosis.json."""
        axes = {"imu_axes": list(self.imu.axes), "velocity_axes": list(self.velocity.axes)}
        return {**self.wiring.content(), "verdict": self.verdict, "sentences": list(self.sentences), **axes}


def conventions_of(model: Model, logs: Sequence[VehicleLog]) -> Conventions:
    """Return what these recordings show; a velocity log is looked at once the IMU is read aright."""
    mass = np.asarray(model.vehicle.coefficients.mass_matrix)
    wiring = wiring_of(logs, model.vehicle.configuration, mass, model.edges)
    stated = model.mounted.mountings
    imu = Mounted(R=wiring.mounting, log_odds=0.5 * wiring.gain / len(logs), stated=stated[0])
    too = imu.turned and turned_too(logs, imu.R)
    read = [imu_mounted(log, imu.R, too) for log in logs] if imu.turned else logs
    R, gain = velocity_mounting(read)
    velocity = Mounted(R=R, log_odds=0.5 * gain / len(logs), stated=stated[1])
    between = 0.0 if velocity.turned else velocity_between(read)
    return Conventions(wiring=wiring, imu=imu, velocity=velocity, attitude=too, between=between)
