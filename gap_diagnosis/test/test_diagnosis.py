"""Diagnoses of generated recordings: right names, honest silence, and what is written of them."""

import json
import math
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.diagnose_io import with_effect, write_diagnosis
from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.diagnosis_json import as_json, effects_of
from gap_diagnosis.diagnosis_words import in_words
from gap_diagnosis.discrepancy import Discrepancy, Feature
from gap_diagnosis.rules import RULES, Rules
from gap_diagnosis.scoreboard.ablation import _afresh, _changed, judged_anew, rows_of
from gap_diagnosis.scoreboard.answers import Answer
from gap_diagnosis.verdict import VERDICTS, verdict_of
from thruster_model.effects.active import ActiveEffects
from thruster_model.parameter_set_io import load_parameter_set


def content(found):
    return as_json(found, runs=["a"], parameter_set="hl", version="0", seed=0)


@pytest.fixture(scope="module")
def coulomb():
    stated, recordings = campaign({"coulomb_friction": {"deceleration": 200.0}}, seed=3)
    return diagnose(recordings, stated)


def test_an_effect_is_named_with_its_size_and_shrink(coulomb):
    (claim,) = coulomb.verdict.claims
    assert (coulomb.verdict.verdict, claim.effect, claim.kind) == ("effect", "coulomb_friction", "structural")
    size = claim.sizes["deceleration"]
    assert abs(size.value - 200.0) < 3.0 * size.std < 60.0
    assert coulomb.shrink.value > 0.9
    assert coulomb.where[0][0] == "rotor"


def test_a_load_cell_s_own_clock_is_no_gap_where_the_runs_say_how_far_it_may_be_off():
    stated, recordings = campaign(load_late=(0.06, -0.045, 0.05), clock_deviations={"load": 0.05})
    assert diagnose(recordings, stated).verdict.verdict == "parameters"  # unknown, if nothing is said


def test_what_explains_less_than_the_nameless_rest_only_resembles(coulomb):
    found = coulomb.investigation
    gained = found.gained["coulomb_friction"]
    for rest, resembles in ((0.5 * gained, False), (2.0 * gained, True)):
        feature = Feature("speed", "n", 2.0 * rest)
        left = replace(found, unexplained=Discrepancy((feature,), rest, np.zeros(found.none.system.known.size)))
        assert ("coulomb_friction" in left.resembling) is resembles
        verdict = verdict_of(left, ())
        assert verdict.verdict == "unknown"  # a third of the gap and more has no name
        words = in_words(replace(coulomb, investigation=left, verdict=verdict))
        assert ("Not claimed: coulomb_friction explains less than is left." in words) is resembles
    assert left.named_share == pytest.approx(1.0 / 3.0, abs=0.05) and found.named_share > 0.99


def test_a_doubted_effect_is_unknown_where_parameters_leave_something_without_a_name_else_nothing_can_be_told(coulomb):
    found, plain = replace(coulomb.investigation), replace(coulomb.investigation)
    for each in (found, plain):
        each.__dict__["helps"] = {"coulomb_friction": 0.1}
    assert coulomb.investigation.unnamed < 6.0 < found.unnamed
    assert verdict_of(found, ()).verdict == "unknown"
    plain.__dict__["unnamed"] = 0.0
    verdict = verdict_of(plain, ())
    assert (verdict.verdict, verdict.reason, verdict.claims) == ("cannot_tell", "several", ())
    words = in_words(replace(coulomb, investigation=plain, verdict=verdict))
    assert "Not claimed: coulomb_friction makes runs that were left out less probable." in words


def test_how_probable_something_nameless_is_follows_from_its_evidence_and_from_what_is_named(coulomb):
    found = coulomb.investigation
    gained = found.gained["coulomb_friction"]

    def unknown(evidence, gain):
        left = Discrepancy((Feature("speed", "n", gain),), evidence, np.zeros(found.none.system.known.size))
        return verdict_of(replace(found, unexplained=left), ()).unknown

    # 6 nats are what the best of 400 functions has by chance; by hand, odds of e^(6 / 1.5) either way
    assert unknown(6.0, gained) == pytest.approx(0.5)
    assert unknown(12.0, gained) == pytest.approx(1.0 - unknown(0.0, gained)) == pytest.approx(0.982, abs=1e-3)
    # a twentieth of the gap belongs to what has a name
    assert unknown(40.0, 0.1 * gained) == pytest.approx(0.05, abs=0.01)


