"""The rig's text protocol: counts by hand, streams in any pieces, garbage."""

import math
import pickle
import random
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench_driver.errors import BenchDriverError, OutOfRange, ThrottleRefused
from bench_driver.text_protocol import (
    END,
    THROTTLE_STEP,
    ZERO_COUNT,
    CommandDecoder,
    LineDecoder,
    Reading,
    count_from_flow,
    count_from_speed,
    encode_reading,
    encode_throttle,
    flow_from_count,
    speed_from_count,
    throttle_count,
    throttle_volts,
)

SPEED_STEP = 0.2440053710937  # 49.9723·5/1024 rad/s, by hand
FLOW_STEP = 0.0005859375  # 0.12·5/1024 m/s, by hand
NEW_BYTES = b"0123456789,-+ .\r\n\x00\xff"


@pytest.mark.parametrize(("u", "count"), [(0.0, 128), (-0.0, 128), (3.0, 51), (-3.0, 204), (1.0, 102), (-1.0, 153)])
def test_a_throttle_has_the_count_computed_by_hand(u: float, count: int) -> None:
    assert throttle_count(u) == count
    assert encode_throttle(u) == str(count).encode() + b"\n"


def test_zero_throttle_is_128_which_is_half_a_step_backwards() -> None:
    assert throttle_count(0.0) == ZERO_COUNT == 128
    assert throttle_volts(128) == pytest.approx(-5 / 255, abs=1e-12)


def test_halves_go_up_also_where_the_even_neighbour_is_below() -> None:
    assert throttle_count(5 - 126.5 / 25.5) == 127  # round() would give 126


def test_count_0_is_5_volts_forward_and_255_is_5_volts_backwards() -> None:
    assert throttle_volts(0) == 5.0
    assert throttle_volts(255) == pytest.approx(-5.0)
    assert (throttle_count(5.0, limit=5.0), throttle_count(-5.0, limit=5.0)) == (0, 255)


def test_the_end_is_no_throttle() -> None:
    assert END == b"-99\n"


def test_counts_of_the_sensors_have_the_values_computed_by_hand() -> None:
    assert speed_from_count(0) == 0.0
    assert speed_from_count(1000) == pytest.approx(1000 * SPEED_STEP)
    assert flow_from_count(0) == 0.3
    assert flow_from_count(512) == pytest.approx(0.0, abs=1e-12)
    assert flow_from_count(1023) == pytest.approx(-0.2994140625)


def test_every_count_of_the_throttle_survives_the_way_there_and_back() -> None:
    assert [throttle_count(throttle_volts(count), limit=5.0) for count in range(256)] == list(range(256))


def test_every_count_of_a_sensor_survives_the_way_there_and_back() -> None:
    for count in range(1024):
        assert count_from_speed(speed_from_count(count)) == count_from_speed(-speed_from_count(count)) == count
        assert count_from_flow(flow_from_count(count)) == count


@given(st.floats(-3, 3))
def test_the_throttle_sent_is_at_most_half_a_step_off_and_within_the_limit(u: float) -> None:
    sent = throttle_volts(throttle_count(u))
    assert abs(sent - u) <= THROTTLE_STEP / 2 + 1e-12
    assert abs(sent) <= 3 + 1e-12


@given(n=st.floats(-249.6, 249.6), U=st.floats(-0.2994, 0.3))
def test_an_emulated_sensor_is_at_most_half_a_step_off(n: float, U: float) -> None:
    assert abs(speed_from_count(count_from_speed(n)) - abs(n)) <= SPEED_STEP / 2 + 1e-9
    assert abs(flow_from_count(count_from_flow(U)) - U) <= FLOW_STEP / 2 + 1e-12


