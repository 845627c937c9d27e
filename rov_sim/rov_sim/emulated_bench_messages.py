"""What the emulated bench knows of its thruster and what its load cell tells, as messages."""

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Header

from rov_sim.emulated_bench import BenchTruth, MeanThrust
from thruster_msgs.msg import ThrusterTruth

__all__ = ["load", "time", "truth"]

_FRAME = "thruster_0"


def time(stamp: int) -> Time:
    """Return an instant [ns] as a message."""
    return Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)


def truth(stamp: int, now: BenchTruth) -> ThrusterTruth:
    """Return the true states."""
    return ThrusterTruth(
        header=Header(stamp=time(stamp), frame_id=_FRAME), n=now.n, axial=now.v, ambient=now.U, thrust=now.T,
        torque=now.Q, throttle=now.u,
    )  # fmt: skip


def load(stamp: int, mean: MeanThrust) -> WrenchStamped:
    """Return the thrust that the load cell tells; the other axes are not simulated."""
    message = WrenchStamped(header=Header(stamp=time(stamp), frame_id=_FRAME))
    message.wrench.force.x = mean.told
    for vector, axis in (("force", "y"), ("force", "z"), ("torque", "x"), ("torque", "y"), ("torque", "z")):
        setattr(getattr(message.wrench, vector), axis, math.nan)
    return message
