"""From weighed sets to a verdict: what is quiet, what the log alone may claim, and which class an effect has."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from generated import campaign, noise_of

from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.diagnosis_json import as_json
from gap_diagnosis.diagnosis_words import in_words, next_step
from gap_diagnosis.investigation import imitated_by_parameters
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.suspects import suspects
from gap_diagnosis.verdict import _is_convention, _is_slight, class_of, verdict_of
from system_identification.fitting import fit
from system_identification.hypothesis import Hypothesis
from system_identification.loose import Loose

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


def test_a_finding_of_the_log_is_claimed_where_nothing_else_is_open(healthy):
    verdict = verdict_of(healthy.investigation, [REPEATS])
    assert (verdict.verdict, [claim.effect for claim in verdict.claims]) == ("effect", ["dropped_samples"])


def test_a_finding_that_is_not_considered_is_unknown(healthy):
    assert verdict_of(healthy.investigation, (), [REPEATS]).verdict == "unknown"


def test_recordings_that_would_not_have_shown_most_effects_cannot_tell(healthy):
    found = healthy.investigation
    blind = [replace(each, visibility=0.0) for each in found.search.rated]
    again = replace(found, search=replace(found.search, rated=blind))
    verdict = verdict_of(again, ())
    assert (verdict.verdict, verdict.reason) == ("cannot_tell", "power")
    words = in_words(replace(healthy, investigation=again, verdict=verdict))
    assert "only 0 % of the effects would have shown" in words


def cannot_tell(healthy, reason):
    return replace(healthy, verdict=replace(healthy.verdict, verdict="cannot_tell", reason=reason))


@pytest.mark.parametrize(
    ("reason", "told"), [("power", "record runs that show more"), ("several", "diagnose --experiment designs")]
)
def test_what_to_do_where_nothing_can_be_told_is_in_the_summary_and_refers_to_no_other_part(healthy, reason, told):
    written = as_json(cannot_tell(healthy, reason), runs=["a"], parameter_set="hl", version="0", seed=0)
    assert told in written["next_step"]
    assert written["summary"].endswith(f"Next: {written['next_step']}")
    assert "below" not in written["summary"] and "above" not in written["summary"]


def test_an_experiment_that_was_designed_is_the_next_step(healthy):
    assert next_step(cannot_tell(healthy, "several"), "Play this.") == "Play this."
    assert next_step(healthy, "Play this.") == "Leave the simulator as it is."


def test_where_nothing_resembles_what_is_unknown_nothing_is_said_to(healthy):
    found = SimpleNamespace(
        unexplained=SimpleNamespace(features=()),
        best=SimpleNamespace(suspects=("a lag",)),
        retuning_helps=1.0,
        none=healthy.investigation.none,
        free=healthy.investigation.free,
    )
    verdict = replace(healthy.verdict, verdict="unknown", resembles=())
    words = in_words(replace(healthy, verdict=verdict, investigation=found, errors=None))
    assert words == "The known effects do not explain the gap."


@pytest.mark.parametrize(
    ("straight", "told", "in_summary"),
    [(None, [], False), (False, ["as held until the next one"], False), (True, ["as straight lines between"], True)],
)
def test_how_commands_act_between_samples_is_told_where_it_was_not_stated(healthy, straight, told, in_summary):
    found = replace(healthy, straight=straight)
    written = as_json(found, runs=["a"], parameter_set="hl", version="0", seed=0)
    assert len(written["log"]) == len(told) and all(a in b for a, b in zip(told, written["log"], strict=True))
    assert (written["log"] != [] and written["log"][0] in written["summary"]) is in_summary


@pytest.mark.parametrize(
    ("effect", "size", "kind"), [("thrust_loss", 0.4, "parametric"), ("coulomb_friction", 200.0, "structural")]
)
def test_the_class_of_an_effect_is_what_parameters_free_of_their_deviations_can_do(effect, size, kind):
    name = {"thrust_loss": "share", "coulomb_friction": "deceleration"}[effect]
    stated, recordings = campaign({effect: {name: size}}, seed=3, spread=0.0, duration=30.0)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    suspect = next(s for s in suspects({"speed", "thrust", "torque", "ambient"}) if s.effect == effect)
    posed = problem.with_effects(suspect.slots)
    noise = noise_of(posed)
    fitted = fit(posed, noise, posed.start(np.array([size]) / suspect.slots[0].width))
    none = np.zeros(problem.known.size)
    loose = Loose({}, none)
    found = Hypothesis(suspects=(suspect,), fitted=fitted, noise=noise, loose=loose)
    assert class_of(*imitated_by_parameters(found, suspect)) == kind


@pytest.mark.parametrize(
    ("value", "unit", "any_two_have"),
    [(0.004, "s", True), (0.006, "s", False), (-1e-4, "s/s", True), (2e-4, "s/s", False), (1e-4, "1", False)],
)
def test_milliseconds_and_what_quartzes_drift_in_a_run_are_no_effect(value, unit, any_two_have):
    claim = SimpleNamespace(sizes={"size": SimpleNamespace(value=value, unit=unit)})
    assert _is_convention(claim, 30.0) == any_two_have


@pytest.mark.parametrize(
    ("effect", "value", "slight"),
    [("brake_asymmetry", -0.004, True), ("brake_asymmetry", 0.012, False), ("load_cell_bias", 0.03, True),
     ("throttle_saturation", 1.0, False)],
)  # fmt: skip
def test_what_any_model_is_off_by_is_no_effect(effect, value, slight):
    claim = SimpleNamespace(effect=effect, sizes={"size": SimpleNamespace(value=value)})
    assert _is_slight(claim) == slight
