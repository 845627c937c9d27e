"""The vehicle's closed loop: the same motion as its parts put together by hand, in Python, with another plant."""

from math import inf, nan

import numpy as np
import pytest
from vehicle_by_hand import NGS, ByHand, body_acceleration, matrix_of, ngs_configuration

from rov_sim.vehicle.live import LiveSettings, LiveVehicle
from rov_sim.vehicle.loop import simulate_vehicle_loop
from rov_sim.vehicle.noisy_odometry import OdometryErrors, OdometryNoise
from rov_sim.vehicle.sensors.errors import drawn_errors
from rov_sim.vehicle_study.assumptions import Assumptions
from rov_sim.vehicle_study.conditions import drawn_vehicle, feedback_of, sensors_of, steering_of
from rov_sim.vehicle_study.controllers import inner_loop_of
from rov_sim.vehicle_study.plan_io import load_plan
from rov_sim.vehicle_study.results_io import contents_of, sets_of
from thruster_control import online as law_online
from thruster_control.allocation.allocate import compiled_allocate
from thruster_control.allocation.failures import allocation
from thruster_control.allocation.settings import allocation_memory
from thruster_control.outer_loop.settings import outer_memory
from thruster_control.outer_loop.step import compiled_outer_loop
from thruster_control.strategies import strategy
from thruster_control.vehicle_set_points import Move, script_of, set_point_at
from thruster_estimation import online as observer_online
from thruster_estimation.belief import Level, level
from thruster_estimation.navigation_belief import Heard
from thruster_estimation.navigation_online import NAVIGATION_START, LateReading, navigation_advance
from thruster_estimation.navigation_output import compiled_output

PLAN = load_plan("thesis")
SETS = sets_of(contents_of(PLAN))
SCRIPT = script_of([Move(0.2, "quintic", {"surge": 0.15, "pitch": 0.2}, 1.5)])
SECONDS, SEED = 2.0, 3


def assumptions(**changes) -> Assumptions:  # type: ignore[no-untyped-def]
    told = {name: assumed.value for name, assumed in PLAN.assumed.items()}
    return Assumptions(**{**told, "duration": SECONDS, "deviation": 0.0, **changes})


def inner_loop(name: str, given: Assumptions):  # type: ignore[no-untyped-def]
    p = SETS.thrusters[strategy(name).parameter_set].coefficients
    return inner_loop_of(name, given, p, SETS.thrusters[given.truth].coefficients)


def run(name: str, given: Assumptions, seed: int = SEED):  # type: ignore[no-untyped-def]
    return simulate_vehicle_loop(
        SCRIPT, drawn_vehicle(given, SETS, (1, seed)), steering_of(given, SETS), inner_loop(name, given),
        feedback_of(given, SETS), period=given.period, duration=given.duration, seed=seed,
    )  # fmt: skip


def euler(q) -> np.ndarray:  # type: ignore[no-untyped-def]
    R = matrix_of(q)
    return np.array([np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])])


def euler_rates_to_body(angles) -> np.ndarray:  # type: ignore[no-untyped-def]
    (s, c), (st, ct) = (np.sin(angles[0]), np.cos(angles[0])), (np.sin(angles[1]), np.cos(angles[1]))
    return np.array([[1.0, 0.0, -st], [0.0, c, s * ct], [0.0, -s, c * ct]])


def thrusts_by_2_22(q, nu, point, gain: float, K_t: np.ndarray) -> np.ndarray:  # type: ignore[no-untyped-def]
    """(2.22) as the thesis writes it, with the measured Euler angles."""
    angles = euler(q)
    B = euler_rates_to_body(angles)
    rate = np.linalg.solve(B, nu[3:])
    step = 1e-6
    B_rate = (euler_rates_to_body(angles + step * rate) - euler_rates_to_body(angles - step * rate)) / (2.0 * step)
    wanted_rate, wanted_acceleration = np.array(point.attitude_rate), np.array(point.attitude_acceleration)
    nu_d = np.concatenate((point.velocity, B @ wanted_rate))
    nu_d_rate = np.concatenate((point.acceleration, B @ wanted_acceleration + B_rate @ wanted_rate))
    feedback = np.concatenate((np.zeros(3), np.linalg.inv(B).T @ (angles - point.attitude)))
    M = np.diag([NGS.mass] * 3 + list(NGS.inertia)) + np.diag(NGS.added)
    without = body_acceleration(q, nu, np.zeros(6), NGS)
    return np.linalg.solve(K_t, M @ (nu_d_rate - gain * (nu - nu_d) - gain * feedback - without))


