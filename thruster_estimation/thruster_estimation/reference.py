r"""Reference observers by filterpy, for recordings: an unscented filter, and the fixed-interval smoother behind it.

States, equations (4.3) to (4.5), noise and ceilings are those of `ekf` in the proper form; what is made of them is not:

ukf   no Jacobian: seven points x, x +- (sqrt(3 P))_i go through the period and tell mean and covariance (Merwe's rule,
      alpha = 1, beta = 2, kappa = 0); both measurements of an instant correct at once.
rts   backwards over the whole recording, x_k <- x_k + K (x_k+1 - f(x_k)): what this model and these sensors can tell
      once the future is known too. No observer in a loop can come nearer.

Nothing is gated: they say what the measurements say.
"""

from collections.abc import Iterator
from math import isfinite, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_estimation.belief import Belief, Status
from thruster_estimation.correction import bounded, innovation_of, speed_measured
from thruster_estimation.errors import EstimationError
from thruster_estimation.matrices import Covariance
from thruster_estimation.offline import COLUMNS, History
from thruster_estimation.propagation import drive_of, predicted
from thruster_estimation.settings import EkfSettings
from thruster_estimation.stepping import concluded, period_of, with_unknown_drive
from thruster_model.compilation import compiled

__all__ = ["REFERENCES", "look_back"]

Array = NDArray[np.float64]
REFERENCES = ("ukf", "rts")
_AMBIGUOUS, _CEILING = int(Status.AMBIGUOUS), int(Status.CEILING)
_STATES = tuple(COLUMNS.index(name) for name in ("n", "v", "U"))
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@compiled
def _period(n, v, U, dt, drive, settings, p):  # type: ignore[no-untyped-def]
    """Return (n, v, U, Q) after `dt` [s]; Q: covariance of what the process noise adds meanwhile."""
    return predicted(n, v, U, Covariance(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), dt, drive, nan, False, settings, p)


def look_back(
    name: str, y_n: Array, y_U: Array, u: Array, dt: Array, belief: Belief, settings: EkfSettings, p: Any
) -> History:
    """Run a reference observer over N periods, as `offline.observe` does an observer.

    The smoother has no innovations of its own: its columns of them are NaN.

    Args:
        name: one of `REFERENCES`.
        y_n: measured speeds [rad/s], y_U: measured ambient flows [m/s], u: throttles [V], dt: periods [s]; each of
            shape (N,), NaN = not measured.
        belief: before the first period.
        settings: `EkfSettings`; p: `ThrusterCoefficients`.

    Raises:
        EstimationError: its covariance is none any more.
    """
    run = _Unscented(y_n, y_U, u, dt, belief, settings, p)
    try:
        history = run.forward()
        return history if name == "ukf" else run.backward(history)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise EstimationError([f"{name}: expected a covariance at sample {run.step}; found {error}"]) from error


