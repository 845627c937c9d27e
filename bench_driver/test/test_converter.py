"""Codes of the converters: by hand, exact where the documentation says so."""

import pytest

from bench_driver.converter import (
    CODE_STEP,
    LARGEST_CODE,
    ZERO_CODE,
    code_from_count,
    code_from_millivolts,
    code_volts,
    millivolts,
)
from bench_driver.errors import OutOfRange, ThrottleRefused
from bench_driver.text_protocol import throttle_volts


def test_the_ends_and_the_middle_of_the_converter_are_5_0_and_minus_5_volts() -> None:
    assert (code_volts(0), code_volts(ZERO_CODE), code_volts(LARGEST_CODE)) == (5.0, 0.0, -5.0)


def test_every_count_of_the_text_protocol_is_set_exactly() -> None:
    for count in range(256):
        assert code_volts(code_from_count(count)) == pytest.approx(throttle_volts(count), abs=1e-12)


def test_zero_millivolts_is_exactly_zero() -> None:
    assert code_volts(code_from_millivolts(millivolts(0.0, limit=3.0))) == 0.0


@pytest.mark.parametrize(("u", "code"), [(5000, 0), (-5000, 4080), (1500, 1428), (1, 2040), (2, 2039), (-2, 2041)])
def test_millivolts_have_the_code_computed_by_hand(u: int, code: int) -> None:
    assert code_from_millivolts(u) == code


def test_every_throttle_is_set_to_within_half_a_step() -> None:
    assert all(abs(code_volts(code_from_millivolts(u)) - u / 1000) <= CODE_STEP / 2 + 1e-9 for u in range(-5000, 5001))


def test_throttles_are_rounded_to_the_nearest_millivolt() -> None:
    assert [millivolts(u, limit=3.0) for u in (1.2344, 1.2346, -1.2346, 3.0)] == [1234, 1235, -1235, 3000]


@pytest.mark.parametrize("u", [3.001, -3.001, float("nan"), float("inf")])
def test_a_throttle_beyond_the_limit_is_refused(u: float) -> None:
    with pytest.raises(ThrottleRefused, match=r"expected a magnitude of at most 3\.0 V"):
        millivolts(u, limit=3.0)


def test_numbers_without_a_code_are_refused() -> None:
    for call in (
        lambda: code_volts(4081),
        lambda: code_from_count(256),
        lambda: code_from_millivolts(5001),
        lambda: millivolts(0.0, limit=6.0),
    ):
        with pytest.raises(OutOfRange, match="expected"):
            call()
