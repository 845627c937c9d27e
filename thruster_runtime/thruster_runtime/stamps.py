"""Stamps as integer nanoseconds: as floats they would lose ticks."""

from typing import Any

__all__ = ["NANOSECONDS", "nanoseconds"]

NANOSECONDS = 1_000_000_000
"""In a second."""


def nanoseconds(stamp: Any) -> int:
    """Return a builtin_interfaces/Time as integer nanoseconds."""
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
