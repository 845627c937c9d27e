"""What cases are drawn, and from what."""

from collections import Counter

import numpy as np
import pytest

from gap_diagnosis.blind_check.cases import KINDS, draw, plan, recordings
from gap_diagnosis.blind_check.catalogue import EFFECTS, OUTSIDE
from thruster_model.parameter_set_io import load_parameter_set

NOMINAL = {model: dict(load_parameter_set(model).values) for model in ("hl", "hq", "simplified")}


def drawn(count, seed=3, **choice):
    return [draw(each, seed, NOMINAL) for each in plan(count, seed, **choice)]


def test_a_case_depends_on_seed_index_and_kind_alone():
    alone = draw(plan(40, 3)[-1], 3, NOMINAL)
    assert alone.described() == drawn(40)[-1].described()
    assert alone.described() != draw(plan(40, 3)[-1], 4, NOMINAL).described()


def test_every_effect_has_twenty_cases_among_twenty_times_as_many_as_effects():
    counts = Counter(name for case in drawn(20 * len(EFFECTS), kinds=["effect"]) for name in case.effects)
    assert set(counts) == set(EFFECTS) and set(counts.values()) == {20}


def test_a_mixed_check_has_all_kinds_in_their_shares_from_early_on():
    counts = Counter(each.kind for each in plan(100, 1))
    assert all(abs(counts[kind] - 100.0 * share) <= 1.0 for kind, share in KINDS.items())


def test_only_a_case_of_kind_none_has_the_nominal_parameters():
    for case in drawn(200):
        off = np.array([factor - 1.0 for factor in case.factors.values()])
        assert "u_dot_max" not in case.factors
        assert np.all(off == 0.0) if case.plan.kind == "none" else np.std(off) > 0.01 and np.max(np.abs(off)) <= 0.125


def test_sizes_lie_within_the_plausible_range_and_take_both_signs_where_both_count():
    signs = {}
    for case in drawn(20 * len(EFFECTS), kinds=["effect"]):
        ((name, sizes),) = case.effects.items()
        size, value = EFFECTS[name].size, next(iter(sizes.values()))
        largest = size.upper if value > 0 else size.most_negative or size.upper
        assert 0.0 < abs(value) <= largest * (1 + 1e-12) and abs(value) >= largest * size.lower / size.upper * (
            1 - 1e-12
        )
        signs.setdefault(name, set()).add(np.sign(value))
    assert all(signs[name] == ({-1.0, 1.0} if kind.size.signed else {1.0}) for name, kind in EFFECTS.items())


def test_a_sweep_goes_down_to_a_hundredth_of_the_plausible_maximum():
    sizes = [case.effects["tach_lag"]["time"] for case in drawn(200, kinds=["sweep"], effects=["tach_lag"])]
    assert 0.004 <= min(sizes) < 0.006 and 0.3 < max(sizes) <= 0.4


def test_no_effect_is_drawn_for_a_model_that_does_not_feel_it():
    for case in drawn(600):
        for name in (*case.effects, *case.outside):
            assert case.model not in {**EFFECTS, **OUTSIDE}[name].inert_in


def test_an_effect_with_an_exact_twin_is_never_left_out():
    left_out = drawn(100, kinds=["left_out"])
    assert all(case.excluded == tuple(case.effects) for case in left_out)
    assert not any(EFFECTS[name].twins for case in left_out for name in case.excluded)


def test_a_pair_is_two_effects_that_are_not_twins():
    for case in drawn(150, kinds=["pair"]):
        first, second = case.effects
        assert first != second and second not in EFFECTS[first].twins


def test_poor_excitation_is_constant_or_gentle_or_stays_low():
    for case in drawn(20, kinds=["poor"]):
        for run in recordings(case, NOMINAL):
            throttle = run.recorded["throttle"].values
            changes = np.count_nonzero(np.abs(np.diff(throttle)) > 1e-12)
            assert changes <= 1 or np.max(np.abs(throttle)) <= 1.2 + 1e-9


def test_the_standard_campaign_is_four_runs_of_thirty_seconds_within_its_range_resting_at_both_ends():
    (case,) = drawn(1, kinds=["none"])
    runs = recordings(case, NOMINAL)
    assert [run.name for run in runs] == ["steps", "multisine", "ramps", "constant"]
    for run in runs:
        throttle = run.recorded["throttle"].values
        assert throttle.size == 750 and np.max(np.abs(throttle)) <= 3.5 + 1e-9
        assert not np.any(throttle[:25]) and not np.any(throttle[-25:])


def test_unknown_choices_are_refused_with_what_is_known():
    with pytest.raises(ValueError, match="kind: expected effect, none"):
        plan(1, 1, kinds=["other"])
    with pytest.raises(ValueError, match="effect: expected log_alignment"):
        plan(1, 1, effects=["gremlins"])
