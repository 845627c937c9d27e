"""The bench's real closed-loop recordings: imported, read, cut to the run's 10 s."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from rov_sim.bench_study.real_runs import PUBLISHED_START, RealRun
from run_bag import Run, read_run
from run_bag.importers.bench import find, import_recording
from run_bag.importers.options import BenchOptions

__all__ = ["read_real_runs", "real_run"]

_OBSERVERS = {"KFNLO": "hl-kfnlo", "NLO": "hl-nlo", "KF": "hl-ekf"}
_REST_ENDS = 0.1  # s before the run


def read_real_runs(path: Path) -> list[RealRun]:
    """Return the closed-loop recordings in a folder of the bench's files or of imported runs.

    Raises:
        RunError, OSError: something cannot be read.
        ValueError: no closed-loop recording there.
    """
    folders = sorted(p for p in path.iterdir() if (p / "metadata.yaml").exists()) if path.is_dir() else []
    if folders:
        runs = [read_run(folder) for folder in folders]
    else:
        with TemporaryDirectory() as temporary:
            groups = [group for group in find([path]).groups if "mat" in group.files]
            runs = [read_run(import_recording(g, Path(temporary), BenchOptions()).directory) for g in groups]
    found = [real_run(run) for run in runs if run.metadata.get("experiment") == "closed loop"]
    if not found:
        raise ValueError(f"{path}: expected recordings of the bench in closed loop (csv and mat); found none")
    return found


def real_run(run: Run, thruster: int = 0) -> RealRun:
    """Return a recording of the bench's controllers.

    Raises:
        MissingChannelError: no thrust set point, throttle, speed or load.
        ValueError: a name that tells neither strategy nor set point.
    """
    prefix = f"thruster_{thruster}"
    wanted = run[f"{prefix}/thrust_setpoint.thrust"]
    start = float(run.time(wanted.name)[0])
    count = len(wanted)
    begins = start + _period(run, wanted.name) * np.arange(count)

    def at(channel: str) -> np.ndarray:
        if channel not in run:
            return np.full(count, np.nan)
        index = np.searchsorted(run.time(channel), begins + 1e-6, side="right") - 1
        return np.where(index >= 0, run[channel].values[np.maximum(index, 0)], np.nan)

    load = f"{prefix}/load.wrench.force.x"
    time, force = run.time(load), run[load].values
    first = float(time[0])
    rest = time < start - _REST_ENDS
    name = run.name.partition("/")[0]
    return RealRun(
        name=name,
        strategy=_strategy(name),
        reference=_reference(name),
        period=_period(run, wanted.name),
        T_d=wanted.values,
        u=at(f"{prefix}/throttle.commanded"),
        y_n=np.abs(at(f"{prefix}/state.n")),
        y_U=at(f"{prefix}/flow.ambient"),
        n_d=at(f"{prefix}/speed_setpoint.n"),
        n_hat=at(f"{prefix}/estimate.n"),
        v_hat=at(f"{prefix}/estimate.v"),
        U_hat=at(f"{prefix}/estimate.ambient"),
        load_time=time,
        load=force - (float(np.mean(force[rest])) if np.any(rest) else 0.0),
        matched_start=start,
        start=first + PUBLISHED_START[name] if name in PUBLISHED_START else start,
    )


def _period(run: Run, channel: str) -> float:
    return float(round(float(np.median(np.diff(run.time(channel)))), 6))


def _strategy(name: str) -> str:
    if "Lookup" in name:
        return "lookup"
    if "1state" in name:
        return "simplified"
    for key, strategy in _OBSERVERS.items():
        if key in name:
            return strategy.replace("hl", "hq") if "HQ" in name or "KFQ" in name else strategy
    raise ValueError(f"{name}: expected the name to tell Lookup, 1state, KF, NLO or KFNLO")


def _reference(name: str) -> str:
    for key, reference in (("Step", "step"), ("Ramp", "triangle"), ("Sine", "sine")):
        if name.endswith(key):
            return reference
    raise ValueError(f"{name}: expected a name that ends in Step, Ramp or Sine")
