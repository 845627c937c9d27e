"""Runs of a vehicle, as files, and what they are good for: sensors, excitation, wiring, and what could be told."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.check_io import topics_within
from gap_diagnosis.findings import Finding, Kind
from gap_diagnosis.suspects import betrayed_by
from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.filtering import foreseen as expected
from gap_diagnosis.vehicle.foresight import foreseen
from gap_diagnosis.vehicle.hypotheses import Hypothesis, described, hypotheses
from gap_diagnosis.vehicle.log import VehicleLog, fewer_throttles, told_in, wanting
from gap_diagnosis.vehicle.log_io import log_of, suited_period
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.oddities import Logged, common_to
from gap_diagnosis.vehicle.stretches import stretches_of
from gap_diagnosis.vehicle.turns import attitudes_with, read_with
from gap_diagnosis.vehicle.unknowns import Key, words_of
from gap_diagnosis.vehicle.velocity_axes import velocity_size
from rov_sim.vehicle.effects.effect import VehicleEffect
from rov_sim.vehicle.settings import active_effects
from run_bag import Run, RunError, Topic, read_run
from run_bag.importers.vehicle_advice import advice_on_vehicle

__all__ = ["check_vehicle"]

Array = NDArray[np.float64]
_SENSORS = {
    "attitude": ("rov/imu.orientation.w", "rov/odometry.pose.pose.orientation.w"),
    "gyro": ("rov/imu.angular_velocity.x", "rov/odometry.twist.twist.angular.x"),
    "accelerometer": ("rov/imu.linear_acceleration.x",),
    "velocity": ("rov/velocity.twist.twist.linear.x",),
    "depth": ("rov/depth.depth",),
    "battery": ("rov/battery.voltage", "rov/battery.current"),
    "tachometer": ("thruster_0/state.n",),
}
"""A channel of each sensor, the first that is there."""
_TURNED = {
    "orientation": "wxyz", "linear_acceleration": "xyz", "angular_velocity": "xyz", "twist.twist.linear": "xyz",
}  # fmt: skip
"""What a sensor tells in axes of its own, with the names of its parts."""
_TOGETHER = 0.95
"""Correlation of two throttles from which on they were hardly commanded apart."""


def check_vehicle(paths: Sequence[Path], model: Model) -> list[Finding]:
    """Return what runs of a vehicle are good for, before any fit.

    Raises:
        RunError: one of them cannot be read at all.
    """
    logs, found, runs = [], [], [read_run(path) for path in paths]
    sensors: list[_Told] = []
    with suppress(RunError):  # told below, of the run that it is in
        model = replace(model, period=suited_period(runs, model.thrusters))
    for run in runs:
        try:
            log = log_of(run, model.thrusters, model.period, stated=model.mounted)
        except RunError as error:
            found.append(Finding(kind="refused", run=run.name, sentence=str(error).removeprefix(f"{run.name}: ")))
            continue
        logs.append(log)
        sensors += _told_by(run, log)
        found += [*_sensors(log), *_throttles(log), *_notes(run, log, model)]
    found = [*_readings(sensors), *found]
    if not logs:
        return found
    found += [Finding(kind="note", about="throttles", sentence=each) for each in fewer_throttles(logs)]
    if lacking := wanting(logs):
        return [*found, Finding(kind="refused", about="fit would refuse", sentence=lacking)]
    found += [_shown_by_log(each) for each in common_to([log.oddities for log in logs])]
    conventions = conventions_of(model, logs)
    logs = [conventions.read(log) for log in logs]
    kind: Kind = "good" if conventions.verdict == "as_stated" and not conventions.wiring.dead else "note"
    says = " ".join(conventions.sentences) or "Commands move the vehicle as the set states."
    found.append(Finding(kind=kind, about="wiring", sentence=says))
    if stated := dict.fromkeys(described(each.id).title for each in active_effects(model.vehicle, model.sets)):
        told = f"{', '.join(stated)}: taken as exact"
        found.append(Finding(kind="good", about="effects that the set states", sentence=told))
    used, thinned = stretches_of(logs)  # as a diagnosis would thin them
    found += [Finding(kind="good", about="long dives", sentence=each) for each in thinned]
    return [*found, *_units(model, logs), *_apart(logs), *_foreseen(model, used)]


class _Told(NamedTuple):
    """What a sensor told in a run: how often, the usual time between two readings and the longest one [s]."""

    sensor: str
    run: str
    readings: int
    every: str
    gap: float


def _told_by(run: Run, log: VehicleLog) -> Iterable[_Told]:
    """Yield what each sensor told."""
    for sensor in (name for name, there in log.there.items() if there):
        names = [name for name in _SENSORS[sensor] if name in run and np.isfinite(run[name].values).any()]
        if sensor == "attitude" and "rov/odometry" in dict(log.took).get(sensor, "").partition(",")[0]:
            names = names[-1:]
        if names:  # none: a tachometer, of another thruster
            time = run.time(names[0])[np.isfinite(run[names[0]].values)]
            steps = np.diff(time)
            every = f"{np.median(steps):.3g}" if steps.size else ""
            yield _Told(sensor, run.name, time.size, every, float(np.max(steps, initial=0.0)))


def _readings(told: Sequence[_Told]) -> Iterable[Finding]:
    """Yield a finding for each sensor that told anything, one for all runs in which it has one rate."""
    alike: dict[tuple[str, str], list[_Told]] = {}
    for each in told:
        alike.setdefault((each.sensor, each.every), []).append(each)
    for (sensor, every), of in alike.items():
        gap = max(each.gap for each in of)
        rate = f", one every {every} s, longest gap {gap:.2g} s" if every else ""
        says = f"{', '.join(str(each.readings) for each in of)} readings{rate}"
        yield from (Finding(kind="good", run=each.run, about=sensor, sentence=says) for each in of)


def _sensors(log: VehicleLog) -> Iterable[Finding]:
    """Yield where readings are from, which were left out, and which sensors told nothing."""
    for sensor, source in log.took:
        yield Finding(kind="good", run=log.name, about=sensor, sentence=source)
    if log.left_out:
        yield Finding(kind="good", run=log.name, sentence=log.left_out)
    missing = [sensor for sensor, there in log.there.items() if not there]
    if missing:
        yield Finding(kind="good", run=log.name, about="not measured", sentence=", ".join(missing))


def _shown_by_log(each: Logged) -> Finding:
    """Return what the log of a sensor shows; stamps that scatter are in nobody's way once readings are put in place."""
    if each.effect != betrayed_by("stamps"):
        return Finding(kind="note", about="log of a sensor", sentence=each.sentence)
    told = f"Readings are put on regular stamps; on their own they would err by {rules.WORTH:g} of their noise or more."
    return Finding(kind="good", about="log of a sensor", sentence=f"{each.sentence} {told}")


