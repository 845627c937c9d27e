"""Fits of hypotheses: a truth is recovered from a wrong start, also along a bent valley; priors decide the rest."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign, noise_of
from scipy.optimize import least_squares

from gap_diagnosis.prediction import LOG_CHANNELS
from gap_diagnosis.problem import FARTHEST, Problem, deviations_of
from gap_diagnosis.sensitivities import sensitivities_of
from gap_diagnosis.suspects import suspects
from system_identification.fitting import fit, fit_past_jumps
from system_identification.hypothesis import weighed
from system_identification.noise import whitener


def problem_of(effects, **options):
    stated, recordings = campaign(effects, duration=12.0, runs=2, **options)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    listed = {s.effect: s for s in suspects({"speed", "ambient", "thrust", "torque"})}
    return problem, listed


@pytest.fixture(scope="module")
def gain():
    problem, listed = problem_of({"throttle_gain": {"share": 0.3}}, seed=11)
    return problem.with_effects(listed["throttle_gain"].slots)


def test_a_size_in_the_span_of_the_parameters_is_followed_to_the_bottom_of_its_valley(gain):
    found = fit(gain, noise_of(gain), gain.start([0.05]), iterations=25)
    deviation = float(np.sqrt(found.covariance[-1, -1]))
    assert abs(found.x[-1] - 0.3) < 3.0 * deviation < 0.15
    other = least_squares(
        lambda x: np.concatenate((noise_of(gain).whiten(gain.residuals(x)), x[: gain.nuisances])),
        found.x,
        method="trf",
        diff_step=1e-4,
        max_nfev=6,
    )
    assert found.cost - 2.0 * other.cost < 0.5
    assert found.x[-1] == pytest.approx(other.x[-1], abs=0.3 * deviation)


def test_where_parameters_are_held_at_the_ends_of_their_ranges_the_others_are_at_their_best():
    problem, _ = problem_of({"throttle_gain": {"share": 0.4}}, seed=13)
    narrow = replace(problem, deviations={name: 0.2 * deviation for name, deviation in problem.deviations.items()})
    found = fit(narrow, noise_of(narrow), narrow.start(), iterations=25)
    assert np.sum(np.abs(found.x[: len(narrow.names)]) == FARTHEST) >= 2
    other = least_squares(
        lambda x: np.concatenate((noise_of(narrow).whiten(narrow.residuals(x)), x)),
        narrow.start(),
        bounds=tuple(narrow.bounded(np.full(found.x.size, far)) for far in (-np.inf, np.inf)),
        diff_step=1e-4,
        max_nfev=60,
    )
    assert found.cost - 2.0 * other.cost < 1e-3 * found.cost


def test_parameters_come_out_within_their_deviations():
    problem, _ = problem_of({}, seed=12)
    found = fit(problem, noise_of(problem), problem.start(), iterations=12)
    count = float(np.sum(problem.known))
    assert found.cost == pytest.approx(count, abs=5.0 * np.sqrt(2.0 * count))
    assert np.max(np.abs(found.x)) < 3.5


def test_sensitivities_agree_with_differences_taken_by_hand(gain):
    x = gain.start([0.2])
    column = gain.nuisances - 3
    moved = x.copy()
    moved[column] += 0.01
    by_hand = (gain.predicted(moved) - gain.predicted(x)) / 0.01
    assert sensitivities_of(gain, x, [column])[gain.known, 0] == pytest.approx(by_hand[gain.known], rel=1e-6, abs=1e-9)


def test_an_effect_without_influence_is_as_uncertain_as_its_range():
    problem, listed = problem_of({}, seed=12)
    posed = problem.with_effects(listed["throttle_saturation"].slots)
    found = fit(posed, noise_of(posed), posed.start([1.25]), iterations=5)
    assert np.sqrt(found.covariance[-1, -1]) == pytest.approx(1.0 / np.sqrt(12.0), rel=1e-6)


@pytest.fixture(scope="module")
def reversal():
    problem, listed = problem_of({"flow_reversal_loss": {"share": 0.75}}, seed=13)
    return problem.with_effects(listed["flow_reversal_loss"].slots)


def test_samples_at_a_jump_do_not_hold_a_fit_back(reversal):
    start = reversal.start([0.35])
    count = float(np.sum(reversal.known))
    held = fit(reversal, noise_of(reversal), start, iterations=25)
    found = fit_past_jumps(reversal, noise_of(reversal), start)
    assert held.cost > 2.0 * count
    assert found.cost == pytest.approx(count, abs=5.0 * np.sqrt(2.0 * count))
    assert reversal.sizes(found.x)["flow_reversal_loss"]["share"] == pytest.approx(0.75, abs=0.02)


def test_a_sample_that_passes_a_threshold_does_not_swamp_a_slope(reversal):
    start, place = reversal.start([0.8]), reversal.names.index("k_w")  # it moves the instants of reversal
    changes = []
    for sign in (1.0, -1.0):
        moved = start.copy()
        moved[place] += 0.5 * sign
        changes.append(reversal.predicted(moved) - reversal.predicted(start))
    jumped = (np.abs(changes[0]) > 1.0) & (np.abs(changes[1]) < 0.2)  # [N] to one side alone
    assert np.any(jumped)
    assert np.max(np.abs(sensitivities_of(reversal, start, [place], 0.05)[jumped])) < 0.5


@pytest.mark.parametrize("size", [0.0, 0.9])
def test_at_the_end_of_its_range_a_size_that_makes_readings_jump_still_has_a_slope(reversal, size):
    at = reversal.start([size / 0.9])
    assert np.nanmax(np.abs(sensitivities_of(reversal, at, [reversal.nuisances]))) > 0.0


CLOCKS = np.array([[0.4, -1.5, 0.8], [1.3, 0.2, -0.9], [-1.1, 0.9, 0.3], [-0.6, 0.4, -0.2]])


def off_by(late):
    """Return a set of four runs whose stamps are late by so much (runs, topics) [s], and by topic how late they are."""
    stated, recordings = campaign({}, seed=14, runs=4)
    given = [dict(zip(("speed", "flow", "load"), each, strict=True)) for each in late]

    def shifted(recording, own):
        signals = recording.experiment.measurements
        moved = {name: replace(each, time=each.time + own[LOG_CHANNELS[name]]) for name, each in signals.items()}
        return replace(recording, experiment=replace(recording.experiment, measurements=moved))

    runs = tuple(shifted(each, own) for each, own in zip(recordings, given, strict=True))
    return Problem(recordings=runs, parameter_set=stated, deviations=deviations_of(stated)), given


@pytest.mark.parametrize(("scatter", "least", "most"), [(0.0, 0.0, 0.5), (4e-3, 1.4, 4.0)])
def test_clocks_that_differ_from_run_to_run_are_found_and_how_widely_they_do(scatter, least, most):
    problem, late = off_by(scatter * CLOCKS)
    found = weighed(problem, (), problem.start(), whitener(problem, problem.start()))
    assert least <= found.noise.levels.conventions <= most
    for signal in ("speed", "thrust"):
        shifts = [problem.situation(found.fitted.x, run).shifts for run in range(4)]
        off = [s.throttle + s.signals[signal] - own[LOG_CHANNELS[signal]] for s, own in zip(shifts, late, strict=True)]
        assert np.median(np.abs(off)) < 5e-4  # a slow run tells less


def test_a_delay_that_all_runs_share_is_no_matter_of_their_clocks():
    problem, _ = off_by(np.tile([0.0, 0.0, 0.014], (4, 1)))
    found = weighed(problem, (), problem.start(), whitener(problem, problem.start()))
    assert found.noise.levels.conventions <= 0.5
    late = next(s for s in suspects({"speed", "ambient", "thrust", "torque"}) if s.key == "log_alignment:load")
    posed = problem.with_effects(late.slots)
    beside = weighed(posed, (late,), posed.start([0.1]), found.noise)
    assert beside.evidence > found.evidence + 100.0
    assert posed.sizes(beside.fitted.x)["log_alignment"]["load"] == pytest.approx(0.014, abs=2e-3)
