"""The plan of the vehicle's study: every assumption with a reason, cases by combination, wrong plans refused."""

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
import yaml

from rov_sim.study.results import Results
from rov_sim.vehicle_study.claims import CLAIMS
from rov_sim.vehicle_study.judgement import judged
from rov_sim.vehicle_study.plan_io import load_plan, parse_plan, plan_of, plan_text
from rov_sim.vehicle_study.results_io import shards
from rov_sim.vehicle_study.scoring import SCORES
from rov_sim.vehicle_study.tables import assumption_table, case_table, claim_table, error_table, finding_lines

PLAN = load_plan("thesis")
TEXT = (resources.files("rov_sim.vehicle_study") / "plans" / "thesis.yaml").read_text("utf-8")


def changed(path: tuple, value) -> str:  # type: ignore[no-untyped-def]
    """The thesis' plan with one entry replaced."""
    document = yaml.safe_load(TEXT)
    at = document
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return yaml.safe_dump(document, sort_keys=False)


def test_the_thesis_plan_has_both_comparisons_and_what_the_claims_may_depend_on() -> None:
    names = [group.name for group in PLAN.groups]
    assert names[:2] == ["speed_loop", "flow"]
    assert len(PLAN.groups[1].strategies) == 9 and "steady-flow" in PLAN.groups[1].strategies
    varied = {key for group in PLAN.groups for key in (*group.change, *group.vary)}
    needed = {"gain", "rate", "feedback", "beliefs", "inflow", "observers", "hull", "layout", "current_north"}
    assert needed <= varied
    assert all(len(assumed.reason) > 3 for assumed in PLAN.assumed.values())


def test_each_combination_of_what_is_varied_is_a_case_and_its_typical_one_is_as_assumed() -> None:
    flow = PLAN.groups[1]
    cases = PLAN.cases(flow)
    assert len(cases) == 3 * 2 and len({case.name for case in cases}) == len(cases)
    assert not any("." in case.name for case in cases)
    typical = PLAN.typical(flow)
    assert typical.name == "flow-gain_2-feedback_truth"
    assert all(getattr(typical.assumptions, name) == assumed.value for name, assumed in PLAN.assumed.items())


def test_what_makes_no_difference_to_a_strategy_is_computed_once() -> None:
    refitted = next(group for group in PLAN.groups if group.name == "refitted")
    case = next(c for c in PLAN.cases(refitted) if c.assumptions.feedback == "truth")
    assert PLAN.computed_as("hq-ekf", case) == "flow-gain_2-feedback_truth"
    assert PLAN.computed_as("lookup", case) == case.name
    stiff = PLAN.cases(next(group for group in PLAN.groups if group.name == "speed_loop_stiff"))
    assert [PLAN.computed_as("lookup", c) for c in stiff] == ["speed_loop-gain_2-rate_25"] * 2
    assert len({PLAN.computed_as("dead-zone", c) for c in stiff}) == 2
    tank = PLAN.cases(next(group for group in PLAN.groups if group.name == "tank_flow"))
    assert [PLAN.computed_as("lookup", c) for c in tank] == ["flow-gain_2-feedback_truth", case.name]
    assert [PLAN.computed_as("hl-nlo", c) for c in tank] == [tank[0].name] * 2
    parts = shards(PLAN, 30)
    assert len(parts) == len(set(parts)) and {s.last - s.first for s in parts} == {25, 5}


def test_a_plan_survives_its_way_through_plain_text() -> None:
    plan, contents = plan_of(plan_text(PLAN, {"thruster hq": "..."}))
    assert plan == PLAN and contents == {"thruster hq": "..."}


@pytest.mark.parametrize(
    ("path", "value", "text"),
    [
        (("assumed", "gain", "unit"), "1/h", "assumed 'gain': expected the unit '1/s'; found '1/h'"),
        (("assumed", "gain"), 2.0, "assumed 'gain': expected value, unit and reason; found 2.0"),
        (("assumed", "colour"), {"value": 1, "unit": "1", "reason": "x"}, "found 'colour'"),
        (("assumed", "rate", "value"), 0, r"rate: expected a number above 0 \[Hz\]; found 0"),
        (("assumed", "feedback", "value"), "luck", "feedback: expected one of exact, truth, estimator; found 'luck'"),
        (("assumed", "duration", "value"), 41.99, "duration: expected whole periods of 0.04 s; found 41.99 s"),
        (("groups", "flow", "strategies"), ["magic"], "group 'flow': expected strategies among .*; found 'magic'"),
        (("groups", "flow", "change"), {"gain": 3}, "group 'flow': expected gain to be changed or varied; found both"),
        (("groups", "flow"), {"title": "x"}, "group 'flow': expected title, strategies, change, vary"),
        (("groups",), {}, "groups: expected at least one; found none"),
    ],
)
def test_a_wrong_plan_is_refused_with_a_sentence(path, value, text) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=text):
        parse_plan(changed(path, value), origin="mine.yaml")


