"""Everything that goes wrong between host and device: what is said, that no measurement is made up, zero on return."""

import random
from collections.abc import Callable

import pytest
from bench_rig import DIALECTS, IDLE, Rig

from bench_driver.emulated_device import EmulatedDevice
from bench_driver.link_diagnosis import Level, LinkDiagnosis
from bench_driver.link_records import LinkLimits, LinkState

ZERO = 0.02  # V


@pytest.fixture(params=list(DIALECTS))
def rig(request: pytest.FixtureRequest) -> Rig:
    made = Rig(DIALECTS[request.param]())
    made.drive()
    return made


def said(rig: Rig) -> tuple[Level, str]:
    diagnosis = rig.diagnosis.diagnose(rig.now)
    return diagnosis.level, diagnosis.sentence


def every(step: int, change: Callable[[bytearray], bytes]) -> Callable[[bytes], bytes]:
    """Return a line that changes every so-manyth piece that is not empty."""
    count = 0

    def line(data: bytes) -> bytes:
        nonlocal count
        count += bool(data)
        return change(bytearray(data)) if data and count % step == 0 else data

    return line


def test_a_good_session_says_so_and_counts_no_fault(rig: Rig) -> None:
    rig.run(6.0)
    level, sentence = said(rig)
    assert (level, sentence.startswith("ready")) == (Level.OK, True), sentence
    assert all(found.tachometer_counts[0] in rig.sensed for _, found in rig.measured)


def test_bytes_lost_in_connecting_are_no_fault_even_if_nobody_asked_before(rig: Rig) -> None:
    diagnosis = LinkDiagnosis(rig.link).diagnose(rig.now)
    assert (diagnosis.level, diagnosis.sentence[:5]) == (Level.OK, "ready"), diagnosis.sentence


def test_faults_that_the_device_counts_are_said_even_beyond_the_end_of_its_counter() -> None:
    rig = Rig(DIALECTS["frames"]())
    rig.drive()
    rig.device._errors[0] = 65_530
    rig.run(0.1)
    before = rig.dialect.faults["device: wrong checksum"]

    def damaged(data: bytes) -> bytes:
        return data[:-1] + bytes([data[-1] ^ 1]) if data else data

    rig.to_device = every(2, damaged)
    rig.run(0.4)
    assert rig.dialect.faults["device: wrong checksum"] - before == pytest.approx(20, abs=2)
    assert "device: wrong checksum" in said(rig)[1]


def test_stamps_are_the_instants_of_the_measurements(rig: Rig) -> None:
    rig.measured.clear()
    rig.run(2.0)
    for arrival, found in rig.measured:
        # The plant's tachometer counts milliseconds: the count is the time at the start of the 10 ms it was held.
        held_from = found.tachometer_counts[0] / 1000
        age = (found.stamp - held_from + 0.5) % 1.0 - 0.5
        assert -0.011 < age < 0.021, age
        assert found.stamp <= arrival


def test_an_absent_port_is_said_to_be_absent() -> None:
    rig = Rig(DIALECTS["text"](), present=False)
    rig.run(1.0)
    assert said(rig) == (Level.ERROR, "absent: no such port; is the device plugged in?")
    assert not rig.measured


def test_unplugging_and_plugging_in_again_goes_through_zero(rig: Rig) -> None:
    rig.present = False
    rig.run(1.5)
    level, sentence = said(rig)
    assert level is Level.ERROR
    assert rig.link.counters["unplugged"] == 1
    assert "unplugged" in sentence or "no such port" in sentence
    assert abs(rig.seen[-1]) <= ZERO  # the device's own watchdog
    measured = len(rig.measured)
    rig.present = True
    rig.sent.clear()
    took = rig.until(LinkState.READY)
    assert took < 4.0
    assert max(map(abs, rig.seen[-round(took / 0.01) : -1])) <= ZERO  # the last went out when the link was ready
    rig.run(0.3)
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)
    assert len(rig.measured) > measured
    level, sentence = said(rig)
    assert (level, "the port was opened again" in sentence) == (Level.WARN, True)


def test_garbage_is_counted_and_measurements_stay_true(rig: Rig) -> None:
    rig.to_host = every(3, lambda data: b"\xff\x00\xa5!" + bytes(data) + b"#\n")
    rig.run(2.0)
    level, sentence = said(rig)
    assert level is Level.WARN
    assert "no frame" in sentence or "no two integers" in sentence or "longer than" in sentence, sentence
    assert all(found.tachometer_counts[0] in rig.sensed for _, found in rig.measured)
    assert rig.link.state is LinkState.READY


