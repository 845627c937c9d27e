"""Probabilities of hypotheses, before and after they are mixed with the prior."""

from dataclasses import replace

import pytest
from generated import campaign

from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.noise import NoiseModel
from gap_diagnosis.posterior import LAPSE, posterior_of


@pytest.fixture(scope="module")
def found():
    """Return the hypotheses weighed for a thruster with a small effect."""
    stated, recordings = campaign({"thrust_asymmetry": {"share": 0.04}}, seed=2)
    return diagnose(recordings, stated).investigation


def _whole(posterior):
    return posterior.none + posterior.unknown + sum(posterior.singles.values()) + sum(posterior.pairs.values())


def test_all_hypotheses_together_are_certain(found):
    for posterior in (posterior_of(found), posterior_of(found).stated, posterior_of(found, scatters=True).stated):
        assert _whole(posterior) == pytest.approx(1.0)


def test_what_is_stated_is_never_certain(found):
    seen, stated = posterior_of(found), posterior_of(found).stated
    assert stated.prior is None
    for key, probability in stated.singles.items():
        assert probability == pytest.approx((1.0 - LAPSE) * seen.singles[key] + LAPSE * seen.prior.singles[key])
        assert 0.0 < probability < 1.0 - 0.9 * LAPSE


def test_another_effect_beside_one_that_scatters_needs_more_evidence(found):
    alone, beside = posterior_of(found), posterior_of(found, scatters=True)
    key = max(alone.singles, key=lambda name: alone.singles[name])
    assert beside.singles[key] / beside.none < 0.1 * alone.singles[key] / alone.none


def test_evidence_counts_less_where_noise_is_larger_than_the_sensors_own(found):
    assert found.beyond_sensors == pytest.approx(1.0, abs=0.1)
    louder = {name: replace(s, marginal=6.0 * s.marginal) for name, s in found.noise.signals.items()}
    doubted = replace(found, noise=NoiseModel(signals=louder))
    assert doubted.beyond_sensors == pytest.approx(6.0, rel=0.1)
    best = max(found.candidates, key=lambda candidate: candidate.evidence).keys[0]
    assert (
        0.0
        < posterior_of(doubted).singles[best] / posterior_of(doubted).none
        < (posterior_of(found).singles[best] / posterior_of(found).none)
    )


@pytest.mark.parametrize(("explained", "believed"), [(500.0, True), (60000.0, False)])
def test_a_second_effect_pays_for_what_the_shape_of_a_large_first_one_may_be_off(explained, believed):
    """Twenty-five units more: much beside five hundred, a third of a thousandth beside sixty thousand."""
    stated, recordings = campaign({"thrust_asymmetry": {"share": 0.3}, "tach_lag": {"time": 0.03}}, seed=2)
    found = diagnose(recordings, stated).investigation
    pair = next(each for each in found.candidates if set(each.keys) == {"thrust_asymmetry", "tach_lag"})
    single = next(each for each in found.candidates if each.keys == ("thrust_asymmetry",))
    weighed = (
        replace(pair, evidence=explained + 25.0, unexplained=None),
        replace(single, evidence=explained, unexplained=None),
    )
    none = replace(found.none, unexplained=None)
    seen = posterior_of(replace(found, none=none, candidates=weighed, stretches=None))
    assert (seen.pairs[pair.keys] > 0.9) == believed
    assert (seen.singles["thrust_asymmetry"] > 0.9) != believed
    assert seen.marginal["thrust_asymmetry"] > 0.9


@pytest.mark.parametrize(("explained", "rivals"), [(500.0, False), (60000.0, True)])
def test_effects_that_explain_alike_are_rivals_though_the_shape_of_one_fits_a_little_better(found, explained, rivals):
    first, second = (each for each in found.candidates[:2] if len(each.suspects) == 1)
    weighed = (
        replace(first, evidence=explained, unexplained=None),
        replace(second, evidence=explained - 10.0, unexplained=None),
    )
    seen = posterior_of(replace(found, none=replace(found.none, unexplained=None), candidates=weighed, stretches=None))
    assert seen.marginal[first.keys[0]] > seen.marginal[second.keys[0]]
    assert (seen.marginal[second.keys[0]] > 0.1) == rivals


def test_sensors_that_are_very_good_make_nothing_out_of_the_last_ten_thousandths_of_a_signal(found):
    """A few units of evidence are much at ordinary noise; at a thirtieth of it integrators differ by as much."""
    best = max(found.candidates, key=lambda candidate: candidate.evidence)
    assert found.inexact < 0.5
    problem = found.none.fitted.problem
    finer = replace(problem, recordings=tuple(_finer(each, 30.0) for each in problem.recordings))
    keen = replace(found, none=replace(found.none, fitted=replace(found.none.fitted, problem=finer)))
    assert keen.inexact == pytest.approx(900.0 * found.inexact, rel=1e-6)
    assert posterior_of(keen).none / posterior_of(keen).of(best.keys) > 100.0 * (
        posterior_of(found).none / posterior_of(found).of(best.keys)
    )


def _finer(recording, times):
    experiment = recording.experiment
    kept = {name: replace(m, noise=m.noise / times) for name, m in experiment.measurements.items()}
    return replace(recording, experiment=replace(experiment, measurements=kept))
