"""A bench that speaks both protocols like the firmware: bytes and time in, bytes and throttles out, no port, no clock.

Which protocol. After a reset the device listens at 9600 baud for text. Bytes that no text has, while no count came for
a second, make it listen at 115200 baud for 300 ms; the first valid frame in that time makes it speak frames, until none
came for a second. So one device serves either host, a text session is not disturbed by garbage, and a device that was
reset finds back to its host.

Text: each count is answered by one reading. Count 128 has to come first, others are neither obeyed nor answered before;
200 ms without a count set count 128; -99 sets zero, disables, and is final until the line was silent for a second.
Frames: see `framed_messages`.

Bytes take their time on the line, at ten bits each.
"""

from collections import deque

from bench_driver import framed_messages as messages
from bench_driver.converter import LARGEST_CODE
from bench_driver.device import Inputs, Outputs
from bench_driver.emulated_output import EmulatedOutput
from bench_driver.errors import OutOfRange
from bench_driver.framed_protocol import BAUD as FRAMED_BAUD
from bench_driver.framed_protocol import CLOCK_WRAP, RATE, SEQUENCES, Frame, FrameDecoder, encode
from bench_driver.text_protocol import BAUD as TEXT_BAUD
from bench_driver.text_protocol import CommandDecoder, Reading, encode_reading

__all__ = ["EmulatedDevice"]

_TICK = 1000  # us; as the firmware's timer
_STATE_PERIOD = 1_000_000 // RATE  # us
_WATCHDOG = 200_000  # us
_SESSION = 1_000_000  # us
_PROBE = 300_000  # us
_BITS_PER_BYTE = 10
_TEXT_BYTES = frozenset(b"0123456789-\r\n")
_GARBLED = 0xFF
_POWER_ON, _RESET_LINE, _WATCHDOG_RESET = 1, 2, 8