def test_partial_frames_are_counted_and_no_measurement_is_made_of_them() -> None:
    rig = Rig(DIALECTS["frames"]())
    rig.drive()
    rig.to_host = every(4, lambda data: bytes(data[: len(data) // 2]))
    rig.run(2.0)
    level, sentence = said(rig)
    assert level is Level.WARN
    assert "jumps of the sequence counter" in sentence and "wrong checksums" in sentence, sentence
    assert all(found.tachometer_counts[0] in rig.sensed for _, found in rig.measured)
    assert rig.link.state is LinkState.READY


def test_silence_in_the_middle_of_a_measurement_is_said_to_be_one(rig: Rig) -> None:
    rig.to_host = lambda data: data[: len(data) // 2]
    while not rig.dialect.waiting:
        rig.step()
    rig.to_host = lambda data: b""
    rig.run(0.5)
    level, sentence = said(rig)
    assert (level, rig.link.state) == (Level.ERROR, LinkState.SILENT)
    assert "bytes of an unfinished one wait" in sentence


def test_wrong_checksums_are_counted_and_no_measurement_is_made_of_them() -> None:
    rig = Rig(DIALECTS["frames"]())
    rig.drive()
    before = len(rig.measured)

    def damaged(data: bytearray) -> bytes:
        data[30] ^= 1
        return bytes(data)

    rig.to_host = every(2, damaged)
    rig.run(1.0)
    assert len(rig.measured) - before == pytest.approx(50, abs=2)
    level, sentence = said(rig)
    assert (level, "wrong checksums" in sentence) == (Level.WARN, True)
    assert rig.dialect.faults["wrong checksum"] == pytest.approx(50, abs=2)


def test_counter_jumps_are_counted_with_the_frames_that_are_lost() -> None:
    rig = Rig(DIALECTS["frames"]())
    rig.drive()
    rig.to_host = every(5, lambda data: b"")
    rig.run(1.0)
    assert rig.dialect.faults["sequence jump"] == pytest.approx(20, abs=2)
    assert rig.dialect.faults["lost frame"] == pytest.approx(20, abs=2)
    level, sentence = said(rig)
    assert (level, "jumps of the sequence counter" in sentence) == (Level.WARN, True)


def test_a_reset_of_the_device_goes_through_zero_and_is_said(rig: Rig) -> None:
    rig.run(1.0)
    rig.device.reset()
    rig.step()
    assert rig.seen[-1] == 0.0
    while rig.link.state is LinkState.READY:
        rig.step()
        assert abs(rig.seen[-1]) <= ZERO
    rig.until(LinkState.READY)
    rig.run(0.3)
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)
    level, sentence = said(rig)
    if rig.dialect.line_speed == 9600:
        assert rig.link.counters["silent"] == 1  # text cannot tell more
    else:
        assert (rig.dialect.resets, level) == (1, Level.WARN)
        assert "the device was reset (1 times so far)" in sentence


def test_a_silent_device_is_given_zero_then_given_up_and_found_again(rig: Rig) -> None:
    rig.run(0.04)
    rig.to_host = lambda data: b""
    rig.step()  # with what had come before
    measured = len(rig.measured)
    rig.run(0.35)
    assert rig.link.state is LinkState.SILENT
    level, sentence = said(rig)
    assert level is Level.ERROR
    assert sentence.startswith("the device is silent: no measurement for 0.2 s")
    assert abs(rig.seen[-1]) <= ZERO
    rig.until(LinkState.LOST)
    assert len(rig.measured) == measured
    assert (rig.device.advance(0.01, IDLE).enabled, rig.is_open) == ((False,), False)
    rig.to_host = lambda data: data
    rig.until(LinkState.READY)
    rig.run(0.3)
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)


def test_a_board_that_opening_resets_is_left_alone_while_its_boot_loader_listens() -> None:
    rig = Rig(DIALECTS["frames"](), limits=LinkLimits())
    rig.device = EmulatedDevice(line_speed=115200, boot_time=1.5)
    rig.drive()
    assert rig.sent[0][0] - rig.opened_at[0] == pytest.approx(2.0)
    assert len(rig.opened_at) == 1


def test_commands_that_do_not_arrive_disable_the_device_and_zero_comes_first_again(rig: Rig) -> None:
    rig.to_device = lambda data: b""
    rig.run(0.3)
    assert abs(rig.seen[-1]) <= ZERO
    rig.to_device = lambda data: data
    rig.throttle = 1.0
    assert rig.link.state is not LinkState.READY
    rig.until(LinkState.READY)
    rig.run(0.3)
    assert rig.seen[-1] == pytest.approx(1.0, abs=0.02)


def test_every_measurement_was_received_whatever_the_line_does(rig: Rig) -> None:
    chance = random.Random(7)

    def line(data: bytes) -> bytes:
        kind = chance.random()
        if kind < 0.1:
            return b""
        if kind < 0.2:
            return data + data
        if kind < 0.3:
            return data[: chance.randrange(len(data) + 1)]
        return data + chance.randbytes(chance.randrange(8)) if kind < 0.4 else data

    rig.to_host = line
    rig.run(5.0)
    count = rig.received.count(b"\n") if rig.dialect.line_speed == 9600 else rig.received.count(b"\xa5\x5a")
    assert 0 < len(rig.measured) <= count
    assert all(abs(u) <= 3.0 for u in rig.seen)
