"""The session with a device: when to open the port, what to send now, what to believe. No port, no clock, no protocol.

    absent ──> opening ──> settling ──> ready <──> silent ──> lost
      ^           │            ^          │          │          │
      └───────────┘            └──────────┴──────────┘          └──> opening …

The caller reports what happened (`opened`, `open_failed`, `received`, `unplugged`) and does what `poll` orders; time is
an argument throughout. Zero is sent first, throttles only once the device has answered zeros and is armed; zero is sent
whenever the last command is older than 200 ms, not a number or from the future, while the device is silent or has
started anew, before the port is closed, and by `stop`. Measurements come from received bytes alone.
"""

import math
from collections.abc import Sequence

from bench_driver.dialect import Dialect, Measurement
from bench_driver.errors import OutOfRange
from bench_driver.link_records import LinkLimits, LinkState, Orders, Sent

__all__ = ["Link"]

_ROUNDING = 1e-6  # s; a caller that polls at exact multiples of the period is not early


class Link:
    """One device behind one port.

    Args:
        dialect: the protocol, which the link then owns.
        limits: see `LinkLimits`.

    Attributes:
        state: where the session stands.
        reason: why, in a sentence.
        sent: what was sent last, None before.
        counters: of the session: "opened", "open failed", "unplugged", "silent", "clipped", "stale command", …
        excused: faults of the stream that connecting left behind, up to when the device last became ready.
        last_measurement: when bytes of the last measurement arrived [s], None before the first.
    """

    def __init__(self, dialect: Dialect, limits: LinkLimits | None = None) -> None:
        self.dialect = dialect
        self.limits = limits or LinkLimits()
        self.state = LinkState.ABSENT
        self.reason = "not tried yet"
        self.sent: Sent | None = None
        self.counters: dict[str, int] = {}
        self.excused: dict[str, int] = {}
        self.last_measurement: float | None = None
        self._stopped = self._close_due = False
        self._since = self._retry_at = self._next_send = -math.inf
        self._failures = self._settled = self._resets = 0
        self._nothing = (math.nan,) * dialect.thrusters
        self._zero = (0.0,) * dialect.thrusters
        self._command: tuple[float, tuple[float, ...]] | None = None
        self._last = self._zero  # before quantisation, for the slew rate

    # What happened

    def command(self, stamp: float, throttles: Sequence[float]) -> None:
        """Take a command given at `stamp` [s]: the throttle of each thruster [V]."""
        if len(throttles) != self.dialect.thrusters:
            raise OutOfRange("number of throttles", f"{self.dialect.thrusters}", len(throttles))
        self._command = (stamp, tuple(float(u) for u in throttles))

    def opened(self, now: float) -> None:
        """The port is open."""
        self._count("opened")
        self.dialect.start()
        self.last_measurement = None
        self._next_send = now + self.limits.quiet
        self._settle(now, "the port was opened")

    def open_failed(self, now: float, reason: str) -> None:
        """The port could not be opened."""
        self._count("open failed")
        self._retire(now, LinkState.ABSENT, reason)

    def unplugged(self, now: float, reason: str) -> None:
        """The open port failed."""
        self._count("unplugged")
        self._retire(now, LinkState.LOST, reason)
        self._close_due = True

    def replaced(self, now: float) -> None:
        """Another device is behind the port's name by now: it is opened at once, the silent one given up."""
        self.unplugged(now, "another device is behind the port's name")
        self._retry_at = now

    def received(self, now: float, data: bytes) -> list[Measurement]:
        """Return the measurements that end in bytes which arrived now, oldest first."""
        measurements = self.dialect.feed(now, data)
        if measurements:
            self.last_measurement = now
            self._settled += len(measurements)
            if self.state is LinkState.SILENT:
                self._settle(now, "the device answers again")
        return measurements

    # What to do

    def poll(self, now: float) -> Orders:
        """Return what has to be done now; to be called at least once in a period."""
        if self._close_due:
            self._close_due = False
            return Orders(close=True)
        if self._stopped:
            return Orders()
        if self.state in (LinkState.ABSENT, LinkState.LOST):
            if now < self._retry_at - _ROUNDING:
                return Orders()
            self._enter(now, LinkState.OPENING, "the port is being opened")
            return Orders(open=True)
        if self.state is LinkState.OPENING:
            return Orders()
        if not self._alive(now):
            return Orders(close=True, data=self.dialect.ending(now))
        if now < self._next_send - _ROUNDING:
            return Orders()
        self._next_send += self.dialect.period
        if self._next_send <= now:  # polled too late: the beat begins anew
            self._next_send = now + self.dialect.period
        return Orders(data=self._send(now))

    def stop(self, now: float) -> bytes:
        """Return what sets zero and ends the run; nothing is ordered afterwards but closing the port."""
        is_open = self.state in (LinkState.SETTLING, LinkState.READY, LinkState.SILENT)
        self._stopped = True
        self._close_due = is_open or self.state is LinkState.OPENING or self._close_due
        self._enter(now, LinkState.ABSENT, "the run was ended")
        if not is_open:
            return b""
        self.sent = Sent(stamp=now, commanded=self._nothing, throttles=self._zero, reason="the run was ended")
        return self.dialect.ending(now)

    def _alive(self, now: float) -> bool:
        """Move between settling, ready, silent and lost; return False when lost."""
        limits, dialect = self.limits, self.dialect
        if dialect.resets != self._resets:
            self._resets = dialect.resets
            self._settle(now, "the device was reset")
        quiet_for = now - (self._since if self.last_measurement is None else self.last_measurement)
        if self.state is LinkState.READY:
            if quiet_for > limits.silence:
                self._count("silent")
                self._enter(now, LinkState.SILENT, f"no measurement for {limits.silence:g} s")
            elif not dialect.armed:
                self._settle(now, "the device disabled its outputs")
            elif self.sent is not None and now - self.sent.stamp > limits.stale:
                self._settle(now, f"nothing was sent for {limits.stale:g} s")
        elif self.state is LinkState.SETTLING:
            if dialect.armed and self._settled >= limits.settle_count and quiet_for <= limits.silence:
                self._failures = 0
                self.excused = dict(dialect.faults)
                self._enter(now, LinkState.READY, "the device is ready")
            elif now - self._since > limits.quiet + limits.give_up:
                self._give_up(now, dialect.refusal or f"the device is not ready after {limits.give_up:g} s")
        elif now - self._since > limits.give_up:
            self._give_up(now, f"no measurement for {limits.silence + limits.give_up:g} s")
        return self.state is not LinkState.LOST

    def _give_up(self, now: float, reason: str) -> None:
        self._count("gave up")
        self._retire(now, LinkState.LOST, reason)

    def _send(self, now: float) -> bytes:
        commanded, reason = self._commanded(now)
        if not reason:
            reach = self.limits.slew * self.dialect.period
            bounded = [max(-self.limits.throttle, min(self.limits.throttle, u)) for u in commanded]
            self._count("clipped", sum(a != b for a, b in zip(bounded, commanded, strict=True)))
            self._last = tuple(max(a - reach, min(a + reach, u)) for a, u in zip(self._last, bounded, strict=True))
            data = self.dialect.throttle(now, self._last)
            throttles = self.dialect.quantised(self._last)
        else:
            self._last = throttles = self._zero
            data = self.dialect.zero(now, enable=self.state is not LinkState.SILENT)
        self.sent = Sent(stamp=now, commanded=commanded, throttles=throttles, reason=reason)
        return data

    def _commanded(self, now: float) -> tuple[tuple[float, ...], str]:
        """Return the command in force, and why it must not be sent."""
        if self._command is None:
            return self._nothing, "no command yet"
        stamp, throttles = self._command
        if self.state is not LinkState.READY:
            return throttles, f"the device is {self.state.value}"
        if not now - stamp <= self.limits.stale + _ROUNDING:
            self._count("stale command")
            return throttles, "the command is too old"
        if not stamp - now <= self.limits.future:
            self._count("command from the future")
            return throttles, "the command is from the future"
        if not all(math.isfinite(u) for u in throttles):
            self._count("command not a number")
            return throttles, "the command is not a number"
        return throttles, ""

    def _settle(self, now: float, reason: str) -> None:
        self._settled = 0
        self._enter(now, LinkState.SETTLING, reason)

    def _retire(self, now: float, state: LinkState, reason: str) -> None:
        wait = min(self.limits.retry_first * 2.0 ** min(self._failures, 30), self.limits.retry_longest)
        self._failures += 1
        self._retry_at = now + wait
        self._last = self._zero
        self._enter(now, state, reason)

    def _enter(self, now: float, state: LinkState, reason: str) -> None:
        self.state, self.reason, self._since = state, reason, now

    def _count(self, what: str, more: int = 1) -> None:
        if more:
            self.counters[what] = self.counters.get(what, 0) + more
