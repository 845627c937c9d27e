"""When, on the host's clock, the device measured: its time stamps without their wrap, mapped by the fastest arrivals.

A frame arrives after its measurement by the time on the line and a delay that is never negative, so the smallest
difference (arrival − device time) in a sliding window is the offset of the clocks plus the smallest delay. A device
clock that is off by 100 ppm moves 1 ms in a window of 10 s.

In lockstep with a simulated device both clocks are one, and no arrival tells when something was measured.
"""

from collections import deque
from typing import Protocol

from bench_driver.framed_protocol import CLOCK_WRAP

__all__ = ["Clock", "DeviceClock", "SharedClock"]

_WRAP = CLOCK_WRAP / 1e6  # s


class Clock(Protocol):
    """Gives the device's stamps on the host's clock.

    Attributes:
        restarts: number of times that the device's clock was found to have jumped.
    """

    restarts: int

    def stamp(self, arrival: float, time: int, *, on_line: float = 0.0) -> float:
        """Return the instant of a measurement on the host's clock [s], never after its arrival.

        Args:
            arrival: when the frame's last byte was read, on the host's clock [s].
            time: the frame's stamp, modulo 2^32 [µs].
            on_line: how long the frame's bytes take on the line [s].
        """
        ...


class DeviceClock:
    """Maps the device's stamps to the host's clock, see `Clock`.

    Args:
        window: over which the fastest arrival counts [s].
        tolerance: a device clock that went on by so much more or less than the host's was restarted [s].
    """

    def __init__(self, *, window: float = 10.0, tolerance: float = 1.0) -> None:
        self.restarts = 0
        self._window = window
        self._tolerance = tolerance
        self._last: tuple[float, int, float] | None = None  # arrival [s], stamp [us], device time [s]
        self._fastest: deque[tuple[float, float]] = deque()  # (arrival, offset), offsets ascending

    def stamp(self, arrival: float, time: int, *, on_line: float = 0.0) -> float:
        """Return the instant of a measurement, see `Clock`."""
        elapsed = 0.0
        if self._last is not None:
            last_arrival, last_time, elapsed = self._last
            # The multiple of the wrap that agrees best with the host's clock.
            step = (time - last_time) / 1e6
            step += _WRAP * round((arrival - last_arrival - step) / _WRAP)
            if abs(step - (arrival - last_arrival)) > self._tolerance:
                self.restarts += 1
                self._fastest.clear()
                step = arrival - last_arrival
            elapsed += step
        self._last = (arrival, time, elapsed)
        offset = arrival - on_line - elapsed
        while self._fastest and self._fastest[-1][1] >= offset:
            self._fastest.pop()
        self._fastest.append((arrival, offset))
        while self._fastest[0][0] < arrival - self._window:
            self._fastest.popleft()
        return elapsed + self._fastest[0][1]


class SharedClock:
    """The host's clock for a device that began with it, see `Clock`; a device that began anew is set to its arrivals.

    Args:
        tolerance: a stamp that lies so far from its arrival is of a device that began anew [s].
    """

    def __init__(self, *, tolerance: float = 1.0) -> None:
        self.restarts = 0
        self._tolerance = tolerance
        self._offset: float | None = None

    def stamp(self, arrival: float, time: int, *, on_line: float = 0.0) -> float:
        """Return the instant of a measurement, see `Clock`."""
        latest, own = arrival - on_line, time / 1e6
        began = self._offset is not None
        offset = self._offset if self._offset is not None else 0.0
        instant = own + offset + _WRAP * round((latest - own - offset) / _WRAP)
        if abs(instant - latest) > self._tolerance:
            self.restarts += began
            offset, instant = latest - own, latest
        self._offset = offset
        return min(instant, latest)
