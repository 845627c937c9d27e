"""Errors of this package: what is wrong, where, what was expected and what was found."""

from collections.abc import Sequence

__all__ = ["ForceTableError", "ParameterSetError", "ThrusterModelError", "UnfitDataError", "VehicleError"]


class ThrusterModelError(Exception):
    """Base of all errors that this package raises for a user's input."""


class _UnusableError(ThrusterModelError):
    """Something of a source, such as a file, that cannot be used."""

    def __init__(self, source: str, problems: Sequence[str]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__("\n".join(f"{source}: {problem}" for problem in self.problems))


class ParameterSetError(_UnusableError):
    """A parameter set that cannot be used; `problems` holds one sentence for each thing that is wrong."""


class ForceTableError(_UnusableError):
    """A table of forces that cannot be used; `problems` holds one sentence for each thing that is wrong."""


class UnfitDataError(ThrusterModelError):
    """Recordings that cannot be fitted; `problems` holds one sentence for each thing that is missing."""

    def __init__(self, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(self.problems))


class VehicleError(_UnusableError):
    """A vehicle that cannot be used; `problems` holds one sentence for each thing that is wrong."""
