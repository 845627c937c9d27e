"""Programmes for the next experiment keep to the rig's limits."""

import numpy as np
import pytest

from gap_diagnosis.experiment_inputs import KINDS, Limits, programmes, within

LIMITS = Limits(largest=2.0, rate=10.0, duration=12.0, dead_zone=(-0.8, 0.9))


@pytest.mark.parametrize("rate", [3.0, 10.0, 1000.0])
def test_no_programme_exceeds_the_largest_throttle_or_the_rate_and_all_begin_and_end_at_rest(rate):
    limits = Limits(largest=2.0, rate=rate, duration=12.0, dead_zone=(-0.8, 0.9))
    for each in programmes(limits, count=90, seed=3):
        assert each.throttle.shape == (300,)
        assert np.max(np.abs(each.throttle)) <= 2.0
        assert np.max(np.abs(np.diff(each.throttle))) <= rate * 0.04 + 1e-12
        assert not np.any(each.throttle[:25]) and not np.any(each.throttle[-25:])
        assert each.time[-1] == pytest.approx(12.0 - 0.04)


def test_two_hundred_programmes_are_of_all_kinds_and_all_different():
    tried = programmes(LIMITS, count=200, seed=0)
    assert {each.kind for each in tried} == set(KINDS)
    assert len({each.throttle.tobytes() for each in tried}) == 200


def test_the_seed_alone_decides_which_programmes_there_are():
    first, second = (programmes(LIMITS, count=18, seed=5) for _ in range(2))
    other = programmes(LIMITS, count=18, seed=6)
    assert all(np.array_equal(a.throttle, b.throttle) for a, b in zip(first, second, strict=True))
    assert not all(np.array_equal(a.throttle, b.throttle) for a, b in zip(first, other, strict=True))


def test_every_kind_moves_the_throttle_out_of_the_dead_zone():
    for each in programmes(LIMITS, count=len(KINDS), seed=1):
        assert np.max(np.abs(each.throttle)) > 0.9, each.kind


def test_commands_within_the_limits_already_stay_as_they_are():
    throttle = np.zeros(300)
    throttle[100:150] = 0.3
    assert np.array_equal(within(LIMITS, throttle), throttle)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"largest": 0.0}, r"largest throttle \[V\] of the next experiment: expected a positive number, found 0"),
        ({"largest": float("nan")}, r"largest throttle \[V\] .* found nan"),
        ({"duration": 2.0}, r"duration \[s\] of the next experiment: expected 4 to 600, found 2"),
        ({"rate": -1.0}, r"rate \[V/s\] .* found -1"),
    ],
)
def test_a_limit_that_is_none_is_refused_with_what_was_expected(wrong, sentence):
    given = {"largest": 2.0, "rate": 10.0, "duration": 12.0} | wrong
    with pytest.raises(ValueError, match=sentence):
        Limits(**given)
