"""What is the same of several thrusters, said once: `thruster_0 to 5/state.n: ...`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

__all__ = ["thrusters_alike"]

_NAME = re.compile(r"thruster_(\d+)(.*)")


def thrusters_alike(told: Iterable[tuple[str, str]]) -> list[str]:
    """Return `name: sentence` for each pair, one for all thrusters of which it differs by their number alone."""
    numbers: dict[tuple[str, str], list[int]] = {}
    for name, sentence in told:
        match = _NAME.fullmatch(name)
        own = numbers.setdefault((match[2] if match else name, sentence), [])
        own += [int(match[1])] if match else []
    return [
        f"{f'thruster_{_numbers(own)}' if own else ''}{name}: {sentence}" for (name, sentence), own in numbers.items()
    ]


def _numbers(ascending: Sequence[int]) -> str:
    """Return numbers in words, three or more in a row as `0 to 5`."""
    rows: list[list[int]] = []
    for each in ascending:
        if rows and each == rows[-1][-1] + 1:
            rows[-1].append(each)
        else:
            rows.append([each])
    return ", ".join(f"{row[0]} to {row[-1]}" if len(row) > 2 else ", ".join(map(str, row)) for row in rows)