def test_the_four_numbers_fall_from_stated_to_noise(coulomb):
    total = coulomb.errors.total
    assert total.as_is > total.retuned > total.with_effect
    assert total.with_effect == pytest.approx(total.noise_floor, abs=0.05)


def test_the_json_is_plain_and_its_budget_adds_up(coulomb):
    written = content(coulomb)
    assert json.loads(json.dumps(written, allow_nan=False)) == written
    assert written["verdict"] in VERDICTS
    budget = written["budget"]
    total = budget["parameters"]["share"] + budget["unexplained"]["share"] + sum(c["share"] for c in budget["causes"])
    assert total == pytest.approx(1.0, abs=1e-9)
    assert [step["step"] for step in budget["left_out"]] == ["as_is", "retuned", "coulomb_friction"]
    channels = written["gap"]["channels"]
    for step, kind in zip(budget["left_out"], ("as_is", "retuned", "with_effect"), strict=True):
        assert step["channels"] == pytest.approx({name: each[kind] for name, each in channels.items()})
    disturbed, noise = budget["floors"]
    assert (disturbed["step"], noise["step"]) == ("disturbance", "noise")
    assert noise["channels"] == pytest.approx({name: each["noise_floor"] for name, each in channels.items()})
    assert budget["left_out"][0]["rms"] > disturbed["rms"] > noise["rms"] == pytest.approx(1.0)
    assert 0.0 < budget["gap"]["disturbance_share"] < 0.1
    assert budget["nameless"]["share"] == budget["unexplained"]["share"]
    assert set(budget["nameless"]["level"]) == {*coulomb.problem.signal_names, "rotor", "axial_flow", "flow"}
    assert budget["unexplained"]["block"] is None
    assert set(budget["process_noise"]) == {"rotor", "axial_flow", "flow", "memory"}
    without = budget["with_causes_without_each_run"]
    if len(coulomb.problem.recordings) < 3:
        assert without is None, "parts were left out, not runs"
    else:
        assert list(without) == [recording.name for recording in coulomb.problem.recordings]
        assert all(each["effects"]["coulomb_friction"]["deceleration"] > 100.0 for each in without.values())
    assert written["p_none"] < 0.01
    assert sum(each["share"] for each in written["where"]) == pytest.approx(1.0)
    effect = written["effects"][0]
    assert {"id", "thruster", "channel", "class", "probability", "parameters", "shrink", "shrink_interval"} <= set(
        effect
    )
    assert "coulomb_friction" in written["summary"]


PAGE = Path(__file__).resolve().parents[2] / "docs" / "diagnosis_json.md"


def described():
    """Return the keys that the page describes, as tuples of their parts."""
    keys = set()
    for line in PAGE.read_text("utf-8").splitlines():
        if line.startswith("| `"):
            first, *others = re.findall(r"`([^`]+)`", line.split(" | ")[0].replace("[]", ""))
            for other in (first, *others):
                parts = other.split(".")  # `.b` after `a` stands beside it
                keys.add((*first.split(".")[: 1 - len(parts)], *parts[1:]) if other[0] == "." else tuple(parts))
    return keys


def written_keys(content, path=()):
    """Yield the keys of a content, as tuples of their parts; what is null or empty ends there."""
    if isinstance(content, list) and content:
        for each in content:
            yield from written_keys(each, path)
    elif isinstance(content, dict) and content:
        for name, each in content.items():
            yield from written_keys(each, (*path, name))
    else:
        yield path, content in (None, [], {})


def test_every_key_is_on_the_page(coulomb):
    keys = described()
    anything = ("resembles", "next_experiment")
    for path, nothing in written_keys(content(coulomb)):
        fitting = [k for k in keys if all(a in ("*", b) for a, b in zip(k, path, strict=False))]
        whole = any(len(k) == len(path) or (nothing and len(k) > len(path)) for k in fitting)
        assert whole or path[0] in anything, ".".join(path)


def test_a_case_is_judged_anew_with_each_rule_changed(coulomb):
    told = {"verdict": coulomb.verdict.verdict, "effects": effects_of(coulomb.verdict)}
    effects = {"coulomb_friction": {"deceleration": 200.0}}
    answer = Answer(
        case="one", generator="lab", kind="one", model="hl", effects=effects, outside={}, distances={}, shares={},
        diagnosis=told, seconds=1.0,
    )  # fmt: skip
    judged = judged_anew(coulomb, answer)
    by_rule = {(each.rule, each.factor): each for each in judged}
    assert len(judged) == len(by_rule) and {each.rule for each in judged} == {each.name for each in fields(Rules)}
    never = by_rule["claimed", math.inf]
    assert never.changed and never.before and not never.right
    assert not by_rule["claimed", 0.8].changed and by_rule["claimed", 0.8].right
    assert Rules() == RULES, "rules are as they were"
    rows = {row[0]: row[1:] for row in rows_of([judged])}
    assert rows["claimed"] == ["0.9", "–", "–", rows["claimed"][3], "1: +0 −1, wrong 0"]


