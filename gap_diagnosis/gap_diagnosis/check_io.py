"""Runs, as files, and what they are good for: all that an import, a fit and a diagnosis would say, before they run."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from gap_diagnosis.findings import Finding, Kind
from gap_diagnosis.readiness import readiness
from gap_diagnosis.recording_io import read_recordings
from gap_diagnosis.stretches import stretches_of
from run_bag import Run, read_run
from run_bag.importers.advice import advice
from run_bag.topic import Topic
from thruster_model.errors import UnfitDataError
from thruster_model.identification.experiment import CHANNELS, SIGNALS
from thruster_model.identification.experiment_io import PreparationOptions, prepare, throttle_channel
from thruster_model.identification.foresight import foreseen
from thruster_model.identification.identifiability import Determination
from thruster_model.parameter_set import ParameterSet
from thruster_model.unmoved import moved_by_parameter

__all__ = ["check", "topics_within"]

_SENSORS = ("rov/imu", "rov/odometry", "rov/velocity", "rov/depth")
"""Topics of a vehicle's own motion: a bench may have the battery alone."""


def check(paths: Sequence[Path], parameter_set: ParameterSet, thruster: int = 0) -> list[Finding]:
    """Return what runs are good for.

    Args:
        paths: of the runs.
        parameter_set: of the simulator, from which a fit would start.
        thruster: index.

    Raises:
        UnfitDataError: with a sentence for each run that cannot be read at all.
    """
    recordings = read_recordings(paths, thruster)  # refuses what no reader takes
    runs = [read_run(path) for path in paths]
    found = [finding for run in runs for finding in (*_of_vehicle(run), *_channels(run, parameter_set, thruster))]
    ready = readiness(stretches_of(recordings), parameter_set)  # as a diagnosis would thin them
    said = {each.sentence for each in ready}
    found += [each for run in runs for each in _advice(run, thruster) if each.sentence not in said]
    return [*found, *ready, *_fit(runs, parameter_set, thruster)]


def _of_vehicle(run: Run) -> Iterable[Finding]:
    """Yield a note of a run that is a vehicle's: of it a set of a thruster tells one thruster alone, as on a bench."""
    thrusters = {name.partition("/")[0] for name in run if name.startswith("thruster_")}
    sensors = sorted({name.partition(".")[0] for name in run if name.startswith(_SENSORS)})
    if len(thrusters) > 1 and sensors:
        seen = f"{len(thrusters)} thrusters and {', '.join(sensors)}"
        told = f"{seen}: of a vehicle's run say `--vehicle` in place of `--set`"
        yield Finding(kind="note", run=run.name, about="of a vehicle", sentence=told)


def _channels(run: Run, parameter_set: ParameterSet, thruster: int) -> Iterable[Finding]:
    """Yield a finding for each channel that matters, and for those that are missing.

    One flow is enough, and torque serves its own coefficients alone: without the other ones nothing is in the way,
    nor without what the model does not have.
    """
    prefix = f"thruster_{thruster}"
    throttle = throttle_channel(run, prefix)
    wanted = {} if throttle is None else {throttle: "V"}
    names = {signal: f"{prefix}/{channel}" for signal, channel in CHANNELS.items()}
    supplied = "nominal_supply" in parameter_set.values
    wanted |= {f"{prefix}/state.supply_voltage": "V"} if supplied else {}
    wanted |= {name: SIGNALS[signal].unit for signal, name in names.items()}
    missing = []
    for name, unit in wanted.items():
        known = np.isfinite(run[name].values) if name in run else np.zeros(0, dtype=np.bool_)
        if not np.any(known):
            missing.append(name)
            continue
        time, values = run.time(name)[known], run[name].values[known]
        steps = np.diff(time)
        period = float(np.median(steps)) if steps.size else 0.0
        rate = (
            f", one every {period:.3g} s ({1.0 / period:.4g} Hz), longest gap {np.max(steps):.2g} s" if period else ""
        )
        told = f"{values.size} samples{rate}; {np.min(values):.4g} to {np.max(values):.4g} {unit}"
        yield Finding(kind="good", run=run.name, about=name, sentence=told)
    flows = {names["axial"], names["ambient"]}
    spare = {names["torque"]} if flows <= set(missing) else {names["torque"], *flows}
    spare |= {name for signal, name in names.items() if signal not in parameter_set.model.signals}
    if needed := [name for name in missing if name not in spare]:
        lacking = [f"{name} (nominal_supply counts)" if name.endswith("supply_voltage") else name for name in needed]
        yield Finding(kind="note", run=run.name, about="not measured", sentence=", ".join(lacking))
    if others := [name for name in missing if name in spare]:
        yield Finding(kind="good", run=run.name, about="not measured", sentence=", ".join(others))
    hold = _holds(run).get("throttle")
    if hold is not None:
        told = f"between two samples the run states `{hold}`"
        yield Finding(kind="good", run=run.name, about="hold of the throttle", sentence=told)


