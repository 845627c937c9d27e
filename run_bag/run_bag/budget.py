"""What reading one recording may cost, in proportion to its size: content, messages, numbers, layouts, definitions.

A file says itself how large its content becomes; a small one that grows beyond these limits is refused with a sentence
before memory or time are spent on it. Whoever has truly dense recordings multiplies all of them: `--larger 10` of the
commands here, or RUN_BAG_LARGER=10 in the environment of every program.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from .errors import TooLargeError

VARIABLE = "RUN_BAG_LARGER"
OVERHEAD = 160
"""Bytes that a message costs in memory beside its content."""


def larger() -> float:
    """Return by how much the limits are raised: RUN_BAG_LARGER, 1 without; TooLargeError where it is no such number."""
    text = os.environ.get(VARIABLE, "") or "1"
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not 1.0 <= factor <= 1e6:
        raise TooLargeError(f"{VARIABLE}: expected a number from 1 to 1000000, found {text!r}", found=text)
    return factor


@dataclass(frozen=True, kw_only=True)
class Limits:
    """How much of each a recording may have: what every one may, and how much more for each byte of its files."""

    content: tuple[float, float] = (256 << 20, 100)  # [B] unpacked
    memory: tuple[float, float] = (512 << 20, 100)  # [B] kept: content, and what every message costs beside it
    messages: tuple[float, float] = (2e6, 1 / 4)
    lines: tuple[float, float] = (2e6, 1 / 4)  # of a text
    numbers: tuple[float, float] = (32e6, 16)  # values in channels
    steps: tuple[float, float] = (1e6, 1 / 2)  # fields looked at to find where they lie
    definitions: tuple[float, float] = (1 << 20, 1 / 64)  # [B] of message definitions that are parsed
    records: tuple[float, float] = (1e5, 1 / 100)  # channels, definitions and metadata


NAMES = {
    "content": "bytes of unpacked content",
    "memory": "bytes of messages in memory",
    "messages": "messages",
    "lines": "lines",
    "numbers": "values in channels",
    "steps": "fields of messages that differ in their layout",
    "definitions": "bytes of message definitions",
    "records": "records beside the messages",
}


class Budget:
    """What is left for one recording; every reader of a part of it takes from here."""

    def __init__(self, size: int, limits: Limits | None = None, factor: float | None = None) -> None:
        """`size`: of its files together [B]; `factor`: raises all limits (None: as the environment says)."""
        factor = larger() if factor is None else factor
        each = limits or Limits()
        self.size = size
        self.limit = {name: int(factor * (base + rate * size)) for name, (base, rate) in vars(each).items()}
        self.spent = dict.fromkeys(self.limit, 0)

    def take(self, what: str, amount: int, path: Path | str) -> None:
        """Spend; TooLargeError beyond the limit."""
        spent = self.spent[what] = self.spent[what] + amount
        limit = self.limit[what]
        if spent > limit:
            text = f"{path}: expected at most {limit} {NAMES[what]} in a recording of {self.size} bytes, found more"
            raise TooLargeError(f"{text}; {VARIABLE}=10 raises this limit", path=path, expected=limit, found=spent)

    def content(self, amount: int, path: Path | str) -> None:
        """Spend on unpacked content [B]."""
        self.take("content", amount, path)

    def message(self, size: int, path: Path | str) -> None:
        """Spend on a message that is kept."""
        self.take("messages", 1, path)
        self.take("memory", size + OVERHEAD, path)

    def left(self, what: str) -> int:
        """Return what may still be spent."""
        return max(0, self.limit[what] - self.spent[what])

    def left_content(self) -> int:
        """Return the content that may still be unpacked [B]."""
        return self.left("content")
