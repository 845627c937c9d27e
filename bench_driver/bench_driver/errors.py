"""The errors of this package, with the facts as attributes."""

from collections.abc import Sequence


class BenchDriverError(Exception):
    """Base of all errors that this package raises on purpose."""


class ThrottleRefused(BenchDriverError, ValueError):
    """A throttle that is not sent.

    Attributes:
        value: throttle asked for [V].
        limit: largest magnitude allowed [V].
    """

    def __init__(self, value: float, limit: float) -> None:
        super().__init__(f"throttle {value!r} V: expected a magnitude of at most {limit!r} V")
        self.value = value
        self.limit = limit

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.value, self.limit)


class OutOfRange(BenchDriverError, ValueError):
    """A number that the protocol cannot carry.

    Attributes:
        what: name and unit of the number.
        expected: what is allowed.
        found: what was given.
    """

    def __init__(self, what: str, expected: str, found: object) -> None:
        super().__init__(f"{what}: expected {expected}, got {found!r}")
        self.what = what
        self.expected = expected
        self.found = found

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.what, self.expected, self.found)


class SettingsRefused(BenchDriverError, ValueError):
    """Settings that cannot be used.

    Attributes:
        problems: a sentence for each.
    """

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("; ".join(problems))
        self.problems = tuple(problems)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.problems,)


class EmulatorFailed(BenchDriverError):
    """The emulated processor cannot be started or does not go on; the message says why."""


class PortFailed(BenchDriverError):
    """A serial port cannot be opened, or is gone.

    Attributes:
        port: its name.
        reason: what happened, and what to do about it where that is known.
        absent: there is no such port, as opposed to one that cannot be used.
    """

    def __init__(self, port: str, reason: str, *, absent: bool = False) -> None:
        super().__init__(f"{port}: {reason}")
        self.port = port
        self.reason = reason
        self.absent = absent

    def __reduce__(self) -> tuple[object, ...]:
        return _rebuilt, (type(self), self.port, self.reason, self.absent)


def _rebuilt(kind: type[PortFailed], port: str, reason: str, absent: bool) -> PortFailed:
    return kind(port, reason, absent=absent)