def by_hand(name: str, given: Assumptions):  # type: ignore[no-untyped-def]
    """The same run put together from the steps of the nodes, (2.22) and a plant written out for this test."""
    inner, K_t, N = inner_loop(name, given), ngs_configuration(), 6
    plant = ByHand(NGS, K_t, [SETS.thrusters[given.truth].coefficients] * N)
    count = given.periods - 1
    noise = OdometryNoise(given.attitude_noise, given.velocity_noise, given.rate_noise)
    errors = OdometryErrors(noise, SEED).take(count)
    drawn = drawn_errors(sensors_of(given, SETS.sensors), SEED, N, round(1e9 * given.period) * count)
    beliefs, loops, held = [observer_online.START] * N, [law_online.START] * N, np.full(N, nan)
    throttles, found = np.zeros(N), []
    for j in range(count):
        k, stamp = j + 1, (j + 1) * round(1e9 * given.period)
        plant.advance(throttles, given.period)
        q, nu, n = plant.state[3:7], plant.state[7:13], plant.state[13 : 13 + N]
        found.append(np.concatenate((q, nu, n)))
        half = 0.5 * errors[j, :3]
        turn = np.concatenate(([np.cos(np.linalg.norm(half))], np.sinc(np.linalg.norm(half) / np.pi) * half))
        w, x = q[0], q[1:]
        told = np.concatenate(([w * turn[0] - x @ turn[1:]], w * turn[1:] + turn[0] * x + np.cross(x, turn[1:])))
        seen = nu + errors[j, 3:]
        T_d = thrusts_by_2_22(told, seen, set_point_at(SCRIPT, k * given.period), given.gain, K_t)
        U = K_t.T @ seen
        for i in range(N):
            y_n = float(n[i] + drawn["tachometer", i][j, 0])
            measured = observer_online.Measured(stamp, y_n, float(U[i]), False)
            beliefs[i] = observer_online.advance(
                beliefs[i], measured, float(held[i]), inner.observer, inner.coefficients
            )
            belief = beliefs[i].belief
            assert belief is not None
            n_hat, v_hat, U_hat = observer_online.states(belief, inner.observer)
            valid = level(belief.status) != Level.INVALID
            ambient = float(U[i]) if name == "steady-flow" else U_hat
            inputs = law_online.Inputs(stamp, float(T_d[i]), n_hat, v_hat, ambient, valid, nan, 0.0)
            loops[i], answer = law_online.advance(loops[i], inputs, given.period, inner.law, inner.coefficients)
            held[i] = answer.u
        throttles = held.copy()
    return np.array(found)


@pytest.mark.parametrize(
    "name",
    [
        "lookup",
        "hq-ekf",
        "hl-kfnlo",
        *(pytest.param(each, marks=pytest.mark.long) for each in ("dead-zone", "steady-flow")),
    ],
)
def test_the_loop_moves_as_its_parts_put_together_by_hand(name: str) -> None:
    given = assumptions(attitude_error="euler", largest_step=1e-3)
    found = by_hand(name, given)
    r = run(name, given).record
    ours = np.concatenate((r.attitude, r.velocity, r.n), axis=1)
    scale = np.array([1.0] * 4 + [0.15] * 3 + [0.2] * 3 + [60.0] * 6)
    assert np.max(np.abs(ours - found) / scale) < 2e-4
    assert r.velocity[-1, 0] > 0.1


def by_nodes(name: str, given: Assumptions):  # type: ignore[no-untyped-def]
    """The same run by what the nodes of the graph call: the live vehicle and a step of each loop."""
    inner, steering, feedback = inner_loop(name, given), steering_of(given, SETS), feedback_of(given, SETS)
    settings = LiveSettings(
        plant=drawn_vehicle(given, SETS, (1, SEED)), sensors=feedback.sensors, period=given.period,
        noise=feedback.noise, seed=SEED,
    )  # fmt: skip
    vehicle, N = LiveVehicle(settings), settings.thrusters
    chosen, room, allocated = (  # of this loop its own
        allocation(steering.vehicle.K_t, steering.allocation),
        outer_memory(),
        allocation_memory(N),
    )
    beliefs, loops, held = [observer_online.START] * N, [law_online.START] * N, np.full(N, nan)
    limit, throttles, found = np.full(N, inf), np.zeros(N), []
    track, T_d, wrench = NAVIGATION_START, np.zeros(N), np.zeros(6)
    for j in range(given.periods - 1):
        now = vehicle.advance(throttles)
        told = {(each.sensor, each.thruster): each.values for each in now.readings}
        attitude, velocity = now.odometry.attitude, now.odometry.velocity
        if feedback.navigation is not None:
            late = [("velocity", ("velocity_x", "velocity_y", "velocity_z")), ("depth", ("depth",))]
            others = [
                LateReading(now.time, dict(zip(fields, told[sensor, -1], strict=True)))
                for sensor, fields in late
                if (sensor, -1) in told
            ]
            track = navigation_advance(track, now.time, Heard(*told["imu", -1]), others, feedback.navigation)
            out = compiled_output(track.belief, feedback.navigation)
            attitude, velocity = np.array(out.attitude), np.array(out.velocity)
        point = set_point_at(SCRIPT, (j + 1) * given.period)
        compiled_outer_loop(room, attitude, velocity, point, given.period, steering.law, steering.vehicle, wrench)
        compiled_allocate(wrench, -limit, limit, chosen, allocated, T_d)
        U = steering.vehicle.inflow.T @ velocity
        for i in range(N):
            measured = observer_online.Measured(now.time, told["tachometer", i][0], float(U[i]), False)
            beliefs[i] = observer_online.advance(
                beliefs[i], measured, float(held[i]), inner.observer, inner.coefficients
            )
            belief = beliefs[i].belief
            assert belief is not None
            estimate, valid = observer_online.states(belief, inner.observer), level(belief.status) != Level.INVALID
            inputs = law_online.Inputs(now.time, float(T_d[i]), *estimate, valid, nan, 0.0)
            loops[i], answer = law_online.advance(loops[i], inputs, given.period, inner.law, inner.coefficients)
            held[i] = answer.u
        throttles = held.copy()
        found.append(
            np.concatenate((now.truth.attitude, now.truth.velocity, now.truth.n, attitude, velocity, throttles))
        )
    return np.array(found)


