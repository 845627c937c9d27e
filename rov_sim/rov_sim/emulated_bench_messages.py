"""What the emulated bench knows of its thruster and what its load cell tells, as records."""

from math import nan
from typing import Any

from geometry_msgs.msg import WrenchStamped

from rov_sim.emulated_bench import BenchTruth, MeanThrust
from thruster_msgs.msg import ThrusterTruth
from thruster_runtime.records import format_of

__all__ = ["load", "truth"]

_FRAME = "thruster_0"
_TRUTH, _LOAD = map(format_of, (ThrusterTruth, WrenchStamped))


def truth(stamp: int, now: BenchTruth) -> Any:
    """Return the true states."""
    return _TRUTH.record(stamp, _FRAME, n=now.n, axial=now.v, ambient=now.U, thrust=now.T, torque=now.Q, throttle=now.u)


def load(stamp: int, mean: MeanThrust) -> Any:
    """Return the thrust that the load cell tells; the other axes are not simulated."""
    return _LOAD.record(stamp, _FRAME, mean.told, nan, nan, nan, nan, nan)
