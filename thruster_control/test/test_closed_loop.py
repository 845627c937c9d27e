"""The laws on the plant: Fig. 3.7, tracking, windup, noise about zero, loss of the estimate."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from thruster_control.dead_zone_compensation import compensated_throttle
from thruster_control.inner_loop import Status
from thruster_control.references import REFERENCES
from thruster_control.scores import chatter, overshoot, reversals, tracking_scores
from thruster_control.settings import BENCH_GAINS, FlowLaw, Gains, RateForm, SimplifiedLaw, ThrustLaw
from thruster_control.strategies_io import load_strategy
from thruster_model.equations.thruster import input_map, rotor_acceleration, thrust, torque
from thruster_model.flow_tank import PlantState
from thruster_model.parameter_set_io import load_parameter_set

HL, SIMPLE = load_parameter_set("hl").coefficients, load_parameter_set("simplified").coefficients
TIME = 0.04 * np.arange(251)
NOISE = (1.7, 0.01)  # rad/s, m/s: of the bench's tachometer and of an observer


@pytest.mark.parametrize("n_0", [-120.0, -60.0, 0.0, 40.0, 140.0])
def test_fig_3_7_from_every_start_the_rotor_is_driven_to_n_d_under_the_ramp_limit(closed_loop, n_0: float) -> None:  # type: ignore[no-untyped-def]
    """Law (3.12) at 1 kHz against the continuous law, integrated by another method."""
    k_u, n_d, step = 20.0, 80.0, 1e-3
    law = SimplifiedLaw(Gains(k_P=k_u, k_I=0.0, rate_form=int(RateForm.NONE), on_estimate=1))
    T_d = float(thrust(n_d, 0.0, SIMPLE))
    run = closed_loop(np.full(600, T_d), law, SIMPLE, SIMPLE, start=PlantState(n_0, 0.0, 0.0, 0.0), dt=step)

    def rate(t, x):  # type: ignore[no-untyped-def]
        u = float(np.clip(compensated_throttle(x[0], n_d, 0.0, k_u, SIMPLE), -3.0, 3.0))
        n_rate = rotor_acceleration(x[0], torque(x[0], 0.0, SIMPLE), input_map(x[1], SIMPLE), SIMPLE)
        return [float(n_rate), float(np.clip((u - x[1]) / 1e-3, -100.0, 100.0))]

    time = step * np.arange(600)
    exact = solve_ivp(
        rate, (0.0, time[-1]), [n_0, 0.0], t_eval=time, method="LSODA", rtol=1e-8, atol=1e-8, max_step=1e-3
    )
    assert run.n_d[-1] == pytest.approx(n_d)
    assert run.n[-1] == pytest.approx(n_d, abs=0.2)
    assert np.max(np.abs(np.diff(run.u))) <= 100.0 * step + 1e-12
    np.testing.assert_allclose(run.n, exact.y[0], atol=1.5)


@pytest.mark.parametrize(("name", "limit"), [("step", 0.25), ("sine", 0.25), ("ramp", 0.3)])
def test_output_feedback_follows_the_thesis_set_points(closed_loop, name: str, limit: float) -> None:  # type: ignore[no-untyped-def]
    reference = REFERENCES[name]
    run = closed_loop(reference.thrust(TIME), FlowLaw(), HL, HL)
    assert tracking_scores(TIME, run.thrust, run.u, reference).rmse < limit
    assert run.status[50] == Status.RUNNING


@pytest.mark.parametrize("name", ["step", "sine", "ramp"])
def test_compensating_the_flow_beats_the_lookup_table_of_the_same_thruster(closed_loop, name: str) -> None:  # type: ignore[no-untyped-def]
    reference = REFERENCES[name]
    scores = {}
    for strategy in ("lookup", "hl-ekf"):
        ready = load_strategy(strategy, parameter_set="hl")
        run = closed_loop(reference.thrust(TIME), ready.settings, ready.coefficients, HL)
        scores[strategy] = tracking_scores(TIME, run.thrust, run.u, reference).rmse
    assert scores["hl-ekf"] < 0.7 * scores["lookup"]


def test_the_integral_takes_out_an_error_of_the_input_map(closed_loop) -> None:  # type: ignore[no-untyped-def]
    truth = HL._replace(c_u2=1.15 * HL.c_u2, delta_u2=0.9 * HL.delta_u2)
    T_d = np.full(250, 6.0)
    errors = {}
    for k_I in (0.0, 10.0):
        run = closed_loop(T_d, FlowLaw(Gains(k_I=k_I)), HL, truth)
        errors[k_I] = abs(run.n[-1] - run.n_d[-1])
    assert errors[0.0] > 5.0
    assert errors[10.0] < 0.5


def test_a_jump_of_the_set_point_does_not_throw_the_rotor_past_n_d(closed_loop) -> None:  # type: ignore[no-untyped-def]
    T_d = REFERENCES["step"].thrust(TIME)
    beyond = {}
    for largest_rate in (Gains().largest_rate, 1e9):
        run = closed_loop(T_d, FlowLaw(Gains(largest_rate=largest_rate)), HL, HL)
        beyond[largest_rate] = float(np.max((run.n - run.n_d)[125:]))
        assert np.any(run.status[125:130] == Status.LIMITED)
    assert beyond[Gains().largest_rate] < 3.0
    assert beyond[1e9] > 8.0


LAWS = [FlowLaw(), SimplifiedLaw(), ThrustLaw()]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_after_a_thrust_out_of_reach_the_rotor_returns_as_if_nothing_had_been(closed_loop, law) -> None:  # type: ignore[no-untyped-def]
    """T_d = 40 N for 6 s, which cannot be had, against what just can; wound up, the throttle would stay at 3 V."""
    p = HL if isinstance(law, FlowLaw) else HL._replace(c_nv_T=0.0)
    runs = []
    for first in (11.0 if isinstance(law, FlowLaw) else 17.0, 40.0):
        T_d = np.concatenate((np.full(150, first), np.full(100, 3.0)))
        runs.append(closed_loop(T_d, law, p, p))
    reached, missed = runs
    assert np.all(missed.status[5:150] == Status.LIMITED) and reached.status[149] == Status.RUNNING
    assert np.all(np.abs(missed.n - reached.n)[150 + 15 :] < 3.0)


def test_a_rotor_that_was_stuck_starts_with_little_overshoot(closed_loop) -> None:  # type: ignore[no-untyped-def]
    """Stuck for 3 s, the error alone would leave sigma = -220 rad; the integral stops where the throttle ends."""
    run = closed_loop(np.full(250, 8.0), FlowLaw(), HL, HL, stop_rotor_until=3.0)
    assert np.all(run.u[10:70] == 3.0)
    assert abs(run.sigma[74]) < 30.0
    assert np.max(run.n - run.n_d) < 10.0
    assert abs(run.n[-1] - run.n_d[-1]) < 0.5


@pytest.mark.parametrize("T_d", [0.0, 0.01, -0.01])
def test_idle_does_not_chatter_under_the_bench_s_noise(closed_loop, T_d: float) -> None:  # type: ignore[no-untyped-def]
    run = closed_loop(np.full(500, T_d), FlowLaw(), HL, HL, noise=NOISE, start=PlantState(60.0, 0.1, 0.1, 2.0))
    assert np.all(run.u == 0.0) and np.all(run.status == Status.IDLE)


def test_set_points_that_are_noise_about_zero_do_not_reverse_the_throttle(closed_loop) -> None:  # type: ignore[no-untyped-def]
    """0.008 N of noise, a thousandth of the thruster's thrust, against a law without an idle band."""
    T_d = 0.008 * np.random.default_rng(5).normal(size=500)
    idle = closed_loop(T_d, FlowLaw(), HL, HL, noise=NOISE)
    eager = FlowLaw()._replace(limits=FlowLaw().limits._replace(idle_thrust=0.0))
    never_idle = closed_loop(T_d, eager, HL, HL, noise=NOISE)
    assert reversals(idle.u) / 20.0 < 0.5
    assert reversals(never_idle.u) / 20.0 > 5.0


