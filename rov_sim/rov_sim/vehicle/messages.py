"""What a simulated vehicle tells besides its sensors' readings, as records of the topics' messages."""

from math import nan
from typing import Any

from nav_msgs.msg import Odometry as OdometryMessage

from rov_sim.vehicle.live import Failing, Odometry
from rov_sim.vehicle.noisy_odometry import OdometryNoise
from rov_sim.vehicle.truth import VehicleTruth
from thruster_msgs.msg import ThrusterFailure, ThrusterTruth
from thruster_runtime.records import format_of

__all__ = ["failure", "odometry", "thruster_truths", "truth"]

_EARTH, _BODY = "map_ned", "base_link_frd"
_ODOMETRY, _TRUTH, _FAILURE = map(format_of, (OdometryMessage, ThrusterTruth, ThrusterFailure))
_CERTAIN = (0.0,) * 36


def _diagonal(*variances: float) -> tuple[float, ...]:
    size = len(variances)
    return tuple(variances[i] if i == j else 0.0 for i in range(size) for j in range(size))


def _pose(stamp: int, position: Any, attitude: Any, pose: Any, motion: Any, twist: Any) -> Any:
    w, x, y, z = attitude
    return _ODOMETRY.record(stamp, _EARTH, _BODY, *position, x, y, z, w, pose, *motion, twist)


def truth(stamp: int, now: VehicleTruth) -> Any:
    """Return rov/truth, of which nothing is uncertain."""
    return _pose(stamp, now.position, now.attitude, _CERTAIN, now.velocity, _CERTAIN)


def odometry(stamp: int, told: Odometry, noise: OdometryNoise) -> Any:
    """Return rov/odometry of the truth with noise of these deviations."""
    turned, moved, turning = (x**2 for x in (noise.attitude, noise.velocity, noise.rate))
    pose = _diagonal(0.0, 0.0, 0.0, turned, turned, turned)
    twist = _diagonal(moved, moved, moved, turning, turning, turning)
    return _pose(stamp, told.position, told.attitude, pose, told.velocity, twist)


def thruster_truths(stamp: int, now: VehicleTruth) -> list[Any]:
    """Return the truth of each thruster."""
    columns = zip(now.n, now.axial, now.ambient, now.thrust, now.torque, now.u, strict=True)
    return [
        _TRUTH.record(stamp, f"thruster_{i}", n=n, axial=v, ambient=U, thrust=T, torque=Q, throttle=u)
        for i, (n, v, U, T, Q, u) in enumerate(columns)
    ]


def failure(stamp: int, failing: Failing) -> Any:
    """Return rov/thruster_failure; the thrust of a stuck one is not known."""
    kind, share = int(failing.kind), failing.effectiveness
    return _FAILURE.record(stamp, _BODY, thruster=failing.thruster, kind=kind, effectiveness=share, stuck_thrust=nan)
