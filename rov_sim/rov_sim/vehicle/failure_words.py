"""Failures of thrusters and sensors to come, in words such as 'T2 dead at 12 s; velocity lost at 8 s'."""

import re
from math import nan

from rov_sim.vehicle.live import LOSABLE, Failing, FailureKind, Losing

__all__ = ["named_failures", "parse_failures"]

_FAILURE = re.compile(r"T(\d+)\s+(dead|weak|stuck)(?:\s+([\d.eE+-]+))?\s+at\s+([\d.eE+-]+)\s*s?", re.IGNORECASE)
_LOSS = re.compile(rf"({'|'.join(LOSABLE)})\s+lost\s+at\s+(\d[\d.eE+-]*)\s*s?", re.IGNORECASE)


def parse_failures(text: str) -> tuple[tuple[Failing, ...], tuple[Losing, ...]]:
    """Return the failures of thrusters and the losses of sensors that a text names; thrusters count from T1.

    Raises:
        ValueError: with each part of the text that names none.
    """
    named = _named(text)
    expected = "'T2 dead at 12 s', 'T1 weak 0.5 at 20 s' or 'velocity lost at 8 s'"
    wrong = [f"failures: expected such as {expected}; found {part!r}" for part, found in named if found is None]
    if wrong:
        raise ValueError("; ".join(wrong))
    failures = tuple(found for _, found in named if isinstance(found, Failing))
    return failures, tuple(found for _, found in named if isinstance(found, Losing))


def named_failures(text: str) -> list[tuple[str, Failing | Losing]]:
    """Return each part of a text that names a failure or a loss, and what it names; other parts are left out."""
    return [(part, found) for part, found in _named(text) if found is not None]


def _named(text: str) -> list[tuple[str, Failing | Losing | None]]:
    return [(part, _failure_of(part)) for part in filter(None, map(str.strip, text.split(";")))]


def _failure_of(part: str) -> Failing | Losing | None:
    try:
        if match := _LOSS.fullmatch(part):
            return Losing(match[1].lower(), float(match[2]))
        match = _FAILURE.fullmatch(part)
        if match is not None and int(match[1]) >= 1 and (match[2].lower() == "weak") == (match[3] is not None):
            share = nan if match[3] is None else float(match[3])
            return Failing(int(match[1]) - 1, FailureKind[match[2].upper()], float(match[4]), share)
    except ValueError:  # a number that is none
        pass
    return None
