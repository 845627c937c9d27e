"""Damaged streams: no decoder raises, and false frames are as rare as the checksum promises.

The long run, with its figures: `MUTATED_STREAMS=1000000 pytest test/test_mutated_streams.py --log-cli-level=INFO`.
"""

import logging
import math
import random
import zlib

import numpy as np
from damaged_streams import mutated

from bench_driver import framed_messages as messages
from bench_driver.framed_protocol import LONGEST_FRAME, Frame, FrameDecoder, encode
from bench_driver.text_protocol import LineDecoder, Reading, encode_reading

log = logging.getLogger(__name__)


def at_most(expected: float) -> float:
    """Return a number that a count with this expectation exceeds once in a million times at most."""
    return expected + 5 * math.sqrt(expected) + 3


def states(chance: random.Random) -> list[Frame]:
    made = []
    for sequence in range(3):
        counts = [chance.randrange(1024) for _ in range(8)]
        state = messages.State(
            enabled=(True,), watchdog=False, echo=sequence, age=0, errors=(0,) * 7, tachometer_counts=(counts[0],),
            flow_counts=(counts[1],), codes=(4 * counts[2] % 4081,), load_counts=tuple(counts[3:8]),
        )  # fmt: skip
        made.append(Frame(messages.STATE, sequence, chance.randrange(1 << 32), state.payload()))
    return made


def test_false_frames_are_as_rare_as_a_checksum_of_32_bits_promises(mutated_streams: int) -> None:
    chance = random.Random(1)
    sent = [states(chance) for _ in range(64)]
    streams = [b"".join(map(encode, frames)) for frames in sent]
    false = checked = sound = 0
    for original, data in mutated(streams, mutated_streams, seed=1):
        decoder = FrameDecoder(messages.FROM_DEVICE)
        frames = decoder.feed(data)
        assert decoder.waiting < LONGEST_FRAME
        wrong = [frame for frame in frames if frame not in sent[original]]
        false += len(wrong)
        sound += len(frames) - len(wrong)
        checked += decoder.rejected["wrong checksum"] + len(wrong)
    log.info("frames: %d streams, %d sound, %d damaged ones checked, %d false, %.1e expected",
             mutated_streams, sound, checked, false, checked / 2**32)  # fmt: skip
    assert sound > mutated_streams / 2
    assert checked > mutated_streams / 2
    assert false <= checked / 2**32 * 1e3


def test_each_byte_of_the_frames_checksum_alone_lets_one_damaged_frame_in_256_pass(mutated_streams: int) -> None:
    chance = np.random.default_rng(2)
    sound = encode(states(random.Random(2))[0])
    body, count = np.frombuffer(sound[2:-4], np.uint8), 5 * mutated_streams
    damage = chance.integers(256, size=(count, 4), dtype=np.uint8)
    places = chance.integers(len(body), size=(count, 4))
    agree = np.zeros(4)
    for row in range(count):
        data = body.copy()
        data[places[row]] = damage[row]
        found = zlib.crc32(data.tobytes()) ^ zlib.crc32(body.tobytes())
        agree += [found >> shift & 0xFF == 0 for shift in (0, 8, 16, 24)]
    assert np.all(np.abs(agree - count / 256) < 5 * math.sqrt(count / 256)), agree


def test_the_text_decoder_raises_nothing_and_lets_pass_only_what_is_a_reading(mutated_streams: int) -> None:
    chance = random.Random(4)
    sent = [[Reading(chance.randrange(1024), chance.randrange(1024)) for _ in range(6)] for _ in range(64)]
    streams = [b"".join(map(encode_reading, readings)) for readings in sent]
    false = sound = rejected = 0
    for original, data in mutated(streams, mutated_streams, seed=4):
        decoder = LineDecoder()
        readings = decoder.feed(data)
        assert len(readings) + decoder.rejected.total() == data.count(b"\n")
        assert all(0 <= r.tachometer_count < 1024 and 0 <= r.flow_count < 1024 for r in readings)
        wrong = sum(reading not in sent[original] for reading in readings)
        false += wrong
        sound += len(readings) - wrong
        rejected += decoder.rejected.total()
    log.info(
        "text: %d streams, %d sound, %d rejected, %d false: there is no checksum",
        mutated_streams,
        sound,
        rejected,
        false,
    )
    assert sound > 2 * mutated_streams
    # Damage that leaves two numbers cannot be seen; this is why frames exist.
    assert 0 < false < rejected
