"""Runs as recordings for the attitude fit: rates and attitude of `rov/odometry`, throttles as moments by K_t."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from run_bag import Run, read_run
from thruster_model.attitude_fit.recording import Recording
from thruster_model.errors import UnfitDataError
from thruster_model.parameter_set import ParameterSet

__all__ = ["DT", "read_recording", "recording_of"]

Array = NDArray[np.float64]
DT = 0.01
_POSE, _TWIST = "rov/odometry.pose.pose.orientation", "rov/odometry.twist.twist.angular"


def read_recording(path: Path, thruster: ParameterSet, configuration: Array) -> Recording:
    """Return the run in that folder as a recording; see `recording_of`."""
    return recording_of(read_run(path), thruster, configuration)


def recording_of(run: Run, thruster: ParameterSet, configuration: Array) -> Recording:
    """Return a run as a recording.

    Args:
        run: with `rov/odometry` and a throttle for each thruster.
        thruster: a set of the model `force_table`, all thrusters alike; at its nominal supply.
        configuration: K_t (6, N).

    Raises:
        UnfitDataError: channels are missing, or the thruster has no table.
    """
    table = thruster.force_table
    if table is None:
        found = f"found model '{thruster.model_name}'"
        raise UnfitDataError([f"{thruster.name}: expected a parameter set of the model 'force_table'; {found}"])
    throttles = [f"thruster_{k}/throttle.commanded" for k in range(configuration.shape[1])]
    needed = [*throttles, *(f"{_POSE}.{c}" for c in "wxyz"), *(f"{_TWIST}.{c}" for c in "xyz")]
    missing = [name for name in needed if name not in run]
    if missing:
        raise UnfitDataError([f"{run.name}: expected the channels {', '.join(missing)}; found {', '.join(run)}"])
    time = run.time(f"{_TWIST}.x")
    start = float(time[0])
    grid = np.arange(0.0, float(time[-1]) - start, DT)
    rates = np.stack([np.interp(grid, time - start, run[f"{_TWIST}.{c}"].values) for c in "xyz"], axis=1)
    w, x, y, z = (run[f"{_POSE}.{c}"].values for c in "wxyz")
    down = np.stack((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)), axis=1)
    gravity = np.stack([np.interp(grid, time - start, down[:, k]) for k in range(3)], axis=1)
    gravity /= np.linalg.norm(gravity, axis=1)[:, None]
    held = np.stack([_held(run.time(n) - start, run[n].values, grid) for n in throttles], axis=1)
    nominal = thruster.values["nominal_supply"]
    thrusts = table.force_at(thruster.command.command(held), nominal, outside="clamp")
    return Recording(name=run.name, dt=DT, rates=rates, gravity=gravity, moments=thrusts @ configuration[3:].T)


def _held(time: Array, values: Array, grid: Array) -> Array:
    """Return the last value at or before each instant; before the first one it is zero."""
    k = np.searchsorted(time, grid, side="right") - 1
    return np.where(k >= 0, values[np.maximum(k, 0)], 0.0)
