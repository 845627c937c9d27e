"""What a recorded run of a vehicle shows over time: the panels of its report."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.poses import attitudes_at, body_rates, euler_angles
from rov_sim.vehicle.recording_io import Motion, VehicleRecording, signal
from rov_sim.vehicle.scores import DEGREES_OF_FREEDOM
from run_bag.report import Axis, Panel, Series

__all__ = [
    "attitude_panels", "battery_panels", "rate_panels", "thruster_panels", "velocity_panels", "wrench_panels",
]  # fmt: skip

Array = NDArray[np.float64]

_THRUSTER = (
    ("Thrust", "T", "N", (("wanted", "thrust_setpoint.thrust"), ("truth", "truth.thrust"))),
    ("Throttle", "u", "V", (("commanded", "throttle.commanded"), ("sent", "throttle.sent"))),
    ("Rotor speed", "n", "rad/s", (("measured", "state.n"), ("estimate", "estimate.n"), ("truth", "truth.n"))),
    ("Axial flow", "v", "m/s", (("estimate", "estimate.v"), ("truth", "truth.axial"))),
    ("Ambient flow", "U", "m/s", (("estimate", "estimate.ambient"), ("truth", "truth.ambient"))),
)
_STYLES: dict[str, dict[str, Any]] = {
    "wanted": {"color": 3}, "measured": {"role": "data"}, "sent": {"role": "data"}, "odometry": {"role": "data"},
    "sensor": {"role": "data"}, "truth": {"color": 0}, "commanded": {"color": 2}, "estimate": {"color": 1},
}  # fmt: skip


def _series(name: str, x: Array, y: Array) -> list[Series]:
    """Return the series, or nothing where it has no value."""
    return [Series(name=name, x=x, y=y, **_STYLES[name])] if np.isfinite(y).any() else []


def _of_motion(recording: VehicleRecording, values: Callable[[Motion], Array], column: int) -> list[Series]:
    series = []
    for name, motion in (("odometry", recording.odometry), ("truth", recording.truth)):
        if motion is not None:
            series += _series(name, motion.time, values(motion)[:, column])
    return series


def _tracking(
    recording: VehicleRecording, first: int, values: Callable[[Motion], Array], wanted: Array | None
) -> list[Panel]:
    """Return the panels of three degrees of freedom from number `first`."""
    panels = []
    for k in range(3):
        each = DEGREES_OF_FREEDOM[first + k]
        series = _of_motion(recording, values, k)
        if wanted is not None and recording.set_points is not None:
            series += _series("wanted", recording.set_points.time, wanted[:, k])
        panels.append(Panel(axis=Axis(name=each.words, unit=each.unit, symbol=each.symbol), series=series))
    return panels


def velocity_panels(recording: VehicleRecording) -> list[Panel]:
    """Return surge, sway and heave."""
    wanted = None if recording.set_points is None else recording.set_points.velocity
    return _tracking(recording, 0, lambda motion: motion.velocity[:, :3], wanted)


def rate_panels(recording: VehicleRecording) -> list[Panel]:
    """Return the rates about the body's axes; those wanted turn the actual attitude as the set points say."""
    wanted, motion = None, recording.motion
    if recording.set_points is not None:
        angles = euler_angles(attitudes_at(recording.set_points.time, motion.time, motion.attitude))
        wanted = body_rates(angles, recording.set_points.rates)
    return _tracking(recording, 3, lambda motion: motion.velocity[:, 3:], wanted)


def attitude_panels(recording: VehicleRecording) -> list[list[Panel]]:
    """Return roll, pitch and yaw, then north, east and depth."""
    wanted = None if recording.set_points is None else recording.set_points.angles
    attitude = _tracking(recording, 6, lambda motion: euler_angles(motion.attitude), wanted)
    position = []
    for k, name in enumerate(("North", "East", "Depth")):
        series = _of_motion(recording, lambda motion: motion.position, k)
        if name == "Depth" and (found := signal(recording.run, "rov/depth.depth")) is not None:
            series = _series("sensor", *found) + series
        position.append(Panel(axis=Axis(name=name, unit="m"), series=series))
    return [attitude, position]


def wrench_panels(recording: VehicleRecording) -> list[list[Panel]]:
    """Return the wanted forces, then the moments, nothing where none were recorded."""
    columns = []
    for kind, unit, symbols in (("force", "N", "XYZ"), ("torque", "N m", "KMN")):
        column = []
        for axis, symbol in zip("xyz", symbols, strict=True):
            word = "Force" if kind == "force" else "Moment"
            series = _signals(recording, (("wanted", f"rov/wrench.wrench.{kind}.{axis}"),))
            if series:
                column.append(Panel(axis=Axis(name=f"{word} {symbol}", unit=unit, symbol=symbol), series=series))
        if column:
            columns.append(column)
    return columns


def thruster_panels(recording: VehicleRecording, index: int) -> list[Panel]:
    """Return what was recorded of a thruster."""
    panels = []
    for words, symbol, unit, channels in _THRUSTER:
        series = _signals(recording, tuple((name, f"thruster_{index}/{field}") for name, field in channels))
        if series:
            panels.append(Panel(axis=Axis(name=words, unit=unit, symbol=symbol), series=series))
    return panels


def battery_panels(recording: VehicleRecording) -> list[Panel]:
    """Return voltage and current of the battery."""
    panels = []
    for words, symbol, unit, field in (("Voltage", "V", "V", "voltage"), ("Current", "I", "A", "current")):
        series = _signals(recording, (("measured", f"rov/battery.{field}"),))
        if series:
            panels.append(Panel(axis=Axis(name=words, unit=unit, symbol=symbol), series=series))
    return panels


def _signals(recording: VehicleRecording, channels: Sequence[tuple[str, str]]) -> list[Series]:
    series = []
    for name, channel in channels:
        found = signal(recording.run, channel)
        if found is not None:
            series += _series(name, *found)
    return series
