"""What the driver measures and sends, as messages; the conversion from counts is the protocol's."""

import math
from collections.abc import Sequence

from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Header

from bench_driver.dialect import Measurement
from bench_driver.driver_settings import LoadCell
from bench_driver.link_records import Sent
from bench_driver.text_protocol import flow_from_count, speed_from_count
from thruster_msgs.msg import FlowVelocity, LoadCellGauges, Throttle, ThrusterState

__all__ = ["flow", "gauges", "load", "state", "throttle_sent"]


def _header(stamp: int, thruster: int) -> Header:
    time = Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)
    return Header(stamp=time, frame_id=f"thruster_{thruster}")


def state(stamp: int, thruster: int, found: Measurement) -> ThrusterState:
    """Return the speed's magnitude: the tachometer knows no direction."""
    return ThrusterState(
        header=_header(stamp, thruster), n=speed_from_count(found.tachometer_counts[thruster]),
        sign_source=ThrusterState.SIGN_UNKNOWN, supply_voltage=math.nan, current=math.nan,
    )  # fmt: skip


def flow(stamp: int, thruster: int, found: Measurement) -> FlowVelocity:
    """Return the ambient flow that the velocimeter's analogue output tells."""
    return FlowVelocity(
        header=_header(stamp, thruster), axial=math.nan, ambient=flow_from_count(found.flow_counts[thruster]),
        quality=math.nan, spike=False,
    )  # fmt: skip


def gauges(stamp: int, volts: Sequence[float]) -> LoadCellGauges:
    """Return the load cell's voltages [V]; the force of each leg is not known here."""
    return LoadCellGauges(header=_header(stamp, 0), voltage=[float(v) for v in volts], force=[math.nan] * len(volts))


def load(stamp: int, cell: LoadCell, found: Measurement) -> WrenchStamped:
    """Return force and moment of a load cell whose matrix is known."""
    fx, fy, fz, mx, my, mz = map(float, cell.wrench(cell.volts(found.load_counts)))
    message = WrenchStamped(header=_header(stamp, 0))
    message.wrench.force.x, message.wrench.force.y, message.wrench.force.z = fx, fy, fz
    message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z = mx, my, mz
    return message


def throttle_sent(stamp: int, thruster: int, sent: Sent | None) -> Throttle:
    """Return what was commanded and sent; NaN both where nothing was."""
    commanded = math.nan if sent is None else sent.commanded[thruster]
    throttle = math.nan if sent is None else sent.throttles[thruster]
    return Throttle(header=_header(stamp, thruster), commanded=commanded, sent=throttle)
