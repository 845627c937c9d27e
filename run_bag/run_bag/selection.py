"""Which topics are meant: by name, by regular expression, or all."""

from __future__ import annotations

import re
from collections.abc import Iterable

from .errors import InvalidRunError


class Selection:
    """Tells which topics are meant.

    A pattern is a regular expression that fits the whole name of a topic, with or without its leading slash; a
    plain name is one that fits itself alone. Topics with a part that begins with an underscore are hidden, and
    only meant where a pattern says the underscore.
    """

    def __init__(self, patterns: Iterable[str], exclude: Iterable[str] = ()) -> None:
        """Compile the patterns.

        Raises:
            InvalidRunError: no pattern, or all those that are no regular expressions.
        """
        problems: list[str] = []
        self._wanted = [_compiled(p, problems) for p in patterns]
        self._excluded = [_compiled(p, problems) for p in exclude]
        if not self._wanted:
            problems.append("expected at least one name or regular expression, found none")
        if problems:
            raise InvalidRunError("topics", problems)

    def __contains__(self, name: str) -> bool:
        """Tell whether a topic is meant; `name` is its full name."""
        hidden = any(part.startswith("_") for part in name.split("/"))
        wanted = any(_fits(p, name) and (not hidden or "_" in p.pattern) for p in self._wanted)
        return wanted and not any(_fits(p, name) for p in self._excluded)


def _compiled(pattern: str, problems: list[str]) -> re.Pattern[str]:
    try:
        return re.compile(pattern)
    except re.error as error:
        problems.append(f"{pattern!r} is no regular expression: {error}")
        return re.compile("(?!)")


def _fits(pattern: re.Pattern[str], name: str) -> bool:
    return pattern.fullmatch(name) is not None or pattern.fullmatch(name.lstrip("/")) is not None
