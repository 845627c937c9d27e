"""The scores of a recorded run of a vehicle, and their form in a file."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.poses import at_instants, attitudes_at, euler_angles
from rov_sim.vehicle.recording_io import VehicleRecording, signal
from rov_sim.vehicle.scores import DEGREES_OF_FREEDOM, Score, flow_score, score, vehicle_scores
from thruster_control.scores import chatter

__all__ = ["RunScores", "ThrusterScores", "as_mapping", "score_run"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ThrusterScores:
    """Of one thruster; NaN and no samples where one of the two signals was not recorded.

    Attributes:
        thrust: true against wanted [N].
        n, v: estimated against true [rad/s], [m/s].
        travel: of its throttle [V].
    """

    thrust: Score
    n: Score
    v: Score
    travel: float


@dataclass(frozen=True, kw_only=True)
class RunScores:
    """Of a run.

    Attributes:
        judged_by: the topic that says what the vehicle did.
        begin, end: of the scored stretch, since the run's start [s].
        tracking: of each degree of freedom, empty without set points.
        odometry: rov/odometry against rov/truth, per degree of freedom; empty where either is missing.
        v: the estimate of v over all thrusters.
        thrusters: by index.
    """

    judged_by: str
    begin: float
    end: float
    tracking: Mapping[str, Score]
    odometry: Mapping[str, Score]
    v: Score
    thrusters: Mapping[int, ThrusterScores]


def score_run(recording: VehicleRecording, *, begin: float = 0.0, end: float = np.inf) -> RunScores:
    """Return the scores of what lies between `begin` and `end` [s since the run's start]."""
    motion, wanted = recording.motion, recording.set_points
    own = motion.time[(motion.time >= begin) & (motion.time <= end)]
    if own.size == 0:
        raise ValueError(f"expected {recording.judged_by} between {begin:g} s and {end:g} s; found no sample")
    tracking: dict[str, Score] = {}
    if wanted is not None:
        kept = (wanted.time >= begin) & (wanted.time <= end)
        time = wanted.time[kept]
        angles = euler_angles(attitudes_at(time, motion.time, motion.attitude))
        velocity = at_instants(time, motion.time, motion.velocity)
        tracking = vehicle_scores(angles, velocity, wanted.angles[kept], wanted.rates[kept], wanted.velocity[kept])
    estimated, true = [], []
    thrusters = {}
    for index in recording.thrusters:
        pairs = {
            name: _pair(recording, f"thruster_{index}/{ours}", f"thruster_{index}/truth.{theirs}", (begin, end))
            for name, ours, theirs in (("n", "estimate.n", "n"), ("v", "estimate.v", "axial"))
        }
        wish, thrust = _pair(
            recording, f"thruster_{index}/thrust_setpoint.thrust", f"thruster_{index}/truth.thrust", (begin, end)
        )
        throttle = signal(recording.run, f"thruster_{index}/throttle.commanded")
        thrusters[index] = ThrusterScores(
            thrust=score(thrust, wish), n=score(*pairs["n"]), v=flow_score(*pairs["v"]),
            travel=np.nan if throttle is None else chatter(throttle[1][_inside(throttle[0], (begin, end))]),
        )  # fmt: skip
        estimated.append(pairs["v"][0])
        true.append(pairs["v"][1])
    none = np.empty(0)
    return RunScores(
        judged_by=recording.judged_by, begin=float(own[0]), end=float(own[-1]), tracking=tracking,
        odometry=_odometry(recording, (begin, end)),
        v=flow_score(np.concatenate([none, *estimated]), np.concatenate([none, *true])), thrusters=thrusters,
    )  # fmt: skip


def _inside(time: Array, stretch: tuple[float, float]) -> NDArray[np.bool_]:
    return (time >= stretch[0]) & (time <= stretch[1])


def _pair(recording: VehicleRecording, ours: str, theirs: str, stretch: tuple[float, float]) -> tuple[Array, Array]:
    """Return a channel and the truth at its instants, empty where either was not recorded."""
    one, other = signal(recording.run, ours), signal(recording.run, theirs)
    if one is None or other is None:
        return np.empty(0), np.empty(0)
    kept = _inside(one[0], stretch)
    return one[1][kept], at_instants(one[0][kept], *other)


def _odometry(recording: VehicleRecording, stretch: tuple[float, float]) -> dict[str, Score]:
    truth, odometry = recording.truth, recording.odometry
    if truth is None or odometry is None:
        return {}
    kept = _inside(odometry.time, stretch)
    time = odometry.time[kept]
    said = np.hstack([odometry.velocity[kept], euler_angles(odometry.attitude[kept])])
    true = np.hstack(
        [
            at_instants(time, truth.time, truth.velocity),
            euler_angles(attitudes_at(time, truth.time, truth.attitude)),
        ]
    )
    return {
        each.id: score(said[:, k], true[:, k], angle=each.unit == "rad") for k, each in enumerate(DEGREES_OF_FREEDOM)
    }


def as_mapping(scores: RunScores) -> dict[str, Any]:
    """Return scores as JSON has them, null where there is none; what a truth is compared with is no set point."""
    units = {each.id: each.unit for each in DEGREES_OF_FREEDOM}
    return {
        "judged_by": scores.judged_by,
        "begin": scores.begin,
        "end": scores.end,
        "tracking": {name: {**_plain(each), "unit": units[name]} for name, each in scores.tracking.items()},
        "odometry": {
            name: {**_plain(each, "mean_true"), "unit": units[name]} for name, each in scores.odometry.items()
        },
        "v": {**_plain(scores.v, "mean_true"), "unit": "m/s"},
        "thrusters": {
            str(index): {
                "thrust": {**_plain(each.thrust), "unit": "N"},
                "n": {**_plain(each.n, "mean_true"), "unit": "rad/s"},
                "v": {**_plain(each.v, "mean_true"), "unit": "m/s"},
                "travel": {"value": _number(each.travel), "unit": "V"},
            }
            for index, each in scores.thrusters.items()
        },
    }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


def _plain(one: Score, reference: str = "set_point") -> dict[str, float | int | None]:
    values = {name: _number(value) for name, value in one._asdict().items()}
    return {reference if name == "set_point" else name: value for name, value in values.items()}
