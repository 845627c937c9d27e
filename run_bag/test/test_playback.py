"""Timelines, their timing and lockstep, without a graph and with a clock of our own."""

import threading
import time
from pathlib import Path

import numpy as np
import pytest

from run_bag import EmptyRunError, InvalidRunError, Topic, write_run
from run_bag.arrivals import Arrivals
from run_bag.errors import MissingParticipantError
from run_bag.finishing import finish
from run_bag.journal import Journal
from run_bag.loss import LossCounter
from run_bag.playback import Lockstep, Played, participants, play, with_ticks
from run_bag.rosbag2 import TopicRecord
from run_bag.selection import Selection
from run_bag.stamps import header_stamp
from run_bag.timeline import Instant, Timeline, read_timeline

SECOND = 10**9
ALL = Selection([".*"])


def run_of(path: Path, **stamps: list[float]) -> Path:
    """Write a run with a ThrustSetpoint topic for each keyword, stamped at these seconds."""
    topics = [
        Topic(
            name=name,
            type="thruster_msgs/ThrustSetpoint",
            stamps=np.array([round(s * SECOND) for s in times]),
            fields={"thrust": np.array(times)},
        )
        for name, times in stamps.items()
    ]
    return write_run(path, topics)


def told(timeline: Timeline) -> list[tuple[float, list[str]]]:
    """Return (seconds, names of topics) of each instant."""
    return [(i.time / SECOND, [timeline.topics[k].name for k, _ in i.messages]) for i in timeline.instants()]


def test_messages_of_one_time_are_one_instant_in_the_order_of_topics(tmp_path: Path) -> None:
    path = run_of(tmp_path / "r", c=[1.5], b=[1.0, 1.5], a=[1.0 + 1e-9, 2.0])
    timeline = read_timeline(path, ALL)
    assert told(timeline) == [(1.0, ["/b"]), (1.000000001, ["/a"]), (1.5, ["/b", "/c"]), (2.0, ["/a"])]
    assert [header_stamp(p) for p in timeline.payloads] == timeline.times.tolist()


def test_topics_and_times_are_chosen(tmp_path: Path) -> None:
    path = run_of(tmp_path / "r", a=[10.0, 10.5, 11.0, 12.0], b=[10.25], clock=[10.0])
    assert told(read_timeline(path, Selection(["a"]), start=0.5, end=1.0)) == [(10.5, ["/a"]), (11.0, ["/a"])]
    assert len(told(read_timeline(path, ALL))) == 5  # its own /clock is not played
    with pytest.raises(EmptyRunError, match=r"nothing to play from 3 s on; it has 2\.000 s"):
        read_timeline(path, ALL, start=3.0)
    with pytest.raises(EmptyRunError, match="nothing to play"):
        read_timeline(path, Selection(["absent"]))
    with pytest.raises(InvalidRunError, match="expected an end behind the start"):
        read_timeline(path, ALL, start=3.0, end=2.0)


def test_a_run_is_ordered_by_log_or_by_stamp(tmp_path: Path) -> None:
    source = read_timeline(run_of(tmp_path / "r", a=[1.0, 2.0]), ALL)
    journal = Journal(tmp_path / "late", {})
    channel = journal.add_topic(TopicRecord(name="/a", type="thruster_msgs/msg/ThrustSetpoint"))
    for payload, log in zip(source.payloads, (7 * SECOND, 8 * SECOND), strict=True):
        journal.add(channel, payload, log_time=log, publish_time=log)
    unstamped = bytes(4) + bytes(8) + source.payloads[0][12:]
    journal.add(channel, b"\0\1\0\0" + unstamped[4:], log_time=9 * SECOND, publish_time=0)
    journal.close()
    finish(tmp_path / "late")
    assert read_timeline(tmp_path / "late", ALL, order="log").times.tolist() == [7 * SECOND, 8 * SECOND, 9 * SECOND]
    assert read_timeline(tmp_path / "late", ALL, order="stamp").times.tolist() == [SECOND, 2 * SECOND, 9 * SECOND]


class FakeClock:
    """Time that passes in waits alone, each of which lasts too long by `error` [s]."""

    def __init__(self, error: float) -> None:
        self.now, self.error = 100.0, error

    def sleep(self, seconds: float) -> bool:
        self.now += seconds + self.error if seconds else 0.0
        return False


@pytest.mark.parametrize("rate", [0.5, 1.0, 20.0])
def test_errors_of_single_waits_do_not_add_up(rate: float) -> None:
    clock, at = FakeClock(1e-4), []
    instants = [Instant(5 * SECOND + i * 10**7, [(0, b"")]) for i in range(2000)]
    played = play(instants, lambda _: at.append(clock.now), rate=rate, monotonic=lambda: clock.now, sleep=clock.sleep)
    late = np.array(at) - 100.0 - np.arange(2000) * 0.01 / rate
    assert late.min() >= -1e-9 and late.max() <= 1.0001e-4 and abs(late[-1]) <= 1.0001e-4
    assert played.messages == 2000 and played.latest == pytest.approx(1e-4, abs=1e-8)


