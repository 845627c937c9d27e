"""What a bench looks like from the plant behind it: counts and bytes in, throttles and bytes out, period by period.

The emulated device and the firmware in an emulator are both a `Device`, in lockstep with a simulated plant or stepped
in real time behind a pseudo-terminal.
"""

from dataclasses import dataclass
from typing import Protocol

from bench_driver.errors import OutOfRange

__all__ = ["Device", "Inputs", "Outputs"]

_LARGEST_COUNT = 1023


@dataclass(frozen=True, kw_only=True, slots=True)
class Inputs:
    """What the converters of the device read, held for a period; 10-bit counts.

    Attributes:
        tachometer_counts, flow_counts: one for each thruster.
        load_counts: one for each channel of the load cell.

    Raises:
        OutOfRange: a count that a 10-bit converter does not give, or numbers of counts that differ.
    """

    tachometer_counts: tuple[int, ...]
    flow_counts: tuple[int, ...]
    load_counts: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if len(self.tachometer_counts) != len(self.flow_counts):
            raise OutOfRange("counts of the flow sensors", f"{len(self.tachometer_counts)}", len(self.flow_counts))
        for count in (*self.tachometer_counts, *self.flow_counts, *self.load_counts):
            if not 0 <= count <= _LARGEST_COUNT:
                raise OutOfRange("count of an input", f"0 to {_LARGEST_COUNT}", count)

    def check(self, thrusters: int, loads: int) -> None:
        """Raise `OutOfRange` unless there is one count for each channel of a device."""
        if (len(self.tachometer_counts), len(self.load_counts)) != (thrusters, loads):
            found = (len(self.tachometer_counts), len(self.load_counts))
            raise OutOfRange("numbers of thrusters and load channels", f"{(thrusters, loads)}", found)


@dataclass(frozen=True, kw_only=True, slots=True)
class Outputs:
    """What the device does at the end of a period.

    Attributes:
        throttles: as the thrusters see them, after the device's quantisation [V]; 0 where the output is disabled.
        enabled: whether each output is switched to its converter.
        data: bytes that left the device during the period.
    """

    throttles: tuple[float, ...]
    enabled: tuple[bool, ...]
    data: bytes


class Device(Protocol):
    """A bench behind its serial line.

    Attributes:
        thrusters, loads: channels of the device.
        line_speed: the baud rate at which the host sends and listens; at another one than the device's own, either
            side sees only garbage.
    """

    thrusters: int
    loads: int
    line_speed: int

    def advance(self, period: float, inputs: Inputs, data: bytes = b"") -> Outputs:
        """Let a period [s] pass, during which the host's bytes arrive one after the other."""
        ...

    def reset(self) -> None:
        """Pull the reset line, as a host does that opens the port."""
        ...
