"""What the driver measures and sends, as records; the conversion from counts is the protocol's."""

import math
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.time import Time
from std_msgs.msg import Header

from bench_driver.dialect import Measurement
from bench_driver.driver_settings import LoadCell
from bench_driver.link_records import Sent
from bench_driver.text_protocol import flow_from_count, speed_from_count
from thruster_msgs.msg import FlowVelocity, LoadCellGauges, Throttle, ThrusterState
from thruster_runtime.records import format_of

__all__ = ["flow", "gauges", "load", "state", "throttle_sent"]


_STATE, _FLOW, _LOAD, _THROTTLE = map(format_of, (ThrusterState, FlowVelocity, WrenchStamped, Throttle))


def _frame(thruster: int) -> str:
    return f"thruster_{thruster}"


def state(stamp: int, thruster: int, found: Measurement) -> Any:
    """Return the speed's magnitude: the tachometer knows no direction."""
    return _STATE.record(
        stamp, _frame(thruster), n=speed_from_count(found.tachometer_counts[thruster]),
        sign_source=ThrusterState.SIGN_UNKNOWN, supply_voltage=math.nan, current=math.nan,
    )  # fmt: skip


def flow(stamp: int, thruster: int, found: Measurement) -> Any:
    """Return the ambient flow that the velocimeter's analogue output tells."""
    return _FLOW.record(
        stamp, _frame(thruster), axial=math.nan, ambient=flow_from_count(found.flow_counts[thruster]),
        quality=math.nan, spike=False,
    )  # fmt: skip


def gauges(stamp: int, volts: Sequence[float]) -> LoadCellGauges:
    """Return the load cell's voltages [V], as a message; the force of each leg is not known here."""
    header = Header(stamp=Time(nanoseconds=stamp).to_msg(), frame_id=_frame(0))
    return LoadCellGauges(header=header, voltage=[float(v) for v in volts], force=[math.nan] * len(volts))


def load(stamp: int, cell: LoadCell, found: Measurement) -> Any:
    """Return force and moment of a load cell whose matrix is known."""
    return _LOAD.record(stamp, _frame(0), *map(float, cell.wrench(cell.volts(found.load_counts))))


def throttle_sent(stamp: int, thruster: int, sent: Sent | None) -> Any:
    """Return what was commanded and sent; NaN both where nothing was."""
    commanded = math.nan if sent is None else sent.commanded[thruster]
    throttle = math.nan if sent is None else sent.throttles[thruster]
    return _THROTTLE.record(stamp, _frame(thruster), commanded=commanded, sent=throttle)
