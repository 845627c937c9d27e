"""All inner loops of a vehicle in one kernel: the same numbers as the steps that the nodes of each thruster take."""

from math import nan

import numpy as np
import pytest

from rov_sim.vehicle.inner_loops import ESTIMATES, Wiring, inner_loops_at_rest, inner_loops_tick
from thruster_control import online as law_online
from thruster_control.strategies_io import load_strategy
from thruster_estimation import online as observer_online
from thruster_estimation.belief import Level, level
from thruster_estimation.settings import bench_settings

PERIOD = 0.04
PERIOD_NS = 40_000_000
THRUSTERS, TICKS = 3, 40


def measured(rng) -> tuple:  # type: ignore[no-untyped-def]
    """Wanted thrust, measured speed and ambient flow of all ticks; a speed and a flow are missing now and then."""
    T_d = rng.normal(0.0, 8.0, (TICKS, THRUSTERS))
    y_n = rng.normal(0.0, 60.0, (TICKS, THRUSTERS))
    y_U = rng.normal(0.0, 0.2, (TICKS, THRUSTERS))
    y_n[7, 1] = y_U[9, 0] = y_U[9, 2] = T_d[12, 0] = nan
    return T_d, y_n, y_U


def by_nodes_steps(name: str, observer, T_d, y_n, y_U) -> np.ndarray:  # type: ignore[no-untyped-def]
    """One thruster as observer node and inner loop node step it."""
    ready = load_strategy(name)
    belief_track, law_track, held = observer_online.START, law_online.START, nan
    out = np.empty((TICKS, 4))
    for k in range(TICKS):
        stamp = k * PERIOD_NS
        estimate, valid = (nan, nan, nan), False
        if ready.strategy.observer != "none":
            seen = observer_online.Measured(stamp, float(y_n[k]), float(y_U[k]), False)
            belief_track = observer_online.advance(belief_track, seen, held, observer, ready.coefficients)
            assert belief_track.belief is not None
            estimate = observer_online.states(belief_track.belief, observer)
            valid = level(belief_track.belief.status) != Level.INVALID
        U = float(y_U[k]) if name == "steady-flow" else estimate[2]
        given = law_online.Inputs(stamp, float(T_d[k]), estimate[0], estimate[1], U, valid, nan, 0.0)
        law_track, answer = law_online.advance(law_track, given, PERIOD, ready.settings, ready.coefficients)
        held = answer.u
        out[k] = *estimate[:2], U, held
    return out


@pytest.mark.parametrize(
    "name",
    [
        "lookup", "dead-zone", "hq-nlo", "hq-kfnlo",
        *(pytest.param(each, marks=pytest.mark.long) for each in ("simplified", "steady-flow", "hl-ekf")),
    ],
)  # fmt: skip
def test_all_loops_in_one_kernel_are_the_nodes_steps_thruster_by_thruster(name: str) -> None:
    ready = load_strategy(name)
    chosen = "speed-ekf" if ready.strategy.observer == "none" else ready.strategy.observer
    observer = bench_settings(chosen, dt=PERIOD)._replace(unsigned=0)
    wiring = Wiring(int(ready.strategy.observer != "none"), int(chosen != "speed-ekf"), int(name == "steady-flow"))
    T_d, y_n, y_U = measured(np.random.default_rng(1))
    loops, told = inner_loops_at_rest(THRUSTERS), np.empty((TICKS, THRUSTERS, len(ESTIMATES)))
    for k in range(TICKS):
        inner_loops_tick(
            loops, k == 0, T_d[k], y_n[k], y_U[k], PERIOD, wiring, observer, ready.settings, ready.coefficients, told[k]
        )
    expected = np.stack([by_nodes_steps(name, observer, *(x[:, i] for x in (T_d, y_n, y_U))) for i in range(THRUSTERS)])
    np.testing.assert_allclose(np.swapaxes(told[:, :, :4], 0, 1), expected, rtol=1e-12, atol=1e-13)
    assert np.ptp(told[:, :, 3]) > 1.0
