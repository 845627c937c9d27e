"""Scores of cases made by hand."""

import numpy as np
import pytest

from gap_diagnosis.blind_check.docs_io import page, write_page
from gap_diagnosis.blind_check.judging import accepts, block_right, is_named, right, size_of, wrong_names
from gap_diagnosis.blind_check.opened import Opened
from gap_diagnosis.blind_check.opened_io import read_opened, write_opened
from gap_diagnosis.blind_check.scoring import score
from gap_diagnosis.blind_check.shrink import actual_shrink
from gap_diagnosis.blind_check.statistics import Share, calibration_error, detection_limit


def key(kind="effect", effects=None, outside=None, excitation="rich", case="case_00000"):
    return {
        "case": case,
        "seed": 1,
        "kind": kind,
        "effects": effects or {},
        "outside": outside or {},
        "excitation": excitation,
    }


def claim(name, probability=0.95, group=(), **more):
    return {"id": name, "probability": probability, "indistinguishable_from": list(group), **more}


def said(*claimed, verdict=None, block=None, candidates=None, p_none=0.0, p_unknown=0.0):
    listed = candidates or {entry["id"]: entry["probability"] for entry in claimed}
    return {
        "verdict": verdict or ("effect" if claimed else "no_gap"),
        "effects": list(claimed),
        "where": [{"block": block, "share": 0.9}, {"block": "other", "share": 0.1}] if block else [],
        "candidates": [{"id": name, "probability": p} for name, p in listed.items()],
        "p_none": p_none,
        "p_unknown": p_unknown,
    }


LAG = {"tach_lag": {"time": 0.1}}


# ---- one case


def test_an_effect_is_right_alone_and_in_a_group_and_wrong_beside_it():
    assert right(key(effects=LAG), said(claim("tach_lag")))
    assert right(key(effects=LAG), said(claim("rotor_inertia", group=["tach_lag"])))
    assert not right(key(effects=LAG), said(claim("rotor_inertia")))
    assert not right(key(effects=LAG), said(verdict="no_gap"))
    assert not right(key(effects=LAG), said(claim("tach_lag"), claim("flow_bias", 0.6)))


def test_an_exact_twin_is_right_on_its_channel_alone():
    late = key(effects={"log_alignment": {"throttle": 0.08}})
    assert is_named(late, "log_alignment", said(claim("command_delay")))
    assert not is_named(late, "log_alignment", said(claim("flow_delay")))
    assert not is_named(late, "log_alignment", said(claim("log_alignment", channel="flow")))
    delayed = key(effects={"command_delay": {"time": 0.1}})
    shifted = {"throttle": {"value": 0.1, "std": 0.001}, "speed": {"value": 0.0, "std": 0.001}}
    assert is_named(delayed, "command_delay", said(claim("log_alignment", parameters=shifted)))
    assert not is_named(delayed, "command_delay", said(claim("log_alignment", channel="thruster_0/state.n")))


def test_without_an_effect_no_gap_and_parameters_are_right_and_nothing_else():
    verdicts = {v: right(key("nuisance"), said(verdict=v)) for v in ("no_gap", "parameters", "unknown", "cannot_tell")}
    assert verdicts == {"no_gap": True, "parameters": True, "unknown": False, "cannot_tell": False}
    assert not right(key("none"), said(claim("tach_lag", 0.4)))


def test_a_foreign_effect_is_right_as_unknown_or_in_its_block_without_a_confident_name():
    foreign = key("outside", outside={"wake_stall": {"share": 0.5}})
    assert right(foreign, said(verdict="unknown"))
    assert right(foreign, said(claim("cavitation", 0.7), block="thrust map"))
    assert not right(foreign, said(claim("cavitation", 0.9), block="thrust map"))
    assert not right(foreign, said(claim("cavitation", 0.7), block="rotor"))
    assert not right(foreign, said(verdict="no_gap"))


def test_poor_data_may_be_called_so():
    assert right(key("poor", effects=LAG, excitation="constant"), said(verdict="not_enough_data"))
    assert not right(key("effect", effects=LAG), said(verdict="not_enough_data"))


def test_the_size_of_an_effect_does_not_depend_on_the_order_of_its_parameters():
    hidden = key(effects={"tank_recirculation": {"delay": 7.0, "share": 0.4}})
    assert size_of(hidden, "tank_recirculation") == 0.4
    assert size_of(key(effects={"log_alignment": {"load": -0.1}}), "log_alignment") == -0.1


