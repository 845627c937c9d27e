"""Effects that only scatter: spikes, repeated samples, a converter's lattice, stamps that jitter.

They are no part of a prediction, so they are judged by the log and by the shape of the residuals, and then taken out
of the way: spikes and repeated samples are masked, scattered stamps replaced by regular ones where those fit better,
and samples on a slope count by what stamps leave of them where no log shows the scatter (jitter.py).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import poisson

from gap_diagnosis.log_check import edge_deviation, within_hole
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import LOG_RULES
from gap_diagnosis.suspects import betrayed_by

__all__ = [
    "Scatter", "found_in_logs", "masks_of", "probability_at", "scattered_before_sorting", "share_deviation",
    "unlike_stated",
]  # fmt: skip

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """One such effect: identifier, signal it was found in, size and its deviation, log odds for it."""

    effect: str
    signal: str
    parameter: str
    size: float
    deviation: float
    log_odds: float
    sentence: str


def masks_of(recordings: Sequence[Recording]) -> dict[tuple[int, str], NDArray[np.bool_]]:
    """Return the samples that say nothing, or nothing more: repeated ones, spikes, lone ones, those of a beginning in
    motion, and all but one of those in which a coarse converter stands still."""
    masks: dict[tuple[int, str], NDArray[np.bool_]] = {}
    hole = _hole(recordings)
    for index, recording in enumerate(recordings):
        log, own = recording.log, (_zeros(recording, hole), _beginning(recording), _standing(recording))
        for table in (log.repeated, log.spikes, log.lone, *own):
            for signal, mask in table.items():
                if np.any(mask):
                    masks[index, signal] = mask | masks.get((index, signal), False)
    return masks


_SETTLING, _SHARE = 1.0, 0.1
"""[s], and at most share of a recording, after which what was before it is forgotten."""


def _beginning(recording: Recording) -> Mapping[str, NDArray[np.bool_]]:
    """Return the first second of a thruster that turns already.

    Commands on their way, what swings behind a load cell, water in motion: what it remembers was not recorded, and
    effects that cancel each other later would make up for it.
    """
    if not recording.in_motion:
        return {}
    experiment = recording.experiment
    end = min(_SETTLING, _SHARE * experiment.dt * experiment.throttle.size)
    return {name: measured.time < end for name, measured in experiment.measurements.items()}


def _standing(recording: Recording) -> Mapping[str, NDArray[np.bool_]]:
    """Return the readings of a coarse tachometer that are as the one before or after: the middle one stays of each row.

    What it cuts off is the same in all of them. Taken for as many errors by chance, zeros of a rotor that turns slower
    than half a step had told of dry friction.
    """
    read, step = recording.experiment.measurements.get("speed"), recording.log.lattice.get("speed", 0.0)
    if read is None or step < LOG_RULES.lattice * read.noise or step == 0.0:
        return {}
    ends = np.append(np.flatnonzero(np.diff(read.values) != 0.0), read.values.size - 1)
    starts = np.concatenate(([0], ends[:-1] + 1))
    standing = np.ones(read.values.size, dtype=np.bool_)
    standing[(starts + ends) // 2] = False
    return {"speed": standing}


_OUTLIERS = 1e-3
"""Share of readings that may lie between a hole's zeros and its edge."""
_ABOUT = np.array([0.25, 0.25, 0.0, 0.25, 0.25])


def _zeros(recording: Recording, hole: float) -> Mapping[str, NDArray[np.bool_]]:
    """Return the zeros of a blind tachometer, and the readings about its threshold: noise decided which of them are
    seen, so their mean is not the speed. By their neighbours, as their own noise must not choose them.
    """
    read = recording.experiment.measurements.get("speed")
    if hole == 0.0 or read is None or not np.any(zero := within_hole(read.values, hole)):
        return {}
    about = np.abs(np.convolve(np.nan_to_num(read.values), _ABOUT, "same"))
    return {"speed": zero | (about < hole + 3.0 * read.noise)}


def _hole(recordings: Sequence[Recording]) -> float:
    """Return the magnitude below which the tachometer reads zero, seen in one recording at least; 0: no such hole."""
    holes = [r.log.hole["speed"] for r in recordings if r.log.hole.get("speed", 0.0) > 0.0]
    if not holes or min(holes) < LOG_RULES.hole:
        return 0.0
    readings = np.concatenate(
        [r.experiment.measurements["speed"].values for r in recordings if "speed" in r.experiment.measurements]
    )
    inside = (np.abs(readings) < 0.95 * min(holes)) & ~within_hole(readings, min(holes))
    return min(holes) if np.mean(inside) < _OUTLIERS else 0.0


