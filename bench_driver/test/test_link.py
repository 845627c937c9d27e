"""The session with a device, both protocols: order of states, zero first, every way to zero, what is sent."""

import math

import pytest
from bench_rig import DIALECTS, IDLE, Rig

from bench_driver import framed_messages as messages
from bench_driver.errors import OutOfRange
from bench_driver.framed_dialect import FramedDialect
from bench_driver.framed_protocol import FrameDecoder
from bench_driver.link import Link
from bench_driver.link_records import LinkLimits, LinkState
from bench_driver.text_dialect import TextDialect

ZERO = 0.02  # V; count 128 is half a step off


@pytest.fixture(params=list(DIALECTS))
def rig(request: pytest.FixtureRequest) -> Rig:
    return Rig(DIALECTS[request.param]())


def throttles_sent(rig: Rig) -> list[int]:
    """Return the counts or millivolts sent, oldest first."""
    data = b"".join(piece for _, piece in rig.sent)
    if isinstance(rig.dialect, TextDialect):
        return [int(line) for line in data.split()]
    frames = FrameDecoder(messages.TO_DEVICE).feed(data)
    commands = [messages.command(frame.payload) for frame in frames if frame.type == messages.COMMAND]
    return [command.throttles[0] for command in commands if command is not None]


def test_making_a_link_orders_nothing_but_to_open_the_port() -> None:
    link = Link(TextDialect())
    assert link.state is LinkState.ABSENT
    orders = link.poll(0.0)
    assert (orders.open, orders.close, orders.data) == (True, False, b"")
    assert link.poll(0.0).data == b""


def test_zero_is_sent_first_and_throttles_only_once_the_device_answered(rig: Rig) -> None:
    rig.throttle = 2.0
    rig.until(LinkState.READY)
    zero = 128 if isinstance(rig.dialect, TextDialect) else 0
    assert set(throttles_sent(rig)[:-1]) == {zero}  # the last may have gone out when the link became ready
    assert max(map(abs, rig.seen[:-1])) <= ZERO
    assert len(rig.measured) >= 5
    rig.run(0.2)
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)


def test_nothing_is_sent_while_the_boot_loader_may_listen() -> None:
    rig = Rig(TextDialect(), limits=LinkLimits(quiet=2.0))
    rig.until(LinkState.READY)
    assert rig.sent[0][0] - rig.opened_at[0] == pytest.approx(2.0)


def test_commands_go_out_once_in_a_period(rig: Rig) -> None:
    rig.drive()
    rig.sent.clear()
    rig.run(2.0)
    assert len(rig.sent) == pytest.approx(2.0 / rig.dialect.period, abs=1)


def test_a_command_older_than_200_ms_becomes_zero(rig: Rig) -> None:
    rig.drive()
    rig.throttle = None
    rig.run(0.17)
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)
    rig.run(0.1)
    assert abs(rig.seen[-1]) <= ZERO
    assert rig.link.sent is not None
    assert rig.link.sent.reason == "the command is too old"
    assert rig.link.state is LinkState.READY
    rig.throttle = 2.0
    rig.run(0.15)
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize(
    ("age", "value", "reason"),
    [
        (0.0, math.nan, "not a number"),
        (0.0, math.inf, "not a number"),
        (-1.0, 2.0, "from the future"),
        (0.3, 2.0, "too old"),
        (math.nan, 2.0, "too old"),
    ],
)
def test_a_command_that_cannot_be_believed_becomes_zero(rig: Rig, age: float, value: float, reason: str) -> None:
    rig.drive()
    rig.throttle = None
    for _ in range(20):
        rig.link.command(rig.now - age, [value])
        rig.step()
    assert abs(rig.seen[-1]) <= ZERO
    assert rig.link.sent is not None and reason in rig.link.sent.reason


def test_a_throttle_beyond_the_limit_is_clipped_and_counted(rig: Rig) -> None:
    rig.drive(4.9 if rig.limits.throttle > 3 else 3.0)
    rig.throttle = -4.9
    rig.run(0.5)
    assert rig.seen[-1] == pytest.approx(-3.0, abs=0.02)
    assert rig.link.counters["clipped"] >= 10
    assert "throttles clipped" in rig.diagnosis.diagnose(rig.now).sentence


def test_the_throttle_changes_by_at_most_100_volts_a_second(rig: Rig) -> None:
    rig.drive(3.0)
    rig.seen.clear()
    rig.throttle = -3.0
    rig.run(0.5)
    steps = [abs(b - a) for a, b in zip([3.0, *rig.seen], rig.seen, strict=False)]
    assert max(steps) <= 100.0 * rig.dialect.period + 0.05
    assert rig.seen[-1] == pytest.approx(-3.0, abs=0.02)


def test_what_was_sent_is_told_after_quantisation(rig: Rig) -> None:
    rig.drive(1.2345)
    assert rig.link.sent is not None
    assert rig.link.sent.commanded == (1.2345,)
    assert rig.link.sent.throttles == (rig.seen[-1],)
    assert rig.link.sent.throttles != (1.2345,)


def test_a_stop_sends_zero_and_the_end_and_nothing_afterwards(rig: Rig) -> None:
    rig.drive()
    data = rig.link.stop(rig.now)
    if isinstance(rig.dialect, TextDialect):
        assert data == b"128\n-99\n"
    rig._advance(data)
    rig._advance(b"")
    assert (rig.seen[-1], rig.device.advance(0.01, IDLE).enabled) == (0.0, (False,))
    orders = rig.link.poll(rig.now)
    assert (orders.open, orders.close, orders.data) == (False, True, b"")
    for _ in range(300):
        rig.now += 0.1
        orders = rig.link.poll(rig.now)
        assert (orders.open, orders.close, orders.data) == (False, False, b"")


def test_a_link_that_was_not_polled_for_long_begins_with_zero_again(rig: Rig) -> None:
    rig.drive()
    for _ in range(30):
        rig._advance(b"")  # the program hangs, the device's watchdog acts
    assert abs(rig.seen[-1]) <= ZERO
    rig.sent.clear()
    rig.run(0.5)
    zero = 128 if isinstance(rig.dialect, TextDialect) else 0
    assert throttles_sent(rig)[0] == zero
    assert rig.seen[-1] == pytest.approx(2.0, abs=0.02)


def test_the_wait_between_attempts_doubles_up_to_five_seconds(rig: Rig) -> None:
    rig.present = False
    rig.run(25.0)
    waits = [b - a for a, b in zip(rig.opened_at, rig.opened_at[1:], strict=False)]
    assert waits == pytest.approx([0.5, 1.0, 2.0, 4.0, 5.0, 5.0, 5.0], abs=0.021)


def test_a_device_that_is_not_the_one_expected_is_never_driven() -> None:
    two = FramedDialect(thrusters=2)
    rig = Rig(two)
    for _ in range(800):
        rig.step()
        assert rig.seen[-1] == 0.0
    assert rig.link.counters["gave up"] >= 1
    assert not rig.measured
    assert "1 thrusters" in two.refusal and "expected 2" in two.refusal


def test_limits_and_commands_that_cannot_be_are_refused() -> None:
    with pytest.raises(OutOfRange, match="limit of the throttle"):
        LinkLimits(throttle=6.0)
    with pytest.raises(OutOfRange, match="stale of the link"):
        LinkLimits(stale=math.nan)
    with pytest.raises(OutOfRange, match="number of throttles"):
        Link(TextDialect()).command(0.0, [1.0, 2.0])
