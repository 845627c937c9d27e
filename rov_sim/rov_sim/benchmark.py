"""How fast the compiled closed loop is: simulated time over time, against the same loop in plain Python steps."""

from __future__ import annotations

import time

import numpy as np

from rov_sim.bench_study.controllers import controller
from rov_sim.closed_loop import Plant, simulate_loop
from rov_sim.vehicle import benchmark as vehicle
from run_bag.benchmark_row import Row
from thruster_control.inner_loop import AT_REST, inner_loop_step
from thruster_control.references import DURATION, sine
from thruster_estimation.observers import observer_step
from thruster_model.flow_tank import PlantState, simulate
from thruster_model.parameter_set_io import load_parameter_set

_PERIOD = 0.04


def rows(rounds: int = 50) -> list[Row]:
    """Measure the sine with HL and the EKF over 10 s, best of three; plain: the steps called one by one from Python."""
    p = load_parameter_set("hl_bench").coefficients
    T_d = sine(_PERIOD * np.arange(round(DURATION / _PERIOD)))
    plant, control = Plant(coefficients=p), controller("hl-ekf", p)
    simulate_loop(T_d, plant, control)
    ours = max(_speed(lambda: simulate_loop(T_d, plant, control), rounds) for _ in range(3))
    few = T_d[: T_d.size // 10]
    plain = max(_speed(lambda: _plain(few, p, control), 1) / 10 for _ in range(3))
    return [Row("closed loop of one thruster, 1 kHz plant", ours, plain, "x real time"), *vehicle.rows()]


def _speed(action, rounds: int) -> float:  # type: ignore[no-untyped-def]
    begin = time.perf_counter()
    for _ in range(rounds):
        action()
    return rounds * DURATION / (time.perf_counter() - begin)


def _plain(T_d, p, control) -> float:  # type: ignore[no-untyped-def]
    state, memory, belief = simulate(p, [0.0], 1e-3), AT_REST, control.belief
    for wanted in map(float, T_d):
        memory, out = inner_loop_step(
            memory, wanted, belief.n, belief.v, belief.U, True, _PERIOD, control.law, control.coefficients
        )
        belief, _ = observer_step(
            belief, abs(float(state.n[-1])), float(state.ambient[-1]), _PERIOD, out.u, control.observer, p
        )
        last = (state.n[-1], state.v[-1], state.ambient[-1], state.u[-1])
        state = simulate(p, [out.u], _PERIOD, initial=PlantState(*map(float, last)))
    return float(state.n[-1])