def _holds(run: Run) -> Mapping[str, str]:
    stated = run.metadata.get("hold")
    return stated if isinstance(stated, Mapping) else {}


def topics_within(run: Run, prefix: str) -> list[Topic]:
    """Return the topics of a run whose names begin so, as an import has them."""
    by_topic: dict[str, dict[str, str]] = {}
    for name in run:
        topic, _, field = name.partition(".")
        if topic.startswith(prefix):
            by_topic.setdefault(topic, {})[field] = name
    return [
        Topic(name=topic, type="", stamps=run[first].stamps, fields={f: run[c].values for f, c in fields.items()})
        for topic, fields in by_topic.items()
        for first in [next(iter(fields.values()))]
        if all(len(run[c]) == len(run[first]) for c in fields.values())
    ]


def _advice(run: Run, thruster: int) -> list[Finding]:
    """Return what the importers would warn of."""
    topics = topics_within(run, f"thruster_{thruster}/")
    return [Finding(kind="note", run=run.name, sentence=sentence) for sentence in advice(topics, _holds(run))]


def _fit(runs: Sequence[Run], parameter_set: ParameterSet, thruster: int) -> list[Finding]:
    """Return what a fit would refuse, else which parameters of the set it would determine."""
    experiments, refused = [], []
    for run in runs:
        try:
            experiments.append(prepare(run, PreparationOptions(thruster=thruster)))
        except UnfitDataError as error:
            refused += list(error.problems)
    judged: tuple[Determination, ...] = ()
    if not refused:
        try:
            judged = foreseen(parameter_set, experiments)
        except UnfitDataError as error:
            refused += list(error.problems)
    if refused:
        return [Finding(kind="refused", about="fit would refuse", sentence=sentence) for sentence in refused]
    known = [each.name for each in judged if each.status == "determined"]
    told = f"{', '.join(known) or 'none'}, each by itself: {len(known)} of {len(judged)}"
    about, kind = "parameters that a fit would determine", _kind(note=not known)
    kept = Finding(kind=kind, about=about, sentence=told, of_fit=True)
    signals = {signal for each in experiments for signal in each.measurements}
    others = [each for each in judged if each.status != "determined"]
    return [kept, *_undetermined(others, parameter_set, signals)]


def _undetermined(judged: Iterable[Determination], parameter_set: ParameterSet, signals: set[str]) -> Iterable[Finding]:
    """Yield why a fit would not determine parameters: no programme helps where their only sensor is missing."""
    unread: dict[frozenset[str], list[str]] = {}
    for each in judged:
        moved = moved_by_parameter(parameter_set, each.name)
        if each.status == "not excited" and moved and not moved & signals:
            unread.setdefault(moved, []).append(each.name)
            continue
        about = f"parameter {each.name} of a fit ({each.status})"
        yield Finding(kind=_kind(note=not each.settled), about=about, sentence=each.sentence, of_fit=True)
    for moved, parameters in unread.items():
        lacking = " or ".join(SIGNALS[name].title.lower() for name in SIGNALS if name in moved)
        told = f"{', '.join(parameters)}: only {lacking} would show it; not measured"
        kind = _kind(note=moved != {"torque"})
        yield Finding(kind=kind, about="parameters of a fit without a sensor", sentence=told, of_fit=True)


def _kind(*, note: bool) -> Kind:
    return "note" if note else "good"
