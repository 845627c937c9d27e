"""What the frames carry: throttles to the device, counts and its own errors back.

Host to device: `Command`, and the bare `STOP` (zero and disable), `ASK_HELLO` and `ASK_RESET` (through the hardware
watchdog). Device to host: `Hello` once it speaks this protocol and when asked, `State` 100 times a second.

Throttles travel in whole millivolts. A thruster is enabled only by a command that enables it and sets zero; afterwards
its throttle is free. No valid command for 200 ms, a stop or a reset sets zero and disables all.
"""

from dataclasses import dataclass
from struct import Struct

from bench_driver.converter import LARGEST_CODE, LARGEST_MILLIVOLTS
from bench_driver.errors import OutOfRange

__all__ = [
    "ASK_HELLO", "ASK_RESET", "COMMAND", "COUNTER_WRAP", "ERRORS", "FROM_DEVICE", "HELLO", "MOST_LOADS",
    "MOST_THRUSTERS", "RESET_CAUSES", "STATE", "STOP", "TO_DEVICE", "VERSION", "Command", "Hello", "State",
    "command", "hello", "reset_cause", "state",
]  # fmt: skip

VERSION = 1
"""Version of the messages; another one is refused."""
MOST_THRUSTERS = 8
MOST_LOADS = 6
COMMAND, STOP, ASK_HELLO, ASK_RESET = 0x01, 0x02, 0x03, 0x04
STATE, HELLO = 0x81, 0x83
ERRORS = ("wrong checksum", "garbage", "bad header", "missing command", "overrun", "refused", "watchdog")
"""The device's error counters, in their order in the payload."""
COUNTER_WRAP = 1 << 16
"""The device's error counters start again here."""
RESET_CAUSES = ("power on", "reset line", "brown-out", "watchdog", "debugger")
"""What the bits 0 to 4 of the reset cause mean."""

_STATE = Struct("<BBHH7HB")
_HELLO = Struct("<BBBBHHH")
_LARGEST_INPUT_COUNT = 1023

