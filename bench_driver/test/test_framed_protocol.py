"""Frames: a known one byte by byte, streams in any pieces, resynchronisation, counters, bounded memory."""

import random
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench_driver import framed_messages as messages
from bench_driver.errors import OutOfRange
from bench_driver.framed_protocol import LONGEST_FRAME, LONGEST_PAYLOAD, OVERHEAD, SYNC, Frame, FrameDecoder, encode

STOP = Frame(messages.STOP, 258, 0x01020304)
STATE = messages.State(
    enabled=(True,), watchdog=False, echo=513, age=7, errors=(1, 2, 3, 4, 5, 6, 7), tachometer_counts=(1023,),
    flow_counts=(512,), codes=(2040,), load_counts=(1, 2, 3, 4, 5, 1023),
)  # fmt: skip


def command(sequence: int, *throttles: int) -> Frame:
    payload = messages.Command(throttles=throttles or (0,), enabled=(True,) * max(len(throttles), 1)).payload()
    return Frame(messages.COMMAND, sequence, 10_000 * sequence, payload)


def decoder() -> FrameDecoder:
    return FrameDecoder(messages.TO_DEVICE)


def test_a_frame_has_the_bytes_written_by_hand() -> None:
    body = bytes([0, 2, 0x02, 0x01, 0x04, 0x03, 0x02, 0x01])
    assert encode(STOP) == b"\xa5\x5a" + body + zlib.crc32(body).to_bytes(4, "little")
    # The catalogue's check value of this CRC-32, so that another implementation agrees.
    assert zlib.crc32(b"123456789") == 0xCBF43926


def test_a_command_has_the_payload_written_by_hand() -> None:
    sent = messages.Command(throttles=(-2, 3000), enabled=(False, True))
    assert sent.payload() == b"\x02\xfe\xff\xb8\x0b"
    assert messages.command(sent.payload()) == sent


def test_a_state_has_the_length_and_the_content_it_had() -> None:
    assert len(STATE.payload()) == 21 + 6 + 12
    assert messages.state(STATE.payload()) == STATE


def test_the_longest_state_is_the_longest_payload() -> None:
    assert max(max(lengths) for lengths in messages.FROM_DEVICE.values()) == LONGEST_PAYLOAD


def test_a_hello_survives_and_names_its_cause() -> None:
    hello = messages.Hello(version=1, cause=10, thrusters=8, loads=0, rate=100, watchdog=200, largest_code=4080)
    assert messages.hello(hello.payload()) == hello
    assert (messages.reset_cause(10), messages.reset_cause(0)) == ("reset line, watchdog", "not told")


@pytest.mark.parametrize(
    "payload",
    [
        b"\x02\x00\x00",  # a flag of a second thruster that does not exist
        b"\x01\x89\x13",  # 5001 mV
        b"\x01\x00\x80",  # −32768 mV
    ],
)
def test_a_command_that_cannot_be_is_none(payload: bytes) -> None:
    assert messages.command(payload) is None


def test_a_state_that_contradicts_itself_is_none() -> None:
    payload = bytearray(STATE.payload())
    payload[20] = 2  # two thrusters in the space of one with six loads
    assert messages.state(bytes(payload)) is None
    payload = bytearray(STATE.payload())
    payload[22] = 4  # a tachometer count of 1279
    assert messages.state(bytes(payload)) is None


STREAMS = [
    (b"", [], {}),
    (encode(STOP), [STOP], {}),
    (b"128\n51\n" + encode(STOP), [STOP], {"garbage": 7}),
    (SYNC + encode(STOP), [STOP], {"bad header": 1, "garbage": 1}),
    (b"\xa5" + encode(STOP), [STOP], {"garbage": 1}),
    (SYNC + b"\x01\x01" + bytes(20), [], {"bad header": 1, "garbage": 23}),
    (encode(command(1))[:-5] + encode(command(2)), [command(2)], {"wrong checksum": 1, "garbage": 11}),
    (encode(STOP)[:-1] + b"\x00" + encode(STOP), [STOP], {"wrong checksum": 1, "garbage": 13}),
]  # fmt: skip


@pytest.mark.parametrize("trailing", [b"", b"\xa5", b"\xa5\x5a", encode(STOP)[:9]])
@pytest.mark.parametrize(("stream", "expected", "rejected"), STREAMS)
def test_frames_are_the_same_whole_byte_by_byte_and_with_bytes_trailing(
    stream: bytes, expected: list[Frame], rejected: dict[str, int], trailing: bytes
) -> None:
    data = stream + trailing
    for pieces in ([data], [bytes([byte]) for byte in data]):
        found = decoder()
        assert [frame for piece in pieces for frame in found.feed(piece)] == expected
        assert +found.rejected == rejected
        assert found.waiting == len(trailing)


def test_a_frame_inside_a_damaged_one_is_found() -> None:
    outer = bytearray(encode(command(1, 0, 0, 0, 0, 0, 0, 0, 0)))
    inner = encode(STOP)
    outer[12 : 12 + len(inner)] = inner
    found = decoder()
    assert found.feed(bytes(outer)) == [STOP]
    assert found.rejected["wrong checksum"] == 1


def test_every_single_and_double_bit_error_is_found() -> None:
    sound = encode(command(3, 1500))
    bits = 8 * len(sound)
    for first in range(bits):
        for second in range(first, bits):
            damaged = bytearray(sound)
            damaged[first // 8] ^= 1 << first % 8
            if second != first:
                damaged[second // 8] ^= 1 << second % 8
            assert not decoder().feed(bytes(damaged))


def test_jumps_lost_and_repeated_frames_are_counted() -> None:
    found = decoder()
    for sequence in (65534, 65535, 0, 1, 1, 5, 4):
        found.feed(encode(command(sequence)))
    assert (found.jumps, found.lost, found.repeated) == (2, 3, 1)


def test_memory_stays_bounded_whatever_arrives() -> None:
    chance = random.Random(1)
    for data in (b"\xa5\x5a" * 5000, bytes(10_000), chance.randbytes(10_000), encode(command(1, *[0] * 8))[:-1] * 300):
        found = decoder()
        for start in range(0, len(data), 7):
            found.feed(data[start : start + 7])
            assert found.waiting < LONGEST_FRAME


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Frame(256, 0, 0), "type of the frame"),
        (lambda: Frame(1, 65536, 0), "sequence number"),
        (lambda: Frame(1, 0, 1 << 32), "time stamp"),
        (lambda: Frame(1, 0, 0, bytes(70)), "length of the payload"),
        (lambda: messages.Command(throttles=(), enabled=()), "as many flags"),
        (lambda: messages.Command(throttles=(5001,), enabled=(True,)), "at most 5000"),
    ],
)
def test_what_a_frame_cannot_carry_is_refused(make: object, text: str) -> None:
    with pytest.raises(OutOfRange, match=text):
        make()  # type: ignore[operator]


@given(st.lists(st.integers(-5000, 5000), min_size=1, max_size=8), st.integers(0, 65535), st.integers(1, 30))
def test_commands_survive_the_line_in_any_pieces(throttles: list[int], sequence: int, size: int) -> None:
    frame = command(sequence, *throttles)
    data = encode(frame)
    assert len(data) == OVERHEAD + 1 + 2 * len(throttles)
    found = decoder()
    assert [f for i in range(0, len(data), size) for f in found.feed(data[i : i + size])] == [frame]


@given(st.lists(st.binary(max_size=60)))
def test_arbitrary_bytes_raise_nothing(pieces: list[bytes]) -> None:
    found = FrameDecoder(messages.FROM_DEVICE)
    for piece in pieces:
        found.feed(piece)
