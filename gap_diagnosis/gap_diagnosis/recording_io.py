"""Runs as recordings for a diagnosis."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.preparing import DT, recording_of, with_log_findings
from gap_diagnosis.recording import Recording
from run_bag import Run, RunError, read_run
from run_bag.importers.advice import as_they_change
from thruster_model.errors import UnfitDataError
from thruster_model.identification import experiment_io
from thruster_model.identification.experiment import CHANNELS
from thruster_model.identification.preparation import noise_level, rest_window, tare_unsigned_speed
from thruster_model.identification.speed_sign import NEAR_REST, lacks_sign, signed_speed, unsigned, with_known_sign

__all__ = ["read_recordings", "recordings_of"]

Array = NDArray[np.float64]
Samples = tuple[Array, Array]
_LONGEST_SILENCE = 0.5  # [s] without a command, where commands come at a steady period
_SHORTEST_PART = 1.0  # [s]
_LEAST_REST = 20  # samples
_UNEVEN = 1.5  # times the usual time between commands, from which on one is missing
_LATEST = 10.0  # [s] that readings may begin after the last command, which is held
_WITHOUT = {
    "previous": "the one before is held",
    "linear": "the line between those beside it is taken",
    None: "those beside it tell what acts",
}
"""Where a stamp holds no command, by how commands act between their samples."""
_SIGNED, _OPPOSITE = ("thrust", "torque", "ambient", "axial"), -0.8
"""Signals that tell a direction; correlation of one of them with the speed below which it goes the other way."""


def read_recordings(
    paths: Iterable[Path], thruster: int = 0, progress: Callable[[str], None] = lambda _: None
) -> list[Recording]:
    """Read runs; all that is wrong with any of them is raised at once.

    Raises:
        UnfitDataError: with a sentence for each run that cannot be read, has no throttle or no measurement, or is
            given more than once.
    """
    found: list[tuple[Path, list[Recording]]] = []
    problems = []
    for path in paths:
        progress(f"read {path.name}")
        if path.resolve() in [other for other, _ in found]:
            problems.append(f"{path}: given more than once; expected different runs")
            continue
        try:
            found.append((path.resolve(), recordings_of(read_run(path), thruster)))
        except (RunError, UnfitDataError, OSError) as error:
            problems.append(str(error))
    problems += _copies(found)
    if problems:
        raise UnfitDataError(problems)
    names = [path.name for path, _ in found]
    return [
        _renamed(each, f"{path.parent.name}/{each.name}") if names.count(path.name) > 1 else each
        for path, recordings in found
        for each in recordings
    ]


def _copies(found: list[tuple[Path, list[Recording]]]) -> list[str]:
    """Return a sentence for each run that holds the samples of another one."""
    problems = []
    for place, (path, recordings) in enumerate(found):
        for other, others in found[:place]:
            if len(others) == len(recordings) and all(map(_alike, others, recordings)):
                problems.append(f"{path}: holds the same samples as {other}; expected different runs")
    return problems


def _alike(first: Recording, second: Recording) -> bool:
    one, two = first.experiment, second.experiment
    return (
        np.array_equal(one.throttle, two.throttle)
        and one.measurements.keys() == two.measurements.keys()
        and all(
            np.array_equal(m.values, two.measurements[name].values, equal_nan=True)
            for name, m in one.measurements.items()
        )
    )


def _renamed(recording: Recording, name: str) -> Recording:
    def other(beside: Recording | None) -> Recording | None:
        return None if beside is None else _renamed(beside, name)

    return replace(
        recording,
        experiment=replace(recording.experiment, name=name),
        regular=other(recording.regular),
        straight=other(recording.straight),
    )


def recordings_of(run: Run, thruster: int = 0) -> list[Recording]:
    """Return a run as a recording, or as several where its throttle falls silent in between.

    Raw readings of a bench (a tachometer without sign, gauges that rest anywhere) are tared, masked and averaged as
    `thruster_model fit` does it; all other runs are taken sample by sample as they are, speeds without sign with that
    of the throttle.

    Raises:
        UnfitDataError: no throttle or nothing measured.
    """
    prefix = f"thruster_{thruster}"
    deviations, hold = _clock_deviations(run), run.hold("throttle")
    if _is_raw(run, prefix):
        options = experiment_io.PreparationOptions(thruster=thruster, dt=DT, air=True)
        return [with_log_findings(experiment_io.prepare(run, options), thruster)]
    throttle = experiment_io.throttle_channel(run, prefix)
    if throttle is None:
        expected = f"expected a channel {prefix}/throttle.commanded with values"
        raise UnfitDataError([f"{run.name}: {expected}; found {', '.join(run)}"])
    warnings: list[str] = list(run.warnings)
    commands = _finite(throttle, run, warnings, _WITHOUT[hold])
    signals: dict[str, Samples] = {}
    for signal, channel in CHANNELS.items():
        name = f"{prefix}/{channel}"
        if name in run and np.any(np.isfinite(run[name].values)):
            samples = _finite(name, run, warnings)
            if samples[0][-1] < commands[0][0] or samples[0][0] > commands[0][-1] + _LATEST:
                expected = f"expected stamps among the throttle's ({commands[0][0]:.1f} to {commands[0][-1]:.1f} s)"
                warnings.append(f"{name}: {expected}, found {samples[0][0]:.1f} to {samples[0][-1]:.1f} s; left out")
            else:
                signals[signal] = samples
    if not signals:
        expected = ", ".join(f"{prefix}/{channel}" for channel in CHANNELS.values())
        found = "; ".join(warnings) or f"found {', '.join(run)}"
        raise UnfitDataError([f"{run.name}: expected one of {expected}; {found}"])
    if "speed" in signals:
        signals["speed"] = _with_sign(run, prefix, signals, commands)
    parts = _parts(commands, signals, f"{prefix}/throttle", warnings)
    recordings: list[Recording] = []
    supply = _supply(run, f"{prefix}/state.supply_voltage")
    for begins, own, measured in parts:
        name = run.name if len(parts) == 1 else f"{run.name} from {begins:.1f} s"
        volts = None if supply is None else (supply[0] - begins, supply[1])
        made = recording_of(
            name, own, measured, thruster=thruster, clock_deviations=deviations, supply=volts, hold=hold
        )
        left_out = [_why_left_out(prefix, s, measured[s]) for s in measured if s not in made.experiment.measurements]
        told = (*(warnings if not recordings else ()), *left_out)
        recordings.append(replace(made, experiment=replace(made.experiment, warnings=told)))
    return recordings


def _clock_deviations(run: Run) -> dict[str, float]:
    """Return how far a run says that its clocks may be off [s], by what they stamp.

    Raises:
        UnfitDataError: a clock that may be off by as long as the run lasts tells nothing.
    """
    stated = run.metadata.get("clock_deviation") or {}
    longest = max((float(run.time(name)[-1]) for name in run if run[name].values.size), default=0.0)
    told = {}
    for name, value in stated.items() if isinstance(stated, Mapping) else [("", stated)]:
        number = 0.0 if value is None else value
        if not isinstance(number, int | float) or not 0.0 <= number <= longest:
            what = f"metadata clock_deviation{f'.{name}' if name else ''}"
            expected = f"expected seconds from 0 to the run's {longest:.1f}"
            raise UnfitDataError([f"{run.name}: {what}: {expected}; found {value!r}"])
        told[str(name)] = float(number)
    return told


def _supply(run: Run, name: str) -> Samples | None:
    """Return stamps [s] and voltage [V] of the supply where it was measured."""
    known = np.isfinite(run[name].values) if name in run else np.zeros(0, dtype=np.bool_)
    return (run.time(name)[known], run[name].values[known]) if np.any(known) else None


def _is_raw(run: Run, prefix: str) -> bool:
    """Tell whether a run comes from a bench's own tachometer, which has no sign: by its driver, or an importer."""
    sign, speed = f"{prefix}/state.sign_source", f"{prefix}/state.n"
    if sign not in run or speed not in run or not unsigned(run[sign].values, run[speed].values):
        return False
    return f"{prefix}/throttle_sent.sent" in run or not lacks_sign(run[sign].values, run[speed].values)


