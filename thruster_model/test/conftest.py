"""A bench that shares no code with the package: equations written anew, integrated by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from thruster_model.identification.experiment import Experiment, Measurement

CELL = 0.04
NOISE = {"speed": 0.3, "axial": 0.008, "ambient": 0.008, "thrust": 0.1, "torque": 4e-4}


def _gamma(u, q):
    if u < q["delta_u1"]:
        return q["c_u1"] * (u - q["delta_u1"])
    return q["c_u2"] * (u - q["delta_u2"]) if u > q["delta_u2"] else 0.0


def _rates(t, x, throttle, q):
    n, v, w = x
    force = q["c_n_T"] * n * abs(n) - q["c_nv_T"] * abs(n) * v - q.get("c_v_T", 0.0) * v * abs(v)
    moment = q["c_n_Q"] * n * abs(n) - q["c_nv_Q"] * abs(n) * v - q.get("c_v_Q", 0.0) * v * abs(v)
    return (
        -q["k_n"] * n - q["k_Q"] * moment + _gamma(throttle(t), q),
        -q["k_v"] * v - q["k_Uv"] * abs(v) * (v - q["k_w"] * w) + q["k_Tv"] * force,
        -q["k_U"] * w - q["k_UU"] * w * abs(w) + q["k_TU"] * force,
    )


def _loads(x, q):
    n, v, _ = x
    force = q["c_n_T"] * n * abs(n) - q["c_nv_T"] * abs(n) * v - q.get("c_v_T", 0.0) * v * abs(v)
    moment = q["c_n_Q"] * n * abs(n) - q["c_nv_Q"] * abs(n) * v - q.get("c_v_Q", 0.0) * v * abs(v)
    return force, moment


def record(name, throttle, duration, parameters, rng, signals, *, drop=None):
    """Return an experiment of `duration` [s] with the smooth throttle(t) [V] and white noise of NOISE on cell means."""
    q = dict(parameters)
    fine = np.arange(0.0, duration, 0.005) + 0.0025
    solution = solve_ivp(
        _rates, (0.0, duration), np.zeros(3), t_eval=fine, args=(throttle, q), max_step=0.02, rtol=1e-6, atol=1e-9
    )
    force, moment = np.array([_loads(x, q) for x in solution.y.T]).T
    n, v, w = solution.y
    true = {"speed": n, "axial": v, "ambient": w, "thrust": force, "torque": moment}
    time = CELL * (np.arange(int(duration / CELL)) + 0.5)
    measurements = {}
    for signal in signals:
        means = true[signal][: time.size * 8].reshape(-1, 8).mean(axis=1)
        values = means + NOISE[signal] * rng.standard_normal(time.size)
        if drop is not None:
            values = np.where(drop(time), np.nan, values)
        measurements[signal] = Measurement(
            signal=signal, time=time, values=values, width=CELL, noise=NOISE[signal]
        )
    dt = 0.002
    at = dt * np.arange(int(duration / dt)) + 0.5 * dt
    commands = np.array([throttle(t) for t in at])
    return Experiment(name=name, dt=dt, throttle=commands, measurements=measurements)


@pytest.fixture
def independent_bench():
    """The function `record`."""
    return record
