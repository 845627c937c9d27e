"""How fast the compiled filter is, against filterpy's with the same equations, in the same run."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from run_bag.benchmark_row import Row
from thruster_estimation.belief import initial_belief
from thruster_estimation.drift import jacobian, rates
from thruster_estimation.offline import COLUMNS, run_observer
from thruster_estimation.settings import bench_settings
from thruster_model.equations.thruster import ThrusterCoefficients, input_map
from thruster_model.parameter_set_io import load_parameter_set

_DT = 0.04
_START = initial_belief(deviation_n=2.0, deviation_v=0.07, deviation_U=0.07)


def rows(updates: int = 500_000) -> list[Row]:
    """Measure updates per second of the filter of n, v, U at 25 Hz (RK4, matrix exponential), best of three rounds.

    Plain: filterpy's extended filter of the same states, with one Euler step and I + F dt per period.
    """
    p = load_parameter_set("hl").coefficients
    few = updates // 500
    plain = max(_speed(lambda: _filterpy(few, p), few) for _ in range(3))
    return [Row("extended Kalman filter of n, v, U", _compiled("ekf", updates, p), plain, "updates/s")]


def _compiled(name: str, updates: int, p: ThrusterCoefficients) -> float:
    n, U, u = _inputs(updates)
    dt, settings, out = np.full(updates, _DT), bench_settings(name), np.empty((len(COLUMNS), updates))
    run_observer(n[:2], U[:2], u[:2], dt[:2], _START, settings, p, out[:, :2].copy())
    return max(_speed(lambda: run_observer(n, U, u, dt, _START, settings, p, out), updates) for _ in range(3))


def _inputs(count: int) -> tuple[Any, Any, Any]:
    phase = 0.01 * np.arange(count)
    return abs(100.0 * np.sin(phase)), 0.1 * np.sin(phase), 3.0 * np.sin(phase)


def _speed(action, count: int) -> float:  # type: ignore[no-untyped-def]
    begin = time.perf_counter()
    action()
    return count / (time.perf_counter() - begin)


def _filterpy(updates: int, p: ThrusterCoefficients) -> NDArray[np.float64]:
    # only for the comparison: filterpy is a requirement of the tests
    from filterpy.kalman import ExtendedKalmanFilter

    kalman = ExtendedKalmanFilter(dim_x=3, dim_z=2)
    settings = bench_settings("ekf")
    kalman.x, kalman.P = np.array(_START[:3]), np.diag([_START.P_nn, _START.P_vv, _START.P_UU])
    kalman.Q = _DT * np.diag([settings.q_n, settings.q_v, settings.q_U])
    kalman.R = np.diag([settings.r_n, settings.r_U])
    for y_n, y_U, u in zip(*_inputs(updates), strict=True):
        n, v, U = map(float, kalman.x)
        kalman.F = np.eye(3) + _DT * np.reshape(jacobian(n, v, U, p), (3, 3))
        kalman.x = kalman.x + _DT * np.array(rates(n, v, U, input_map(u, p), 0.0, False, p))
        kalman.P = kalman.F @ kalman.P @ kalman.F.T + kalman.Q
        sign = np.sign(kalman.x[0])
        kalman.update(
            np.array([y_n, y_U]),
            lambda x, sign=sign: np.array([[sign, 0.0, 0.0], [0.0, 0.0, 1.0]]),
            lambda x, sign=sign: np.array([sign * x[0], x[2]]),
        )
    return np.asarray(kalman.x)