def _throttles(log: VehicleLog) -> Iterable[Finding]:
    """Yield how thrusters were commanded, and which hardly were."""
    largest, spread = np.abs(log.throttles).max(axis=0), log.throttles.std(axis=0)
    told = f"up to {', '.join(f'{volts:.2g}' for volts in largest)} V over {log.duration:.1f} s"
    told += f", in periods of {1e3 * log.period:.4g} ms"
    yield Finding(kind="good", run=log.name, about="throttles", sentence=told)
    idle = [str(i) for i in np.flatnonzero(spread < rules.LEAST_EXCITATION)]
    if idle:
        told = f"thruster {', '.join(idle)} hardly moved: expected commands that vary by {rules.LEAST_EXCITATION:g} V"
        yield Finding(kind="note", run=log.name, about="throttles", sentence=told)


def _notes(run: Run, log: VehicleLog, model: Model) -> list[Finding]:
    """Return what the reader decided, and what an import would warn of that does not know how sensors are mounted."""
    decided = [Finding(kind="good", run=run.name, sentence=s) for s in log.notes]
    imu, velocity = model.mounted.mountings
    mounted = {"rov/imu": imu, "rov/velocity": velocity}
    topics = [_in_body(topic, mounted.get(topic.name)) for topic in topics_within(run, "rov/")]
    return decided + [Finding(kind="note", run=run.name, sentence=s) for s in advice_on_vehicle(topics)]