def test_what_is_left_without_a_name_is_asked_anew_where_a_rule_takes_the_doubts_away(coulomb):
    found, rest = coulomb.investigation, 2.0 * coulomb.investigation.gained["coulomb_friction"]
    nameless = Discrepancy((Feature("speed", "n", 2.0 * rest),), rest, np.zeros(found.none.system.known.size))
    left = replace(found, unexplained=nameless)
    assert left.doubts and left.unnamed != pytest.approx(rest)
    with _changed("nameless", math.inf):
        anew = _afresh(left, "nameless")
        assert not anew.doubts and anew.unnamed == rest


def test_the_exported_set_carries_the_effect_and_predicts_as_the_diagnosis_does(coulomb, tmp_path):
    write_diagnosis(coulomb, content(coulomb), tmp_path)
    exported = load_parameter_set(str(tmp_path / "with_effect.yaml"))
    assert exported.effects.sizes["coulomb_friction"]["deceleration"] == pytest.approx(200.0, rel=0.2)
    fitted = coulomb.verdict.chosen.fitted
    assert exported.values["k_n"] == pytest.approx(fitted.problem.values(fitted.x)["k_n"])
    assert with_effect(coulomb).effects.sizes == exported.effects.sizes


def test_effects_that_the_set_has_switched_on_already_are_part_of_the_simulator(coulomb):
    again = diagnose(coulomb.problem.recordings, with_effect(coulomb))
    assert again.verdict.verdict in ("no_gap", "parameters")
    assert again.errors.total.as_is == pytest.approx(1.0, abs=0.05)


def test_retuned_parameters_suffice_where_nothing_but_parameters_is_off():
    stated, recordings = campaign(seed=4)
    found = diagnose(recordings, stated)
    assert found.verdict.verdict == "parameters"
    assert not found.verdict.claims and not content(found)["effects"]
    assert found.retuned is found.investigation.none.fitted  # not as free runs would have it, pushes and all


def test_nothing_is_claimed_where_the_parameters_are_right():
    stated, recordings = campaign(seed=5, spread=0.0)
    found = diagnose(recordings, stated)
    assert not found.verdict.claims and found.verdict.verdict in ("no_gap", "parameters")


@pytest.mark.long
def test_nothing_is_claimed_where_the_parameters_are_right_and_mostly_there_is_no_gap():
    found = [diagnose(recordings, stated) for stated, recordings in (campaign(seed=s, spread=0.0) for s in (5, 15, 25))]
    assert not any(each.verdict.claims for each in found)
    assert [each.verdict.verdict for each in found].count("no_gap") >= 2


@pytest.mark.long
def test_what_is_in_no_library_is_called_unknown():
    stated, recordings = campaign(outside={"drive_resonance": {"share": 0.7, "frequency": 1.0}}, seed=6)
    assert diagnose(recordings, stated).verdict.verdict == "unknown"


def test_two_effects_are_both_named():
    effects = {"tach_lag": {"time": 0.15}, "thrust_asymmetry": {"share": 0.3}}
    stated, recordings = campaign(effects, seed=7, duration=12.0, runs=2)
    found = diagnose(recordings, stated)
    assert {claim.effect for claim in found.verdict.claims} == set(effects)


@pytest.mark.long
def test_an_effect_of_a_thruster_that_is_wired_the_wrong_way_round_is_named_beside_that():
    effects = {"coulomb_friction": {"deceleration": 150.0}, "thruster_polarity": {"reversed": 1.0}}
    stated, recordings = campaign(effects, seed=6, runs=4, duration=20.0)
    assert {claim.effect for claim in diagnose(recordings, stated).verdict.claims} == set(effects)


@pytest.mark.long
def test_a_second_effect_that_only_strains_the_parameters_is_named_too():
    effects = {"entrained_water": {"impulse": 0.004}, "tach_scale": {"share": 0.2}}
    stated, recordings = campaign(effects, seed=4)
    found = diagnose(recordings, stated)
    assert {claim.effect for claim in found.verdict.claims} == set(effects)


