"""Errors of this package: what is wrong, where, what was expected and what was found."""

from collections.abc import Sequence

__all__ = ["EstimationError"]


class EstimationError(Exception):
    """Input of a user that cannot be used; `problems` holds one sentence for each thing that is wrong."""

    def __init__(self, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(self.problems))