def test_only_confident_names_that_no_group_excuses_are_wrong_names():
    found = said(claim("flow_bias", 0.9), claim("cavitation", 0.7), claim("rotor_inertia", 0.95, group=["tach_lag"]))
    assert wrong_names(key(effects=LAG), found) == ["flow_bias"]


def test_twins_share_a_block_and_words_after_the_first_do_not_count():
    late = key(effects={"log_alignment": {"throttle": 0.08}})
    assert block_right(late, said(block="command")) and block_right(late, said(block="log"))
    assert not block_right(late, said(block="sensor"))
    assert block_right(key(effects=LAG), said(block="sensor: thruster_0/state.n"))


# ---- statistics


def test_wilsons_interval_is_the_textbooks():
    assert Share(8, 10).interval == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert Share(0, 100).interval == pytest.approx((0.0, 0.0370), abs=1e-4)


def test_a_detection_limit_is_found_where_nine_in_ten_are_found():
    rng = np.random.default_rng(1)
    sizes = np.exp(rng.uniform(np.log(0.01), np.log(1.0), 4000)) * rng.choice([-1, 1], 4000)
    chance = 1.0 / (1.0 + np.exp(-4.0 * np.log(np.abs(sizes) / 0.1)))
    limit = detection_limit(sizes, rng.random(4000) < chance, rng)
    expected = 0.1 * np.exp(np.log(9.0) / 4.0)
    assert limit.value == pytest.approx(expected, rel=0.1)
    assert limit.interval[0] < expected < limit.interval[1]


def test_a_limit_beyond_all_sizes_says_so():
    rng, sizes = np.random.default_rng(1), np.geomspace(0.1, 1.0, 20)
    assert detection_limit(sizes, np.ones(20), rng).value == 0.0
    assert detection_limit(sizes, np.zeros(20), rng).value == np.inf
    assert detection_limit(sizes, np.ones(20), rng, falls=True).value == np.inf


def test_a_limit_of_an_effect_that_grows_as_its_size_falls_is_met_from_below():
    rng, sizes = np.random.default_rng(1), np.geomspace(1.0, 30.0, 60)
    assert 8.0 < detection_limit(sizes, sizes < 10.0, rng, falls=True).value < 12.0


def test_calibration_errors_are_weighted_by_how_many_said_so():
    error, bins = calibration_error([0.95] * 8 + [0.55] * 2, [True] * 8 + [True, False])
    assert error == pytest.approx(0.8 * 0.05 + 0.2 * 0.05)
    assert [entry["count"] for entry in bins] == [2, 8]


def test_a_model_with_a_tenth_of_the_error_shrinks_the_gap_by_a_hundredth_short_of_all():
    truth = np.zeros(100)
    before, after = ({"a": {"n": np.full(100, size)}} for size in (12.0, 1.2))
    assert actual_shrink({"a": {"n": truth, "thrust": truth}}, before, after) == pytest.approx(0.99)
    assert actual_shrink({"a": {"n": truth}}, {}, {}) is None


# ---- all figures


def example():
    cases = []
    for i, size in enumerate(np.geomspace(0.06, 0.9, 30)):
        found, name = size > 0.1, f"case_{i:05d}"
        parameters = {"time": {"value": 1.02 * size, "std": 0.02 * size, "unit": "s"}}
        diagnosis = (
            said(claim("tach_lag", 0.95, parameters=parameters, shrink=0.9), block="sensor") if found else said()
        )
        if found:
            truth = {"steps": {"n": np.zeros(10)}}
            kept = {"retuned": {"steps": {"n": [10.0] * 10}}, "with_effect": {"steps": {"n": [1.0] * 10}}}
            diagnosis |= {"predictions": kept}
        else:
            truth, diagnosis = {}, diagnosis | {"p_none": 0.95}
        hidden = key(effects={"tach_lag": {"time": float(size)}}, case=name)
        cases.append(Opened.of(hidden, diagnosis, truth))
    for i in range(20):
        diagnosis = said(claim("flow_bias", 0.85)) if i == 0 else said(p_none=0.95)
        cases.append(Opened(key=key("none", case=f"case_1{i:04d}"), diagnosis=diagnosis))
    both = {**LAG, "flow_bias": {"offset": 0.1}}
    cases.append(Opened(key=key("pair", effects=both), diagnosis=said(claim("tach_lag"), claim("flow_bias"))))
    cases.append(Opened(key=key("pair", effects=both), diagnosis=said(claim("tach_lag"))))
    return cases


