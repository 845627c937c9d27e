"""The sampled speed loop: by hand, against the roots of its polynomial, and against the nonlinear loop itself."""

import math

import numpy as np
import pytest

from thruster_control.settings import BENCH_GAINS, Gains, Limits, SimplifiedLaw
from thruster_control.stability import SpeedLoop, largest_delay, largest_gain, spectral_radius, speed_loop, transition
from thruster_model.equations.thruster import input_map
from thruster_model.flow_tank import PlantState
from thruster_model.parameter_set_io import load_parameter_set

P = load_parameter_set("hl_bench").coefficients
PERIOD = 0.04  # s
BENCH = speed_loop(P, BENCH_GAINS, n=100.0, period=PERIOD)
DEFAULT = speed_loop(P, Gains(), n=100.0, period=PERIOD)


def test_the_loop_about_a_speed_by_hand() -> None:
    expected = P.k_n + 2.0 * P.k_Q * P.c_Q2 * 100.0
    assert expected == pytest.approx(14.7045, abs=1e-4)
    assert BENCH.rotor_rate == pytest.approx(expected, rel=1e-6)
    assert (pytest.approx(30.0), 10.0, 0.04) == (BENCH.gain, BENCH.k_I, BENCH.period)
    assert pytest.approx(5.0) == DEFAULT.gain
    on_estimate = speed_loop(P, Gains(on_estimate=1), n=100.0, period=PERIOD)
    assert on_estimate.gain == pytest.approx(5.0 - expected, rel=1e-6)


def test_the_bench_s_form_is_unstable_with_one_period_of_delay_and_15_percent_more_gain() -> None:
    assert spectral_radius(BENCH, gain=1.15, delay=PERIOD) == pytest.approx(1.02, abs=0.002)
    assert spectral_radius(BENCH, gain=1.0, delay=PERIOD) < 1.0
    assert largest_gain(BENCH, delay=PERIOD) == pytest.approx(1.107, abs=0.002)
    assert largest_delay(BENCH) == pytest.approx(0.069, abs=0.001)


@pytest.mark.parametrize("n", [0.0, 50.0, 110.0])
def test_the_default_is_stable_with_margin(n: float) -> None:
    loop = speed_loop(P, Gains(), n=n, period=PERIOD)
    assert spectral_radius(loop, gain=1.15, delay=PERIOD) < 0.98
    assert largest_gain(loop, delay=PERIOD) > 6.0
    assert largest_delay(loop, gain=1.15) > 0.5


def test_without_integral_and_with_one_period_of_delay_it_is_the_quadratic_by_hand() -> None:
    """z^2 - a z + b K = 0; complex roots have |z| = sqrt(b K)."""
    loop = SpeedLoop(14.0, 30.0, 0.0, PERIOD)
    b = (1.0 - math.exp(-14.0 * PERIOD)) / 14.0
    assert spectral_radius(loop, delay=PERIOD) == pytest.approx(math.sqrt(30.0 * b))
    assert spectral_radius(loop) == pytest.approx(abs(math.exp(-14.0 * PERIOD) - 30.0 * b))


@pytest.mark.parametrize("delay", [0.0, 0.01, 0.04, 0.055, 0.13])
@pytest.mark.parametrize("k_I", [0.0, 10.0])
def test_the_matrix_predicts_a_loop_integrated_in_small_steps(delay: float, k_I: float) -> None:
    """Exact steps of the rotor over the pieces between the instants at which its drive changes."""
    loop, gain, N = SpeedLoop(14.0, 9.0, k_I, PERIOD), 1.2, 12
    n, sigma, commands, speeds = 1.0, 0.0, {}, []
    fine = 80  # per period; every delay here is a multiple of the fine step
    for i in range(N * fine):
        if i % fine == 0:
            commands[i] = -loop.gain * n - loop.k_I * sigma
            sigma += PERIOD * n
            speeds.append(n)
        acting = commands.get((i - round(delay / PERIOD * fine)) // fine * fine, 0.0)
        decay = math.exp(-14.0 * PERIOD / fine)
        n = decay * n + gain * acting * (1.0 - decay) / 14.0
    F = transition(loop, gain=gain, delay=delay)
    x, predicted = np.eye(F.shape[0])[0], []
    for _ in range(N):
        predicted.append(x[0])
        x = F @ x
    np.testing.assert_allclose(predicted, speeds, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("gain", "grows"), [(1.05, False), (1.15, True)])
def test_the_nonlinear_loop_grows_or_decays_as_the_radius_says(closed_loop, gain: float, grows: bool) -> None:  # type: ignore[no-untyped-def]
    """Small deviations from n_d = 100 rad/s; the true input map is steeper about the believed steady throttle."""
    p = P._replace(c_nv_T=0.0, u_dot_max=1e6)
    gains, alpha = BENCH_GAINS._replace(k_I=0.0), p.k_n * 100.0 + p.k_Q * p.c_Q2 * 1e4
    u = alpha / p.c_u2 + p.delta_u2
    truth = p._replace(c_u2=gain * p.c_u2, delta_u2=u - alpha / (gain * p.c_u2))
    assert input_map(u, truth) == pytest.approx(alpha)
    law, start = SimplifiedLaw(gains, Limits(u_dot_max=1e6)), PlantState(100.5, 0.0, 0.0, u)
    error = closed_loop(np.full(60, p.c_T2 * 1e4), law, p, truth, late=True, start=start).n[10:] - 100.0
    peaks = np.abs(error).reshape(10, 5).max(axis=1)
    factor = np.exp(np.polyfit(5.0 * np.arange(10), np.log(peaks), 1)[0])
    radius = spectral_radius(speed_loop(p, gains, n=100.0, period=PERIOD), gain=gain, delay=PERIOD)
    assert (factor > 1.0) == grows
    assert factor == pytest.approx(radius, abs=0.005)


def test_loops_that_are_none_are_refused() -> None:
    with pytest.raises(ValueError, match="expected gain > 0, delay >= 0 s"):
        transition(DEFAULT, gain=-1.0)
    with pytest.raises(ValueError, match="delay >= 0 s"):
        transition(DEFAULT, delay=math.nan)


def test_a_loop_that_is_unstable_anyway_has_no_margin() -> None:
    wild = SpeedLoop(14.0, 100.0, 10.0, PERIOD)
    assert spectral_radius(wild) > 1.0
    assert math.isnan(largest_gain(wild)) and math.isnan(largest_delay(wild))
