"""Hours in the sealed cases' world under the watch's own code: peaks of healthy vehicles, delays of a loss."""

from dataclasses import replace
from typing import Any

import numpy as np

from gap_diagnosis.vehicle.baseline import baseline
from gap_diagnosis.vehicle.blind.draws import SETS, Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded_run
from gap_diagnosis.vehicle.blind.truth import Truth, truth_of
from gap_diagnosis.vehicle.blind.world import COLUMNS
from gap_diagnosis.vehicle.false_alarms import Excursions
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import log_of
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.watching import Watch
from run_bag import Channel, Run, Topic

__all__ = ["Watched", "watched_draw"]

KINDS = ("hold", "steps", "sines")
LEARNED = ("steps", "sines")
"""Runs of a minute each that the watch learns from, as an operator would record them first."""
_MINUTE, _LATE, _AFTER = 60.0, 20.0, 60.0
_BASELINE, _LOSSES = 1000, 2000
"""Numbers of the runs: their programmes and noises differ from those of the hours."""


def watched_draw(seed: int) -> Draw:
    """Return a healthy vehicle with its water and sensors, drawn from a seed."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(83,)))
    return Draw(
        seed=seed, vehicle=str(rng.choice(SETS)), deviations=float(rng.uniform(0.4, 1.2)),
        wrench=float(rng.uniform(0.02, 0.4)), time=float(np.exp(rng.uniform(np.log(0.5), np.log(10.0)))),
        noise=float(np.exp(rng.uniform(-1.1, 1.1))), kinds=LEARNED, duration=_MINUTE,
    )  # fmt: skip


class Watched:
    """One drawn vehicle with what its watch has learned."""

    def __init__(self, draw: Draw, model: Model) -> None:
        """Record the baseline and learn from it."""
        self.draw, self.model = draw, model
        self._truth = truth_of(draw, model.vehicle, model.sets)
        logs = [self._log(self._truth, _BASELINE + k, kind, _MINUTE) for k, kind in enumerate(LEARNED)]
        self._values, self._noises = baseline(model, logs)

    def _log(self, truth: Truth, run: int, kind: str, duration: float) -> VehicleLog:
        draw = replace(self.draw, duration=duration)
        topics = recorded_run(draw, truth, self.model.vehicle, self.model.sensors, run, kind)
        return log_of(_run(topics), self.model.thrusters)

    def _ratios(self, log: VehicleLog) -> tuple[Watch, list[Any]]:
        watch, piece, found = Watch(self.model, self._noises, self._values), round(1.0 / log.period), []
        for first in range(0, log.count - piece + 1, piece):
            watch.step(log.part(first, first + piece))
            found.append(watch.ratios.copy())
        return watch, found

    def healthy(self, run: int, minutes: float) -> dict[str, Any]:
        """Return the peaks of one dive in which nothing is wrong."""
        kind = KINDS[run % len(KINDS)]
        log = self._log(self._truth, run, kind, minutes * _MINUTE)
        watch, ratios = self._ratios(log)
        seen = Excursions(len(watch.names))
        for each in ratios:
            seen.add(each)
        return {"kind": kind, "hours": log.duration / 3600.0, "peaks": [round(p, 2) for p in seen.close()]}

    def loss(self, run: int, share: float = 0.3) -> dict[str, Any]:
        """Return how the ratio of a thruster climbs that begins to lose thrust in mid-dive, second by second."""
        rng = np.random.default_rng(np.random.SeedSequence(self.draw.seed, spawn_key=(84, run)))
        i, kind = int(rng.integers(self.model.thrusters)), KINDS[run % len(KINDS)]
        table = self._truth.thrusters.copy()
        table[i, COLUMNS.index("share")], table[i, COLUMNS.index("since")] = 1.0 - share, _LATE
        log = self._log(self._truth._replace(thrusters=table), _LOSSES + run, kind, _LATE + _AFTER)
        watch, ratios = self._ratios(log)
        own = [j for j, name in enumerate(watch.names) if name[1] == i]
        late = round(_LATE)
        n = log.speeds[round(_LATE / log.period) :, i]
        thrust = float(np.nanmean(self.model.sets[i].coefficients.c_T2 * n**2)) * float(1.0 - share)
        return {
            "kind": kind, "thruster": i, "thrust": thrust,
            "ratios": [round(float(max(r[own])), 1) for r in ratios[late:]],
            "others": [round(float(np.delete(r, own).max()), 1) for r in ratios[late:]],
        }  # fmt: skip


def _run(topics: list[Topic]) -> Run:
    """Return topics as a run that was read back."""
    channels = {}
    for topic in topics:
        for path, values in topic.fields.items():
            name = f"{topic.name}.{path}"
            stamps = np.asarray(topic.stamps, dtype=np.int64)
            channels[name] = Channel(name=name, stamps=stamps, values=np.asarray(values, dtype=np.float64))
    return Run(name="made here", channels=channels)