def _in_body(topic: Topic, R: Array | None) -> Topic:
    """Return what a sensor that is mounted by R, if it is a turned one, tells in the body's axes."""
    if R is None:
        return topic
    fields = dict(topic.fields)
    for head, parts in _TURNED.items():
        names = [f"{head}.{part}" for part in parts]
        if all(name in fields for name in names):
            told = np.column_stack([np.asarray(fields[name], dtype=np.float64) for name in names])
            if len(parts) == 3:
                told = read_with(told, R)
            else:  # a message of the gyro alone has none
                there = np.isfinite(told).all(axis=1) & np.any(told != 0.0, axis=1)
                told[there] = attitudes_with(told[there], R)
            fields.update(zip(names, told.T, strict=True))
    return replace(topic, fields=fields)


def _units(model: Model, logs: Sequence[VehicleLog]) -> Iterable[Finding]:
    """Yield where readings are of another size than set and sensors' file foresee: of a thruster's speed under these
    commands, of the battery at rest; or a velocity log of another than depth and accelerometer tell."""
    ratios = []
    for log in (each for each in logs if each.there["tachometer"]):
        there = np.abs(expected(model, log, log.throttles, {})[0].speeds)
        fast = there > 0.5 * np.max(there, where=np.isfinite(there), initial=0.0)
        ratios.append(np.abs(log.speeds[fast]) / there[fast])
    yield from _sized(
        "tachometer", ratios, "the speeds of the set's thrusters under these commands", rules.ANOTHER_UNIT
    )
    volts = [log.battery[:, 0] / model.sensors.nominal_voltage for log in logs if log.there["battery"]]
    stated = f"the nominal voltage of the sensors' file, {model.sensors.nominal_voltage:g} V"
    yield from _sized("battery", volts, stated, rules.ANOTHER_BATTERY)
    size = velocity_size(logs)
    what = "what depth and accelerometer say of the velocity"
    yield from _sized("velocity", [] if size is None else [np.array([size])], what, rules.ANOTHER_UNIT)


def _sized(about: str, ratios: Sequence[Array], what: str, most: float) -> Iterable[Finding]:
    """Yield a finding where readings over what is foreseen are `most` or more, or the other way round."""
    told = np.concatenate([np.zeros(0), *(each[np.isfinite(each)] for each in ratios)])
    middle = float(np.median(told)) if told.size else 1.0
    if not 1.0 / most < middle < most:
        says = f"reads {middle:.3g} times {what}; is the unit that of the recording?"
        yield Finding(kind="note", about=about, sentence=says)


def _apart(logs: Sequence[VehicleLog]) -> Iterable[Finding]:
    """Yield the pairs of thrusters that were hardly commanded apart in any of the recordings."""
    throttles = np.concatenate([log.throttles - log.throttles.mean(axis=0) for log in logs])
    size = np.linalg.norm(throttles, axis=0)
    likeness = np.abs(throttles.T @ throttles) / np.maximum(np.outer(size, size), 1e-12)
    pairs = [f"{i} and {j}" for i, j in np.argwhere(np.triu(likeness, 1) > _TOGETHER)]
    if pairs:
        told = f"thrusters {'; '.join(pairs)} were hardly commanded apart: whose an effect is will be hard to tell"
        yield Finding(kind="note", about="excitation", sentence=f"{told}; `pulses` commands each alone")