def test_an_emulated_sensor_saturates() -> None:
    assert count_from_speed(1e9) == count_from_speed(-math.inf) == 1023
    assert (count_from_flow(1.0), count_from_flow(-1.0)) == (0, 1023)


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda: throttle_count(3.001), ThrottleRefused, "throttle 3.001 V: expected a magnitude of at most 3.0 V"),
        (lambda: encode_throttle(-4.5, limit=4.0), ThrottleRefused, "throttle -4.5 V: .* at most 4.0 V"),
        (lambda: throttle_count(math.nan), ThrottleRefused, "throttle nan V"),
        (lambda: throttle_count(math.inf, limit=5.0), ThrottleRefused, "throttle inf V"),
        (lambda: throttle_count(0.0, limit=6.0), OutOfRange, "limit of the throttle .*0 to 5.0, got 6.0"),
        (lambda: throttle_count(0.0, limit=math.nan), OutOfRange, "limit of the throttle .* got nan"),
        (lambda: throttle_volts(256), OutOfRange, "an integer from 0 to 255, got 256"),
        (lambda: throttle_volts(1.5), OutOfRange, "an integer from 0 to 255, got 1.5"),  # type: ignore[arg-type]
        (lambda: speed_from_count(1024), OutOfRange, "tachometer: expected an integer from 0 to 1023, got 1024"),
        (lambda: flow_from_count(-1), OutOfRange, "flow sensor: expected an integer from 0 to 1023, got -1"),
        (lambda: Reading(0, 1024), OutOfRange, "flow sensor: .* got 1024"),
        (lambda: count_from_speed(math.nan), OutOfRange, "speed .* a number, got nan"),
        (lambda: count_from_flow(math.nan), OutOfRange, "flow velocity .* a number, got nan"),
    ],
)
def test_what_cannot_be_sent_is_refused_with_value_and_limit(
    call: Callable[[], object], kind: type[BenchDriverError], message: str
) -> None:
    with pytest.raises(kind, match=message) as caught:
        call()
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_a_refused_throttle_names_its_facts() -> None:
    with pytest.raises(ThrottleRefused) as caught:
        throttle_count(3.5)
    assert (caught.value.value, caught.value.limit) == (3.5, 3.0)
    assert throttle_count(3.5, limit=4.0) == 38  # 38.25


READINGS = [
    (b"", [], {}),
    (b"0,0\n", [(0, 0)], {}),
    (b"1023,1023\r\n512,7\n", [(1023, 1023), (512, 7)], {}),
    (b"1024,5\n5,9999\n6,6\n", [(6, 6)], {"count above 1023": 2}),
    (b"\n12\n1,2,3\n-1,2\n 1,2\n01,2\n1,\n1,2\r\r\n", [], {"not two integers": 8}),
    (b"1,2\r3,4\n5,6\n", [(5, 6)], {"not two integers": 1}),
    (b"1023,1023,12\n5,6\n", [(5, 6)], {"longer than 10 bytes": 1}),
    (b"9" * 5000 + b"\n5,6\n", [(5, 6)], {"longer than 10 bytes": 1}),
]  # fmt: skip
COMMANDS = [
    (b"", [], False, {}),
    (b"128\n51\r\n0\n255\n", [128, 51, 0, 255], False, {}),
    (b"128\n-99\n0\nrubbish\n", [128], True, {}),
    (b"256\n1000\n12\n", [12], False, {"count above 255": 2}),
    (b"\n-98\n+1\n1.0\n-99 \n007\n10000\n", [], False, {"not an integer": 7}),
    (b"-9" * 50 + b"\n128\n", [128], False, {"longer than 10 bytes": 1}),
]
TRAILING = [b"", b"1", b"1023,", b"12,3", b"-99", b"\r", b"\xff"]


def pieces(stream: bytes) -> list[list[bytes]]:
    """Return the stream whole and byte by byte."""
    return [[stream], [bytes([byte]) for byte in stream]]


@pytest.mark.parametrize("trailing", TRAILING)
@pytest.mark.parametrize(("stream", "expected", "rejected"), READINGS)
def test_readings_are_the_same_whole_byte_by_byte_and_with_bytes_trailing(
    stream: bytes, expected: list[tuple[int, int]], rejected: dict[str, int], trailing: bytes
) -> None:
    for cut in pieces(stream + trailing):
        decoder = LineDecoder()
        assert [reading for piece in cut for reading in decoder.feed(piece)] == [Reading(*e) for e in expected]
        assert decoder.rejected == rejected
        assert (decoder.last_rejected is None) == (not rejected)