@pytest.mark.parametrize("T_d", [0.05, 0.1, 0.2])
def test_a_small_thrust_chatters_with_the_bench_s_rate_and_hardly_with_the_default(closed_loop, T_d: float) -> None:  # type: ignore[no-untyped-def]
    a_second = {}
    for gains in (Gains(), BENCH_GAINS):
        run = closed_loop(np.full(1000, T_d), FlowLaw(gains), HL, HL, noise=NOISE)
        a_second[gains] = reversals(run.u) / 40.0
    assert a_second[Gains()] < 0.6
    assert a_second[BENCH_GAINS] > 2.0


def test_the_bench_s_rate_costs_more_than_twice_the_travel_of_the_throttle(closed_loop) -> None:  # type: ignore[no-untyped-def]
    T_d = REFERENCES["sine"].thrust(TIME)
    travel = {g: chatter(closed_loop(T_d, FlowLaw(g), HL, HL, noise=NOISE).u) for g in (Gains(), BENCH_GAINS)}
    assert travel[BENCH_GAINS] > 2.0 * travel[Gains()]


def test_with_delay_and_gain_error_the_bench_s_form_swings_and_the_default_does_not(closed_loop) -> None:  # type: ignore[no-untyped-def]
    truth = HL._replace(c_u1=1.15 * HL.c_u1, c_u2=1.15 * HL.c_u2)
    swing = {}
    for gains in (Gains(), BENCH_GAINS):
        run = closed_loop(np.full(250, 8.0), FlowLaw(gains), HL, truth, late=True)
        swing[gains] = float(np.ptp(run.u[200:]))
    assert swing[Gains()] < 0.02
    assert swing[BENCH_GAINS] > 1.0


