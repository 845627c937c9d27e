"""From probabilities to a verdict: what may be called quiet, and what the log alone may not claim."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.candidate import Candidate, with_air
from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.diagnosis_words import in_words
from gap_diagnosis.fitting import fit
from gap_diagnosis.noise import NoiseModel, white_noise
from gap_diagnosis.posterior import Posterior, posterior_of
from gap_diagnosis.problem import Problem, SizeSlot, deviations_of
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.suspects import suspects
from gap_diagnosis.verdict import class_of, verdict_of

REPEATS = Scatter(
    effect="dropped_samples",
    signal="",
    parameter="share",
    size=0.004,
    deviation=0.001,
    log_odds=40.0,
    sentence="0.4 % of the samples repeat the sample before them",
)


@pytest.fixture(scope="module")
def healthy():
    """Return the diagnosis of a thruster that is as stated."""
    stated, recordings = campaign(seed=2, spread=0.0)
    return diagnose(recordings, stated)


def seen(none, **singles):
    return Posterior(none=none, unknown=1.0 - none - sum(singles.values()), singles=singles, pairs={}, beside={})


def test_nothing_is_said_to_be_wrong_only_where_no_effect_is_much_more_probable_than_none(healthy):
    found = healthy.investigation
    assert verdict_of(found, seen(0.5, cavitation=0.3), ()).verdict in ("no_gap", "parameters")
    assert verdict_of(found, seen(0.25, cavitation=0.35), ()).verdict in ("no_gap", "parameters")
    favoured = verdict_of(found, seen(0.15, cavitation=0.8), ())
    assert (favoured.verdict, favoured.reason) == ("cannot_tell", "several")


def test_a_finding_of_the_log_does_not_settle_what_else_is_open(healthy):
    found = healthy.investigation
    assert [c.effect for c in verdict_of(found, seen(0.6, cavitation=0.1), [REPEATS]).claims] == ["dropped_samples"]
    undecided = verdict_of(found, seen(0.01, cavitation=0.5, tach_lag=0.48), [REPEATS])
    assert (undecided.verdict, undecided.claims) == ("cannot_tell", ())


def test_each_way_of_not_knowing_has_its_own_words(healthy):
    found = healthy.investigation
    louder = {name: replace(s, marginal=6.0 * s.marginal) for name, s in found.noise.signals.items()}
    noisy = replace(found, noise=NoiseModel(signals=louder))
    blind = replace(found, screened=tuple(replace(s, visibility=0.0) for s in found.screened))
    words = {}
    for name, known, posterior in (
        ("several", found, seen(0.01, cavitation=0.5, tach_lag=0.48)),
        ("noise", noisy, seen(0.6)),
        ("power", blind, seen(0.6)),
    ):
        verdict = verdict_of(known, posterior, ())
        assert (verdict.verdict, verdict.reason) == ("cannot_tell", name)
        words[name] = in_words(replace(healthy, investigation=known, verdict=verdict))
    assert "several explanations remain (cavitation 0.50, tach_lag 0.48, none 0.01)" in words["several"]
    assert f"{noisy.beyond_sensors:.1f} times what the samples themselves show" in words["noise"]
    assert "only 0 % of the effects would have shown" in words["power"]


def test_an_effect_has_the_class_beside_air_that_it_has_alone():
    stated, recordings = campaign(
        {"ventilation": {"share": 0.5, "onset": 60.0}, "thrust_loss": {"share": 0.4}}, seed=3, spread=0.0, duration=30.0
    )
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    noise = white_noise({"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4})
    suspect = next(s for s in suspects({"speed", "thrust", "torque", "ambient"}) if s.effect == "thrust_loss")
    assert all(isinstance(slot, SizeSlot) for slot in suspect.slots)
    posed = problem.with_effects(suspect.slots)
    fitted = fit(posed, noise, posed.start(np.array([0.4]) / suspect.slots[0].width))
    alone = Candidate(suspects=(suspect,), fitted=fitted, evidence=0.0, noise=noise)
    beside = with_air(alone)
    assert class_of(alone, suspect) == class_of(beside, suspect)


@pytest.fixture(scope="module")
def parametric_pair():
    """Return the diagnosis of a thruster with two effects that parameters can imitate."""
    stated, recordings = campaign(
        {"throttle_gain": {"share": 0.3}, "propeller_fouling": {"share": 0.3}}, seed=8, duration=30.0, runs=4
    )
    return diagnose(recordings, stated)


def test_two_effects_that_parameters_can_imitate_are_not_claimed(parametric_pair):
    verdict = parametric_pair.verdict
    assert (verdict.verdict, verdict.reason) == ("cannot_tell", "parameters")
    assert "parameters beyond their stated deviations can imitate both" in in_words(parametric_pair)


def test_what_is_unknown_beside_two_effects_does_not_speak_for_them(parametric_pair):
    found, posterior = parametric_pair.investigation, posterior_of(parametric_pair.investigation)
    (keys, sure) = max(posterior.pairs.items(), key=lambda each: each[1])
    assert sure > 0.9
    doubtful = replace(
        posterior,
        unknown=0.3,
        pairs={keys: 0.7},
        singles=dict.fromkeys(posterior.singles, 0.0),
        beside=dict.fromkeys(keys, 0.3),
        prior=None,
    )
    assert verdict_of(found, doubtful, ()).reason == "several"
