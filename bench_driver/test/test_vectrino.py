"""The velocimeter's stream: packets by hand, the real recording, pieces, damage."""

import math
from struct import pack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench_driver.vectrino import LONGEST_PACKET, Packet, VectrinoDecoder, Velocity, VelocityHeader, checksum


def closed(body: bytes) -> bytes:
    return body + pack("<H", checksum(body))


def velocity(count: int, *, status: int = 0x23, numbers: tuple[int, ...] = (-1234, 5, 0, 32767)) -> bytes:
    return closed(b"\xa5\x51" + pack("<BB4h8B", status, count, *numbers, 100, 15, 21, 0, 99, 50, 1, 0))


NOISE, FOUND = (10, 15, 0, 21, 2, 3, 1, 1), (1913, 14796)
HEADER = closed(b"\xa5\x50\x15\x00" + pack("<HHHH8BhH16B", 3367, 5, 70, 160, *NOISE, *FOUND, *range(16)))
INFORMATION = closed(b"\xa5\x0f\x05\x00text")


def test_the_checksum_is_the_one_computed_by_hand() -> None:
    assert checksum(b"") == 0xB58C
    assert checksum(b"\x01\x02\xff\xff") == (0xB58C + 0x0201 + 0xFFFF) % 65536


def test_a_velocity_packet_has_the_values_written_into_it() -> None:
    (record,) = VectrinoDecoder().feed(velocity(7))
    assert isinstance(record, Velocity)
    assert record.velocity == pytest.approx((-0.1234, 0.0005, 0.0, 3.2767))
    assert (record.count, record.amplitude, record.correlation) == (7, (100, 15, 21, 0), (99, 50, 1, 0))
    assert record.known_status


def test_status_bit_5_tells_the_unit_of_the_velocity() -> None:
    (coarse,) = VectrinoDecoder().feed(velocity(0, status=0x03))
    assert isinstance(coarse, Velocity)
    assert coarse.velocity == pytest.approx((-1.234, 0.005, 0.0, 32.767))


def test_a_status_that_is_not_documented_is_marked() -> None:
    (record,) = VectrinoDecoder().feed(velocity(0, status=0x43))
    assert isinstance(record, Velocity)
    assert not record.known_status


def test_the_signal_to_noise_ratio_is_known_once_the_header_told_the_noise() -> None:
    before, header, after = VectrinoDecoder().feed(velocity(0) + HEADER + velocity(1))
    assert isinstance(before, Velocity) and isinstance(after, Velocity)
    assert header == VelocityHeader(
        noise_amplitude=(10, 15, 0, 21), noise_correlation=(2, 3, 1, 1), temperature=19.13, sound_speed=1479.6
    )
    assert all(map(math.isnan, before.snr))
    assert after.snr == pytest.approx((20.0, 0.0, math.nan, math.nan), nan_ok=True)


STREAM = INFORMATION + HEADER + b"".join(velocity(count % 256) for count in range(250, 260))


@pytest.mark.parametrize("trailing", [b"", b"\xa5", b"\xa5\x51", velocity(4)[:-1]])
def test_records_are_the_same_whole_byte_by_byte_and_with_bytes_trailing(trailing: bytes) -> None:
    results = []
    for pieces in ([STREAM + trailing], [bytes([byte]) for byte in STREAM + trailing]):
        decoder = VectrinoDecoder()
        found = [record for piece in pieces for record in decoder.feed(piece)]
        assert found[0] == Packet(0x0F, INFORMATION)
        assert [record.count for record in found[2:] if isinstance(record, Velocity)] == [*range(250, 256), *range(4)]
        assert (+decoder.rejected, decoder.jumps, decoder.waiting) == ({}, 0, len(trailing))
        results.append([repr(record) for record in found])  # repr: NaN equals NaN
    assert results[0] == results[1]


def test_damage_costs_the_record_that_it_hit_and_no_other() -> None:
    damaged = bytearray(velocity(1))
    damaged[9] ^= 4
    decoder = VectrinoDecoder()
    found = decoder.feed(b"\x00\xa5\xa5" + velocity(0) + bytes(damaged) + velocity(2)[:10] + velocity(3))
    assert [record.count for record in found if isinstance(record, Velocity)] == [0, 3]
    assert decoder.rejected["wrong checksum"] == 2
    assert (decoder.jumps, decoder.lost) == (1, 2)


@given(st.lists(st.binary(max_size=60)))
def test_arbitrary_bytes_raise_nothing_and_memory_stays_bounded(pieces: list[bytes]) -> None:
    decoder = VectrinoDecoder()
    for piece in [b"\xa5\x05\x00\x08", *pieces]:  # a packet of 4096 bytes announced
        decoder.feed(piece)
        assert decoder.waiting < LONGEST_PACKET


def test_every_byte_of_the_real_recording_lies_in_a_packet(vectrino_recording: bytes) -> None:
    decoder = VectrinoDecoder()
    pieces = (vectrino_recording[i : i + 37] for i in range(0, len(vectrino_recording), 37))
    found = [record for piece in pieces for record in decoder.feed(piece)]
    velocities = [record for record in found if isinstance(record, Velocity)]
    others = [record.identifier for record in found if isinstance(record, Packet)]
    assert (len(velocities), others) == (18_727, [0x05, 0x04, 0x00, 0x07, 0x07, 0x0F])
    assert (+decoder.rejected, decoder.jumps, decoder.waiting) == ({}, 0, 0)
    assert decoder.header is not None
    # Fresh water of 19.13 °C: 1480 m/s (Bilaniuk and Wong 1993).
    assert decoder.header.temperature == 19.13
    assert decoder.header.sound_speed == pytest.approx(1480.0, abs=1.0)
    assert all(record.known_status for record in velocities)
    assert min(min(record.correlation) for record in velocities) == 1
    assert max(abs(v) for record in velocities for v in record.velocity) == pytest.approx(1.443)


def test_one_damaged_byte_in_a_thousand_of_the_recording_costs_no_other_record(vectrino_recording: bytes) -> None:
    data = bytearray(vectrino_recording)
    hit = range(5100, len(data), 1000)
    for at in hit:
        data[at] ^= 0x55
    decoder = VectrinoDecoder()
    found = [record for record in decoder.feed(bytes(data)) if isinstance(record, Velocity)]
    assert len(found) == 18_727 - len(hit)
    assert decoder.lost == len(hit)
