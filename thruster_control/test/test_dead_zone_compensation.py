"""The controller: values by hand, the claims of section 3.3.1, and what each of them assumes."""

from collections.abc import Callable

import numba
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from thruster_control.dead_zone_compensation import compensated_throttle, demanded_drive
from thruster_model.equations.dead_zone import dead_zone_crossing_time, ramp_limited
from thruster_model.equations.thruster import ThrusterCoefficients, input_map, rotor_acceleration, torque
from thruster_model.parameter_set_io import load_parameter_set

P = load_parameter_set("simplified").coefficients
K_U = 20.0  # 1/s

Array = NDArray[np.float64]


def plant(n: float, u: float) -> float:
    """Return dn/dt [rad/s^2] of (3.8) under the acting throttle u [V]."""
    return float(rotor_acceleration(n, torque(n, 0.0, P), input_map(u, P), P))


def constant(level: float) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    return (lambda t: level + 0.0 * t), (lambda t: 0.0 * t)


def swinging(amplitude: float, omega: float) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    return (lambda t: amplitude * np.sin(omega * t)), (lambda t: amplitude * omega * np.cos(omega * t))


def closed_loop(set_point, n_0, time, *, k_u=K_U, rate_error=0.0, known=P):  # type: ignore[no-untyped-def]
    """Return n [rad/s] at `time` [s] with the throttle acting at once; the controller believes `known`."""
    n_d, n_d_rate = set_point

    def rate(t, x):  # type: ignore[no-untyped-def]
        u = compensated_throttle(x[0], n_d(t), n_d_rate(t) + rate_error, k_u, known)
        return [plant(x[0], float(u))]

    solution = solve_ivp(rate, (0.0, time[-1]), [n_0], t_eval=time, method="DOP853", rtol=1e-12, atol=1e-11)
    assert solution.success
    return solution.y[0]


# Values by hand, Table 3.1: Q(100) = 3.255e-5 (10^4 - 0.0192), Q(-100) = 1.577e-5 (-10^4 + 0.0215).
@pytest.mark.parametrize(
    ("n", "n_d", "n_d_rate", "alpha", "u"),
    [
        (100.0, 100.0, 0.0, 1152.02329, 1152.02329 / 709.0 + 0.9254),
        (-100.0, -100.0, 0.0, -1140.66996, -1140.66996 / 793.6 - 0.8475),
        (0.0, 50.0, 0.0, 1000.0, 1000.0 / 709.0 + 0.9254),
        (0.0, 0.0, -793.6, -793.6, -1.8475),
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, -50.0, 1000.0, 0.0, 0.0),
    ],
)
def test_drive_and_throttle_are_those_found_by_hand(
    n: float, n_d: float, n_d_rate: float, alpha: float, u: float
) -> None:
    assert demanded_drive(n, n_d, n_d_rate, K_U, P) == pytest.approx(alpha, abs=1e-4)
    assert compensated_throttle(n, n_d, n_d_rate, K_U, P) == pytest.approx(u, abs=1e-6)


def test_a_batch_equals_its_scalars() -> None:
    n, n_d = np.linspace(-200.0, 200.0, 9)[:, None], np.linspace(-100.0, 100.0, 5)
    batch = compensated_throttle(n, n_d, 30.0, K_U, P)
    assert batch.shape == (9, 5)
    one_by_one = [[float(compensated_throttle(a, b, 30.0, K_U, P)) for b in n_d] for a in n[:, 0]]
    np.testing.assert_array_equal(batch, one_by_one)


@numba.njit
def _compiled_throttle(n: float, n_d: float, n_d_rate: float, k_u: float, p: ThrusterCoefficients) -> float:
    return compensated_throttle(n, n_d, n_d_rate, k_u, p).item()  # type: ignore[no-any-return]


@pytest.mark.parametrize("n", [-100.0, 0.0, 100.0, np.nan])
def test_compiled_and_plain_throttle_agree(n: float) -> None:
    plain = float(compensated_throttle(n, 20.0, -5.0, K_U, P))
    assert _compiled_throttle(n, 20.0, -5.0, K_U, P) == pytest.approx(plain, rel=1e-14)


@pytest.mark.parametrize("unknown", range(4), ids=["n", "n_d", "n_d_rate", "k_u"])
def test_an_unknown_input_commands_zero_and_leaves_the_rest_of_the_batch(unknown: int) -> None:
    inputs = [np.full(3, value) for value in (40.0, 60.0, 10.0, K_U)]
    good = compensated_throttle(*inputs, P)
    inputs[unknown][1] = np.nan
    u = compensated_throttle(*inputs, P)
    assert np.isnan(demanded_drive(*inputs, P)[1])
    assert u.tolist() == [good[0], 0.0, good[2]]


TIME = np.linspace(0.0, 0.5, 101)
CASES = [(constant(50.0), -80.0), (constant(-50.0), 80.0), (swinging(100.0, 12.0), -40.0)]