class _Unscented:
    """filterpy's filter over one recording; what filterpy calls a time step is here the number of the period."""

    def __init__(self, y_n: Array, y_U: Array, u: Array, dt: Array, belief: Belief, settings: Any, p: Any) -> None:
        from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter  # half a second, for references only

        self._measured, self._u, self._dt = (y_n, y_U), u, dt
        self._belief, self._settings, self._p = belief, settings, p
        self._drives, self._noises = np.zeros(u.size), np.zeros((u.size, 3, 3))
        self._points = MerweScaledSigmaPoints(3, alpha=1.0, beta=2.0, kappa=0.0)
        self._filter = UnscentedKalmanFilter(3, 2, 0, None, self._moved, self._points)
        self._filter.x, self._filter.P = np.array(belief[:3]), _matrix(Covariance(*belief[3:9]))
        self.step = 0

    def _moved(self, x: Array, k: int) -> Array:
        n, v, U = x
        return np.array(_period(n, v, U, self._dt[k], self._drives[k], self._settings, self._p)[:3])

    def forward(self) -> History:
        """Return what the filter believes after each period."""
        out, belief, ukf = np.empty((len(COLUMNS), self._u.size)), self._belief, self._filter
        self._states, self._covariances = np.empty((self._u.size, 3)), np.empty((self._u.size, 3, 3))
        for k in range(self._u.size):
            self.step = k
            flags = self._predict(k)
            P = _covariance(ukf.P)
            y_n, r_n, ambiguous = speed_measured(float(ukf.x[0]), P.nn, float(self._measured[0][k]), self._settings)
            y_U = float(self._measured[1][k] - ukf.x[2])
            used = [isfinite(y_n), isfinite(y_U)]
            found = innovation_of(
                y_n, y_U if used[1] else nan, P.nn + r_n if used[0] else nan, P.nU if all(used) else nan,
                P.UU + self._settings.r_U if used[1] else nan, *used,
            )  # fmt: skip
            self._correct(np.array([y_n, y_U]), np.array([r_n, self._settings.r_U]), np.array(used))
            flags |= _AMBIGUOUS if ambiguous and used[0] else 0
            n, v, U = map(float, ukf.x)
            P, stale = _covariance(ukf.P), self._settings.stale
            belief, found = concluded(belief, n, v, U, P, found, flags, self._dt[k], P, stale, self._settings)
            out[:, k] = [*belief[:10], *found]
            self._states[k], self._covariances[k] = ukf.x, ukf.P
        return History(out, belief)

    def _predict(self, k: int) -> int:
        """Predict over period k; return flags."""
        ukf, dt, u, s = self._filter, self._dt[k], self._u[k], self._settings
        n, v, U = map(float, ukf.x)
        self._drives[k] = drive_of(n, v, u, self._p)
        Q = _period(n, v, U, dt, self._drives[k], s, self._p)[3]
        self._noises[k] = _matrix(Q._replace(nn=with_unknown_drive(Q.nn, u, dt, s)))
        ukf.Q = self._noises[k]
        ukf.predict(k)
        P, at_ceiling = bounded(_covariance(ukf.P), s.largest_n, s.largest_v, s.largest_U)
        ukf.P = _matrix(P)
        ukf.sigmas_f = self._points.sigma_points(ukf.x, ukf.P)
        return int(period_of(dt, u)[1]) | (_CEILING if at_ceiling else 0)

    def _correct(self, y: Array, r: Array, used: NDArray[np.bool_]) -> None:
        """Correct by the innovations y of n and U that are used; r: their variances."""
        ukf, seen = self._filter, np.array([0, 2])[used]
        if seen.size:
            ukf.update(ukf.x[seen] + y[used], R=np.diag(r[used]), hx=lambda x: x[seen])
            ukf.P = 0.5 * (ukf.P + ukf.P.T)

    def backward(self, history: History) -> History:
        """Return what the smoother makes of the filter's beliefs."""
        from filterpy.kalman import unscented_transform

        noises: Iterator[Array] = iter(self._noises[:0:-1])

        def transform(points: Array, means: Array, weights: Array, _: Any, *how: Any) -> Any:
            return unscented_transform(points, means, weights, next(noises), *how)  # filterpy's would be the last one

        periods = [*range(1, self._u.size), 0]  # from sample k to the next
        x, P, _ = self._filter.rts_smoother(self._states, self._covariances, dts=periods, UT=transform)
        out = history.table.copy()
        out[list(_STATES)] = x.T
        for row, (i, j) in enumerate(_PAIRS, start=COLUMNS.index("P_nn")):
            out[row] = P[:, i, j]
        out[COLUMNS.index("y_n") : COLUMNS.index("dof")] = nan
        return History(out, history.last)


def _matrix(P: Covariance) -> Array:
    return np.array([[P.nn, P.nv, P.nU], [P.nv, P.vv, P.vU], [P.nU, P.vU, P.UU]])


def _covariance(P: Array) -> Covariance:
    return Covariance(*(float(P[i, j]) for i, j in _PAIRS))
