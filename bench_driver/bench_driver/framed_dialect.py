"""The framed protocol behind the link's face, see `dialect`."""

from collections.abc import Callable, Sequence

from bench_driver import framed_messages as messages
from bench_driver import framed_protocol, text_protocol
from bench_driver.converter import LARGEST_CODE, code_from_millivolts, code_volts, millivolts
from bench_driver.device_clock import Clock, DeviceClock
from bench_driver.dialect import BITS_PER_BYTE, Measurement, added
from bench_driver.framed_protocol import Frame, FrameDecoder

__all__ = ["FramedDialect"]

_DEVICE_ERRORS = tuple(f"device: {name}" for name in messages.ERRORS)


class FramedDialect:
    """The framed protocol, see `Dialect`.

    Args:
        thrusters: how many the device is expected to have.
        clock: makes what stamps the states, anew whenever the port is opened.
    """

    line_speed = framed_protocol.BAUD
    period = 1 / framed_protocol.RATE

    def __init__(self, *, thrusters: int = 1, clock: Callable[[], Clock] = DeviceClock) -> None:
        self.thrusters = thrusters
        self._make_clock = clock
        self.resets = 0
        self.refusal = ""
        self.device = ""
        self._sequence = 0
        self._before: dict[str, int] = {}
        self._listen()

    @property
    def armed(self) -> bool:
        """Return whether the device said what it is and all its outputs are enabled."""
        return self._hello is not None and self._enabled

    @property
    def faults(self) -> dict[str, int]:
        """Return how often each fault of the stream has happened since the dialect was made."""
        decoder = self._decoder
        own = {**decoder.rejected, "sequence jump": decoder.jumps, "lost frame": decoder.lost, **self._contradictions}
        return added(self._before, {**own, **self._device_errors})

    @property
    def waiting(self) -> int:
        """Return the number of bytes of a frame that is not whole yet."""
        return self._decoder.waiting

    def start(self) -> None:
        """Forget the stream: the port was opened."""
        self._before = self.faults
        self._listen()

    def _listen(self) -> None:
        self._decoder = FrameDecoder(messages.FROM_DEVICE)
        self._contradictions = {"contradictory state": 0}
        self._device_errors = dict.fromkeys(_DEVICE_ERRORS, 0)
        self._last_errors: tuple[int, ...] | None = None
        self._clock = self._make_clock()
        self._hello: messages.Hello | None = None
        self._enabled = False

    def zero(self, now: float, *, enable: bool) -> bytes:
        """Return a command of zeros, and the question what the device is while that is not known."""
        ask = b"" if self._hello else self._frame(now, messages.ASK_HELLO)
        nothing = (0,) * self.thrusters
        return ask + self._command(now, nothing, enable=enable and self._hello is not None and not self.refusal)

    def throttle(self, now: float, throttles: Sequence[float]) -> bytes:
        """Return the command that sets the throttles [V]."""
        return self._command(now, tuple(_millivolts(u) for u in throttles), enable=True)

    def quantised(self, throttles: Sequence[float]) -> tuple[float, ...]:
        """Return what the throttles [V] become in the device."""
        return tuple(code_volts(code_from_millivolts(_millivolts(u))) for u in throttles)

    def ending(self, now: float) -> bytes:
        """Return a command of zeros that disables, and a stop."""
        return self._command(now, (0,) * self.thrusters, enable=False) + self._frame(now, messages.STOP)

    def feed(self, now: float, data: bytes) -> list[Measurement]:
        """Return the states, stamped by the device's clock."""
        found = []
        for frame in self._decoder.feed(data):
            on_line = (framed_protocol.OVERHEAD + len(frame.payload)) * BITS_PER_BYTE / self.line_speed
            restarts = self._clock.restarts
            stamp = self._clock.stamp(now, frame.time, on_line=on_line)
            if self._clock.restarts > restarts:
                self.resets += 1
                self._begin_anew()
            if frame.type == messages.HELLO:
                self._meet(frame)
                continue
            state = messages.state(frame.payload)
            if state is None or len(state.enabled) != self.thrusters:
                self._contradictions["contradictory state"] += 1
                continue
            self._count(state.errors)
            self._enabled = all(state.enabled)
            found.append(_measurement(stamp, state))
        return found

    def _meet(self, frame: Frame) -> None:
        hello = messages.hello(frame.payload)
        if self._hello is not None and frame.sequence == 0:
            self._begin_anew()
        self._hello = hello
        self.refusal = ""
        if hello.version != messages.VERSION:
            self.refusal = f"the device speaks version {hello.version}, expected {messages.VERSION}"
        elif (hello.thrusters, hello.largest_code) != (self.thrusters, LARGEST_CODE):
            self.refusal = (
                f"the device has {hello.thrusters} thrusters and largest code {hello.largest_code}, "
                f"expected {self.thrusters} and {LARGEST_CODE}"
            )
        self.device = (
            f"frames, {hello.thrusters} thrusters, {hello.loads} load channels, {hello.rate} Hz; last reset: "
            f"{messages.reset_cause(hello.cause)}"
        )

    def _count(self, errors: tuple[int, ...]) -> None:
        """Add what the device's counters went on by since the first state, not what connecting left behind."""
        for name, old, new in zip(_DEVICE_ERRORS, self._last_errors or errors, errors, strict=True):
            self._device_errors[name] += (new - old) % messages.COUNTER_WRAP
        self._last_errors = errors

    def _begin_anew(self) -> None:
        """Begin a session with a device that did."""
        self._before = self.faults
        self._decoder.rejected.clear()
        self._decoder.jumps = self._decoder.lost = 0
        self._contradictions = {"contradictory state": 0}
        self._device_errors = dict.fromkeys(_DEVICE_ERRORS, 0)
        self._last_errors = None
        self._hello = None
        self._enabled = False

    def _command(self, now: float, throttles: tuple[int, ...], *, enable: bool) -> bytes:
        command = messages.Command(throttles=throttles, enabled=(enable,) * self.thrusters)
        return self._frame(now, messages.COMMAND, command.payload())

    def _frame(self, now: float, kind: int, payload: bytes = b"") -> bytes:
        time = round(1e6 * now) % framed_protocol.CLOCK_WRAP
        frame = Frame(kind, self._sequence, time, payload)
        self._sequence = (self._sequence + 1) % framed_protocol.SEQUENCES
        return framed_protocol.encode(frame)


def _measurement(stamp: float, state: messages.State) -> Measurement:
    return Measurement(
        stamp=stamp, tachometer_counts=state.tachometer_counts, flow_counts=state.flow_counts,
        load_counts=state.load_counts,
        throttles=tuple(code_volts(code) if on else 0.0 for code, on in zip(state.codes, state.enabled, strict=True)),
    )  # fmt: skip


def _millivolts(u: float) -> int:
    return millivolts(u, limit=text_protocol.FULL_SCALE)
