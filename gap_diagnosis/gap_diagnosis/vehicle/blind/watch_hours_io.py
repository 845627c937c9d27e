"""Hours in the sealed cases' world under the watch's own code: peaks of healthy vehicles, delays of failures."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.baseline import baseline
from gap_diagnosis.vehicle.blind.draws import SETS, Draw
from gap_diagnosis.vehicle.blind.recording_io import LATE, recorded_run
from gap_diagnosis.vehicle.blind.truth import Truth, truth_of
from gap_diagnosis.vehicle.blind.world import COLUMNS
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import log_of, suited_period
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.watching import Watch
from run_bag import Channel, Run, Topic

__all__ = ["Watched", "watched_draw"]

KINDS = ("hold", "steps", "sines")
LEARNED = ("steps", "sines")
"""Runs of a minute each that the watch learns from, as an operator would record them first."""
_MINUTE, _AFTER = 60.0, 60.0
_BASELINE, _LOSSES, _FAILURES = 1000, 2000, 3000
"""Numbers of the runs: their programmes and noises differ from those of the hours."""
EFFECTS = {
    "gyro": "imu_bias.rate", "accelerometer": "imu_bias.force", "velocity log": "velocity_scale.share",
    "tachometer": "tach_scale.share", "foam lost": "buoyancy_offset.force",
    "depth sensor": "depth_bias.offset", "compass": "heading_bias.angle",
}  # fmt: skip
"""What fails beside thrusters, and the effect and its parameter that tell of it: a gyro off by 0.03 rad/s, an
accelerometer by 0.4 m/s^2, a velocity log by a quarter, a tachometer that tells 0, 5 N of foam, jumps of a depth sensor
by 0.3 to 1 m, of a compass by 0.3 to 1 rad."""


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
        runs = [self._run(self._truth, _BASELINE + k, kind, _MINUTE) for k, kind in enumerate(LEARNED)]
        self.model = replace(model, period=suited_period(runs, model.thrusters))  # as `watch` does
        self._healthy = baseline(self.model, [self._read(run) for run in runs])

    def _run(self, truth: Truth, run: int, kind: str, duration: float, outside: str = "") -> Run:
        draw = replace(self.draw, duration=duration, outside=outside)
        return _as_run(recorded_run(draw, truth, self.model.vehicle, self.model.sensors, run, kind))

    def _read(self, run: Run) -> VehicleLog:
        return log_of(run, self.model.thrusters, self.model.period, stated=self.model.mounted)

    def _log(self, truth: Truth, run: int, kind: str, duration: float, outside: str = "") -> VehicleLog:
        return self._read(self._run(truth, run, kind, duration, outside))

    def _ratios(self, log: VehicleLog) -> tuple[Watch, list[Any]]:
        watch, piece, found = Watch(self.model, self._healthy), round(1.0 / log.period), []
        for first in range(0, log.count - piece + 1, piece):
            watch.step(log.part(first, first + piece))
            found.append(watch.ratios.copy())
        return watch, found

    def healthy(self, run: int, minutes: float) -> dict[str, Any]:
        """Return the highest log ratio of all failures in each minute of a dive in which nothing is wrong."""
        kind = KINDS[run % len(KINDS)]
        log = self._log(self._truth, run, kind, minutes * _MINUTE)
        highest = np.max(self._ratios(log)[1], axis=1)
        peaks = [round(float(each.max()), 2) for each in np.split(highest, range(60, highest.size, 60))]
        return {"kind": kind, "hours": log.duration / 3600.0, "minutes": peaks}

    def loss(self, run: int, share: float = 0.3) -> dict[str, Any]:
        """Return how the ratio of a thruster climbs that begins to lose thrust in mid-dive, second by second."""
        rng = np.random.default_rng(np.random.SeedSequence(self.draw.seed, spawn_key=(84, run)))
        i, kind = int(rng.integers(self.model.thrusters)), KINDS[run % len(KINDS)]
        table = self._truth.thrusters.copy()
        table[i, COLUMNS.index("share")], table[i, COLUMNS.index("since")] = 1.0 - share, LATE
        log = self._log(self._truth._replace(thrusters=table), _LOSSES + run, kind, LATE + _AFTER)
        n = log.speeds[round(LATE / log.period) :, i]
        thrust = float(np.nanmean(self.model.sets[i].coefficients.c_T2 * n**2)) * float(1.0 - share)
        return {"kind": kind, "thruster": i, "thrust": thrust, **self._climbs(log, "thrust_loss.share", i)}

    def failure(self, run: int) -> dict[str, Any]:
        """Return how the ratio of a sensor climbs that fails in mid-dive, or of foam that is lost then, likewise."""
        rng = np.random.default_rng(np.random.SeedSequence(self.draw.seed, spawn_key=(85, run)))
        name, kind = list(EFFECTS)[run % len(EFFECTS)], KINDS[int(rng.integers(len(KINDS)))]
        outside = "lost_foam" if name == "foam lost" else ""
        log = self._log(self._truth, _FAILURES + run, kind, LATE + _AFTER, outside)
        told, speeds, begun = log.told.copy(), log.speeds.copy(), round(LATE / log.period)
        place: str | int | None = None
        axis, sign = int(rng.integers(3)), float(rng.choice((-1.0, 1.0)))
        jump, attitude = float(rng.uniform(0.3, 1.0)) * sign, log.attitude.copy()
        if name == "gyro":
            place, told[begun:, 3 + axis] = "xyz"[axis], told[begun:, 3 + axis] + 0.03 * sign
        elif name == "accelerometer":
            place, told[begun:, 6 + axis] = "xyz"[axis], told[begun:, 6 + axis] + 0.4 * sign
        elif name == "velocity log":
            told[begun:, 10:] *= 1.0 + 0.25 * sign
        elif name == "tachometer":
            place = int(rng.integers(self.model.thrusters))
            speeds[begun:, place] = 0.0
        elif name == "depth sensor":
            told[begun:, 9] += jump
        elif name == "compass":
            read = begun + np.flatnonzero(np.isfinite(attitude[begun:]).all(axis=1))
            turned = Rotation.from_euler("z", jump) * Rotation.from_quat(np.roll(attitude[read], -1, axis=1))
            attitude[read] = np.roll(turned.as_quat(), 1, axis=1)
        spoiled = replace(log, told=told, speeds=speeds, attitude=attitude)
        return {"kind": kind, "failure": name, **self._climbs(spoiled, EFFECTS[name], place)}

    def _climbs(self, log: VehicleLog, effect: str, place: str | int | None) -> dict[str, list[float]]:
        """Return the log ratio of one effect in its place, and the largest of all others, from `LATE` on."""
        watch, ratios = self._ratios(log)
        own = [
            j
            for j, (h, _) in enumerate(watch.followed)
            if f"{h.effect}.{h.parameters[0]}" == effect and place in (h.thruster, h.axis)
        ]
        return {
            "ratios": [round(float(max(r[own])), 1) for r in ratios[round(LATE) :]],
            "others": [round(float(np.delete(r, own).max()), 1) for r in ratios[round(LATE) :]],
        }


def _as_run(topics: list[Topic]) -> Run:
    """Return topics as a run that was read back."""
    channels = {}
    for topic in topics:
        for path, values in topic.fields.items():
            name = f"{topic.name}.{path}"
            stamps = np.asarray(topic.stamps, dtype=np.int64)
            channels[name] = Channel(name=name, stamps=stamps, values=np.asarray(values, dtype=np.float64))
    return Run(name="made here", channels=channels)