TO_DEVICE: dict[int, frozenset[int]] = {
    COMMAND: frozenset(1 + 2 * n for n in range(1, MOST_THRUSTERS + 1)),
    STOP: frozenset({0}),
    ASK_HELLO: frozenset({0}),
    ASK_RESET: frozenset({0}),
}
"""Lengths of the payloads that the device accepts, by type."""
FROM_DEVICE: dict[int, frozenset[int]] = {
    STATE: frozenset(
        _STATE.size + 6 * n + 2 * loads for n in range(1, MOST_THRUSTERS + 1) for loads in range(MOST_LOADS + 1)
    )
    & frozenset(range(_STATE.size + 6 * MOST_THRUSTERS + 1)),
    HELLO: frozenset({_HELLO.size}),
}
"""Lengths of the payloads that the host accepts, by type."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Command:
    """Throttles of all thrusters.

    Attributes:
        throttles: [mV], one for each thruster of the device.
        enabled: which thrusters are to be driven; the others are held at zero.
    """

    throttles: tuple[int, ...]
    enabled: tuple[bool, ...]

    def __post_init__(self) -> None:
        n = len(self.throttles)
        if not 1 <= n <= MOST_THRUSTERS or len(self.enabled) != n:
            raise OutOfRange("command", f"as many flags as throttles, 1 to {MOST_THRUSTERS}", (n, len(self.enabled)))
        for throttle in self.throttles:
            if not abs(throttle) <= LARGEST_MILLIVOLTS:
                raise OutOfRange("throttle [mV]", f"a magnitude of at most {LARGEST_MILLIVOLTS}", throttle)

    def payload(self) -> bytes:
        """Return the payload."""
        return Struct(f"<B{len(self.throttles)}h").pack(_bits(self.enabled), *self.throttles)


def command(payload: bytes) -> Command | None:
    """Return the command in a payload, None if a throttle is out of range."""
    n = (len(payload) - 1) // 2
    flags, *throttles = Struct(f"<B{n}h").unpack(payload)
    if flags >> n or any(abs(throttle) > LARGEST_MILLIVOLTS for throttle in throttles):
        return None
    return Command(throttles=tuple(throttles), enabled=_flags(flags, n))


@dataclass(frozen=True, kw_only=True, slots=True)
class State:
    """Measurements of the device, taken at the frame's time stamp.

    Attributes:
        enabled: which thrusters are driven.
        watchdog: commands are missing, all outputs are zero.
        echo: sequence number of the last valid frame from the host.
        age: time since then [ms], 65535 if longer or never.
        errors: the device's counters, in the order of `ERRORS`.
        tachometer_counts, flow_counts: 10-bit counts of each thruster.
        codes: the code that each converter stands at.
        load_counts: 10-bit counts of the load cell's channels.
    """

    enabled: tuple[bool, ...]
    watchdog: bool
    echo: int
    age: int
    errors: tuple[int, ...]
    tachometer_counts: tuple[int, ...]
    flow_counts: tuple[int, ...]
    codes: tuple[int, ...]
    load_counts: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.enabled)
        if not 1 <= n <= MOST_THRUSTERS or {len(self.tachometer_counts), len(self.flow_counts), len(self.codes)} != {n}:
            raise OutOfRange("state", f"the same number of flags and counts, 1 to {MOST_THRUSTERS}", n)
        if len(self.load_counts) > MOST_LOADS or len(self.errors) != len(ERRORS):
            raise OutOfRange("state", f"at most {MOST_LOADS} loads, {len(ERRORS)} counters", len(self.load_counts))
        for count in (*self.tachometer_counts, *self.flow_counts, *self.load_counts):
            if not 0 <= count <= _LARGEST_INPUT_COUNT:
                raise OutOfRange("count of an input", f"0 to {_LARGEST_INPUT_COUNT}", count)
        for code in self.codes:
            if not 0 <= code <= LARGEST_CODE:
                raise OutOfRange("code of the converter", f"0 to {LARGEST_CODE}", code)

    def payload(self) -> bytes:
        """Return the payload."""
        sizes = len(self.enabled) | len(self.load_counts) << 4
        head = _STATE.pack(_bits(self.enabled), self.watchdog, self.echo, self.age, *self.errors, sizes)
        counts = (*self.tachometer_counts, *self.flow_counts, *self.codes, *self.load_counts)
        return head + Struct(f"<{len(counts)}H").pack(*counts)


def state(payload: bytes) -> State | None:
    """Return the state in a payload, None if it contradicts itself or a count is out of range."""
    flags, watchdog, echo, age, *errors, sizes = _STATE.unpack_from(payload)
    n, loads = sizes & 0x0F, sizes >> 4
    if len(payload) != _STATE.size + 6 * n + 2 * loads or flags >> n:
        return None
    counts = Struct(f"<{3 * n + loads}H").unpack_from(payload, _STATE.size)
    try:
        return State(
            enabled=_flags(flags, n), watchdog=bool(watchdog & 1), echo=echo, age=age, errors=tuple(errors),
            tachometer_counts=counts[:n], flow_counts=counts[n : 2 * n], codes=counts[2 * n : 3 * n],
            load_counts=counts[3 * n :],
        )  # fmt: skip
    except OutOfRange:
        return None


@dataclass(frozen=True, kw_only=True, slots=True)
class Hello:
    """What the device is.

    Attributes:
        version: version of the messages.
        cause: bits of the last reset, see `reset_cause`.
        thrusters, loads: channels of the device.
        rate: states a second [Hz].
        watchdog: time without a command after which all outputs go to zero [ms].
        largest_code: code of −5 V.
    """

    version: int
    cause: int
    thrusters: int
    loads: int
    rate: int
    watchdog: int
    largest_code: int

    def payload(self) -> bytes:
        """Return the payload."""
        return _HELLO.pack(
            self.version, self.cause, self.thrusters, self.loads, self.rate, self.watchdog, self.largest_code
        )


def hello(payload: bytes) -> Hello:
    """Return what a payload says of the device."""
    version, cause, thrusters, loads, rate, watchdog, largest_code = _HELLO.unpack(payload)
    return Hello(
        version=version, cause=cause, thrusters=thrusters, loads=loads, rate=rate, watchdog=watchdog,
        largest_code=largest_code,
    )  # fmt: skip


def reset_cause(cause: int) -> str:
    """Return the bits of a reset's cause in words."""
    return ", ".join(name for bit, name in enumerate(RESET_CAUSES) if cause >> bit & 1) or "not told"


def _bits(flags: tuple[bool, ...]) -> int:
    return sum(1 << i for i, flag in enumerate(flags) if flag)


def _flags(bits: int, n: int) -> tuple[bool, ...]:
    return tuple(bool(bits >> i & 1) for i in range(n))
