"""What every device does with frames: the one emulated in Python, and the firmware on an emulated processor."""

import random
from collections.abc import Callable
from itertools import pairwise

import pytest
from bench_hosts import FRAMES, Frames, Text, inputs

from bench_driver import framed_messages as messages
from bench_driver.converter import code_volts
from bench_driver.device import Device
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.simavr_device_io import SimavrDevice

MakeDevice = Callable[..., Device]


@pytest.fixture
def frames(make_device: MakeDevice) -> Frames:
    host = Frames(make_device(line_speed=FRAMES))
    host.connect()
    return host


def test_a_framed_host_is_found_within_a_third_of_a_second_and_greeted(make_device: MakeDevice) -> None:
    host = Frames(make_device(line_speed=FRAMES))
    for _ in range(34):
        host.say(host.command(0, enable=False))
    first = host.found[0]
    assert (first.type, first.sequence) == (messages.HELLO, 0)
    (hello,) = host.hellos
    assert (hello.version, hello.thrusters, hello.loads, hello.rate, hello.watchdog) == (1, 1, 6, 100, 200)


@pytest.mark.parametrize(("thrusters", "loads"), [(1, 6), (8, 0), (3, 5)])
def test_100_states_a_second_carry_every_input_and_even_stamps(
    make_device: MakeDevice, thrusters: int, loads: int
) -> None:
    host = Frames(make_device(thrusters=thrusters, loads=loads, line_speed=FRAMES))
    host.connect()
    host.found.clear()
    for _ in range(200):
        host.say(host.command(*[0] * thrusters))
    assert 199 <= len(host.states) <= 201
    sensed = inputs(host.device)
    for state in host.states:
        assert state.tachometer_counts == sensed.tachometer_counts
        assert state.flow_counts == sensed.flow_counts
        assert state.load_counts == sensed.load_counts
    stamps = [frame.time for frame in host.found]
    assert all(abs(b - a - 10_000) < 300 for a, b in pairwise(stamps))
    assert abs(stamps[-1] - stamps[0] - 10_000 * (len(stamps) - 1)) < 300
    assert (+host.decoder.rejected, host.decoder.jumps) == ({}, 0)
    assert host.states[-1].errors == host.states[0].errors


def test_a_state_echoes_the_last_command_and_the_codes_of_the_converters(frames: Frames) -> None:
    frames.drive(1500)
    frames.say()
    state = frames.states[-1]
    assert (state.echo, state.enabled, state.codes) == (frames.sequence, (True,), (1428,))
    assert 8 <= state.age <= 32


def test_a_thruster_is_enabled_by_zero_alone(frames: Frames) -> None:
    assert frames.say(frames.command(1000)).enabled == (False,)
    assert frames.say(frames.command(0, enable=False)).enabled == (False,)
    assert frames.say(frames.command(0)).enabled == (True,)
    assert frames.say(frames.command(1000)).throttles == (code_volts(1632),)
    assert frames.say(frames.command(1000, enable=False)).throttles == (0.0,)
    frames.say()
    assert frames.states[-1].errors[messages.ERRORS.index("refused")] == 1


def test_each_thruster_is_enabled_for_itself(make_device: MakeDevice) -> None:
    host = Frames(make_device(thrusters=3, loads=5, line_speed=FRAMES))
    host.connect()
    both = messages.Command(throttles=(0, 500, 0), enabled=(True, True, False))
    assert host.say(host.frame(messages.COMMAND, both.payload())).enabled == (True, False, False)
    outputs = host.say(host.command(2500, 0, -2500))
    assert outputs.enabled == (True, True, False)
    assert outputs.throttles == (2.5, 0.0, 0.0)


def test_200_ms_without_a_command_disable_and_zero_has_to_come_first_again(frames: Frames) -> None:
    frames.drive(1500)
    assert frames.say(b"", 0.17).throttles == (1.5,)
    assert frames.say(b"", 0.03).throttles == (0.0,)
    frames.say(b"", 0.02)
    state = frames.states[-1]
    assert (state.watchdog, state.enabled, state.codes) == (True, (False,), (2040,))
    assert state.errors[messages.ERRORS.index("watchdog")] == 1
    assert frames.say(frames.command(1500)).enabled == (False,)
    assert frames.say(frames.command(0) + frames.command(1500)).throttles == (1.5,)


def test_questions_do_not_feed_the_watchdog(frames: Frames) -> None:
    frames.drive(1500)
    for _ in range(25):
        outputs = frames.say(frames.frame(messages.ASK_HELLO))
    assert outputs.enabled == (False,)
    assert len(frames.hellos) > 20


def test_a_stop_disables_at_once(frames: Frames) -> None:
    assert frames.drive(1500).enabled == (True,)
    assert frames.say(frames.frame(messages.STOP)).enabled == (False,)
    assert frames.say(frames.command(1500)).enabled == (False,)


