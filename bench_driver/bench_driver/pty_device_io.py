"""A device on a pseudo-terminal: drivers open it like a serial port.

A pseudo-terminal has no speed and no reset line: the device's `line_speed` says which speed the host uses, and opening
it resets nothing.
"""

import os
import select
import termios
import tty
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType

from bench_driver.device import Device, Inputs, Outputs

__all__ = ["PtyDevice"]

_READ_AT_ONCE = 4096
_TOO_LATE = 0.25  # s

Plant = Callable[[float, Outputs], Inputs]
"""What the device measures next, from the period [s] and what the device did in the last one."""


class PtyDevice:
    """Serves a device; to be closed, best as a context manager.

    Args:
        device: the emulated device or the firmware in its emulator; stays the caller's to close.
        plant: the plant behind it.
        start: what the device measures first.

    Attributes:
        path: of the pseudo-terminal, the name of the port.
        outputs: what the device did last, None before the first step.
    """

    def __init__(self, device: Device, plant: Plant, start: Inputs) -> None:
        self.device = device
        self.outputs: Outputs | None = None
        self._plant = plant
        self._inputs = start
        self._heard = b""
        # The far end stays open here, or closing a port would look like a fault to the device.
        self._near, self._far = os.openpty()
        tty.setraw(self._far, termios.TCSANOW)
        os.set_blocking(self._near, False)
        self.path = os.ttyname(self._far)

    def listen(self, timeout: float = 0.0) -> bytes:
        """Return what the host has written since the device last advanced; wait up to `timeout` [s] for more of it.

        The device does not get it before `advance`.
        """
        if select.select([self._near], [], [], timeout)[0]:
            with suppress(BlockingIOError):
                self._heard += os.read(self._near, _READ_AT_ONCE)
        return self._heard

    def advance(self, period: float) -> Outputs:
        """Let a period [s] pass with what the host has written, and hand it what the device sends."""
        data = self.listen()
        self._heard = b""
        self.outputs = self.device.advance(period, self._inputs, data)
        self._inputs = self._plant(period, self.outputs)
        if self.outputs.data:
            with suppress(BlockingIOError):  # nobody reads: bytes are lost as on a real line
                os.write(self._near, self.outputs.data)
        return self.outputs

    def run(
        self,
        stopped: Callable[[], bool],
        clock: Callable[[], float],
        wait: Callable[[float], object],
        *,
        period: float = 0.002,
    ) -> None:
        """Serve in real time until `stopped`.

        Args:
            stopped: asked once in a period.
            clock: time [s], e.g. time.monotonic.
            wait: lets so many seconds pass, e.g. time.sleep or threading.Event.wait.
            period: step of the device [s].
        """
        due = clock()
        while not stopped():
            self.advance(period)
            due += period
            left = due - clock()
            if left > 0:
                wait(left)
            elif left < -_TOO_LATE:
                due = clock()  # the machine was busy: time is lost, not caught up in a burst

    def close(self) -> None:
        """Unplug: an open port fails, and the path is gone."""
        for end in ("_near", "_far"):
            if getattr(self, end) >= 0:
                os.close(getattr(self, end))
                setattr(self, end, -1)

    def __enter__(self) -> "PtyDevice":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
