"""The bench's real closed-loop recordings: imported, read, cut to the run's 10 s."""

from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType

import numpy as np

from rov_sim.bench_study.real_runs import PUBLISHED_START, RealRun, model_followed
from run_bag import Run, read_run
from run_bag.importers.bench import find, import_recording
from run_bag.importers.options import BenchOptions
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["add_controller_argument", "controllers_told", "read_real_runs", "real_run"]

_OBSERVERS = {"KFNLO": "kfnlo", "NLO": "nlo", "KF": "ekf"}
_MODELS = {"hl": "hl_bench", "hq": "hq_bench"}
_REST_ENDS = 0.1  # s before the run


def add_controller_argument(parser: ArgumentParser) -> None:
    """Let a command be told which model each recording's controller followed, for `controllers_told`."""
    text = "hl or hq, for a recording whose n_d tells neither"
    parser.add_argument("--controller", action="append", default=[], metavar="RUN=MODEL", help=text)


def controllers_told(given: Sequence[str]) -> dict[str, str]:
    """Return the models by recording of RUN=MODEL.

    Raises:
        ValueError: not of this form, or another model than hl and hq.
    """
    told = {}
    for text in given:
        run, _, model = text.partition("=")
        if not run or model not in _MODELS:
            raise ValueError(f"--controller: expected RUN=hl or RUN=hq; found {text!r}")
        told[run] = model
    return told


def read_real_runs(path: Path, models: Mapping[str, str] = MappingProxyType({})) -> list[RealRun]:
    """Return the closed-loop recordings in a folder of the bench's files or of imported runs.

    models: by recording, "hl" or "hq", which its controller followed; else it is read off the recording.

    Raises:
        RunError, OSError: something cannot be read.
        ValueError: no closed-loop recording there, or one that does not tell its controller.
    """
    folders = sorted(p for p in path.iterdir() if (p / "metadata.yaml").exists()) if path.is_dir() else []
    if folders:
        runs = [read_run(folder) for folder in folders]
    else:
        with TemporaryDirectory() as temporary:
            groups = [group for group in find([path]).groups if "mat" in group.files]
            runs = [read_run(import_recording(g, Path(temporary), BenchOptions()).directory) for g in groups]
    found = [real_run(run, models) for run in runs if run.metadata.get("experiment") == "closed loop"]
    if not found:
        raise ValueError(f"{path}: expected recordings of the bench in closed loop (csv and mat); found none")
    return found


def real_run(run: Run, models: Mapping[str, str] = MappingProxyType({}), thruster: int = 0) -> RealRun:
    """Return a recording of the bench's controllers.

    Raises:
        MissingChannelError: no thrust set point, throttle, speed or load.
        ValueError: a name that tells neither strategy nor set point, or an n_d of neither HL nor HQ.
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
    n_d, v_hat = at(f"{prefix}/speed_setpoint.n"), at(f"{prefix}/estimate.v")
    return RealRun(
        name=name,
        strategy=_strategy(name, models.get(name), wanted.values, n_d, v_hat),
        reference=_reference(name),
        period=_period(run, wanted.name),
        T_d=wanted.values,
        u=at(f"{prefix}/throttle.commanded"),
        y_n=np.abs(at(f"{prefix}/state.n")),
        y_U=at(f"{prefix}/flow.ambient"),
        n_d=n_d,
        n_hat=at(f"{prefix}/estimate.n"),
        v_hat=v_hat,
        U_hat=at(f"{prefix}/estimate.ambient"),
        load_time=time,
        load=force - (float(np.mean(force[rest])) if np.any(rest) else 0.0),
        matched_start=start,
        start=first + PUBLISHED_START[name] if name in PUBLISHED_START else start,
    )


def _period(run: Run, channel: str) -> float:
    return float(round(float(np.median(np.diff(run.time(channel)))), 6))


def _strategy(name: str, model: str | None, T_d: np.ndarray, n_d: np.ndarray, v_hat: np.ndarray) -> str:
    if "Lookup" in name:
        return "lookup"
    if "1state" in name:
        return "simplified"
    observer = next((observer for key, observer in _OBSERVERS.items() if key in name), None)
    if observer is None:
        raise ValueError(f"{name}: expected the name to tell Lookup, 1state, KF, NLO or KFNLO")
    if model is None:
        known = {key: load_parameter_set(given).coefficients for key, given in _MODELS.items()}
        model = model_followed(T_d, n_d, v_hat, known)
    if model is None:
        expected = "expected n_d to follow HL or HQ at the recorded estimate"
        raise ValueError(f"{name}: {expected}; found neither: say which with --controller {name}=hl or {name}=hq")
    return f"{model}-{observer}"


def _reference(name: str) -> str:
    for key, reference in (("Step", "step"), ("Ramp", "triangle"), ("Sine", "sine")):
        if name.endswith(key):
            return reference
    raise ValueError(f"{name}: expected a name that ends in Step, Ramp or Sine")
