"""Runs in, recovered thrust out as runs of their own."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from run_bag import Run, RunError, Topic, read_run, write_run
from thruster_model.errors import UnfitDataError
from thruster_model.identification.experiment_io import throttle_channel
from thruster_model.load_cell.preparation import Array, Recording
from thruster_model.load_cell.recovery import Recovered

__all__ = ["read_recordings", "recording_of", "write_recovered"]


def read_recordings(paths: Iterable[Path], thruster: int = 0) -> list[tuple[Run, Recording]]:
    """Read runs; all that is wrong with any of them is raised at once.

    Raises:
        UnfitDataError: with a sentence for each run that cannot be read or holds no load cell.
    """
    found, problems = [], []
    for path in paths:
        try:
            run = read_run(path)
            found.append((run, recording_of(run, thruster)))
        except (RunError, UnfitDataError, OSError) as error:
            problems.append(str(error))
    names = [recording.name for _, recording in found]
    problems += [f"{name}: given more than once" for name in sorted({n for n in names if names.count(n) > 1})]
    if problems:
        raise UnfitDataError(problems)
    return found


def recording_of(run: Run, thruster: int = 0) -> Recording:
    """Return the load cell of a run with rotor speed and throttle on its samples."""
    prefix = f"thruster_{thruster}"
    names = [f"{prefix}/load.wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
    missing = [name for name in names if name not in run]
    if missing:
        raise UnfitDataError(
            [f"{run.name}: expected a load cell's {', '.join(missing)}; channels are {', '.join(run)}"]
        )
    time = run.time(names[0])
    gauges = [f"{prefix}/gauges.force[{i}]" for i in range(6)]
    has_gauges = all(name in run and len(run[name]) == time.size for name in gauges)
    setpoint = f"{prefix}/thrust_setpoint.thrust"
    return Recording(
        name=run.name,
        time=time,
        wrench=np.stack([run[name].values for name in names], axis=1),
        legs=np.stack([run[name].values for name in gauges], axis=1) if has_gauges else None,
        speed=_on(run, (f"daq/{prefix}/state.n", f"{prefix}/state.n"), time, hold=False),
        throttle=_on(run, (throttle_channel(run, prefix),), time, hold=True),
        setpoint=(run.time(setpoint), run[setpoint].values) if setpoint in run else None,
        turned=_turned(run),
    )


def _on(run: Run, names: tuple[str | None, ...], time: Array, *, hold: bool) -> Array | None:
    name = next((n for n in names if n in run), None)
    if name is None:
        return None
    known = np.isfinite(run[name].values)
    at, values = run.time(name)[known], run[name].values[known]
    if at.size == 0:
        return None
    if not hold:
        return np.asarray(np.interp(time, at, values))
    index = np.searchsorted(at, time + 1e-9, side="right") - 1
    return np.where(index >= 0, values[np.maximum(index, 0)], 0.0)


def _turned(run: Run) -> bool:
    decisions = run.metadata.get("import", {}).get("decisions", [])
    return any(d.get("what") == "load cell turned round" and d.get("value") is True for d in decisions)


def write_recovered(path: Path, run: Run, recovered: Recovered, record: dict[str, object], thruster: int = 0) -> Path:
    """Write the recovered thrust as a run of its own; the recording it came from is not touched.

    Topic `thruster_i/load_recovered` holds the thrust [N] as force.x; everything else is NaN, not measured. Its
    standard deviation [N] is force.x of `thruster_i/load_recovered_deviation`.
    """
    name = f"thruster_{thruster}/load_recovered"
    stamps = run.start + np.round(recovered.cell_time * 1e9).astype(np.int64)
    frame = run[f"thruster_{thruster}/load.wrench.force.x"].frame
    topics = [
        Topic(
            name=name + suffix,
            type="geometry_msgs/msg/WrenchStamped",
            stamps=stamps,
            fields={"wrench.force.x": values},
            frame=frame,
        )
        for suffix, values in (("", recovered.cell_thrust), ("_deviation", recovered.cell_deviation))
    ]
    write_run(path, topics, {"what": "thrust recovered from a ringing load cell", "from": run.name, **record})
    return path