class EmulatedDevice:
    """A device with its converters, see `Device`.

    Args:
        thrusters: 1 to 8; text drives the first.
        loads: channels of the load cell, 0 to 6; with more than two thrusters, at most 8 − thrusters.
        line_speed: see `Device`.
        boot_time: time after a reset during which the boot loader swallows every byte [s].
    """

    def __init__(
        self, *, thrusters: int = 1, loads: int = 6, line_speed: int = TEXT_BAUD, boot_time: float = 0.0
    ) -> None:
        if not 1 <= thrusters <= messages.MOST_THRUSTERS:
            raise OutOfRange("number of thrusters", f"1 to {messages.MOST_THRUSTERS}", thrusters)
        if not 0 <= loads <= min(messages.MOST_LOADS, 8 - thrusters):
            raise OutOfRange("number of load channels", f"0 to {min(messages.MOST_LOADS, 8 - thrusters)}", loads)
        self.thrusters = thrusters
        self.loads = loads
        self.line_speed = line_speed
        self._boot_time = round(1e6 * boot_time)
        self._now = 0  # us since the start
        self._arriving: deque[tuple[int, int]] = deque()  # (us, byte)
        self._line_free = 0
        self._boot(_POWER_ON)

    def advance(self, period: float, inputs: Inputs, data: bytes = b"") -> Outputs:
        """Let a period [s] pass, during which the host's bytes arrive one after the other."""
        inputs.check(self.thrusters, self.loads)
        self._inputs = inputs
        for byte in data:
            self._line_free = max(self._line_free, self._now) + self._byte_time(self.line_speed)
            self._arriving.append((self._line_free, byte))
        end = self._now + round(1e6 * period)
        while (at := min(self._next_tick, self._arriving[0][0] if self._arriving else end + 1)) <= end:
            self._now = at
            if at < self._ready:
                self._skip(at)
            elif self._arriving and self._arriving[0][0] == at:
                self._receive(self._arriving.popleft()[1])
            else:
                self._next_tick += _TICK
                self._tick()
        self._now = end
        sent = bytearray()
        while self._leaving and self._leaving[0][0] <= end:
            sent.append(self._leaving.popleft()[1])
        return Outputs(throttles=self._output.throttles, enabled=tuple(self._output.enabled), data=bytes(sent))

    def reset(self) -> None:
        """Pull the reset line, as a host does that opens the port."""
        self._boot(_RESET_LINE)

    def _boot(self, cause: int) -> None:
        self._cause = cause
        self._output = EmulatedOutput(self.thrusters)
        self._booted = self._now
        self._ready = self._now + self._boot_time
        self._next_tick = self._now + _TICK
        self._last_byte = self._now
        self._speak_text()

    def _skip(self, at: int) -> None:
        """Let the boot loader swallow what happens at this time."""
        if self._arriving and self._arriving[0][0] == at:
            self._arriving.popleft()
        else:
            self._next_tick += _TICK

    def _open(self, mode: str, speed: int) -> None:
        self._mode = mode
        self._speed = speed
        self._since = self._now
        self._leaving: deque[tuple[int, int]] = deque()
        self._sending_until = self._now

    def _speak_text(self) -> None:
        self._open("text", TEXT_BAUD)
        self._lines = CommandDecoder()
        self._last_count: int | None = None

    def _probe(self) -> None:
        self._open("probe", FRAMED_BAUD)
        self._frames = FrameDecoder(messages.TO_DEVICE)
        self._errors = [0] * len(messages.ERRORS)
        self._host_sequence: int | None = None

    def _speak_frames(self) -> None:
        self._mode = "frames"
        self._output.disable()
        self._sequence = 0
        self._last_command = self._now
        self._missing_commands = False
        self._next_state = self._now + _STATE_PERIOD
        self._send_hello()

    def _receive(self, byte: int) -> None:
        if self._speed != self.line_speed:
            byte = _GARBLED
        self._last_byte = self._now
        if self._mode == "text":
            self._receive_text(byte)
        else:
            for frame in self._frames.feed(bytes([byte])):
                if self._mode != "text":  # a frame before it may have asked for a reset
                    self._handle(frame)

    def _tick(self) -> None:
        if self._mode == "text":
            self._tick_text()
        elif self._mode == "probe":
            if self._now - self._since >= _PROBE:
                self._speak_text()
        elif self._now - self._last_frame >= _SESSION:
            self._output.disable()
            self._speak_text()
        else:
            self._tick_frames()

    # Text

    def _receive_text(self, byte: int) -> None:
        alive = self._last_count is not None and self._now - self._last_count < _SESSION
        if byte not in _TEXT_BYTES and not alive:
            self._probe()
            return
        counts = self._lines.feed(bytes([byte]))
        if self._lines.ended:
            self._output.disable()
        for count in counts:
            self._last_count = self._now
            if self._output.set_count(count):
                reading = Reading(self._inputs.tachometer_counts[0], self._inputs.flow_counts[0])
                self._send(encode_reading(reading))

    def _tick_text(self) -> None:
        if self._lines.ended and self._now - self._last_byte >= _SESSION:
            self._lines = CommandDecoder()
        if self._last_count is not None and self._now - self._last_count >= _WATCHDOG and self._output.enabled[0]:
            self._output.hold_zero_count()

    # Frames

    def _handle(self, frame: Frame) -> None:
        if self._mode == "probe":
            self._speak_frames()
        self._last_frame = self._now
        if self._host_sequence is not None:
            step = (frame.sequence - self._host_sequence) % SEQUENCES
            self._count("missing command", step - 1 if 1 < step < SEQUENCES // 2 else 0)
        self._host_sequence = frame.sequence
        if frame.type == messages.COMMAND:
            command = messages.command(frame.payload)
            if command is None or len(command.throttles) != self.thrusters:
                self._count("refused", 1)
                return
            self._last_command = self._now
            self._missing_commands = False
            self._count("refused", self._output.set_command(command))
        elif frame.type == messages.STOP:
            self._output.disable()
        elif frame.type == messages.ASK_HELLO:
            self._send_hello()
        elif frame.type == messages.ASK_RESET:
            self._boot(_WATCHDOG_RESET)

    def _tick_frames(self) -> None:
        if self._now - self._last_command >= _WATCHDOG and not self._missing_commands:
            self._missing_commands = True
            self._count("watchdog", 1)
            self._output.disable()
        if self._now >= self._next_state:
            self._next_state += _STATE_PERIOD
            self._send_frame(messages.STATE, self._state().payload())

    def _state(self) -> messages.State:
        errors = dict(zip(messages.ERRORS, self._errors, strict=True))
        for name, count in self._frames.rejected.items():
            errors[name] = (errors[name] + count) % SEQUENCES
        return messages.State(
            enabled=tuple(self._output.enabled), watchdog=self._missing_commands, echo=self._host_sequence or 0,
            age=min((self._now - self._last_frame) // 1000, SEQUENCES - 1),
            errors=tuple(errors[name] for name in messages.ERRORS),
            tachometer_counts=self._inputs.tachometer_counts, flow_counts=self._inputs.flow_counts,
            codes=tuple(self._output.codes), load_counts=self._inputs.load_counts,
        )  # fmt: skip

    def _send_hello(self) -> None:
        hello = messages.Hello(
            version=messages.VERSION, cause=self._cause, thrusters=self.thrusters, loads=self.loads, rate=RATE,
            watchdog=_WATCHDOG // 1000, largest_code=LARGEST_CODE,
        )  # fmt: skip
        self._send_frame(messages.HELLO, hello.payload())

    def _send_frame(self, kind: int, payload: bytes) -> None:
        self._send(encode(Frame(kind, self._sequence, (self._now - self._booted) % CLOCK_WRAP, payload)))
        self._sequence = (self._sequence + 1) % SEQUENCES

    def _count(self, name: str, more: int) -> None:
        i = messages.ERRORS.index(name)
        self._errors[i] = (self._errors[i] + more) % SEQUENCES

    def _send(self, data: bytes) -> None:
        for byte in data:
            self._sending_until = max(self._sending_until, self._now) + self._byte_time(self._speed)
            self._leaving.append((self._sending_until, byte if self._speed == self.line_speed else _GARBLED))

    @staticmethod
    def _byte_time(speed: int) -> int:
        return round(1e6 * _BITS_PER_BYTE / speed)