def _with_sign(run: Run, prefix: str, signals: Mapping[str, Samples], throttle: Samples) -> Samples:
    """Return speeds with their signs; NaN where nothing tells one.

    A tachometer without sign has the throttle's, unless two sensors say that the thruster turns the other way.
    """
    speed = signals["speed"]
    sign, values = f"{prefix}/state.sign_source", run[f"{prefix}/state.n"].values
    if sign not in run:
        return speed
    if lacks_sign(run[sign].values, values):
        time, found = _signed(*speed, throttle)
        likeness = [_likeness(time, found, *each) for name, each in signals.items() if name in _SIGNED]
        turned = len(likeness) > 1 and max(likeness) < 0.0 and min(likeness) < _OPPOSITE
        return time, -found if turned else found
    return speed[0], with_known_sign(run[sign].values[np.isfinite(values)], speed[1])


def _likeness(time: Array, speed: Array, stamps: Array, readings: Array) -> float:
    """Return the correlation, about zero, of readings with speeds; 0 where they have no instant together."""
    there = np.isfinite(speed) & (time >= stamps[0]) & (time <= stamps[-1])
    n, y = speed[there], np.interp(time[there], stamps, readings)
    return float(n @ y) / max(np.sqrt(float(n @ n) * float(y @ y)), 1e-300)


