"""Findings about runs, before any fit or diagnosis, and what they come to."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

__all__ = ["Finding", "Kind", "lines_of", "usable"]

Kind = Literal["good", "note", "refused"]
_MARKS: dict[Kind, str] = {"good": "  ", "note": "? ", "refused": "! "}
_LISTS, _WIDTH = ("effects that", "numbers that"), 120
"""What a list is about, and the columns from which on it is broken."""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One sentence about recordings: "good", a "note" of what is in the way, or why something is "refused".

    Attributes:
        kind, sentence: of it.
        about: what it is about, "" where that is a run as a whole.
        run: name of the recording, "" where it is about all of them.
        of_fit: whether it is about a fit alone, and asks nothing of a diagnosis.
    """

    kind: Kind
    sentence: str
    about: str = ""
    run: str = ""
    of_fit: bool = False


def usable(found: Sequence[Finding]) -> bool:
    """Tell whether nothing would be refused."""
    return all(each.kind != "refused" for each in found)


def lines_of(found: Sequence[Finding]) -> list[str]:
    """Return a line for each finding, marked, and one of what they come to; what holds of several runs is one.

    Of a long list there are several, those beyond the first one indented.
    """
    runs: dict[tuple[Kind, str, str], list[str]] = {}
    for each in found:
        runs.setdefault((each.kind, each.about, each.sentence), []).append(each.run)
    count = len({each.run for each in found} - {""})
    lines = []
    for (kind, about, sentence), of in runs.items():
        whose = "each run" if len(of) == count > 1 else ", ".join(filter(None, of)) + " alike" * (len(of) > 1)
        line = _MARKS[kind] + ": ".join(filter(None, (whose, about, sentence)))
        lines += _broken(line) if about.startswith(_LISTS) else [line]
    refused = sum(kind == "refused" for kind, _, _ in runs)
    notes = _counted(sum(kind == "note" for kind, _, _ in runs), "note", "?")
    of_fit = len({(each.about, each.sentence) for each in found if each.kind == "note" and each.of_fit})
    notes += f", {of_fit} of a fit alone" if of_fit else ""
    told = f"not usable as it is: {_counted(refused, 'refusal', '!')}, {notes}" if refused else f"usable: {notes}"
    return [*lines, told]


def _broken(line: str) -> list[str]:
    return textwrap.wrap(line, _WIDTH, subsequent_indent=6 * " ", break_long_words=False, break_on_hyphens=False)


def _counted(number: int, what: str, mark: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'} ({mark})"