@pytest.mark.parametrize(("set_point", "n_0"), CASES, ids=["forward", "backward", "swinging"])
def test_theorem_1_the_error_decays_with_k_u_through_a_change_of_sign(set_point, n_0) -> None:  # type: ignore[no-untyped-def]
    n = closed_loop(set_point, n_0, TIME)
    n_d = set_point[0](TIME)
    assert n.min() < -10.0 < 10.0 < n.max()
    np.testing.assert_allclose(n - n_d, (n_0 - n_d[0]) * np.exp(-K_U * TIME), rtol=1e-6)


def test_theorem_1_holds_while_the_throttle_itself_changes_sign() -> None:
    set_point, n_0 = CASES[2]
    n = closed_loop(set_point, n_0, TIME)
    u = compensated_throttle(n, set_point[0](TIME), set_point[1](TIME), K_U, P)
    assert u.min() < P.delta_u1 < P.delta_u2 < u.max()


@pytest.mark.parametrize("wrong", [{"k_n": 1.1 * P.k_n}, {"c_u2": 1.1 * P.c_u2}, {"delta_u2": 1.1 * P.delta_u2}])
def test_theorem_1_assumes_known_parameters(wrong: dict[str, float]) -> None:
    n = closed_loop(constant(50.0), -80.0, TIME, known=P._replace(**wrong))
    assert abs(n[-1] - 50.0) > 100.0 * 130.0 * np.exp(-K_U * TIME[-1])


def test_theorem_1_assumes_that_the_throttle_is_not_limited() -> None:
    error = limited_loop(-80.0, -1.85, 50.0, K_U, 0.1)[0][-1] - 50.0
    assert abs(error) > 1.05 * 130.0 * np.exp(-K_U * 0.1)


@pytest.mark.parametrize("epsilon", [-200.0, 200.0])
@pytest.mark.parametrize("n_0", [-80.0, 50.0, 180.0])
def test_corollary_1_1_a_constant_error_of_the_rate_ends_at_its_bound(epsilon: float, n_0: float) -> None:
    time = np.linspace(0.0, 1.5, 31)
    error = closed_loop(constant(50.0), n_0, time, rate_error=epsilon) - 50.0
    bound = abs(epsilon) / K_U
    assert error[-1] == pytest.approx(epsilon / K_U, rel=1e-6)
    transient = abs(n_0 - 50.0 - epsilon / K_U) * np.exp(-K_U * time)
    assert np.all(np.abs(error) <= bound + transient + 1e-6)


@pytest.mark.parametrize("n_0", [-200.0, -1.0, -0.1, 0.1, 1.0, 200.0])
@pytest.mark.parametrize("u", [-0.8, 0.0, 0.9])
def test_theorem_2_in_the_dead_zone_the_rotor_runs_down_at_least_as_fast_as_k_n(n_0: float, u: float) -> None:
    time = np.linspace(0.0, 1.0, 51)
    solution = solve_ivp(lambda t, x: [plant(x[0], u)], (0.0, 1.0), [n_0], t_eval=time, rtol=1e-10, atol=1e-14)
    n = solution.y[0]
    assert np.all(np.abs(n) <= abs(n_0) * np.exp(-P.k_n * time) * (1.0 + 1e-7))
    assert np.all(n * n_0 > 0.0)


STEP = 1e-4  # s


def limited_loop(n: float, u: float, n_d: float, k_u: float, duration: float) -> tuple[Array, Array]:
    """Return n [rad/s] and the acting throttle [V] at each STEP, the throttle limited to 3 V and 100 V/s."""
    speeds, throttles = [], []
    for _ in range(round(duration / STEP)):
        commanded = np.clip(compensated_throttle(n, n_d, 0.0, k_u, P), -3.0, 3.0)
        u = float(ramp_limited(u, commanded, P.u_dot_max, STEP))
        n += STEP * plant(n, u)
        speeds.append(n)
        throttles.append(u)
    return np.array(speeds), np.array(throttles)


@pytest.mark.parametrize("direction", [-1.0, 1.0])
@pytest.mark.parametrize("k_u", [5.0, 20.0, 100.0])
def test_with_the_ramp_limit_the_dead_zone_is_crossed_within_t_max(direction: float, k_u: float) -> None:
    t_max = dead_zone_crossing_time(P.delta_u1, P.delta_u2, P.u_dot_max)
    assert t_max == pytest.approx(0.017729)
    n_0 = -direction * 100.0
    n, u = limited_loop(n_0, float(compensated_throttle(n_0, n_0, 0.0, k_u, P)), -n_0, k_u, 1.5)
    inside = (u > P.delta_u1) & (u < P.delta_u2)
    stay = STEP * np.count_nonzero(inside)
    assert np.count_nonzero(np.diff(inside.astype(int)) == 1) == 1
    assert t_max - 2.0 * STEP < stay <= t_max + STEP
    assert n[-1] == pytest.approx(-n_0, rel=0.01)