def found_in_logs(recordings: Sequence[Recording]) -> list[Scatter]:
    """Return what the logs show of spikes, repeated samples and lattices."""
    found: list[Scatter | None] = []
    repeats = [*_shares(recordings, "repeated").values(), *(each for r in recordings for each in r.log.lost.values())]
    hit, of = sum(h for h, _ in repeats), sum(n for _, n in repeats)
    if of and hit >= 5 and hit / of > 0.003:
        share = hit / of
        found.append(_share_found(betrayed_by("repeats"), "", share, of, hit, "repeat the sample before them"))
    lone = _shares(recordings, "lone").values()
    others = max(LOG_RULES.ordinary, sum(h for h, _ in lone) / max(sum(n for _, n in lone), 1))
    for signal, (hit, of) in _shares(recordings, "spikes").items():
        if of and hit / of > LOG_RULES.spikes and poisson.sf(hit - 1, others * of) < LOG_RULES.chance:
            share = hit / of / _VISIBLE
            found.append(_share_found(betrayed_by("spikes"), signal, share, of, hit, "are spikes"))
    hole = _hole(recordings)
    if hole > 0.0:
        readings = [m.values for r in recordings if (m := r.experiment.measurements.get("speed")) is not None]
        found.append(
            Scatter(
                effect=betrayed_by("zeros"),
                signal="speed",
                parameter="threshold",
                size=hole,
                deviation=edge_deviation(readings, hole),
                log_odds=LOG_RULES.certain,
                sentence=f"the tachometer reads zero below {hole:.3g} rad/s",
            )
        )
    steps = [r.log.lattice.get("speed", 0.0) for r in recordings if "speed" in r.experiment.measurements]
    if steps and min(steps) > 0.0 and max(steps) < 1.01 * min(steps):
        found.append(_lattice_found(recordings, float(np.median(steps))))
    return [each for each in found if each is not None]


def unlike_stated(found: Sequence[Scatter], stated: Mapping[str, Mapping[str, float]]) -> list[Scatter]:
    """Return what these sizes of a set's effects do not have: where a simulator does the same there is no gap."""

    def alike(each: Scatter) -> bool:
        size = stated.get(each.effect, {}).get(each.parameter, 0.0)
        return abs(each.size - size) < max(LOG_RULES.alike * size, 3.0 * each.deviation * (size > 0.0))

    return [each for each in found if not alike(each)]


_VISIBLE = 0.93
"""Share of spikes of 0.3 m/s that stand out of an ordinary velocimeter's noise."""


def probability_at(log_odds: float) -> float:
    """Return the probability of an effect for which a log speaks with these odds."""
    return float(1.0 / (1.0 + np.exp(-(min(log_odds, LOG_RULES.certain) - LOG_RULES.rare))))


def share_deviation(share: float, of: int) -> float:
    """Return the standard deviation of a share that was counted among so many samples."""
    return float(np.sqrt(max(share * (1.0 - share), 1e-6) / of))


def _share_found(effect: str, signal: str, share: float, of: int, hit: int, what: str) -> Scatter:
    sentence = f"{100 * hit / of:.1f} % of the samples{' of ' + signal if signal else ''} {what}"
    return Scatter(
        effect=effect,
        signal=signal,
        parameter="share",
        size=float(min(share, 1.0)),
        deviation=share_deviation(share, of),
        log_odds=2.0 * hit,
        sentence=sentence,
    )


def _lattice_found(recordings: Sequence[Recording], step: float) -> Scatter | None:
    noise = min(r.experiment.measurements["speed"].noise for r in recordings if "speed" in r.experiment.measurements)
    if step < LOG_RULES.lattice * noise:
        return None
    return Scatter(
        effect=betrayed_by("lattice"),
        signal="speed",
        parameter="step",
        size=step,
        deviation=1e-3 * step,
        log_odds=LOG_RULES.certain,
        sentence=f"all readings of the tachometer are multiples of {step:.3g} rad/s",
    )


def _shares(recordings: Sequence[Recording], name: str) -> dict[str, tuple[int, int]]:
    """Return by signal how many readings the logs show so, and of how many; one moves the mean of several."""
    counts: dict[str, tuple[int, int]] = {}
    for recording in recordings:
        for signal, mask in getattr(recording.log, name).items():
            width = recording.experiment.measurements[signal].width
            hit, of = counts.get(signal, (0, 0))
            counts[signal] = (hit + int(np.sum(mask)), of + recording.log.together(signal, width) * mask.size)
    return counts


def scattered_before_sorting(scatter: float, period: float) -> float:
    """Return the standard deviation [s] of stamps `period` [s] apart that scatter by `scatter` once put in order."""
    shocks = np.random.default_rng(0).standard_normal(4000)
    regular = np.arange(shocks.size)
    low, high = scatter / period, 20.0 * scatter / period
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if np.std(np.sort(regular + middle * shocks) - regular) < scatter / period else (low, middle)
        )
    return float(low * period)