@pytest.mark.long
def test_an_effect_beside_air_is_named_too():
    effects = {"ventilation": {"share": 0.4, "onset": 60.0}, "entrained_water": {"impulse": 0.008}}
    stated, recordings = campaign(effects, seed=4)
    found = diagnose(recordings, stated)
    assert {claim.effect for claim in found.verdict.claims} == set(effects)


def test_exact_twins_are_one_group():
    stated, recordings = campaign({"command_delay": {"time": 0.05}}, seed=8, runs=2)
    (claim,) = diagnose(recordings, stated).verdict.claims
    assert {claim.effect, *(name.split(":")[0] for name in claim.alike)} == {"command_delay", "log_alignment"}
    assert abs(next(iter(claim.sizes.values())).value) == pytest.approx(0.05, abs=2e-3)


@pytest.mark.long
def test_without_load_cell_and_flow_meter_the_answer_is_less_certain_not_wrong():
    effects = {"coulomb_friction": {"deceleration": 200.0}}
    stated, recordings = campaign(effects, seed=3, channels=("n",))
    (claim,) = diagnose(recordings, stated).verdict.claims
    assert "coulomb_friction" in (claim.effect, *claim.alike)


@pytest.mark.long
def test_an_effect_that_is_left_out_is_not_named_and_nothing_else_is():
    stated, recordings = campaign({"coulomb_friction": {"deceleration": 300.0}}, seed=3)
    found = diagnose(recordings, stated, excluded=("coulomb_friction",))
    assert found.verdict.verdict == "unknown"
    assert "coulomb_friction" not in found.verdict.probabilities


@pytest.mark.long
def test_a_diagnosis_repeats_itself():
    stated, recordings = campaign({"flow_bias": {"offset": 0.05}}, seed=9, runs=2, duration=8.0)
    first, second = (content(diagnose(recordings, stated, seed=2)) for _ in range(2))
    assert first == second


def test_predictions_are_held_out(coulomb):
    problem = coulomb.problem
    assert set(coulomb.predictions) == {"as_is", "retuned", "with_effect"}
    inside = np.abs(
        problem.measured - coulomb.investigation.none.fitted.problem.predicted(coulomb.investigation.none.fitted.x)
    )
    outside = np.abs(problem.measured - coulomb.predictions["retuned"])
    assert np.nanmean(outside**2) > np.nanmean(inside**2)


def test_a_converter_that_the_set_has_is_no_gap():
    coarse = {"tach_quantization": {"step": 4.0}}
    stated, recordings = campaign(coarse, spread=0.0, runs=2, duration=12.0, channels=("n", "thrust"))
    found = diagnose(recordings, replace(stated, effects=ActiveEffects(sizes=coarse)))
    assert found.verdict.verdict in ("no_gap", "parameters") and not found.verdict.claims


def test_a_size_stands_beside_that_of_the_set(coulomb):
    stated = replace(coulomb.parameter_set, effects=ActiveEffects(sizes={"coulomb_friction": {"deceleration": 12.0}}))
    assert "(in the set: 12 " in in_words(replace(coulomb, parameter_set=stated))


@pytest.mark.long
def test_a_coarse_tachometer_is_no_friction():
    stated, recordings = campaign({"tach_quantization": {"step": 12.4}}, seed=10)
    claims = diagnose(recordings, stated).verdict.claims
    assert [claim.effect for claim in claims] == ["tach_quantization"]


@pytest.mark.long
def test_an_effect_that_a_first_fit_left_in_another_valley_is_not_named_as_a_pair():
    mode = {"load_cell_resonance": {"frequency": 29.0, "damping": 0.23}}
    read = ("n", "thrust", "torque")
    stated, recordings = campaign(mode, model="simplified", seed=6, runs=4, duration=30.0, channels=read)
    found = diagnose(recordings, stated)
    assert found.investigation.best.keys == ("load_cell_resonance",)
    assert found.verdict.verdict in ("effect", "cannot_tell")  # water that is carried along looks alike at 29 Hz


@pytest.mark.parametrize(
    ("late", "named"), [pytest.param(0.0012, [], marks=pytest.mark.long), (0.02, ["log_alignment"])]
)
def test_what_simulators_disagree_about_within_a_step_is_no_effect(late, named):
    stated, recordings = campaign(seed=3)
    shifted = []
    for recording in recordings:
        measurements = {
            name: replace(m, time=m.time + (late if name == "speed" else 0.0))
            for name, m in recording.experiment.measurements.items()
        }
        shifted.append(replace(recording, experiment=replace(recording.experiment, measurements=measurements)))
    assert [claim.effect for claim in diagnose(shifted, stated).verdict.claims] == named
