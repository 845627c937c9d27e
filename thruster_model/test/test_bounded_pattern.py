"""Patterns of strangers: those in use are taken, those that would take minutes are refused before any is matched."""

import warnings

import pytest

from thruster_model.bounded_pattern import LONGEST_NAME, MOST_WAYS, bounded, ways


@pytest.mark.parametrize(
    ("text", "counted"),
    [
        ("12 V", 1), ("[0-9]+ V", 31), (".*", 32), ("([0-9.]+) ?V", 31 * 2), ("a{2,4}", 3), ("a?", 2),
        ("10 V|12 V|14 V|16 V", 4), ("a{40}", 1), ("(a|bc)(d|ef)", 4), ("(a|bc){2}", 4), ("(a|bc)?", 3), ("(ab)*", 32),
        ("(?=a+)b", 31), ("a*?b*", 32 * 32), ("(a)?(?(1)b+|c)", 2 * 32), (r"(.)\1", 1), (r"^\d+ V$", 31),
    ],
)  # fmt: skip
def test_ways_are_counted_as_by_hand(text, counted):
    assert ways(text) == counted
    assert bounded(text).pattern == text


@pytest.mark.parametrize(
    "text",
    [
        "(a+)+b",
        "(a*)*",
        "((a|a))*b",
        "(a|aa)+$",
        "(.*)(.*)(.*)(.*)(.*)x",
        "(a|a)" * 25 + "b",
        "(" * 40 + "a" + "*)" * 40,
    ],
)
def test_what_may_take_minutes_is_refused(text):
    assert ways(text) == MOST_WAYS + 1
    with pytest.raises(ValueError, match="may take minutes"):
        bounded(text)


def test_the_worst_that_is_taken_ends():
    assert ways("(.*)(.*)(.*)(.*)x") == 32**4 <= MOST_WAYS
    assert bounded("(.*)(.*)(.*)(.*)x").search("a" * LONGEST_NAME) is None


@pytest.mark.parametrize(
    ("text", "sentence"),
    [("[", "unterminated"), ("a" * 201, "longer than 200"), ("[[a]", "nested set"), ("a{99999999999}", "repetition")],
)
def test_what_is_none_or_ambiguous_is_refused_and_not_warned_of(text, sentence):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match=sentence):
            bounded(text)