@pytest.mark.parametrize(("name", "feedback"), [("hq-ekf", "truth"), ("lookup", "estimator")])
def test_the_loop_is_what_the_nodes_of_the_graph_call_to_rounding(name: str, feedback: str) -> None:
    given = assumptions(deviation=0.05, feedback=feedback)
    found, whole = by_nodes(name, given), run(name, given)
    r = whole.record
    ours = np.concatenate((r.attitude, r.velocity, r.n, r.told_attitude, r.told_velocity, whole.of("u")), axis=1)
    np.testing.assert_allclose(ours, found, rtol=1e-9, atol=1e-9)


def test_a_run_depends_on_its_seed_alone() -> None:
    given = assumptions(deviation=0.05)
    one, again, other = (run("hq-ekf", given, seed).record for seed in (1, 1, 2))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, again, strict=True))
    assert not np.array_equal(one.velocity, other.velocity)


def test_all_strategies_of_a_seed_meet_the_same_noise_and_the_same_vehicle() -> None:
    given = assumptions(deviation=0.05, duration=0.08)
    runs = [run(name, given).record for name in ("lookup", "hq-ekf", "hl-kfnlo")]
    for other in runs[1:]:  # before the first throttle acts
        assert np.array_equal(runs[0].y_n, other.y_n) and np.array_equal(runs[0].told_attitude, other.told_attitude)
    assert drawn_vehicle(given, SETS, (1, 5)).thrusters == drawn_vehicle(given, SETS, (1, 5)).thrusters
    assert len({p.k_n for p in drawn_vehicle(given, SETS, (1, 5)).thrusters}) == 6


def test_exact_feedback_is_the_truth_and_an_estimator_s_is_near_it() -> None:
    exact = run("hq-ekf", assumptions(feedback="exact")).record
    assert np.array_equal(exact.told_velocity, exact.velocity)
    np.testing.assert_allclose(exact.told_attitude, exact.attitude, atol=1e-15)
    np.testing.assert_allclose(exact.y_n, exact.n, atol=1e-12)
    estimated = run("hq-ekf", assumptions(feedback="estimator")).record
    late = slice(25, None)
    assert 0.0 < np.max(np.abs(estimated.told_velocity[late] - estimated.velocity[late])) < 0.05
    assert np.max(np.abs(estimated.told_attitude - estimated.attitude)) < 0.02


def test_observers_that_are_told_no_inflow_predict_it_for_a_tank() -> None:
    told = run("hq-ekf", assumptions())
    untold = run("hq-ekf", assumptions(inflow="tank"))
    assert np.all(np.isnan(untold.record.y_U)) and np.all(np.isfinite(told.record.y_U))

    def error(found) -> float:  # type: ignore[no-untyped-def]
        return float(np.sqrt(np.mean((found.of("U") - found.record.ambient)[25:] ** 2)))

    assert error(told) < 0.02 < error(untold)


def test_a_sensor_that_reads_between_the_ticks_is_refused() -> None:
    given = assumptions()
    feedback = feedback_of(given, SETS)
    with pytest.raises(ValueError, match=r"imu: expected readings at multiples of 0\.03 s"):
        simulate_vehicle_loop(
            SCRIPT, drawn_vehicle(given, SETS, (1, 0)), steering_of(given, SETS), inner_loop("lookup", given), feedback,
            period=0.03, duration=3.0,
        )  # fmt: skip
    with pytest.raises(ValueError, match="duration: expected two periods"):
        simulate_vehicle_loop(
            SCRIPT, drawn_vehicle(given, SETS, (1, 0)), steering_of(given, SETS), inner_loop("lookup", given), feedback,
            period=0.04, duration=0.04,
        )  # fmt: skip


def test_the_known_vehicle_is_the_one_by_hand() -> None:
    c = steering_of(assumptions(), SETS).vehicle
    np.testing.assert_allclose(c.K_t, ngs_configuration(), atol=1e-6)
    assert np.isclose(c.weight, NGS.mass * 9.81) and np.allclose(np.diag(c.M_A), NGS.added)
    assert np.allclose(np.diag(c.D_Q), NGS.quadratic) and inf > c.buoyancy > c.weight
