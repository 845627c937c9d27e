"""What speaks for something without a name: lines, stretches of lost thrust, effects beyond what is plausible."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from generated import campaign, noise_of

from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.diagnosis_json import as_json
from gap_diagnosis.discrepancy import discrepancy
from gap_diagnosis.investigation import InVain
from gap_diagnosis.lines import lines_of
from gap_diagnosis.problem import Problem, deviations_of
from system_identification.fitting import fit


def test_effects_are_sought_no_further_where_they_explain_less_than_is_left_and_leave_as_much():
    def of(keys, evidence):
        return SimpleNamespace(keys=keys, suspects=keys, evidence=evidence)

    def told(left, before, gained, keys=("a", "b", "c")):
        judge = InVain()
        judge.known = {keys: left, keys[:-1]: before}
        return judge(of(keys[:-1], 0.0), of(keys, gained))

    assert told(left=214.0, before=188.0, gained=33.0)  # a command that is bent, with a third effect
    assert not told(left=32.0, before=33.0, gained=174.0)  # several effects, as each is found
    assert not told(left=150.0, before=188.0, gained=33.0)  # less is left
    assert not told(left=214.0, before=188.0, gained=350.0)  # it explains more than is left
    assert not told(left=5.0, before=4.0, gained=3.0)  # nothing to speak of is left
    assert not told(left=214.0, before=188.0, gained=33.0, keys=("a", "b"))


def lines_in(fitted):
    return lines_of(fitted, fitted.problem.happened(fitted.x))


def fitted_with(added, signal="thrust"):
    """Return the fit of a thruster as stated, with (time -> values) added to a signal of the first recording."""
    stated, recordings = campaign(seed=4, spread=0.0, duration=30.0, runs=2)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    rows = next(each.rows for each in problem.series if each.signal == signal)
    time = recordings[0].experiment.measurements[signal].time
    observed = problem.measured.copy()
    observed[rows] += added(time)
    heard = replace(problem, observed=observed)
    return fit(heard, noise_of(heard), heard.start()), rows, added(time)


def test_a_line_is_found_at_its_frequency_in_its_signal_and_taken_out():
    fitted, rows, wave = fitted_with(lambda t: 0.2 * np.sin(2.0 * np.pi * 3.3 * t + 0.4))
    (line,) = lines_in(fitted)
    assert list(line.odds) == ["thrust"]
    assert "3.3 Hz" in line.name and "growing" not in line.name
    assert np.std(line.explained[rows] - wave) < 0.2 * np.std(wave)
    others = np.delete(line.explained, np.arange(rows.start, rows.stop))
    assert not np.any(others)


def test_a_line_that_grows_is_said_to_grow():
    fitted, _, _ = fitted_with(lambda t: 0.5 * (t / 30.0) * np.sin(2.0 * np.pi * 1.2 * t))
    assert lines_in(fitted)[0].name == "a line at 1.2 Hz, growing with time"


def coloured(keep, size, seed):
    rng = np.random.default_rng(seed)

    def noise(time):
        values = np.zeros(time.size)
        for k in range(1, time.size):
            values[k] = keep * values[k - 1] + size * rng.standard_normal()
        return values

    return noise


@pytest.mark.parametrize(("keep", "seed"), [(0.0, 1), (0.9, 2), (0.9, 3), (0.99, 4), (-0.7, 5)])
def test_noise_of_a_smooth_colour_has_no_line(keep, seed):
    fitted, _, _ = fitted_with(coloured(keep, 0.3, seed))
    assert lines_in(fitted) == []


def test_a_line_is_evidence_for_something_unknown_and_is_not_taken_for_noise():
    fitted, rows, wave = fitted_with(lambda t: 0.3 * np.sin(2.0 * np.pi * 2.3 * t))
    found = discrepancy(fitted, noise_of(fitted.problem))
    assert found.evidence > 20.0
    assert (found.features[0].signal, found.features[0].name) == ("thrust", "a line at 2.3 Hz")
    assert np.std(wave - found.explained[rows]) < 0.3 * np.std(wave)


def test_a_hum_is_listed_and_says_nothing_against_a_model():
    fitted, _, _ = fitted_with(lambda t: 0.09 * np.sin(2.0 * np.pi * 2.3 * t))
    assert lines_in(fitted)[0].evidence > 0.0
    found = discrepancy(fitted, noise_of(fitted.problem))
    assert "a line at 2.3 Hz" in [feature.name for feature in found.features]
    assert found.evidence < 1.0


@pytest.mark.long
def test_thrust_lost_in_stretches_that_the_states_foresee_is_not_air():
    stated, recordings = campaign(outside={"wake_stall": {"share": 0.5}}, seed=3, spread=0.0, duration=30.0, runs=4)
    found = diagnose(recordings, stated)
    assert "ventilation" not in found.verdict.probabilities


@pytest.fixture(scope="module")
def bent():
    """Return the diagnosis of a throttle that bends by its cube: a limit and more sag than there can be."""
    stated, recordings = campaign(outside={"throttle_cubic": {"curvature": 0.04}}, seed=5, duration=30.0, runs=4)
    return diagnose(recordings, stated)


@pytest.mark.long
def test_a_throttle_that_bends_by_its_cube_is_none_of_the_library(bent):
    assert bent.verdict.verdict == "unknown" and not bent.verdict.claims


@pytest.mark.long
def test_what_is_unknown_has_a_budget_that_adds_up(bent):
    budget = as_json(bent, runs=("a", "b", "c", "d"), parameter_set="hl", version="0", seed=0)["budget"]
    shares = [budget["parameters"]["share"], *(cause["share"] for cause in budget["causes"])]
    assert sum(shares) + budget["unexplained"]["share"] == pytest.approx(1.0, abs=1e-6)
    assert [step["step"] for step in budget["left_out"][:2]] == ["as_is", "retuned"]
    assert all(len(step["by_run"]) == 4 for step in budget["left_out"])
    for cause in budget["causes"]:
        assert all(len(sizes) == 4 for sizes in cause["sizes_by_run_left_out"].values())


@pytest.mark.long
def test_an_effect_near_the_end_of_its_range_is_not_pressed():
    stated, recordings = campaign({"propeller_fouling": {"share": 0.59}}, seed=6)
    found = diagnose(recordings, stated)
    assert [claim.effect for claim in found.verdict.claims] == ["propeller_fouling"]


@pytest.mark.parametrize(
    ("limit", "duration", "runs"), [pytest.param(1.2, 30.0, 4, marks=pytest.mark.long), (3.35, 15.0, 3)]
)
def test_a_limit_is_found_far_below_the_largest_command_and_just_below_it(limit, duration, runs):
    stated, recordings = campaign({"throttle_saturation": {"limit": limit}}, seed=7, duration=duration, runs=runs)
    assert 3.4 < max(np.max(np.abs(each.experiment.throttle)) for each in recordings) < 3.7
    (claim,) = diagnose(recordings, stated).verdict.claims
    assert claim.effect == "throttle_saturation"
    assert claim.sizes["limit"].value == pytest.approx(limit, abs=0.05)
