"""A bench that shares no code with the package: equations written anew, integrated by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from run_bag import Topic, write_run
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


def _simulate(throttle, duration, q, at):
    """Return every signal at the instants `at` [s]."""
    solution = solve_ivp(
        _rates,
        (0.0, duration),
        np.zeros(3),
        t_eval=at,
        args=(throttle, q),
        max_step=0.02,
        rtol=1e-6,
        atol=1e-9,
    )
    force, moment = np.array([_loads(x, q) for x in solution.y.T]).T
    n, v, w = solution.y
    return {"speed": n, "axial": v, "ambient": w, "thrust": force, "torque": moment}


def record(name, throttle, duration, parameters, rng, signals, *, drop=None):
    """Return an experiment of `duration` [s] of the smooth throttle(t) [V], white NOISE on cell means."""
    true = _simulate(throttle, duration, dict(parameters), np.arange(0.0, duration, 0.005) + 0.0025)
    time = CELL * (np.arange(int(duration / CELL)) + 0.5)
    measurements = {}
    for signal in signals:
        means = true[signal][: time.size * 8].reshape(-1, 8).mean(axis=1)
        values = means + NOISE[signal] * rng.standard_normal(time.size)
        if drop is not None:
            values = np.where(drop(time), np.nan, values)
        measurements[signal] = Measurement(signal=signal, time=time, values=values, width=CELL, noise=NOISE[signal])
    dt = 0.002
    at = dt * np.arange(int(duration / dt)) + 0.5 * dt
    commands = np.array([throttle(t) for t in at])
    return Experiment(name=name, dt=dt, throttle=commands, measurements=measurements)


@pytest.fixture
def independent_bench():
    """The function `record`."""
    return record


def topic(name, kind, time, fields):
    """Return a topic of thruster 0 with stamps at `time` [s], on a clock that starts at 1 s."""
    package = "geometry_msgs" if kind == "WrenchStamped" else "thruster_msgs"
    stamps = 1_000_000_000 + np.round(np.asarray(time) * 1e9).astype(np.int64)
    return Topic(name=name, type=f"{package}/msg/{kind}", stamps=stamps, fields=fields)


def record_run(folder, throttle, duration, parameters, rng, *, flow="axial", metadata=None):
    """Write what the bench records of the smooth throttle(t) [V] as the run `folder`, and return that.

    At 500 Hz rotor speed with an unsigned rest value of 1.2 rad/s, thrust and torque; flow at 25 Hz.
    """
    time = np.arange(0.0, duration, 0.002)
    true = _simulate(throttle, duration, dict(parameters), time)
    commands = np.array([throttle(t + 0.001) for t in time])
    speed = np.where(true["speed"] < 0.0, -1.0, 1.0) * (np.abs(true["speed"]) + 1.2)
    slow = np.arange(0.0, duration, CELL)
    velocity = np.interp(slow, time, true[flow]) + NOISE[flow] * rng.standard_normal(slow.size)
    noise = {name: np.sqrt(20.0) * NOISE[name] * rng.standard_normal(time.size) for name in NOISE}
    load = {
        "wrench.force.x": 0.7 + true["thrust"] + noise["thrust"],
        "wrench.torque.x": 0.004 + true["torque"] + noise["torque"],
    }
    inferred = np.full(time.size, 2)
    topics = [
        topic("thruster_0/throttle", "Throttle", time, {"commanded": commands}),
        topic("thruster_0/state", "ThrusterState", time, {"n": speed + noise["speed"], "sign_source": inferred}),
        topic("thruster_0/load", "WrenchStamped", time, load),
        topic("thruster_0/flow", "FlowVelocity", slow, {flow: velocity}),
    ]
    return write_run(folder, topics, metadata or {})


@pytest.fixture
def bench_topic():
    """The function `topic`."""
    return topic


@pytest.fixture(scope="session")
def recorded_run():
    """The function `record_run`."""
    return record_run