def _foreseen(model: Model, logs: Sequence[VehicleLog]) -> list[Finding]:
    """Return which numbers and effects these recordings could tell at best."""
    best = foreseen(model, logs)
    shown = [h for h, _ in best.effects if h not in best.hidden]
    there = told_in(logs)
    every, tried = hypotheses(model, dict.fromkeys(there, True)), hypotheses(model, there)
    blind = sorted({described(name).title for name in {h.effect for h in every} - {h.effect for h in tried}})
    told = f"{len(shown)} of {len(best.effects)}, each on one thruster, axis or sensor, at some size within its range"
    names = _grouped(shown, best.hidden) if shown else ""
    told = ": ".join(filter(None, (told, names)))
    found = [Finding(kind="good" if shown else "note", about="effects that would show", sentence=told)]
    of_several = {described(h.effect).title: None for h in tried if h.effect not in {h.effect for h, _ in best.effects}}
    if of_several:
        told = f"{', '.join(of_several)}: whether these recordings show them is not foreseen"
        found.append(Finding(kind="good", about="effects that are looked for, too", sentence=told))
    if best.hidden:
        told = f"{_grouped(best.hidden)}: they hide behind the noise or behind numbers that are uncertain"
        found.append(Finding(kind="note", about="effects that would not show", sentence=told))
    if blind:
        found.append(Finding(kind="good", about="effects that cannot be looked for", sentence=", ".join(blind)))
    told = f"{len(best.told)} of {len(best.numbers)}, together with all others"
    found.append(
        Finding(kind="good" if best.told else "note", about="numbers that a fit would determine", sentence=told)
    )
    if best.untold:
        names = _named(best.untold)
        found.append(Finding(kind="good", about="numbers that a fit would leave as they are", sentence=names))
    return found


def _grouped(effects: Sequence[Hypothesis], others: Sequence[Hypothesis] | None = None) -> str:
    """Return effects in words, each once, with where it would be; of one that is none of the others, everywhere, only
    its name where `others` are given."""
    whole = set() if others is None else {h.effect for h in effects} - {h.effect for h in others}
    places: dict[str, dict[str, dict[int, None]]] = {}
    for h in effects:
        part = " ".join(filter(None, (h.sensor, h.axis, _KINDS.get(h.kind or "", h.kind)))).replace("_", " ")
        own = places.setdefault(described(h.effect).title, {}).setdefault(part or _everywhere(h), {})
        own |= {} if h.thruster is None else {h.thruster: None}
    named = {described(effect).title for effect in whole}
    return "; ".join(
        title if title in named else f"{title} ({', '.join(_place(*each) for each in of.items())})"
        for title, of in places.items()
    )


_KINDS = {"both": "both ways"}
"""Kinds of effects that are no words by themselves."""


def _place(part: str, thrusters: Mapping[int, None]) -> str:
    """Return a place in words, such as `sway both ways of thruster 0 1 2`."""
    own = f"thruster {' '.join(map(str, thrusters))}" if thrusters else ""
    return " of ".join(filter(None, (part, own)))


def _everywhere(h: Hypothesis) -> str:
    """Return what an effect without a place is on, "" where it is on a thruster."""
    if h.thruster is not None:
        return ""
    effect = described(h.effect)
    of_thrusters = "thruster" in effect.may_take if isinstance(effect, VehicleEffect) else effect.block != "log"
    return "all thrusters" if of_thrusters else "the vehicle"


def _named(keys: Sequence[Key]) -> str:
    """Return numbers in words, each thruster's own ones by what they are."""
    own: dict[str, list[str]] = {}
    for key in keys:
        if key[0] == "own":
            own.setdefault(key[1], []).append(str(key[2]))
    others = [words_of(key) for key in keys if key[0] != "own"]
    return ", ".join([*others, *(f"{name} of thruster {' '.join(thrusters)}" for name, thrusters in own.items())])
