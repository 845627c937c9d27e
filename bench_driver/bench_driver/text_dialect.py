"""The rig's text protocol behind the link's face, see `dialect`."""

from collections.abc import Sequence

from bench_driver import text_protocol
from bench_driver.converter import code_from_count, code_volts
from bench_driver.dialect import BITS_PER_BYTE, Measurement, added
from bench_driver.text_protocol import LineDecoder

__all__ = ["TextDialect"]


class TextDialect:
    """The rig's text protocol, see `Dialect`. A reset of the device cannot be seen, only its silence."""

    line_speed = text_protocol.BAUD
    period = text_protocol.PERIOD
    thrusters = 1
    resets = 0
    refusal = ""
    device = "text, one thruster"

    def __init__(self) -> None:
        self._before: dict[str, int] = {}
        self._decoder = LineDecoder()
        self._zeros = self._answers = 0

    @property
    def armed(self) -> bool:
        """Return whether a zero was answered."""
        return self._zeros > 0 and self._answers > 0

    @property
    def faults(self) -> dict[str, int]:
        """Return how often each fault of the stream has happened since the dialect was made."""
        return added(self._before, self._decoder.rejected)

    @property
    def waiting(self) -> int:
        """Return the number of bytes of a line that has not ended yet."""
        return self._decoder.waiting

    def start(self) -> None:
        """Forget the stream: the port was opened."""
        self._before = self.faults
        self._decoder = LineDecoder(mid_line=True)
        self._zeros = self._answers = 0

    def zero(self, now: float, *, enable: bool) -> bytes:
        """Return count 128, with which the device also becomes ready."""
        self._zeros += 1
        return text_protocol.encode_throttle(0.0)

    def throttle(self, now: float, throttles: Sequence[float]) -> bytes:
        """Return the line that sets the throttle [V]."""
        (u,) = throttles
        return text_protocol.encode_throttle(u, limit=text_protocol.FULL_SCALE)

    def quantised(self, throttles: Sequence[float]) -> tuple[float, ...]:
        """Return what the throttle [V] becomes in the device."""
        (u,) = throttles
        count = text_protocol.throttle_count(u, limit=text_protocol.FULL_SCALE)
        return (code_volts(code_from_count(count)),)

    def ending(self, now: float) -> bytes:
        """Return count 128 and -99."""
        return text_protocol.encode_throttle(0.0) + text_protocol.END

    def feed(self, now: float, data: bytes) -> list[Measurement]:
        """Return the readings; their stamp is when the first byte of the last line went onto the line."""
        readings = self._decoder.feed(data)
        self._answers += len(readings) if self._zeros else 0
        return [
            Measurement(
                stamp=now - len(text_protocol.encode_reading(reading)) * BITS_PER_BYTE / self.line_speed,
                tachometer_counts=(reading.tachometer_count,),
                flow_counts=(reading.flow_count,),
            )
            for reading in readings
        ]
