"""A serial line inside the test: the host's port at one end, an emulated device at the other, no system in between."""

from bench_driver.device import Inputs
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.errors import PortFailed

__all__ = ["FakeLine"]


class FakeLine:
    """Opens as a port; what was written reaches the device when it advances.

    Attributes:
        plugged: whether the port can be opened, and goes on once it is.
        count: of the tachometer.
        throttle: what the thruster sees [V].
        loses_answers: whether the device's bytes are lost.
    """

    def __init__(self, line_speed: int) -> None:
        self.device = EmulatedDevice(line_speed=line_speed)
        self.plugged = True
        self.count = 100
        self.throttle = 0.0
        self.loses_answers = False
        self._to_device = self._to_host = b""

    def open(self, name: str, line_speed: int) -> "FakeLine":
        """Open the port."""
        self._check()
        return self

    def advance(self, period: float) -> None:
        """Let a period [s] pass."""
        inputs = Inputs(tachometer_counts=(self.count,), flow_counts=(512,), load_counts=(512, 612, 512, 512, 512, 512))
        steps = max(round(period / 0.005), 1)
        for _ in range(steps):
            outputs = self.device.advance(period / steps, inputs, self._to_device)
            self._to_device = b""
            self._to_host += b"" if self.loses_answers else outputs.data
        self.throttle = outputs.throttles[0]

    def babble(self, data: bytes) -> None:
        """Put bytes onto the line to the host."""
        self._to_host += data

    def read(self) -> bytes:
        """Return what has arrived."""
        self._check()
        data, self._to_host = self._to_host, b""
        return data

    def write(self, data: bytes) -> None:
        """Take the host's bytes."""
        self._check()
        self._to_device += data

    def replaced(self) -> bool:
        """Tell that it is still the same line."""
        return False

    def close(self) -> None:
        """Close the port."""

    def _check(self) -> None:
        if not self.plugged:
            raise PortFailed("fake", "no such port; is the device plugged in?", absent=True)
