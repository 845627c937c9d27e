"""Errors of this package: what is wrong, where, what was expected and what was found."""

from collections.abc import Sequence

__all__ = ["ScriptError", "SteadyStatesError", "ThrusterControlError"]


class ThrusterControlError(Exception):
    """Base of all errors that this package raises for a user's input; `problems` holds a sentence for each."""

    def __init__(self, source: str, problems: Sequence[str]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__("\n".join(f"{source}: {problem}" for problem in self.problems))


class SteadyStatesError(ThrusterControlError):
    """Steady states that give no table; `problems` holds one sentence for each thing that is wrong."""


class ScriptError(ThrusterControlError):
    """A script of set points that cannot be used; `problems` holds one sentence for each thing that is wrong."""
