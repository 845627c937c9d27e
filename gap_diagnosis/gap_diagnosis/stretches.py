"""Long recordings, thinned: stretches in which the throttle moves most, spread over all of each.

What is diagnosed costs time in proportion to what is simulated, and minutes of one kind of run tell little more than
one minute does. Each stretch is a recording of its own that begins in motion.
"""

import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.preparing import with_log_findings
from gap_diagnosis.recording import Recording

__all__ = ["LENGTH", "LONGEST", "THINNED", "stretches_of"]

LENGTH = 15.0
"""Of a stretch [s]: some ten times what rotor and water take to settle."""
LONGEST, THINNED = 300.0, 75.0
"""Recordings that are longer together [s] are thinned to this [s], as far as the caller does not say otherwise: a
diagnosis takes a minute then."""
_APART = 1.0  # s between the stretches that are compared
_RESTS = 0.05
"""Of its largest reading, by which a load cell's rest value wanders over a long recording."""
_WANDERING = ("thrust", "torque")


def stretches_of(recordings: Sequence[Recording], longest: float | None = None) -> list[Recording]:
    """Return recordings of no more than about `longest` [s] together; the first one's warnings say what was done."""
    total = sum(each.experiment.duration for each in recordings)
    if total <= (longest or LONGEST):
        return list(recordings)
    longest = longest or THINNED
    found: list[Recording] = []
    for each in recordings:
        duration = each.experiment.duration
        count = max(1, int(longest * duration / total / LENGTH))
        if duration <= count * LENGTH:
            found.append(each)
            continue
        stretches = [_stretch(each, begins, f"{each.name} from {begins:.0f} s") for begins in _liveliest(each, count)]
        found += [_warning(stretches[0], each.experiment.warnings), *stretches[1:]]
    if len(found) == len(recordings) and all(map(operator.is_, found, recordings)):
        return found
    used = sum(each.experiment.duration for each in found)
    told = (
        f"of {total:.0f} s recorded, the {used:.0f} s in which the throttle moves most are used, in {len(found)} "
        f"stretches spread over all of it; what changes more slowly is not seen "
        f"(diagnose --longest {total:.0f} uses all)"
    )
    return [_warning(found[0], (told, *found[0].experiment.warnings)), *found[1:]]


def _warning(recording: Recording, warnings: tuple[str, ...]) -> Recording:
    return replace(recording, experiment=replace(recording.experiment, warnings=warnings))


def _liveliest(recording: Recording, count: int) -> list[float]:
    """Return the beginnings [s] of `count` stretches, one in each of as many equal parts."""
    experiment = recording.experiment
    dt, part = experiment.dt, experiment.duration / count
    travelled = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(experiment.throttle)))))
    found = []
    for k in range(count):
        begins = np.arange(k * part, max((k + 1) * part - LENGTH, k * part + 1e-9), _APART)
        places = (begins / dt).astype(np.int64)
        ends = np.minimum(places + round(LENGTH / dt), travelled.size - 1)
        found.append(float(dt * places[int(np.argmax(travelled[ends] - travelled[places]))]))
    return found


def _readings(recording: Recording) -> Iterator[Recording]:
    """Yield a recording in all ways in which it may be read."""
    yield recording
    for other in (recording.regular, recording.straight):
        if other is not None:
            yield from _readings(other)


def _first(recording: Recording, begins: float) -> int:
    """Return the step of the simulation with which a stretch begins."""
    return round(begins / recording.experiment.dt)


def _inside(recording: Recording, begins: float) -> dict[str, NDArray[np.bool_]]:
    """Return by signal which samples are within a stretch, shape (M,)."""
    start = _first(recording, begins) * recording.experiment.dt
    return {
        signal: (m.time - 0.5 * m.width >= start) & (m.time + 0.5 * m.width < start + LENGTH)
        for signal, m in recording.experiment.measurements.items()
    }


def _stretch(recording: Recording, begins: float, name: str) -> Recording:
    """Return a stretch of a recording, of the same samples in whichever way it is read."""
    ways = [_inside(each, begins) for each in _readings(recording)]
    together = {signal: np.logical_and.reduce([way[signal] for way in ways]) for signal in ways[0]}
    return _cut(recording, begins, name, together)


def _cut(recording: Recording, begins: float, name: str, taken: Mapping[str, NDArray[np.bool_]]) -> Recording:
    """Return a stretch on a clock of its own, by the same name with regular stamps and straight commands."""
    experiment = recording.experiment
    first = _first(recording, begins)
    start = first * experiment.dt
    measurements = {}
    for signal, m in experiment.measurements.items():
        if np.any(inside := taken[signal]):
            rest = _RESTS * float(np.nanmax(np.abs(m.values))) if signal in _WANDERING else 0.0
            measurements[signal] = replace(
                m,
                time=m.time[inside] - start,
                values=m.values[inside],
                offset_std=float(np.hypot(m.offset_std, rest)),
            )
    part = experiment.between(first, first + round(LENGTH / experiment.dt))
    own = replace(part, name=name, measurements=measurements, warnings=())
    log = recording.log
    found = with_log_findings(own, recording.thruster, log.scatter, log.period, log.lost)
    regular, straight = (
        None if other is None else _cut(other, begins, name, taken) for other in (recording.regular, recording.straight)
    )
    return replace(found, regular=regular, straight=straight)