def test_what_is_late_is_published_at_once_and_nothing_is_left_out() -> None:
    clock, at = FakeClock(0.0), []

    def slow(instant: Instant) -> None:
        at.append(clock.now - 100.0)
        clock.now += 0.25 if len(at) == 1 else 0.0

    instants = [Instant(i * SECOND // 10, [(0, b"")]) for i in range(5)]
    played = play(instants, slow, rate=1.0, monotonic=lambda: clock.now, sleep=clock.sleep)
    assert at == pytest.approx([0.0, 0.25, 0.25, 0.3, 0.4])
    assert played == Played(5, pytest.approx(0.15))


def test_playing_ends_when_it_is_stopped() -> None:
    published: list[int] = []
    instants = [Instant(i, [(0, b"")]) for i in range(10)]
    for rate in (None, 1.0):
        published.clear()
        play(
            instants,
            lambda i: published.append(i.time),
            rate=rate,
            monotonic=lambda: 0.0,
            sleep=lambda _: len(published) == 3,
        )
        assert published == [0, 1, 2]


def test_a_clock_ticks_evenly_between_instants() -> None:
    instants = [Instant(t, [(0, b"")]) for t in (100, 103, 130, 131)]
    assert [i.time for i in with_ticks(instants, 10)] == [100, 103, 110, 120, 130, 131]
    assert [i.time for i in with_ticks(instants, 0)] == [100, 103, 130, 131]
    assert [len(i.messages) for i in with_ticks(instants, 10)] == [1, 1, 0, 0, 1, 1]


def test_participants_are_given_with_the_inputs_that_they_answer() -> None:
    assert participants(["/a", "b:c,/d"]) == {"/a": None, "/b": frozenset({"/c", "/d"})}
    for wrong in ("a:", ":a", ""):
        with pytest.raises(InvalidRunError, match="expected OUTPUT or OUTPUT:INPUT,INPUT"):
            participants([wrong])


def test_lockstep_names_everyone_who_is_missing_and_no_one_else() -> None:
    lockstep = Lockstep(participants(["a", "b", "c:x"]), timeout=0.01)
    lockstep.arrived("/a", 2 * SECOND)
    lockstep.arrived("/b", 1 * SECOND)
    lockstep.wait(1 * SECOND, {"/y"}, lambda: False)  # c does not answer y
    with pytest.raises(
        MissingParticipantError, match=r"no message stamped 2.000000000 s within 0.01 s on /b, /c$"
    ) as e:
        lockstep.wait(2 * SECOND, {"/x"}, lambda: False)
    assert e.value.found == ("/b", "/c")
    lockstep.wait(3 * SECOND, set(), lambda: False)  # nothing was asked
    lockstep.again()
    with pytest.raises(MissingParticipantError, match="/a, /b"):
        lockstep.wait(1 * SECOND, {"/y"}, lambda: False)


def test_lockstep_goes_on_as_soon_as_the_answer_is_there_or_the_player_is_stopped() -> None:
    lockstep = Lockstep(participants(["a"]), timeout=60.0)
    stop = threading.Event()
    begin = time.monotonic()
    timer = threading.Timer(0.05, lockstep.arrived, ("/a", 5))
    timer.start()
    lockstep.wait(5, {"/x"}, stop.is_set)

    def halt() -> None:
        stop.set()
        lockstep.wake()

    timer = threading.Timer(0.05, halt)
    timer.start()
    lockstep.wait(6, {"/x"}, stop.is_set)
    assert time.monotonic() - begin < 10.0


def test_arrivals_are_complete_up_to_the_slowest_topic() -> None:
    arrivals = Arrivals(["a", "b"])
    assert arrivals.complete == -1 and not arrivals.arrived("a", 5) and arrivals.complete == -1
    assert arrivals.arrived("b", 3) and arrivals.complete == 3 and arrivals.missing(4) == ("b",)
    assert not arrivals.arrived("b", 2)  # out of order
    assert arrivals.arrived("b", 9) and arrivals.complete == 5


@pytest.mark.parametrize(
    ("publishers", "numbers", "lost"),
    [
        (1, [1, 2, 3], 0),
        (1, [7, 8, 9], 0),  # what was sent before we came is no loss
        (1, [1, 2, 5, 6, 10], 5),
        (1, [1, 2, 3, 1, 2, 3], 0),  # started again
        (2, [1, 1, 2, 2, 3, 3], 0),
        (2, [100, 7, 101, 8, 9, 102], 0),
        (2, [100, 7, 101, 12, 103], 5),
        (2, [7, 100, 8, 101], 0),
    ],
)
def test_gaps_in_the_numbers_of_publishers_are_losses(publishers: int, numbers: list[int], lost: int) -> None:
    counter = LossCounter(lambda: publishers)
    assert sum(counter.arrived(n) for n in numbers) == counter.lost == lost


@pytest.mark.parametrize(
    ("patterns", "exclude", "fitting", "others"),
    [
        (["a"], [], ["/a"], ["/ab", "/a/b", "/b"]),
        (["/a/.*", "b"], [], ["/a/b", "/a/b/c", "/b"], ["/a", "/x/a/b"]),
        ([".*"], ["a", ".*/raw"], ["/b"], ["/a", "/b/raw", "/_hidden", "/b/_action/status"]),
        (["_hidden"], [], ["/_hidden"], []),
    ],
)
def test_topics_are_chosen_by_whole_names(
    patterns: list[str], exclude: list[str], fitting: list[str], others: list[str]
) -> None:
    selection = Selection(patterns, exclude)
    assert all(name in selection for name in fitting)
    assert not any(name in selection for name in others)