def _signed(time: Array, magnitude: Array, throttle: Samples) -> Samples:
    """Return speeds with the sign of the throttle; NaN about reversals and near rest, where it tells nothing.

    A tachometer that reads at rest what is more than its noise's magnitude has that taken off.
    """
    speed = signed_speed(time, magnitude, throttle)
    rest = rest_window(*throttle)
    still = magnitude[(time >= rest[0]) & (time <= rest[1])]
    if still.size >= _LEAST_REST and np.mean(still) > 3.0 * np.std(still):
        speed = tare_unsigned_speed(time, speed, rest).values
    near = np.abs(speed) < NEAR_REST * noise_level(speed)
    # With their neighbours: noise decided which of them are near.
    return time, np.where(np.convolve(near, np.ones(3), "same") > 0.0, np.nan, speed)


def _finite(name: str, run: Run, warnings: list[str], without: str = "") -> Samples:
    """Return the samples that are numbers; NaN says that nothing was measured, infinity that something is wrong.

    `without`: what is done where a command is missing; "" where readings may. Commands that are there at even times
    miss none: where each row is an event, most rows are of a sensor.
    """
    time, values = run.time(name), run[name].values
    known = np.isfinite(values)
    infinite = int(np.sum(np.isinf(values)))
    if infinite:
        warnings.append(f"{name}: expected numbers, found {infinite} infinite ones; left out")
    missing = int(np.sum(np.isnan(values)))
    steps = np.diff(time[known])
    if missing and without and steps.size and np.max(steps) > _UNEVEN * np.median(steps):
        warnings.append(f"{name}: {missing} of {values.size} stamps hold no command; {without}")
    return time[known], values[known]


def _parts(
    commands: Samples, signals: Mapping[str, Samples], name: str, warnings: list[str]
) -> list[tuple[float, Samples, dict[str, Samples]]]:
    """Return where each part begins [s] and its samples, on a clock of its own: between silences of the throttle."""
    time, values = commands
    steps = np.diff(time)
    period = float(np.median(steps)) if steps.size else 0.0
    silent = np.flatnonzero(steps > max(_LONGEST_SILENCE, 10.0 * period))
    # Commands that are written as they change are silent while they are held, and the sensors are not.
    held = as_they_change(values) and all(
        any(np.any((at > time[k] + 0.1) & (at < time[k + 1] - 0.1)) for at, _ in signals.values()) for k in silent
    )
    if not silent.size or period > 0.1 or held:
        return [(0.0, commands, dict(signals))]
    edges = [0, *(int(k) + 1 for k in silent), time.size]
    parts = []
    for k in silent:
        warnings.append(
            f"{name}: no commands for {steps[k]:.1f} s from {time[k]:.1f} s on; what was measured meanwhile is left out"
        )
    for first, last in pairwise(edges):
        begins, ends = float(time[first]), float(time[last - 1]) + period
        if ends - begins < _SHORTEST_PART:
            continue
        measured = {}
        for signal, (at, read) in signals.items():
            inside = (at >= begins - 1e-9) & (at < ends)
            if np.any(inside):
                measured[signal] = (at[inside] - begins, read[inside])
        if measured:
            parts.append((begins, (time[first:last] - begins, values[first:last]), measured))
    return parts or [(0.0, commands, dict(signals))]


def _why_left_out(prefix: str, signal: str, samples: Samples) -> str:
    time, values = samples
    name = f"{prefix}/{CHANNELS[signal]}"
    if np.ptp(values) == 0.0:
        return f"{name}: expected readings that move, found {values[0] + 0.0:g} throughout; left out"
    period = float(np.median(np.diff(time))) if time.size > 1 else np.inf
    return f"{name}: expected at least 20 samples, found {time.size}, one every {period:.2g} s; left out"