def test_a_gap_in_the_estimates_is_bridged_and_a_long_one_ends_at_zero(closed_loop) -> None:  # type: ignore[no-untyped-def]
    T_d = np.full(250, 6.0)
    valid = np.ones(250, bool)
    valid[100:110] = False
    bridged = closed_loop(T_d, FlowLaw(), HL, HL, valid=valid)
    assert np.all(bridged.status[100:110] == Status.HOLDING)
    assert np.max(np.abs(np.diff(bridged.u[90:130]))) < 0.02
    assert np.max(np.abs(bridged.thrust[100:130] - 6.0)) < 0.1
    valid[100:200] = False
    run = closed_loop(T_d, FlowLaw(), HL, HL, valid=valid)
    silent = run.u[100:200]
    assert silent[11] > 1.5 and np.all(np.diff(silent[12:]) <= 0.0)
    assert np.all(silent[20:] == 0.0)
    assert abs(run.thrust[-1] - 6.0) < 0.3


def test_the_pi_loop_with_the_load_cell_ends_at_the_wanted_thrust_though_its_map_is_wrong(closed_loop) -> None:  # type: ignore[no-untyped-def]
    from thruster_control.inner_loop import AT_REST, compiled_step
    from thruster_model import flow_tank

    state, memory, forces = flow_tank.AT_REST, AT_REST, []
    for _ in range(400):
        T = float(thrust(state.n, state.v, HL))
        memory, out = compiled_step(memory, 6.0, state.n, math.nan, math.nan, True, 0.04, ThrustLaw(), SIMPLE, T, 0.0)
        made = flow_tank.simulate(HL, [out.u], 0.04, initial=state)
        state = PlantState(made.n[-1], made.v[-1], made.ambient[-1], made.u[-1])
        forces.append(T)
    assert forces[-1] == pytest.approx(6.0, abs=0.05)
    assert overshoot(forces, 0.0, 6.0) < 0.4
