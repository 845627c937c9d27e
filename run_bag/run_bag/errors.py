"""All errors of this package: one hierarchy, with the facts as attributes.

Every error says what was wrong, what was expected, what was found and where. Facts that do not apply are
None.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


class RunError(Exception):
    """Base of everything this package raises on purpose.

    Attributes:
        path: file or directory concerned.
        topic: topic concerned, as in the file.
        position: index of the message, line of the file or offset in bytes; the message says which.
        expected: what was expected.
        found: what was found instead.
    """

    def __init__(
        self,
        message: str,
        *,
        path: Path | str | None = None,
        topic: str | None = None,
        position: int | None = None,
        expected: object = None,
        found: object = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.path = None if path is None else Path(path)
        self.topic = topic
        self.position = position
        self.expected = expected
        self.found = found

    def __reduce__(self) -> tuple[object, ...]:
        return (_restore, (type(self), self.args, self.__dict__))


def _restore(kind: type[RunError], args: tuple[object, ...], facts: dict[str, object]) -> RunError:
    """Rebuild a pickled error, so that errors cross process borders whole."""
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(facts)
    return error


class InvalidRunError(RunError):
    """A channel, a run or a topic to be written is not well formed; `problems` lists all that is wrong."""

    def __init__(self, what: str, problems: Sequence[str], *, path: Path | str | None = None) -> None:
        super().__init__(f"{what}: " + "; ".join(problems), path=path)
        self.what = what
        self.problems = tuple(problems)


class MissingChannelError(RunError, LookupError):
    """The run has no channel of this name; `available` lists those it has."""

    def __init__(self, message: str, *, name: str, available: Sequence[str]) -> None:
        super().__init__(message, expected=name, found=tuple(available))
        self.name = name
        self.available = tuple(available)


class NotARunError(RunError):
    """There is nothing at the path that can be read as a run: no MCAP file, or a file that is no MCAP."""


class MissingTopicError(RunError):
    """A requested topic is not in the file."""


class SchemaError(RunError):
    """A message type is unknown, or payload and message definition do not fit together."""


class StampOrderError(RunError):
    """The stamps of one topic run backwards at message `position`; `expected` is the earlier stamp [ns]."""


class EmptyRunError(RunError):
    """The file holds no message, or no channel with a measured value."""


class TooLargeError(RunError):
    """A size in the file exceeds the cap that protects memory."""


class RunExistsError(RunError):
    """The target exists already; nothing is ever overwritten."""


class CannotWriteError(RunError):
    """The target cannot be written: no permission, no space, or something in the way."""


class RecordingError(RunError):
    """A recording that is to be imported is malformed or of another format."""


class NotThereError(RecordingError):
    """An entry of a map is in no recording, or in several; `asked` says for what, `found` what there is instead."""

    def __init__(self, entry: str, expected: str, found: str, *, path: Path | str | None = None) -> None:
        self.asked = f"{'' if path is None else f'{path}: '}{entry}: expected {expected}"
        super().__init__(f"{self.asked}, found {found}", path=path, expected=expected, found=found)


class ClockError(RunError):
    """The topics of a run are on two clocks; `found` names the first topic of each."""


class MissingParticipantError(RunError):
    """Played in lockstep, and someone did not answer: `found` names the topics, `position` is the instant [ns]."""
