"""What came of a run as numbers: the thesis' normalised errors (`vehicle.scores`), and what explains them."""

from math import inf

import numpy as np
from numpy.typing import NDArray

from rov_sim.study.statistics import rms
from rov_sim.vehicle.loop import VehicleLoopRun
from rov_sim.vehicle.scores import flow_score, vehicle_scores
from thruster_control.inner_loop import Status as LoopStatus
from thruster_estimation.belief import Status
from thruster_estimation.navigation_belief import NavigationStatus

__all__ = ["SCORES", "UNITS", "score"]

Array = NDArray[np.float64]

UNITS = {
    "surge": "1", "pitch_rate": "1", "pitch": "1", "sway": "m/s", "heave": "m/s", "roll": "rad", "yaw": "rad",
    "thrust": "N", "n_hat": "rad/s", "v_hat": "1", "v_hat_rms": "m/s", "v_largest": "m/s", "U_hat": "m/s",
    "limited": "1", "lost": "1",
}  # fmt: skip
"""surge, pitch_rate, pitch: normalised errors of the true motion; sway, heave, roll, yaw: root mean square, their set
points are zero. thrust: true less wanted, all thrusters. n_hat, U_hat: errors of what the laws took for it; v_hat: the
normalised one, v_hat_rms, v_largest [m/s]: root mean square and largest. limited: share of the periods in which a
throttle or its rate was at a limit. lost: 1 for a run in which an observer was started again, v̂ was off by 1 m/s or an
angle by 1 rad, else 0."""
SCORES = tuple(UNITS)
_LOST_FLOW, _LOST_ATTITUDE = 1.0, 1.0  # m/s, rad
_RESTARTED, _NAVIGATION_RESTARTED = int(Status.RESTARTED), int(NavigationStatus.RESTARTED)


def score(run: VehicleLoopRun) -> dict[str, float]:
    """Return the `SCORES` of a run; all but `lost` infinite where it left the numbers."""
    r, wanted = run.record, run.wanted()
    if not bool(np.all(np.isfinite(r.velocity)) and np.all(np.isfinite(r.attitude))):
        return {name: 1.0 if name == "lost" else inf for name in SCORES}
    s = vehicle_scores(run.angles(), r.velocity, wanted.attitude, wanted.attitude_rate, wanted.velocity)
    v = flow_score(run.of("v"), r.axial)
    restarted = bool(np.any(run.of("observer_status").astype(np.int64) & _RESTARTED))
    astray = any(not s[name].largest < _LOST_ATTITUDE for name in ("roll", "pitch", "yaw")) or v.largest >= _LOST_FLOW
    found = {name: s[name].normalised for name in ("surge", "pitch_rate", "pitch")}
    found |= {name: s[name].rmse for name in ("sway", "heave", "roll", "yaw")}
    return found | {
        "thrust": rms(r.thrust - r.T_d),
        "n_hat": rms(run.of("n") - r.n),
        "v_hat": v.normalised,
        "v_hat_rms": v.rmse,
        "v_largest": v.largest,
        "U_hat": rms(run.of("U") - r.ambient),
        "limited": float(np.mean(run.of("loop_status") == LoopStatus.LIMITED)),
        "lost": float(restarted or astray or bool(np.any(r.status[:, 2] & _NAVIGATION_RESTARTED))),
    }
