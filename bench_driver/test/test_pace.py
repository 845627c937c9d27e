"""The driver's two paces on a line inside the test: in lockstep with a clock, and by a clock that the test moves."""

import math

import pytest
from fake_line import FakeLine

from bench_driver.driver_settings import DriverSettings
from bench_driver.link import Link
from bench_driver.link_records import LinkLimits, LinkState, Sent
from bench_driver.pace_io import LockstepPace, RealTimePace

PERIODS = {"text": 40_000_000, "frames": 10_000_000}  # ns
SPEEDS = {"text": 9600, "frames": 115200}
SECOND = 1_000_000_000


class Lockstep:
    """A driver's pace, a device and the plant's tick; answers each state with a throttle."""

    def __init__(self, protocol: str) -> None:
        self.settings = DriverSettings(port="fake", protocol=protocol, lockstep=True, limits=LinkLimits(quiet=0.0))  # type: ignore[arg-type]
        self.line, self.wall, self.tick_length = FakeLine(SPEEDS[protocol]), 0.0, PERIODS[protocol]
        self.link = Link(self.settings.dialect(), self.settings.limits)
        self.pace = LockstepPace(self.settings, self.link, lambda: self.wall, self.line.open)
        self.now = 0
        self.throttle: float | None = 2.0
        self.states: list[int] = []
        self.told: list[tuple[int, Sent | None]] = []

    def tick(self) -> None:
        """Let a period pass as the emulated bench does; wait as long as the pace does."""
        self.line.advance(1e-9 * self.tick_length)
        self.now += self.tick_length
        self.told += self.pace.tick(self.now)
        words = len(self.told)
        for _ in range(100):
            for stamp, _found in self.pace.read():
                self.states.append(stamp)
                if self.throttle is not None:
                    self.pace.command(stamp, 0, self.throttle)
            self.told += self.pace.write()
            if len(self.told) > words:
                return
            self.wall += 0.5
        raise AssertionError("the period did not end")

    def until_ready(self) -> None:
        """Let periods pass until the link is ready."""
        for _ in range(200):
            if self.link.state is LinkState.READY:
                return
            self.tick()
        raise AssertionError(self.link.reason)


@pytest.fixture(params=list(PERIODS))
def lockstep(request: pytest.FixtureRequest) -> Lockstep:
    return Lockstep(request.param)


def test_each_tick_ends_with_exactly_one_word_about_what_was_sent(lockstep: Lockstep) -> None:
    for _ in range(100):
        lockstep.tick()
    assert [stamp for stamp, _ in lockstep.told] == [lockstep.tick_length * (i + 1) for i in range(100)]
    assert lockstep.told[0][1] is None, "the port was only opened"
    assert lockstep.told[-1][1] is not None


def test_a_throttle_acts_in_the_period_after_the_state_it_answers_has_arrived(lockstep: Lockstep) -> None:
    lockstep.until_ready()
    for _ in range(3):
        lockstep.tick()
    lockstep.throttle = -1.0
    lockstep.tick()
    assert lockstep.line.throttle == pytest.approx(2.0, abs=0.02), "it has not been sent before the tick"
    for _ in range(4):
        lockstep.tick()
    assert lockstep.line.throttle == pytest.approx(-1.0, abs=0.02)


def test_a_reading_in_text_is_stamped_by_the_tick_that_asked_for_it() -> None:
    lockstep = Lockstep("text")
    lockstep.until_ready()
    lockstep.line.count = 321
    lockstep.states.clear()
    lockstep.tick()
    lockstep.tick()
    assert lockstep.states == [lockstep.now - 80_000_000, lockstep.now - 40_000_000]


def test_a_frame_is_stamped_by_the_devices_clock_which_began_with_the_simulation() -> None:
    lockstep = Lockstep("frames")
    lockstep.until_ready()
    lockstep.states.clear()
    for _ in range(5):
        lockstep.tick()
    ages = [
        tick - stamp
        for tick, stamp in zip(
            range(lockstep.now - 40_000_000, lockstep.now + 1, 10_000_000), lockstep.states, strict=True
        )
    ]
    assert len(set(ages)) == 1, ages
    assert 3_000_000 < ages[0] < 14_000_000, "on the line for 4 ms, read at the next tick"
    assert all(stamp % 1_000_000 == 0 for stamp in lockstep.states), "whole milliseconds, as the device counts"


