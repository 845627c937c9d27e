"""One face for both protocols, for `Link`: what to send, what came back, whether the device is ready to be driven."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

__all__ = ["BITS_PER_BYTE", "Dialect", "Measurement", "added"]

BITS_PER_BYTE = 10
"""On the line, with start and stop bit."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Measurement:
    """What the device measured at one instant; counts as received.

    Attributes:
        stamp: instant of the measurement on the host's clock [s].
        tachometer_counts, flow_counts: of each thruster.
        load_counts: of each load channel; text has none.
        throttles: what each converter stood at [V], 0 where the output was disabled; None: text does not tell.
    """

    stamp: float
    tachometer_counts: tuple[int, ...]
    flow_counts: tuple[int, ...]
    load_counts: tuple[int, ...] = ()
    throttles: tuple[float, ...] | None = None


class Dialect(Protocol):
    """A protocol as the link uses it.

    Attributes:
        line_speed: [baud].
        period: time between two commands [s].
        thrusters: number of thrusters driven.
        resets: how often the device was found to have been reset.
        refusal: why the device cannot be driven at all, or an empty string.
        device: what the device said about itself, or an empty string.
    """

    line_speed: int
    period: float
    thrusters: int
    resets: int
    refusal: str
    device: str

    @property
    def armed(self) -> bool:
        """Return whether the device has answered zero and takes throttles now."""
        ...

    @property
    def faults(self) -> dict[str, int]:
        """Return how often each fault of the stream has happened since the dialect was made."""
        ...

    @property
    def waiting(self) -> int:
        """Return the number of bytes of a measurement that is not whole yet."""
        ...

    def start(self) -> None:
        """Forget the stream: the port was opened."""
        ...

    def zero(self, now: float, *, enable: bool) -> bytes:
        """Return what sets all throttles to zero; `enable` makes the device ready for others."""
        ...

    def throttle(self, now: float, throttles: Sequence[float]) -> bytes:
        """Return what sets the throttles [V], each of at most 5 V."""
        ...

    def quantised(self, throttles: Sequence[float]) -> tuple[float, ...]:
        """Return what the throttles [V] become in the device."""
        ...

    def ending(self, now: float) -> bytes:
        """Return what sets zero and ends the run."""
        ...

    def feed(self, now: float, data: bytes) -> list[Measurement]:
        """Return the measurements that end in bytes which arrived now."""
        ...


def added(before: Mapping[str, int], now: Mapping[str, int]) -> dict[str, int]:
    """Return the sums of two sets of counters."""
    total = dict(before)
    for name, count in now.items():
        if count:
            total[name] = total.get(name, 0) + count
    return total
