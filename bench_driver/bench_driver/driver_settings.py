"""What a driver is told at its start: port, protocol, pace, limits, load cell."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench_driver.device_clock import DeviceClock, SharedClock
from bench_driver.dialect import Dialect
from bench_driver.errors import SettingsRefused
from bench_driver.framed_dialect import FramedDialect
from bench_driver.framed_messages import MOST_LOADS, MOST_THRUSTERS
from bench_driver.link_records import LinkLimits
from bench_driver.text_dialect import TextDialect
from bench_driver.text_protocol import FULL_SCALE

__all__ = ["DriverSettings", "LoadCell", "ProtocolName"]

ProtocolName = Literal["text", "frames"]
_VOLTS_PER_COUNT = FULL_SCALE / 1024


@dataclass(frozen=True, kw_only=True)
class LoadCell:
    """From the counts of the load cell's channels to what they tell.

    Attributes:
        matrix: wrench [N, N, N, N m, N m, N m] per voltage of each gauge [V], (6, 6); None: only gauges are told.
        rest: voltage of each gauge without load [V], (6,).

    Raises:
        SettingsRefused: other shapes, or numbers that are not finite.
    """

    matrix: NDArray[np.float64] | None = None
    rest: NDArray[np.float64] = field(default_factory=lambda: np.full(MOST_LOADS, 0.5 * FULL_SCALE))

    @classmethod
    def of(cls, matrix: ArrayLike, rest: ArrayLike) -> "LoadCell":
        """Return the load cell of 36 numbers, row by row, or none, and 6."""
        given, offsets = np.asarray(matrix, dtype=np.float64).ravel(), np.asarray(rest, dtype=np.float64).ravel()
        wrong = []
        if given.size not in (0, MOST_LOADS**2) or not np.all(np.isfinite(given)):
            wrong.append(f"load_matrix: expected no or {MOST_LOADS**2} finite numbers; found {given.size}")
        if offsets.size != MOST_LOADS or not np.all(np.isfinite(offsets)):
            wrong.append(f"load_rest: expected {MOST_LOADS} finite numbers; found {offsets.size}")
        if wrong:
            raise SettingsRefused(wrong)
        return cls(matrix=given.reshape(MOST_LOADS, MOST_LOADS) if given.size else None, rest=offsets)

    def volts(self, counts: tuple[int, ...]) -> NDArray[np.float64]:
        """Return the voltage of each gauge [V], (6,), NaN for channels that the device has not."""
        told = np.full(MOST_LOADS, math.nan)
        told[: len(counts)] = _VOLTS_PER_COUNT * np.asarray(counts, dtype=np.float64)
        return told

    def wrench(self, volts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return force [N] and moment [N m] for the gauges' voltages [V], (6,) each; needs a matrix."""
        if self.matrix is None:
            raise SettingsRefused(["load_matrix: expected the matrix of the load cell; found none"])
        return np.asarray(self.matrix @ (volts - self.rest))

    def counts(self, wrench: ArrayLike) -> tuple[int, ...]:
        """Return what the converters of a simulated load cell give for a wrench, (6,); saturates like they do."""
        volts = self.rest if self.matrix is None else self.rest + np.linalg.solve(self.matrix, np.asarray(wrench))
        return tuple(int(min(max(math.floor(v / _VOLTS_PER_COUNT + 0.5), 0), 1023)) for v in volts)


@dataclass(frozen=True, kw_only=True)
class DriverSettings:
    """See the descriptions of the driver's parameters.

    Attributes:
        port: name of the serial port.
        protocol: `text` or `frames`.
        thrusters: of the device.
        lockstep: whether /clock gives the pace.
        poll: time between two looks at the port [s].
        reading_timeout: in lockstep, longest wait for the bytes of a period [s of the wall].
        answer_timeout: in lockstep, longest wait for the throttle that answers a state [s of the wall].
        limits: of the link.
        load_cell: behind the device's load channels.

    Raises:
        SettingsRefused: everything that is wrong, in one sentence each.
    """

    port: str
    protocol: ProtocolName = "text"
    thrusters: int = 1
    lockstep: bool = False
    poll: float = 0.002
    reading_timeout: float = 0.2
    answer_timeout: float = 10.0
    limits: LinkLimits = field(default_factory=LinkLimits)
    load_cell: LoadCell = field(default_factory=LoadCell)

    def __post_init__(self) -> None:
        wrong = []
        if not self.port:
            wrong.append("port: expected the name of a serial port, e.g. /dev/ttyACM0; found none")
        if self.protocol not in get_args(ProtocolName):
            wrong.append(f"protocol: expected one of {', '.join(get_args(ProtocolName))}; found {self.protocol!r}")
        most = 1 if self.protocol == "text" else MOST_THRUSTERS
        if not 1 <= self.thrusters <= most:
            wrong.append(f"thrusters: expected 1 to {most} with the protocol {self.protocol}; found {self.thrusters}")
        for name in ("poll", "reading_timeout", "answer_timeout"):
            if not 0.0 < getattr(self, name) < math.inf:
                wrong.append(f"{name}: expected a finite time above 0 s; found {getattr(self, name)} s")
        if wrong:
            raise SettingsRefused(wrong)

    def dialect(self) -> Dialect:
        """Return the protocol as the link uses it."""
        if self.protocol == "text":
            return TextDialect()
        clock: Callable[[], DeviceClock | SharedClock] = SharedClock if self.lockstep else DeviceClock
        return FramedDialect(thrusters=self.thrusters, clock=clock)
