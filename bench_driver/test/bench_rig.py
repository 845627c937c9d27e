"""A link on an emulated device, stepped through time that the test makes, with faults on the line."""

from collections.abc import Callable
from dataclasses import dataclass, field

from bench_driver.device import Inputs
from bench_driver.dialect import Dialect, Measurement
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.framed_dialect import FramedDialect
from bench_driver.link import Link
from bench_driver.link_diagnosis import LinkDiagnosis
from bench_driver.link_records import LinkLimits, LinkState
from bench_driver.text_dialect import TextDialect

__all__ = ["DIALECTS", "IDLE", "Rig"]

IDLE = Inputs(tachometer_counts=(0,), flow_counts=(0,), load_counts=(0,) * 6)

DIALECTS: dict[str, Callable[[], Dialect]] = {"text": TextDialect, "frames": FramedDialect}


@dataclass
class Rig:
    """Steps of 10 ms.

    Attributes:
        present: whether the port can be opened.
        to_host, to_device: what the line makes of the device's and of the host's bytes.
        measured: measurements with the time of the step they came in.
        sensed: the tachometer counts that the device was ever given.
        received: every byte that the host got.
    """

    dialect: Dialect
    limits: LinkLimits = field(default_factory=lambda: LinkLimits(quiet=0.0))
    present: bool = True
    to_host: Callable[[bytes], bytes] = lambda data: data
    to_device: Callable[[bytes], bytes] = lambda data: data
    now: float = 100.0
    throttle: float | None = None
    is_open: bool = False
    measured: list[tuple[float, Measurement]] = field(default_factory=list)
    sensed: set[int] = field(default_factory=set)
    received: bytes = b""
    sent: list[tuple[float, bytes]] = field(default_factory=list)
    opened_at: list[float] = field(default_factory=list)
    seen: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.device = EmulatedDevice(line_speed=self.dialect.line_speed)
        self.link = Link(self.dialect, self.limits)
        self.diagnosis = LinkDiagnosis(self.link)
        self._waiting = b""

    def step(self) -> None:
        """Let 10 ms pass."""
        link, data = self.link, b""
        if self.is_open and not self.present:
            link.unplugged(self.now, "the device does not answer on its bus; was it unplugged?")
        if self.throttle is not None:
            link.command(self.now, [self.throttle])
        if self.is_open and self.present:
            self.received += self._waiting
            self.measured += [(self.now, found) for found in link.received(self.now, self._waiting)]
            self._waiting = b""
        orders = link.poll(self.now)
        if orders.data and self.is_open and self.present:
            data = orders.data
            self.sent.append((self.now, data))
        if orders.close:
            self.is_open, self._waiting = False, b""
        if orders.open:
            self.is_open = self.present
            self.opened_at.append(self.now)
            if self.present:
                link.opened(self.now)
            else:
                link.open_failed(self.now, "no such port; is the device plugged in?")
        self._advance(data)
        self.diagnosis.diagnose(self.now)

    def _advance(self, data: bytes) -> None:
        count = int(1000 * self.now) % 1000
        self.sensed.add(count)
        inputs = Inputs(tachometer_counts=(count,), flow_counts=(512,), load_counts=(0,) * 6)
        outputs = self.device.advance(0.01, inputs, self.to_device(data))
        if self.is_open:
            self._waiting += self.to_host(outputs.data)
        self.seen.append(outputs.throttles[0])
        self.now = round(self.now + 0.01, 9)

    def run(self, time: float) -> None:
        """Let a time [s] pass."""
        for _ in range(round(time / 0.01)):
            self.step()

    def until(self, state: LinkState, time: float = 5.0) -> float:
        """Let time pass until the link is in a state; return how long it took [s]."""
        start = self.now
        while self.link.state is not state:
            assert self.now - start < time, f"{self.link.state} after {time} s: {self.link.reason}"
            self.step()
        return self.now - start

    def drive(self, throttle: float = 2.0) -> None:
        """Get ready and drive for half a second."""
        self.throttle = throttle
        self.until(LinkState.READY)
        self.run(0.5)
        assert abs(self.seen[-1] - throttle) < 0.03, self.seen[-1]
