"""A link on a real port: one step at a time, and zero on every way out."""

from collections.abc import Callable
from types import TracebackType
from typing import Protocol

from bench_driver.dialect import Measurement
from bench_driver.errors import PortFailed
from bench_driver.link import Link
from bench_driver.link_records import LinkState
from bench_driver.serial_port_io import SerialPort

__all__ = ["Port", "SerialSession"]


_DOUBTFUL = (LinkState.SETTLING, LinkState.SILENT)


class Port(Protocol):
    """What a session needs of a port."""

    def read(self) -> bytes:
        """Return the bytes that have arrived, or raise `PortFailed`."""
        ...

    def write(self, data: bytes) -> None:
        """Hand bytes to the port, or raise `PortFailed`."""
        ...

    def replaced(self) -> bool:
        """Tell whether the name leads to another device by now than the one that is open."""
        ...

    def close(self) -> None:
        """Close the port."""
        ...


class SerialSession:
    """Does what the link orders and tells it what happened; a context manager that ends the run when it is left.

    Args:
        link: the link, not stopped.
        name: of the port.
        clock: the time that the link is told [s], e.g. time.monotonic.
        open_port: opens a port by name and line speed.
    """

    def __init__(
        self, link: Link, name: str, clock: Callable[[], float], open_port: Callable[[str, int], Port] = SerialPort
    ) -> None:
        self.link = link
        self.name = name
        self._clock = clock
        self._open_port = open_port
        self._port: Port | None = None

    def step(self) -> list[Measurement]:
        """Read, then write what is due; to be called several times in a period, never blocks for long.

        Returns:
            The measurements received since the last step, oldest first.
        """
        measurements = self.receive()
        self.send()
        return measurements

    def receive(self) -> list[Measurement]:
        """Read only; return the measurements received since the last time, oldest first."""
        now = self._clock()
        if self._port is None:
            return []
        try:
            return self.link.received(now, self._port.read())
        except PortFailed as failure:
            self.link.unplugged(now, failure.reason)
            return []

    def send(self) -> None:
        """Do what the link orders: write what is due, open or close the port."""
        now = self._clock()
        if self._port is not None and self.link.state in _DOUBTFUL and self._port.replaced():
            self.link.replaced(now)
        try:
            self._obey(now)
        except PortFailed as failure:
            self.link.unplugged(now, failure.reason)
            self._obey(now)

    def close(self) -> None:
        """Command zero, end the run and close the port; may be called again."""
        now = self._clock()
        data = self.link.stop(now)
        if self._port is not None:
            try:
                self._port.write(data)
            except PortFailed:
                pass  # gone: its own watchdog sets zero
            finally:
                self._close()

    def __enter__(self) -> "SerialSession":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _obey(self, now: float) -> None:
        orders = self.link.poll(now)
        if orders.open:
            try:
                self._port = self._open_port(self.name, self.link.dialect.line_speed)
            except PortFailed as failure:
                self.link.open_failed(now, failure.reason)
            else:
                self.link.opened(self._clock())
        if orders.data and self._port is not None:
            try:
                self._port.write(orders.data)
            except PortFailed:
                if not orders.close:
                    raise
        if orders.close:
            self._close()

    def _close(self) -> None:
        if self._port is not None:
            self._port.close()
        self._port = None
