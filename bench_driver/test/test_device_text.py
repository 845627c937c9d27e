"""What every device does with text: the one emulated in Python, and the firmware on an emulated processor."""

from collections.abc import Callable

import pytest
from bench_hosts import FRAMES, Text, inputs

from bench_driver.converter import code_from_count, code_volts
from bench_driver.device import Device
from bench_driver.text_protocol import Reading

MakeDevice = Callable[..., Device]
ZERO = code_volts(code_from_count(128))


@pytest.fixture
def text(make_device: MakeDevice) -> Text:
    return Text(make_device())


def test_each_count_is_answered_by_one_reading_of_the_inputs(text: Text) -> None:
    for count in [128] * 10 + [51] * 10:
        text.say(b"%d\n" % count)
    sensed = inputs(text.device)
    assert text.readings == [Reading(sensed.tachometer_counts[0], sensed.flow_counts[0])] * 20
    assert not text.decoder.rejected


def test_a_silent_host_hears_nothing(text: Text) -> None:
    assert text.say(b"128\n").data
    assert text.say(b"", 1.5).data == b""


def test_counts_before_the_first_128_are_neither_obeyed_nor_answered(text: Text) -> None:
    for count in (0, 51, 255, 127):
        outputs = text.say(b"%d\n" % count)
        assert (outputs.throttles, outputs.enabled) == ((0.0,), (False,))
    assert not text.readings
    assert text.say(b"128\n").enabled == (True,)
    assert text.readings


def test_the_throttle_is_exactly_that_of_the_count(text: Text) -> None:
    text.say(b"128\n")
    for count in (0, 1, 51, 127, 128, 204, 254, 255):
        assert text.say(b"%d\r\n" % count).throttles == (5 - 10 * (16 * count) / 4080,)


def test_200_ms_without_a_count_set_128_and_the_next_count_is_obeyed(text: Text) -> None:
    text.say(b"128\n")
    set_to = text.say(b"51\n").throttles
    assert text.say(b"", 0.15).throttles == set_to
    assert text.say(b"", 0.03).throttles == (ZERO,)
    assert text.say(b"51\n").throttles == set_to


def test_minus_99_disables_and_is_final_until_a_second_of_silence(text: Text) -> None:
    text.say(b"128\n51\n")
    assert text.say(b"-99\n51\n128\n51\n").enabled == (False,)
    answered = len(text.readings)
    for _ in range(10):
        assert text.say(b"128\n51\n").throttles == (0.0,)
    assert len(text.readings) == answered
    text.say(b"", 1.1)
    assert text.say(b"51\n").enabled == (False,)
    assert text.say(b"128\n51\n").throttles == (code_volts(816),)


def test_garbage_between_lines_costs_only_the_line_that_it_hit(text: Text) -> None:
    text.say(b"128\n")
    for garbage in (b"\x00\xff\n", b"5x\n", b"999999999999\n", b"256\n", b"-98\n", b"051\n", b"\r\r\n", b"\n\n"):
        before = len(text.readings)
        outputs = text.say(garbage + b"77\n")
        assert outputs.throttles == (code_volts(16 * 77),)
        assert len(text.readings) == before + 1


def test_a_line_in_single_bytes_is_the_same_line(text: Text) -> None:
    for byte in b"128\n51\n":
        outputs = text.say(bytes([byte]), 0.01)
    assert outputs.throttles == (code_volts(816),)


def test_a_reset_disables_and_zero_has_to_come_first_again(text: Text) -> None:
    text.say(b"128\n")
    text.say(b"51\n")
    text.device.reset()
    assert text.say(b"").throttles == (0.0,)
    assert text.say(b"51\n").enabled == (False,)
    assert text.say(b"128\n51\n").enabled == (True,)


def test_at_25_hz_no_line_is_lost_and_each_reading_takes_its_time_on_the_line(text: Text) -> None:
    for _ in range(75):
        text.say(b"128\n")
    assert len(text.readings) == 75
    # 4 bytes there and 8 back at 9600 baud take 12.5 ms.
    assert b"\n" not in text.say(b"128\n", 0.012).data
    assert b"\n" in text.say(b"", 0.004).data


def test_bytes_at_the_wrong_speed_do_not_disturb_a_text_session(text: Text) -> None:
    text.say(b"128\n")
    text.device.line_speed = FRAMES
    text.say(b"51\n")
    text.device.line_speed = 9600
    assert text.say(b"\n77\n").throttles == (code_volts(16 * 77),)