def test_a_reset_asked_for_goes_through_the_watchdog_and_is_reported(frames: Frames) -> None:
    frames.drive(1500)
    frames.found.clear()
    assert frames.say(frames.frame(messages.ASK_RESET)).throttles == (0.0,)
    for _ in range(50):
        assert frames.say(frames.command(1500)).throttles == (0.0,)
    (hello,) = frames.hellos
    assert "watchdog" in messages.reset_cause(hello.cause)
    assert frames.found[-1].time < 600_000


def test_a_command_with_a_wrong_checksum_moves_nothing_and_is_counted(frames: Frames) -> None:
    frames.drive(500)
    before = frames.states[-1].errors[0]
    for _ in range(5):
        bad = bytearray(frames.command(2500))
        bad[-1] ^= 1
        assert frames.say(bytes(bad)).throttles == (0.5,)
    frames.say(frames.command(500))
    frames.say()
    assert frames.states[-1].errors[0] == before + 5


def test_commands_that_are_missing_are_counted_by_their_sequence(frames: Frames) -> None:
    frames.sequence += 7
    frames.say(frames.command(0))
    frames.say()
    assert frames.states[-1].errors[messages.ERRORS.index("missing command")] == 7


@pytest.mark.parametrize(
    "payload",
    [b"\x03\x00\x00\x00\x00", b"\x01\x89\x13", b"\x01\x00\x80", b"\x03\x00\x00"],
    ids=["two thrusters", "5001 mV", "-32768 mV", "flag of a second thruster"],
)
def test_a_command_that_cannot_be_is_refused_and_does_not_feed_the_watchdog(frames: Frames, payload: bytes) -> None:
    frames.drive(500)
    for _ in range(25):
        outputs = frames.say(frames.frame(messages.COMMAND, payload))
    assert outputs.enabled == (False,)
    assert frames.states[-1].errors[messages.ERRORS.index("refused")] >= 24


def test_garbage_between_commands_is_tolerated_and_counted(frames: Frames) -> None:
    chance = random.Random(5)
    frames.drive(500)
    for k in range(60):
        frames.say(chance.randbytes(20) + b"\xa5\x5a" + frames.command(500 + k))
    for _ in range(6):
        outputs = frames.say(frames.command(-500))
    assert outputs.throttles == (code_volts(2244),)
    frames.say()
    errors = dict(zip(messages.ERRORS, frames.states[-1].errors, strict=True))
    assert errors["garbage"] > 1000
    assert errors["bad header"] >= 59
    assert errors["overrun"] == 0


@pytest.mark.parametrize("line_speed", [9600, FRAMES])
def test_random_bytes_never_enable_an_output(make_device: MakeDevice, line_speed: int) -> None:
    chance = random.Random(line_speed)
    device = make_device(line_speed=line_speed)
    for _ in range(100):
        outputs = device.advance(0.02, inputs(device), chance.randbytes(chance.randrange(line_speed // 600)))
        assert outputs.throttles == (0.0,)


def test_after_a_second_of_silence_the_device_listens_for_text_again(frames: Frames) -> None:
    frames.drive(1500)
    frames.say(b"", 1.1)
    frames.device.line_speed = 9600
    host = Text(frames.device)
    for _ in range(3):
        outputs = host.say(b"128\n")
    assert len(host.readings) == 3
    assert outputs.throttles == (code_volts(2048),)


def test_both_devices_do_the_same_in_a_long_random_session(request: pytest.FixtureRequest) -> None:
    emulator, firmware = request.getfixturevalue("build")(3, 5)
    chance = random.Random(6)
    with SimavrDevice(emulator, firmware, thrusters=3, loads=5, line_speed=FRAMES) as processor:
        hosts = [Frames(EmulatedDevice(thrusters=3, loads=5, line_speed=FRAMES)), Frames(processor)]
        for host in hosts:
            host.connect()
        for step in range(400):
            kind = chance.random()
            throttles = tuple(chance.choice([0, chance.randrange(-5000, 5001)]) for _ in range(3))
            enabled = tuple(chance.random() < 0.9 for _ in range(3))
            payload = messages.Command(throttles=throttles, enabled=enabled).payload()
            pause = chance.choice([0.05, 0.15, 0.19, 0.23, 0.4])
            did = []
            for host in hosts:
                if kind < 0.9:
                    did.append(host.say(host.frame(messages.COMMAND, payload)))
                elif kind < 0.95:
                    did.append(host.say(host.frame(messages.STOP)))
                else:
                    did.append(host.say(b"", pause))
            assert (did[0].throttles, did[0].enabled) == (did[1].throttles, did[1].enabled), f"step {step}"
        for host in hosts:
            host.say()
        python, compiled = (host.states[-1] for host in hosts)
        assert python.errors[3:] == compiled.errors[3:]
