"""What is raised on purpose here, with the facts as attributes."""

from __future__ import annotations

__all__ = ["CdrError", "CdrTooLargeError", "NotWrittenError", "YamlError"]


class YamlError(ValueError):
    """A YAML file cannot be read, is no YAML or could mean two things.

    Attributes:
        origin: the file, or what the text is called.
        told: the sentence without the file.
        position: the line, None where it is the whole file.
    """

    def __init__(self, origin: str, told: str, *, line: int | None = None) -> None:
        self.origin, self.position = origin, line
        self.told = told if line is None else f"line {line}: {told}"
        super().__init__(f"{origin}{': ' if line is None else ', '}{self.told}")

    def __reduce__(self) -> tuple[object, ...]:
        return (_restored, (self.args, self.__dict__))


def _restored(args: tuple[object, ...], facts: dict[str, object]) -> YamlError:
    """Rebuild a pickled error, so that errors cross process borders whole."""
    error = YamlError.__new__(YamlError)
    error.args = args
    error.__dict__.update(facts)
    return error


class NotWrittenError(OSError):
    """The file system refused: nothing is there, or what was there before. `errno` is the system's number."""

    def __init__(self, target: object, error: OSError) -> None:
        super().__init__(f"{target}: cannot be written: {error.strerror or error}; nothing was left there")
        self.errno = error.errno


class CdrError(ValueError):
    """A message's bytes and its definition do not fit together, or one of them is none.

    Attributes:
        expected: what was expected, None where the sentence says it.
        found: what was found instead.
    """

    def __init__(self, told: str, *, expected: object = None, found: object = None) -> None:
        super().__init__(told)
        self.expected, self.found = expected, found


class CdrTooLargeError(CdrError):
    """More items in one message than are read."""