def test_figures_of_a_check_made_by_hand():
    scores = score(example(), np.random.default_rng(0))
    assert scores.limits["tach_lag"].value == pytest.approx(0.1, rel=0.3)
    above = scores.shares["right verdict, above the limit"]
    assert above.of > 40 and above.hits >= above.of - 2
    assert scores.shares["effect claimed where there is none"] == Share(1, 20)
    assert scores.shares["both effects of a pair named"] == Share(1, 2)
    assert scores.shares["90 % intervals of sizes cover"].value == 1.0
    assert scores.numbers["median size error"] == pytest.approx(0.02)
    assert scores.numbers["median difference of stated and actual shrink"] == pytest.approx(0.09)
    assert scores.wrong == [("case_10000", "", "flow_bias")]
    assert scores.confusion["none", "flow_bias"] == 1 and scores.confusion["none", "no_gap"] == 19
    assert scores.numbers["log score of base rates"] < 0.0


def test_opened_cases_give_the_same_figures_from_a_file(tmp_path):
    cases, file = example(), tmp_path / "opened.jsonl.gz"
    write_opened(cases, file)
    assert read_opened(file) == cases
    assert score(read_opened(file), np.random.default_rng(0)) == score(cases, np.random.default_rng(0))


def test_a_case_does_not_decide_about_the_limit_that_it_is_held_against():
    rng, rates = np.random.default_rng(0), []
    for _ in range(100):
        cases = []
        for i, size in enumerate(np.geomspace(0.06, 0.4, 3)):
            diagnosis = said(claim("tach_lag")) if rng.random() < 0.6 else said(p_none=0.9)
            cases.append(Opened(key=key(effects={"tach_lag": {"time": float(size)}}, case=str(i)), diagnosis=diagnosis))
        rates.append(score(cases, rng).shares["right verdict, above the limit"])
    hits, of = sum(r.hits for r in rates), sum(r.of for r in rates)
    assert of > 50 and 0.4 < hits / of < 0.8, "found at random, blind to size"


def test_sizes_above_the_targets_are_scored_by_themselves():
    cases = [
        Opened(key=key(effects={"tach_lag": {"time": size}}, case=str(size)), diagnosis=said(p_none=0.9))
        for size in (0.01, 0.04, 0.2)
    ]
    assert score(cases, np.random.default_rng(0)).shares["right verdict, above the target of the limit"] == Share(0, 2)


def test_late_stamps_are_probable_by_their_channel():
    late = key(effects={"log_alignment": {"speed": 0.05}})
    assert accepts(late, "log_alignment:speed") and not accepts(late, "log_alignment:load")
    assert not accepts(late, "none") and not accepts(late, "command_delay")
    assert accepts(key(effects={"command_delay": {"time": 0.05}}), "log_alignment:throttle")
    assert accepts(key("none"), "none") and accepts(key("outside", outside={"wake_stall": {"share": 0.5}}), "unknown")
    assert accepts(key("left_out", effects={"thrust_loss": {"share": 0.5}}), "none"), "parameters imitate it"
    given = said(claim("log_alignment", 0.97), candidates={"log_alignment:speed": 0.97}, p_none=0.03)
    scores = score([Opened(key=late, diagnosis=given)], np.random.default_rng(0))
    assert scores.numbers["log score"] == pytest.approx(np.log(0.97))
    assert scores.numbers["calibration error"] == pytest.approx(0.03)


def test_look_alikes_count_on_their_channel_alone_and_by_the_probability_of_their_group():
    late = key(effects={"log_alignment": {"speed": 0.05}})
    assert right(late, said(claim("tach_lag", group=["log_alignment:speed"])))
    assert not right(late, said(claim("tach_lag", group=["log_alignment:load"])))
    assert wrong_names(key("none"), said(claim("tach_lag", 0.6, group=["rotor_inertia"], group_probability=0.99)))


def test_no_cases_give_no_figures_and_no_error():
    scores = score([], np.random.default_rng(0))
    assert all(found.of == 0 for found in scores.shares.values()) and "| – |" in page(scores, "none")


def test_the_page_shows_each_figure_beside_its_target_and_its_pictures(tmp_path):
    scores = score(example(), np.random.default_rng(0))
    files = write_page(scores, tmp_path / "blind_check.md", "46 cases.")
    text = files[0].read_text()
    assert "| effect claimed where there is none | 5.0 % (0.9–23.6; 1 of 20) | ≤ 3 % |" in text
    assert "`tach_lag`" in text and "case_10000" in text
    for file in files[1:]:
        assert file.name in text and file.read_text().lstrip().startswith("<?xml")
    assert {file.stem.split("_")[-1] for file in files[1:]} == {"confusion", "reliability", "sizes", "shrink", "limits"}
