"""A serial port that never blocks for long and says plainly what is wrong with it.

Opening a port resets most Arduinos (the DTR line falls onto their reset); nothing is sent by opening.
"""

import errno
import os
import termios
from types import TracebackType

import serial

from bench_driver.errors import PortFailed

__all__ = ["SerialPort"]

_READ_AT_ONCE = 65536
_REASONS = {
    errno.EACCES: (
        "no permission; add the user to the group that owns the port (Debian, Ubuntu: `sudo adduser $USER dialout`, "
        "then log in again), or install a udev rule for the board"
    ),
    errno.EBUSY: "in use by another program",
    errno.EAGAIN: "in use by another program",
    errno.ENOTDIR: "no such port",
    errno.ENOENT: "no such port; is the device plugged in?",
    errno.ENXIO: "the port has no device behind it; was it unplugged?",
    errno.ENODEV: "the port has no device behind it; was it unplugged?",
    errno.EIO: "the device does not answer on its bus; was it unplugged?",
    errno.ENOTTY: "not a serial port",
}
_ABSENT = {errno.ENOENT, errno.ENOTDIR, errno.ENXIO, errno.ENODEV}
_LOCKED = "Could not exclusively lock port"


class SerialPort:
    """An open port, locked against other programs; to be closed, best as a context manager.

    Args:
        name: e.g. /dev/ttyACM0, or a link in /dev/serial/by-id.
        line_speed: [baud].
        deadline: longest time that a write may take [s].

    Raises:
        PortFailed: the port cannot be opened.
    """

    def __init__(self, name: str, line_speed: int, *, deadline: float = 0.05) -> None:
        self.name = name
        self._deadline = deadline
        try:
            self._port = serial.Serial(
                name, line_speed, timeout=0, write_timeout=deadline, exclusive=True, rtscts=False, xonxoff=False
            )
        except (serial.SerialException, OSError) as error:
            raise _failure(name, error) from error
        except ValueError as error:
            raise PortFailed(name, f"{error}") from error

    def read(self) -> bytes:
        """Return the bytes that have arrived, perhaps none.

        Raises:
            PortFailed: the port is gone.
        """
        try:
            return bytes(self._port.read(min(self._port.in_waiting, _READ_AT_ONCE)))
        except (serial.SerialException, OSError, TypeError) as error:  # TypeError: closed in the meantime
            raise _failure(self.name, error) from error

    def write(self, data: bytes) -> None:
        """Hand bytes to the port.

        Raises:
            PortFailed: the port is gone, or does not take the bytes before the deadline.
        """
        if not data:
            return
        try:
            self._port.write(data)
        except serial.SerialTimeoutException as error:
            raise PortFailed(self.name, f"took no bytes for {self._deadline:g} s") from error
        except (serial.SerialException, OSError, TypeError) as error:
            raise _failure(self.name, error) from error

    def replaced(self) -> bool:
        """Tell whether the name leads to another device by now than the one that is open."""
        try:
            there, held = os.stat(self.name), os.fstat(self._port.fd)
        except (OSError, TypeError):  # nothing there, or closed in the meantime
            return False
        return (there.st_dev, there.st_ino, there.st_rdev) != (held.st_dev, held.st_ino, held.st_rdev)

    def close(self) -> None:
        """Send what waits, as far as the deadline allows, and close; may be called again."""
        try:
            self._port.close()
        except (serial.SerialException, OSError):
            self._port.fd = None  # the device is gone: nothing is left to be closed

    def __enter__(self) -> "SerialPort":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _failure(name: str, error: Exception) -> PortFailed:
    number = errno.EBUSY if _LOCKED in str(error) else _number(error) or _number(error.__context__)
    return PortFailed(name, _REASONS.get(number, f"the port failed: {error}"), absent=number in _ABSENT)


def _number(error: BaseException | None) -> int:
    """Return the system's number of an error, 0 if it has none."""
    if isinstance(error, OSError) and error.errno:
        return error.errno
    if isinstance(error, termios.error) and error.args:
        return int(error.args[0])
    return 0
