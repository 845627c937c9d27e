"""Errors of parameter sets and how sure they are: Monte Carlo, closed forms, the thesis' steady states."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from thruster_model.identification.evaluation import (
    Comparison,
    Evaluation,
    bootstrap_errors,
    compare,
    evaluate,
    fit_shifts,
    shifts_of,
)
from thruster_model.identification.experiment import Experiment, Measurement
from thruster_model.identification.fit import noise_of
from thruster_model.identification.spectrum import amplitude_density
from thruster_model.identification.steady_state import predicted_steady_states, steady_states
from thruster_model.parameter_set_io import load_parameter_set

ALL = ("speed", "axial", "ambient", "thrust", "torque")


def remembering(rng, rho, shape):
    """First-order autoregressions of unit variance along the last axis."""
    innovations = np.sqrt(1.0 - rho**2) * rng.standard_normal(shape)
    innovations[..., 0] /= np.sqrt(1.0 - rho**2)
    return lfilter([1.0], [1.0, -rho], innovations)


def speed_only(residuals, noise=1.0):
    return Evaluation(residuals={(0, "speed"): np.asarray(residuals)}, noise={"speed": noise})


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_the_bootstrap_knows_the_scatter_of_the_root_mean_square_error(rho):
    rng = np.random.default_rng(1)
    sample = remembering(rng, rho, (400, 3000))
    scatter = float(np.std(np.sqrt(np.mean(sample**2, axis=1))))
    closed_form = 0.5 * np.sqrt(2.0 / 3000 * (1.0 + rho**2) / (1.0 - rho**2))
    assert scatter == pytest.approx(closed_form, rel=0.15)
    stated = [np.std(bootstrap_errors([[series]], block=100)[0]) for series in sample[:40]]
    assert np.mean(stated) == pytest.approx(scatter, rel=0.2)


def test_blocks_that_are_shorter_than_the_memory_would_claim_too_much():
    sample = remembering(np.random.default_rng(2), 0.9, (20, 3000))
    short = np.mean([np.std(bootstrap_errors([[s]], block=1)[0]) for s in sample])
    long = np.mean([np.std(bootstrap_errors([[s]], block=100)[0]) for s in sample])
    assert long > 2.0 * short


def test_the_draws_are_paired_so_that_what_both_share_does_not_count():
    rng = np.random.default_rng(3)
    shared = rng.standard_normal(3000)
    extra = 0.1 * rng.standard_normal(3000)
    first, second = bootstrap_errors([[shared + extra], [shared]], block=25)
    assert np.std(first - second) < 0.3 * np.hypot(np.std(first), np.std(second))
    again, once_more = bootstrap_errors([[shared], [shared]], block=25)
    np.testing.assert_array_equal(again, once_more)


def test_the_error_of_a_difference_is_its_scatter_over_many_recordings():
    rng = np.random.default_rng(4)
    differences, stated = [], []
    for k in range(200):
        shared = remembering(rng, 0.8, 1500)
        ours, theirs = shared, 1.05 * shared + 0.2 * remembering(rng, 0.8, 1500)
        row = compare(speed_only(ours), speed_only(theirs), block=60, draws=200, seed=k)[0]
        differences.append(row.error - row.reference)
        stated.append(row.difference_error)
    assert np.mean(stated) == pytest.approx(np.std(differences), rel=0.2)


@pytest.mark.parametrize(
    ("error", "reference", "difference_error", "worse"),
    [(1.2, 1.0, 0.1, True), (1.2, 1.0, 0.3, False), (0.8, 1.0, 0.1, False), (1.0, 1.0, 0.0, False)],
)
def test_worse_means_by_more_than_the_standard_error(error, reference, difference_error, worse):
    row = Comparison(
        signal="speed", error=error, reference=reference, difference_error=difference_error, interval=(0.0, 1.0)
    )
    assert row.worse is worse


def test_the_total_weighs_by_noise_and_counts_every_cell():
    residuals = {
        (0, "speed"): np.array([0.6, -0.6, np.nan, 0.6]),  # twice the noise, three cells
        (1, "thrust"): np.array([0.5]),  # five times the noise, one cell
    }
    evaluation = Evaluation(residuals=residuals, noise={"speed": 0.3, "thrust": 0.1})
    assert evaluation.total == pytest.approx(np.sqrt((3 * 4.0 + 25.0) / 4))
    assert evaluation.rmse("speed") == pytest.approx(0.6)
    assert evaluation.rmse("thrust", 1) == pytest.approx(0.5)
    assert np.isnan(evaluation.rmse("thrust", 0))
    assert np.isnan(evaluation.rmse("torque"))
    assert evaluation.signals == ("speed", "thrust")


def test_a_comparison_has_a_row_per_signal_and_ends_with_the_total():
    rng = np.random.default_rng(5)
    residuals = {(0, "thrust"): rng.standard_normal(300), (0, "speed"): rng.standard_normal(300)}
    ours = Evaluation(residuals=residuals, noise={"speed": 0.5, "thrust": 2.0})
    theirs = replace(ours, residuals={k: 3.0 * v for k, v in residuals.items()})
    rows = compare(ours, theirs, block=10)
    assert [r.signal for r in rows] == ["speed", "thrust", "total"]
    assert rows[0].error == pytest.approx(ours.rmse("speed"))
    assert rows[2].error == pytest.approx(ours.total)
    assert all(r.reference == pytest.approx(3.0 * r.error) for r in rows)


@pytest.fixture(scope="module")
def truth():
    return load_parameter_set("hl")


def wavy(t):
    return (t > 1.0) * 2.6 * np.sin(1.3 * (t - 1.0)) * np.cos(0.23 * (t - 1.0))


def moved(run, late, signals, **changes):
    """The run with the measurements named `late` [s], whose clocks may be off."""
    changed = {
        n: replace(m, time=m.time + late.get(n, 0.0), shift_std=signals.get(n, 0.0))
        for n, m in run.measurements.items()
    }
    return replace(run, measurements=changed, **changes)


def test_the_truth_is_judged_as_nothing_but_noise(independent_bench, truth):
    run = independent_bench("run", wavy, 12.0, truth.values, np.random.default_rng(6), ALL)
    evaluation = evaluate(truth, [run], noise_of([run]))
    assert evaluation.total == pytest.approx(1.0, abs=4.0 / np.sqrt(2 * 5 * 300))
    assert evaluation.rmse("thrust") == pytest.approx(0.1, rel=0.2)
    wrong = truth.with_values({"c_u2": 1.1 * truth.values["c_u2"]}, source="wrong")
    row = compare(evaluate(wrong, [run], noise_of([run])), evaluation, block=50)[-1]
    assert row.worse


def test_clock_shifts_are_recovered_for_the_throttle_and_for_a_signal(independent_bench, truth):
    rng = np.random.default_rng(7)
    runs = [independent_bench(f"{k}", wavy, 12.0, truth.values, rng, ALL) for k in range(2)]
    everything = dict.fromkeys(ALL, 0.03)
    first = moved(runs[0], everything, {}, throttle_shift_std=0.05)
    second = moved(runs[1], {"axial": -0.08}, {"axial": 0.1})
    noise = noise_of(runs)
    unknowns = fit_shifts(truth, [first, second], noise)
    found = shifts_of(truth, [first, second], unknowns)
    assert unknowns.shape == (2,)
    assert found[0].throttle == pytest.approx(0.03, abs=2e-3)
    assert found[1].signals["axial"] == pytest.approx(-0.08, abs=0.02)
    with_shifts = evaluate(truth, [first, second], noise)
    without = evaluate(truth, [first, second], noise, np.zeros(2))
    assert with_shifts.total == pytest.approx(1.0, abs=0.08)
    assert without.total > 1.3 * with_shifts.total


def test_without_uncertain_clocks_there_is_nothing_to_shift(independent_bench, truth):
    run = independent_bench("run", wavy, 4.0, truth.values, np.random.default_rng(8), ("speed",))
    assert fit_shifts(truth, [run], noise_of([run])).shape == (0,)


def test_masked_cells_keep_their_places_in_the_residuals(independent_bench, truth):
    def drop(time):
        return (time > 2.0) & (time < 3.0)

    rng = np.random.default_rng(9)
    run = independent_bench("run", wavy, 4.0, truth.values, rng, ("speed",), drop=drop)
    evaluation = evaluate(truth, [run], {"speed": 0.3})
    residuals = evaluation.residuals[0, "speed"]
    np.testing.assert_array_equal(np.isnan(residuals), drop(run.measurements["speed"].time))
    assert evaluation.rmse("speed") == pytest.approx(0.3, rel=0.3)


def test_the_hq_set_settles_where_the_thesis_parameters_say():
    states = predicted_steady_states(load_parameter_set("hq").coefficients, np.array([3.0, 0.0]))
    assert states["speed"][0] == pytest.approx(110.81, abs=0.01)
    assert states["axial"][0] == pytest.approx(0.1268, abs=2e-4)
    assert states["ambient"][0] == pytest.approx(0.1412, abs=2e-4)
    assert states["thrust"][0] == pytest.approx(12.13, abs=0.02)
    assert all(values[1] == 0.0 for values in states.values())


def test_predicted_steady_states_have_come_to_rest():
    """The ambient flow is the slowest: it must solve k_U U + k_UU U|U| = k_TU T."""
    hq = load_parameter_set("hq")
    q = hq.values
    throttles = np.array([-3.0, -1.2, 1.2, 3.0])
    states = predicted_steady_states(hq.coefficients, throttles)
    force = q["k_TU"] * np.abs(states["thrust"])
    flow = (np.sqrt(q["k_U"] ** 2 + 4.0 * q["k_UU"] * force) - q["k_U"]) / (2.0 * q["k_UU"])
    np.testing.assert_allclose(states["ambient"], np.sign(throttles) * flow, rtol=1e-3)


def plateaus(levels, seconds, rng, rho=0.0):
    """An experiment of plateaus: speed of 30 rad/s/V times the throttle, residuals of unit variance."""
    throttle = np.repeat(np.asarray(levels, dtype=float), [round(s / 0.002) for s in seconds])
    time = 0.04 * (np.arange(int(throttle.size * 0.002 / 0.04)) + 0.5)
    means = 30.0 * throttle[(time / 0.002).astype(int)] + remembering(rng, rho, time.size)
    speed = Measurement(signal="speed", time=time, values=means, width=0.04, noise=1.0)
    return Experiment(name="plateaus", dt=0.002, throttle=throttle, measurements={"speed": speed})


def test_plateaus_are_found_where_the_throttle_holds_long_enough():
    experiment = plateaus([0.0, 1.0, 2.0, -3.0, 0.0], [5.0, 6.0, 2.5, 7.0, 5.0], np.random.default_rng(10))
    found = steady_states([experiment])
    assert [p.throttle for p in found] == [1.0, -3.0]
    for plateau in found:
        mean, error = plateau.signals["speed"]
        assert mean == pytest.approx(30.0 * plateau.throttle, abs=5.0 * error)


def test_what_precedes_the_settling_does_not_enter():
    experiment = plateaus([0.0, 1.0], [1.0, 5.0], np.random.default_rng(11))
    speed = experiment.measurements["speed"]
    unsettled = np.where(speed.time < 3.0, 1e6, speed.values)
    experiment = replace(experiment, measurements={"speed": replace(speed, values=unsettled)})
    assert steady_states([experiment])[0].signals["speed"][0] == pytest.approx(30.0, abs=1.0)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_the_standard_errors_of_plateaus_are_their_scatter(rho):
    rng = np.random.default_rng(12)
    pairs = [steady_states([plateaus([1.0], [22.0], rng, rho)])[0].signals["speed"] for _ in range(150)]
    means, errors = np.array(pairs).T
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(np.std(means), rel=0.25)


def test_a_plateau_without_values_has_no_such_signal():
    experiment = plateaus([1.0], [6.0], np.random.default_rng(13))
    speed = experiment.measurements["speed"]
    empty = replace(speed, values=np.full_like(speed.values, np.nan))
    found = steady_states([replace(experiment, measurements={"speed": empty})])
    assert found[0].signals == {}


@pytest.mark.parametrize("rate", [25.0, 40.0])
def test_white_noise_has_its_level_at_every_frequency(rate):
    values = 0.3 * np.random.default_rng(14).standard_normal(40_000)
    frequency, density = amplitude_density([values], rate)
    assert frequency[0] == pytest.approx(rate / 128)
    assert frequency[-1] == pytest.approx(rate / 2)
    level = 0.3 * np.sqrt(2.0 / rate)
    np.testing.assert_allclose(density[:-1], level, rtol=0.15)  # the last one is one-sided already
    assert np.mean(density[:-1]) == pytest.approx(level, rel=0.02)


def test_the_densities_add_up_to_the_variance():
    values = remembering(np.random.default_rng(15), 0.5, 40_000)
    frequency, density = amplitude_density([values], 25.0)
    assert np.sum(density**2) * frequency[0] == pytest.approx(np.var(values), rel=0.05)


def test_gaps_split_the_series_and_short_stretches_do_not_count():
    rng = np.random.default_rng(16)
    values = rng.standard_normal(40_000)
    values[::1000] = np.nan
    values[5000:5200] = np.nan
    values[5050:5150] = 1e3 * rng.standard_normal(100)
    _, density = amplitude_density([values, np.full(500, np.nan)], 25.0)
    assert np.mean(density[:-1]) == pytest.approx(np.sqrt(2.0 / 25.0), rel=0.02)
    frequency, density = amplitude_density([values[5050:5150]], 25.0)
    assert frequency.size == density.size == 0


def test_longer_stretches_count_for_more():
    rng = np.random.default_rng(17)
    loud, quiet = 2.0 * rng.standard_normal(6400), rng.standard_normal(19_200)
    _, density = amplitude_density([loud, quiet], 2.0)
    assert np.mean(density[:-1] ** 2) == pytest.approx((4.0 + 3.0) / 4.0, rel=0.1)
