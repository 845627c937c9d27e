"""Findings about runs, before any fit or diagnosis, and what they come to."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

__all__ = ["Finding", "Kind", "lines_of", "usable"]

Kind = Literal["good", "note", "refused"]
_MARKS: dict[Kind, str] = {"good": "  ", "note": "? ", "refused": "! "}


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One sentence about recordings: "good", a "note" of what is in the way, or why something is "refused"."""

    kind: Kind
    about: str
    sentence: str


def usable(found: Sequence[Finding]) -> bool:
    """Tell whether nothing would be refused."""
    return all(each.kind != "refused" for each in found)


def lines_of(found: Sequence[Finding]) -> list[str]:
    """Return a line for each finding, marked, and one of what they come to."""
    refused = sum(each.kind == "refused" for each in found)
    notes = f"{sum(each.kind == 'note' for each in found)} notes (?)"
    last = f"not usable as it is: {refused} refusals (!), {notes}" if refused else f"usable: {notes}"
    return [*(f"{_MARKS[each.kind]}{each.about}: {each.sentence}" for each in found), last]