@pytest.mark.parametrize("trailing", TRAILING)
@pytest.mark.parametrize(("stream", "expected", "ended", "rejected"), COMMANDS)
def test_commands_are_the_same_whole_byte_by_byte_and_with_bytes_trailing(
    stream: bytes, expected: list[int], ended: bool, rejected: dict[str, int], trailing: bytes
) -> None:
    for cut in pieces(stream + trailing):
        decoder = CommandDecoder()
        assert [count for piece in cut for count in decoder.feed(piece)] == expected
        assert (decoder.ended, decoder.rejected) == (ended, rejected)


def test_a_partial_line_is_kept_and_a_missing_end_publishes_nothing() -> None:
    decoder = LineDecoder()
    assert decoder.feed(b"10") == []
    assert decoder.feed(b"23,4") == []
    assert decoder.feed(b"5\n") == [Reading(1023, 45)]


def test_the_rest_of_a_line_is_no_reading_when_the_port_was_opened_in_its_middle() -> None:
    decoder = LineDecoder(mid_line=True)
    assert decoder.feed(b"23,5\n7,8\n") == [Reading(7, 8)]
    assert (decoder.rejected, decoder.last_rejected) == ({"start not seen": 1}, b"23,5")


def test_memory_stays_bounded_without_an_end_of_line() -> None:
    for decoder in (LineDecoder(), CommandDecoder()):
        for _ in range(1000):
            decoder.feed(b"1" * 1000)
        assert len(decoder._lines._start) <= 10


def mutated(stream: bytes, seed: int) -> bytes:
    """Return the stream with one byte in twenty replaced, dropped or doubled."""
    chance = random.Random(seed)
    out = bytearray()
    for byte in stream:
        new = chance.choice([bytes([chance.choice(NEW_BYTES)]), b"", bytes([byte, byte])])
        out += new if chance.random() < 0.05 else bytes([byte])
    return bytes(out)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32), size=st.integers(1, 64))
def test_20000_mutated_bytes_give_no_error_no_reading_out_of_range_and_the_same_in_pieces(seed: int, size: int) -> None:
    chance = random.Random(seed)
    sent = b"".join(encode_reading(Reading(chance.randrange(1024), chance.randrange(1024))) for _ in range(3000))
    stream = mutated(sent[:20_000], seed)
    whole, cut = LineDecoder(), LineDecoder()
    readings = whole.feed(stream)
    assert readings
    assert all(0 <= r.tachometer_count <= 1023 and 0 <= r.flow_count <= 1023 for r in readings)
    assert len(readings) + whole.rejected.total() == stream.count(b"\n")
    assert [r for i in range(0, len(stream), size) for r in cut.feed(stream[i : i + size])] == readings
    assert cut.rejected == whole.rejected


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_20000_mutated_bytes_give_no_count_out_of_range(seed: int) -> None:
    chance = random.Random(seed)
    sent = b"".join(encode_throttle(chance.uniform(-3, 3)) for _ in range(7000))
    stream = mutated(sent[:20_000], seed)
    decoder = CommandDecoder()
    counts = decoder.feed(stream)
    assert counts
    assert all(0 <= count <= 255 for count in counts)
    assert decoder.ended or len(counts) + decoder.rejected.total() == stream.count(b"\n")


@given(st.lists(st.binary(max_size=40)))
def test_arbitrary_bytes_raise_nothing(cut: list[bytes]) -> None:
    readings, commands = LineDecoder(), CommandDecoder()
    for piece in cut:
        readings.feed(piece)
        commands.feed(piece)


@given(st.lists(st.builds(Reading, st.integers(0, 1023), st.integers(0, 1023))))
def test_readings_survive_the_line(sent: list[Reading]) -> None:
    assert LineDecoder().feed(b"".join(map(encode_reading, sent))) == sent


@given(st.lists(st.floats(-3, 3)))
def test_throttles_survive_the_line_as_counts(sent: list[float]) -> None:
    decoder = CommandDecoder()
    assert decoder.feed(b"".join(map(encode_throttle, sent)) + END) == [throttle_count(u) for u in sent]
    assert decoder.ended