def test_an_unknown_plan_is_refused_with_the_known_ones() -> None:
    with pytest.raises(
        ValueError, match=r"expected a YAML file or one of the known plans \(.*thesis.*\); found neither"
    ):
        load_plan("nothing")


def invented(pitch: dict[tuple[str, str], float], seeds: int = 30) -> Results:
    """Scores that are all alike but for the error of pitch, by (strategy, case)."""
    rng = np.random.default_rng(1)
    scores = {}
    for key, value in pitch.items():
        scores[key] = {name: np.full(seeds, 0.05) + 1e-4 * rng.standard_normal(seeds) for name in SCORES}
        scores[key]["pitch"] = value * (1.0 + 0.01 * rng.standard_normal(seeds))
        scores[key]["lost"] = np.zeros(seeds)
    return Results(scores=scores)


def claim(study: Results, key: str):  # type: ignore[no-untyped-def]
    return next(j for j in judged(study, PLAN.all_cases) if j.claim.key == key)


def test_a_claim_depends_on_what_differs_between_neighbouring_cases_of_different_verdicts() -> None:
    pitch = {}
    for case in PLAN.cases(PLAN.groups[1]):
        better = 0.05 if case.assumptions.feedback == "truth" else 0.15
        pitch |= {("lookup", case.name): 0.1, ("simplified", case.name): better}
    found = claim(invented(pitch), "6")
    assert (found.verdict, found.depends) == ("depends", ("feedback",))
    assert found.share(PLAN.all_cases, "flow") == (3, 6)


def test_claims_follow_the_scores_and_what_was_not_run_is_not_tested() -> None:
    case = PLAN.typical(PLAN.groups[1]).name
    errors = {"lookup": 0.3, "simplified": 0.4, "hl-ekf": 0.02, "hl-nlo": 0.03, "hl-kfnlo": 0.03, "hq-ekf": 0.01,
              "hq-nlo": 0.02, "hq-kfnlo": 0.025}  # fmt: skip
    study = invented({(s, case): x for s, x in errors.items()})
    verdicts = {j.claim.key: j.verdict for j in judged(study, PLAN.all_cases)}
    assert verdicts == {
        "1": "not tested", "2a": "not tested", "2b": "confirmed", "3a": "confirmed", "3b": "confirmed",
        "4": "confirmed", "5": "confirmed", "6": "not confirmed", "7": "not confirmed", "8a": "confirmed",
        "8b": "confirmed",
    }  # fmt: skip
    study.scores["hq-ekf", case]["v_largest"][3] = 1.5
    assert claim(study, "8a").verdict == "in part"


def test_a_halved_error_confirms_the_first_claim_and_one_that_is_lower_by_a_tenth_does_so_in_part() -> None:
    case = PLAN.typical(PLAN.groups[0]).name
    study = invented({("lookup", case): 0.2, ("dead-zone", case): 0.1})
    study.scores["lookup", case]["pitch_rate"][:] = 0.1
    assert claim(study, "1").verdict == "confirmed"
    study.scores["dead-zone", case]["pitch"][:] = 0.19
    study.scores["dead-zone", case]["pitch_rate"][:] = 0.09
    assert claim(study, "1").verdict == "in part"
    study.scores["dead-zone", case]["pitch"][:] = 0.3
    assert claim(study, "1").verdict == "not confirmed"


def test_tables_name_every_strategy_and_every_claim() -> None:
    flow = PLAN.groups[1]
    case = PLAN.typical(flow).name
    study = invented({(s, case): 0.05 for s in flow.strategies})
    told = error_table(study, case)
    assert all(f"`{s}`" in told for s in flow.strategies)
    judgements = judged(study, PLAN.all_cases)
    assert all(f"| {c.key} |" in claim_table(judgements, PLAN, PLAN.all_cases) for c in CLAIMS)
    assert "- **5** " in finding_lines(judgements, case)
    assert case_table(study, PLAN, flow).count("\n") == 2
    assert "K_P = gain I" in assumption_table(replace(PLAN))