def test_a_state_without_answer_ends_in_zero_and_is_told(lockstep: Lockstep) -> None:
    lockstep.until_ready()
    for _ in range(3):
        lockstep.tick()
    lockstep.throttle = None
    for _ in range(math.ceil(0.3 * SECOND / lockstep.tick_length)):
        lockstep.tick()
    assert lockstep.pace.unanswered >= 6
    assert "no throttle came" in lockstep.pace.trouble()
    assert lockstep.line.throttle == pytest.approx(0.0, abs=0.021)
    lockstep.throttle = 1.5
    lockstep.tick()
    assert lockstep.pace.trouble() == ""


def test_a_device_that_falls_silent_does_not_stop_time(lockstep: Lockstep) -> None:
    lockstep.until_ready()
    lockstep.line.loses_answers = True
    for _ in range(math.ceil(0.4 * SECOND / lockstep.tick_length)):
        lockstep.tick()
    assert lockstep.link.state is LinkState.SILENT
    assert lockstep.line.throttle == pytest.approx(0.0, abs=0.021)


def test_a_simulation_that_begins_anew_does_not_turn_the_links_time_back(lockstep: Lockstep) -> None:
    lockstep.until_ready()
    before = lockstep.pace.now
    lockstep.now = 0
    lockstep.tick()
    assert lockstep.pace.now == before
    lockstep.tick()
    assert lockstep.pace.now == pytest.approx(before + 1e-9 * lockstep.tick_length)


class RealTime:
    """A pace whose clocks the test moves; the node's clock is 1000 s ahead of the link's."""

    def __init__(self, thrusters: int = 1) -> None:
        protocol = "text" if thrusters == 1 else "frames"
        self.settings = DriverSettings(
            port="fake", protocol=protocol, thrusters=thrusters, limits=LinkLimits(quiet=0.0)
        )  # type: ignore[arg-type]
        self.line, self.now = FakeLine(SPEEDS[protocol]), 50.0
        self.link = Link(self.settings.dialect(), self.settings.limits)
        self.pace = RealTimePace(self.settings, self.link, lambda: self.now, self.stamp, self.line.open)

    def stamp(self) -> int:
        return round(1e9 * (self.now + 1000.0))

    def run(self, time: float, throttle: float | None = None) -> tuple[list[int], list[tuple[int, Sent | None]]]:
        stamps, sent = [], []
        for _ in range(round(time / 0.005)):
            self.line.advance(0.005)
            self.now += 0.005
            if throttle is not None:
                self.pace.command(self.stamp(), 0, throttle)
            stamps += [stamp for stamp, _ in self.pace.read()]
            sent += self.pace.write()
        return stamps, sent


def test_in_real_time_stamps_are_of_the_nodes_clock_and_before_the_arrival() -> None:
    scene = RealTime()
    begun = scene.stamp()
    stamps, sent = scene.run(1.0, 1.0)
    assert len(stamps) >= 20
    assert all(begun < stamp < scene.stamp() for stamp in stamps)
    told = [(stamp, each) for stamp, each in sent if each is not None]
    assert len(told) == len({stamp for stamp, _ in told}) >= 20, "each sending is told once"
    assert told[-1][1].throttles[0] == pytest.approx(1.0, abs=0.02)


def test_readings_that_arrive_together_have_stamps_in_order() -> None:
    scene = RealTime()
    scene.run(0.5)
    scene.line.babble(b"1,2\n3,4\n5,6\n")
    found = scene.pace.read()
    assert [measured.tachometer_counts for _, measured in found][-3:] == [(1,), (3,), (5,)]
    stamps = [stamp for stamp, _ in found]
    assert stamps == sorted(set(stamps))


def test_in_real_time_a_command_is_as_old_as_its_stamp_says() -> None:
    scene = RealTime()
    scene.run(1.0, 1.0)
    assert scene.line.throttle == pytest.approx(1.0, abs=0.02)
    for _ in range(60):  # they come all the time, but are 0.3 s old
        scene.run(0.005)
        scene.pace.command(scene.stamp() - 300_000_000, 0, 1.0)
    assert scene.line.throttle == pytest.approx(0.0, abs=0.021)


def test_nothing_is_commanded_before_every_thruster_has_its_throttle() -> None:
    scene = RealTime(thrusters=2)
    scene.pace.command(scene.stamp(), 0, 1.0)
    assert scene.link._command is None
    scene.pace.command(scene.stamp() + 1, 1, -1.0)
    stamp, throttles = scene.link._command or (math.nan, ())
    assert throttles == (1.0, -1.0)
    assert stamp == pytest.approx(scene.now, abs=1e-6)
